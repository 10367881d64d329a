"""Linear Kalman filter of place and velocity in the plane, and its smoother: bridges gaps between reports.

References
----------
[1] Rauch, Tung, Striebel, Maximum likelihood estimates of linear dynamic systems (1965).
[2] Correction of AIS tracks by the unscented Kalman filter, eq. 1 and 2 (linear filter), gaps of 5 and 10 minutes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.catalog import AisModel, FilterModel, filter_model
from navfix.errors import InputError
from navfix.picture.motion.history import History
from navfix.picture.motion.outcome import Carried, Declined
from navfix.types import FloatArray

UNKNOWN_MPS = 15.0  # 1 sigma per axis of the velocity of a ship that does not tell it


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """Mean (4,) in (north m, east m, north m/s, east m/s) and covariance (4, 4) at a time."""

    time_s: float
    mean: FloatArray
    covariance: FloatArray


def predict(moment: Moment, to_s: float, constants: FilterModel) -> Moment:
    """Move on with constant velocity; the acceleration is white noise (source, eq. 1)."""
    t = to_s - moment.time_s
    F = transition(t)
    return Moment(to_s, F @ moment.mean, F @ moment.covariance @ F.T + noise(t, constants.acceleration_walk_mps))


def correct(moment: Moment, H: FloatArray, observed: FloatArray, R: FloatArray) -> Moment:
    """Return the moment after an observation (source, eq. 2 and the gain)."""
    P = moment.covariance
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    left = np.eye(4) - K @ H
    return Moment(moment.time_s, moment.mean + K @ (observed - H @ moment.mean), left @ P @ left.T + K @ R @ K.T)


def transition(time_s: float) -> FloatArray:
    """Return the transition matrix (4, 4) of constant velocity."""
    F = np.eye(4)
    F[0, 2] = F[1, 3] = time_s
    return F


def noise(time_s: float, walk_mps: float) -> FloatArray:
    """Return what a white acceleration adds in a time; ``walk_mps`` is the velocity's walk per root second."""
    t = abs(time_s)
    both = math.copysign(0.5 * t**2, time_s)
    block = np.array([[t**3 / 3.0, both], [both, t]])
    return np.asarray(np.kron(walk_mps**2 * block, np.eye(2)), dtype=np.float64)


def smoothed(past: History, asked_s: Sequence[float], constants: FilterModel | None = None) -> list[Moment]:
    """Return place and velocity at the times asked [POSIX s], from the reports before **and** after each.

    The plane is that of the history, about its newest report. Between two reports that tell their velocities the mean
    is the cubic through both.

    Raises
    ------
    InputError : a time outside of the history
    """
    constants = constants or filter_model()
    if any(not past.time_s[-1] <= t <= past.time_s[0] for t in asked_s):
        raise InputError("a smoother answers for times between the first and the last report only")
    observed = {float(past.time_s[i]): i for i in range(len(past))}
    times = sorted({*observed, *map(float, asked_s)})
    filtered, predicted = [_corrected(_unknown(past, times[0]), past, observed.get(times[0]), constants)], []
    for time_s in times[1:]:
        predicted.append(predict(filtered[-1], time_s, constants))
        filtered.append(_corrected(predicted[-1], past, observed.get(time_s), constants))
    found = {times[-1]: filtered[-1]}
    later = filtered[-1]
    for moment, ahead in zip(reversed(filtered[:-1]), reversed(predicted), strict=True):
        later = _back(moment, ahead, later)
        found[later.time_s] = later
    return [found[float(time_s)] for time_s in asked_s]


def carry(past: History, at_s: float, model: AisModel) -> Carried | Declined:
    """Return the step from the newest report to the smoothed place at an instant between reports."""
    if not past.time_s[-1] < at_s < past.time_s[0]:
        return Declined("a smoother needs a report on each side of the instant")
    (moment,) = smoothed(past, [at_s])
    variance = 0.5 * float(np.trace(moment.covariance[:2, :2]))
    clock_m = model.clock_sigma_s * math.hypot(moment.mean[2], moment.mean[3])
    return Carried(float(moment.mean[0]), float(moment.mean[1]), math.hypot(math.sqrt(variance), clock_m))


def _unknown(past: History, time_s: float) -> Moment:
    place = np.array([past.north_m[-1], past.east_m[-1], 0.0, 0.0])
    return Moment(time_s, place, np.diag([1e6, 1e6, UNKNOWN_MPS**2, UNKNOWN_MPS**2]))


def _corrected(moment: Moment, past: History, index: int | None, constants: FilterModel) -> Moment:
    """Return a moment after a report of the history, as it is where there is none."""
    if index is None:
        return moment
    speed, course = float(past.speed_mps[index]), float(past.course_rad[index])
    place = [float(past.north_m[index]), float(past.east_m[index])]
    if not (math.isfinite(speed) and math.isfinite(course)):
        return correct(moment, np.eye(4)[:2], np.array(place), constants.position_sigma_m**2 * np.eye(2))
    cos, sin = math.cos(course), math.sin(course)
    turn = np.array([[cos, -sin], [sin, cos]])
    across = math.hypot(constants.speed_sigma_mps, math.radians(constants.course_sigma_deg) * speed)
    R = constants.position_sigma_m**2 * np.eye(4)
    R[2:, 2:] = turn @ np.diag([constants.speed_sigma_mps**2, across**2]) @ turn.T
    return correct(moment, np.eye(4), np.array([*place, speed * cos, speed * sin]), R)


def _back(moment: Moment, ahead: Moment, later: Moment) -> Moment:
    """Return a filtered moment improved by what came later (Rauch, Tung, Striebel)."""
    F = transition(ahead.time_s - moment.time_s)
    G = np.linalg.solve(ahead.covariance, F @ moment.covariance).T
    covariance = moment.covariance + G @ (later.covariance - ahead.covariance) @ G.T
    return Moment(moment.time_s, moment.mean + G @ (later.mean - ahead.mean), 0.5 * (covariance + covariance.T))
