"""The filter of one track: constant velocity relative to own ship, in a plane that does not turn with her."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """A plot in the plane: position (2,) [m] and its covariance (2, 2) [m2]."""

    position: FloatArray
    covariance: FloatArray


def measured(range_m: float, bearing_deg: float, range_sigma_m: float, bearing_sigma_deg: float) -> Measured:
    """Return range and bearing as a position with covariance, eq. (11.2)."""
    bearing_rad = math.radians(bearing_deg)
    cos, sin = math.cos(bearing_rad), math.sin(bearing_rad)
    turn = np.array([[cos, -sin], [sin, cos]])
    variance = np.array([range_sigma_m**2, (range_m * math.radians(bearing_sigma_deg)) ** 2])
    return Measured(range_m * turn[:, 0], (turn * variance) @ turn.T)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Position and velocity relative to own ship (4,) [m, m/s] with covariance (4, 4), at a time [POSIX s]."""

    time_s: float
    mean: FloatArray
    covariance: FloatArray

    @property
    def range_m(self) -> float:
        return math.hypot(self.mean[0], self.mean[1])

    @property
    def bearing_deg(self) -> float:
        """Bearing in the plane of the tracker, which does not turn with own ship."""
        return math.degrees(math.atan2(self.mean[1], self.mean[0])) % 360.0

    @property
    def speed_mps(self) -> float:
        return math.hypot(self.mean[2], self.mean[3])


def start(time_s: float, seen: Measured, speed_sigma_mps: float) -> State:
    """Return the state after one plot: the velocity is zero with the sigma of relative speeds at sea."""
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = seen.covariance
    covariance[2:, 2:] = speed_sigma_mps**2 * np.eye(2)
    return State(time_s, np.concatenate([seen.position, np.zeros(2)]), covariance)


def predict(state: State, time_s: float, acceleration_mps2: float) -> State:
    """Carry a state to another time, eq. (11.3); the acceleration is white from turn to turn."""
    mean, covariance = carried(state.mean, state.covariance, np.array(time_s - state.time_s), acceleration_mps2)
    return State(time_s, mean, covariance)


def update(state: State, seen: Measured) -> State:
    """Take a plot into a state of the same time, eq. (11.4)."""
    mean, covariance = blended(state.mean, state.covariance, seen.position, seen.covariance)
    return State(state.time_s, mean, covariance)


def carried(
    mean: FloatArray, covariance: FloatArray, dt_s: FloatArray, acceleration_mps2: float
) -> tuple[FloatArray, FloatArray]:
    """Carry means (..., 4) and covariances (..., 4, 4) over ``dt_s`` (...), forward or backward, eq. (11.3)."""
    transition = np.broadcast_to(np.eye(4), covariance.shape).copy()
    transition[..., 0, 2] = transition[..., 1, 3] = dt_s
    gain = np.zeros((*mean.shape[:-1], 4, 2))
    gain[..., 0, 0] = gain[..., 1, 1] = 0.5 * dt_s * dt_s
    gain[..., 2, 0] = gain[..., 3, 1] = dt_s
    noise = acceleration_mps2**2 * (gain @ np.swapaxes(gain, -1, -2))
    moved = (transition @ mean[..., None])[..., 0]
    return moved, transition @ covariance @ np.swapaxes(transition, -1, -2) + noise


def blended(
    mean: FloatArray, covariance: FloatArray, position: FloatArray, spread: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Take positions (..., 2) with covariance (..., 2, 2) into states of the same time, eq. (11.4) in Joseph's form."""
    innovation_covariance = covariance[..., :2, :2] + spread
    gain = np.swapaxes(np.linalg.solve(innovation_covariance, covariance[..., :2, :]), -1, -2)
    better = mean + (gain @ (position - mean[..., :2])[..., None])[..., 0]
    keep = np.broadcast_to(np.eye(4), covariance.shape).copy()
    keep[..., :, :2] -= gain
    rest = gain @ spread @ np.swapaxes(gain, -1, -2)
    return better, keep @ covariance @ np.swapaxes(keep, -1, -2) + rest
