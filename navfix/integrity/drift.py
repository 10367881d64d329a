"""Slow differences over a window of epochs: a constant offset and a steady drift, eq. (7.9) and (7.10)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from navfix.types import FloatArray


class Difference(NamedTuple):
    """GNSS - fix at a time [s]: north, east [m] (2,) and its covariance (2, 2)."""

    time_s: float
    ne_m: FloatArray
    covariance_m2: FloatArray


@dataclass(frozen=True, slots=True)
class ErrorModel:
    """How errors of successive differences belong together.

    ``steady_share`` of the variance stays as it is (AIS antennas, hulls, radar alignment); the rest is forgotten with
    ``memory_s`` (tracking filters, reports carried forward). ``drift_sigma_mps`` is the rate at which what stays may
    change all the same, 1 sigma per axis.
    """

    steady_share: float = 0.5
    memory_s: float = 10.0
    drift_sigma_mps: float = 0.02


@dataclass(frozen=True, slots=True)
class Slow:
    """Mean offset [m] and drift [m/s] over a window: values, and the limits that chance explains along them."""

    window_s: float
    offset_m: float
    offset_limit_m: float
    drift_mps: float
    drift_limit_mps: float
    azimuth_deg: float

    @property
    def beyond(self) -> bool:
        """Whether offset or drift is more than chance explains."""
        return self.offset_m > self.offset_limit_m or self.drift_mps > self.drift_limit_mps

    @property
    def in_words(self) -> str:
        """What is beyond, drift before offset."""
        if self.drift_mps > self.drift_limit_mps:
            return (
                f"GNSS leaves the fix at {self.drift_mps:.2f} m/s towards {self.azimuth_deg:03.0f}° over "
                f"{self.window_s:.0f} s; up to {self.drift_limit_mps:.2f} m/s are explained"
            )
        return (
            f"GNSS lies {self.offset_m:.0f} m off in the mean of {self.window_s:.0f} s; up to "
            f"{self.offset_limit_m:.0f} m are explained"
        )


def slow_difference(differences: Sequence[Difference], model: ErrorModel, probability: float) -> Slow | None:
    """Test the mean and the trend of the differences, each passed by a good receiver with ``probability``.

    None with fewer than four of them, or all at one time.
    """
    time = np.array([d.time_s for d in differences])
    if len(time) < 4 or np.ptp(time) <= 0.0:
        return None
    values = np.array([d.ne_m for d in differences])
    covariance = np.mean([d.covariance_m2 for d in differences], axis=0)
    correlation = (1.0 - model.steady_share) * np.exp(-np.abs(time[:, None] - time) / model.memory_s)
    each = np.full(len(time), 1.0 / len(time))
    trend = time - time.mean()
    trend /= float(trend @ trend)
    offset, drift = each @ values, trend @ values
    offset_covariance = covariance * (model.steady_share + float(each @ correlation @ each))
    drift_covariance = covariance * float(trend @ correlation @ trend) + model.drift_sigma_mps**2 * np.eye(2)
    return Slow(
        window_s=float(np.ptp(time)),
        offset_m=float(np.hypot(*offset)),
        offset_limit_m=_limit(offset, offset_covariance, probability),
        drift_mps=float(np.hypot(*drift)),
        drift_limit_mps=_limit(drift, drift_covariance, probability),
        azimuth_deg=math.degrees(math.atan2(drift[1], drift[0])) % 360.0,
    )


def _limit(vector: FloatArray, covariance: FloatArray, probability: float) -> float:
    """Return the length along ``vector`` that chance passes with ``probability``."""
    length = float(np.hypot(*vector))
    along = vector / length if length > 0.0 else np.linalg.eigh(covariance)[1][:, 1]
    return math.sqrt(-2.0 * math.log(probability) / float(along @ np.linalg.solve(covariance, along)))
