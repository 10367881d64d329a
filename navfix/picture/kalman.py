"""Kalman filter of one coordinate at constant velocity: the local filter of each sensor before fusion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Filtered:
    """State (value, rate) and covariance (2, 2) at ``time_s``."""

    time_s: float
    state: FloatArray
    covariance: FloatArray

    @property
    def value(self) -> float:
        return float(self.state[0])

    @property
    def rate(self) -> float:
        return float(self.state[1])


def start(time_s: float, value: float, variance: float, *, rate: float = 0.0, rate_variance: float) -> Filtered:
    """Return the state after the first measurement."""
    return Filtered(time_s, np.array([value, rate]), np.diag([variance, rate_variance]))


def predict(track: Filtered, time_s: float, acceleration: float) -> Filtered:
    """Carry a state to another time with white acceleration of this sigma over the step: eq. (9.1).

    Backward steps carry the state and widen the covariance alike.
    """
    dt = time_s - track.time_s
    A = np.array([[1.0, dt], [0.0, 1.0]])
    w = np.array([dt * dt / 2.0, dt]) * acceleration
    return Filtered(time_s, A @ track.state, A @ track.covariance @ A.T + np.outer(w, w))


def update(track: Filtered, value: float, variance: float, *, row: int = 0) -> Filtered:
    """Take a measurement of the value (row 0) or the rate (row 1) in: gain (9.3), state (9.2), covariance (9.4)."""
    P = track.covariance
    K = P[:, row] / (P[row, row] + variance)
    state = track.state + K * (value - track.state[row])
    keep = np.eye(2)
    keep[:, row] -= K
    return Filtered(track.time_s, state, keep @ P @ keep.T + np.outer(K, K) * variance)
