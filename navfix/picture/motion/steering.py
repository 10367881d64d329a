"""How a ship steers: speed, course, rate of turn, change of speed and unsteadiness, from what it reported lately."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from navfix.catalog import PersistingModel
from navfix.picture.motion.history import History
from navfix.types import FloatArray

STILL_MPS = 0.3  # below this a reported course is noise
UNSTEADY_MEMORY_S = 60.0


@dataclass(frozen=True, slots=True)
class Steering:
    """Motion at the newest report.

    ``turn_rate_rad_s`` and ``acceleration_mps2`` are regressions over the last seconds, shrunk towards zero;
    ``unsteadiness_rad`` is the scatter of the courses of the last minute, ``span_s`` the time that the history covers.
    """

    speed_mps: float
    course_rad: float
    turn_rate_rad_s: float = 0.0
    acceleration_mps2: float = 0.0
    unsteadiness_rad: float = 0.0
    span_s: float = 0.0


@lru_cache(maxsize=8192)
def steering(past: History, model: PersistingModel) -> Steering | None:
    """Return how a ship steers, None where its newest report tells no speed, or no course at a speed that has one."""
    speed, course = float(past.speed_mps[0]), float(past.course_rad[0])
    if not math.isfinite(speed) or (not math.isfinite(course) and speed > STILL_MPS):
        return None
    if not math.isfinite(course):
        return Steering(speed, 0.0)
    told = np.isfinite(past.speed_mps) & np.isfinite(past.course_rad)
    ago_s = past.time_s[told] - past.time_s[0]  # 0, then negative
    if len(ago_s) < 2:
        return Steering(speed, course)
    turned, gained = past.course_rad[told] - course, past.speed_mps[told] - speed
    rate = _slope(ago_s, turned, model.turn_memory_s, model.turn_shrink_s2)
    if past.turn_rate_rad_s is not None and abs(past.turn_rate_rad_s) <= model.fastest_turn_rad_s:
        rate += model.reported_turn_share * (past.turn_rate_rad_s - rate)
    limit = model.fastest_turn_rad_s
    growth = _slope(ago_s, gained, model.speed_memory_s, model.speed_shrink_s2)
    return Steering(
        speed_mps=speed,
        course_rad=course,
        turn_rate_rad_s=min(max(rate, -limit), limit),
        acceleration_mps2=min(max(growth, -model.strongest_mps2), model.strongest_mps2),
        unsteadiness_rad=_scatter(turned, np.exp(ago_s / UNSTEADY_MEMORY_S)),
        span_s=float(-ago_s[-1]),
    )


def _slope(ago_s: FloatArray, value: FloatArray, memory_s: float, shrink_s2: float) -> float:
    """Return the slope of a straight line, weights falling with age, shrunk: sum t v / (sum t^2 + shrink)."""
    weight = np.exp(ago_s / memory_s)
    share = weight / weight.sum()
    t, v = ago_s - share @ ago_s, value - share @ value
    return float((weight * t) @ v / ((weight * t) @ t + shrink_s2))


def _scatter(value: FloatArray, weight: FloatArray) -> float:
    share = weight / weight.sum()
    return math.sqrt(float(share @ (value - share @ value) ** 2))
