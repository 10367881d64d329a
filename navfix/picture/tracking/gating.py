"""Which plots a track could have made: statistical distances of all tracks to all plots of a turn at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.picture.tracking.filter import Measured, State
from navfix.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Distances:
    """(n tracks, m plots): chi-square distance and log determinant of the innovation's covariance (m4)."""

    chi2: FloatArray
    log_det: FloatArray

    @property
    def log_likelihood(self) -> FloatArray:
        """Log density [1/m2] of each plot under each track's prediction."""
        log_density: FloatArray = -0.5 * (self.chi2 + self.log_det) - np.log(2.0 * np.pi)
        return log_density


def distances(
    states: Sequence[State], seen: Sequence[Measured], time_s: FloatArray, acceleration_mps2: float
) -> Distances:
    """Return the distance of every track, at the time of every plot (m,) [POSIX s], to that plot, eq. (11.5)."""
    mean = np.array([state.mean for state in states]).reshape(-1, 4)
    covariance = np.array([state.covariance for state in states]).reshape(-1, 4, 4)
    position = np.array([plot.position for plot in seen]).reshape(-1, 2)
    dt = time_s[None, :] - np.array([state.time_s for state in states])[:, None]
    gap = position[None, :, :] - mean[:, None, :2] - dt[..., None] * mean[:, None, 2:]
    cross = covariance[:, :2, 2:] + covariance[:, 2:, :2]
    by_time = dt[..., None, None]
    spread = (
        covariance[:, None, :2, :2]
        + by_time * cross[:, None]
        + by_time**2 * covariance[:, None, 2:, 2:]
        + 0.25 * acceleration_mps2**2 * by_time**4 * np.eye(2)
        + np.array([plot.covariance for plot in seen]).reshape(1, -1, 2, 2)
    )
    determinant = spread[..., 0, 0] * spread[..., 1, 1] - spread[..., 0, 1] ** 2
    chi2 = (
        spread[..., 1, 1] * gap[..., 0] ** 2
        - 2.0 * spread[..., 0, 1] * gap[..., 0] * gap[..., 1]
        + spread[..., 0, 0] * gap[..., 1] ** 2
    ) / determinant
    return Distances(chi2, np.log(determinant))
