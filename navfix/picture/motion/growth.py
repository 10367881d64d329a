"""How the sigma of a carried position grows with the age of the report: fitted to recordings, one set a class."""

from __future__ import annotations

import math

from navfix.catalog import AisModel
from navfix.picture.motion.steering import Steering

LEAST_SIGMA_M = 1.0
UNSTEADY_AFTER_S = 30.0  # age at which half of the unsteadiness has come into the path; memory of an unknown one
WIDEST_RAD = 1.5  # beyond this the direction is as good as unknown


def step_sigma_m(steers: Steering, age_s: float, model: AisModel) -> float:
    """Return the sigma per axis [m] that carrying a moving ship by ``age_s`` adds (theory, eq. 13.5).

    The time of the report is uncertain; speed errors grow with age; the path spreads, more for a ship that is turning
    or whose course scattered in the last minute. A short history does not know that scatter: a typical one is taken.
    """
    age, speed = abs(age_s), steers.speed_mps
    way_m = speed * age
    unknown_rad = model.typical_unsteadiness_rad * math.exp(-0.5 * steers.span_s / UNSTEADY_AFTER_S)
    unsteady_rad = min(math.hypot(steers.unsteadiness_rad, unknown_rad), WIDEST_RAD)
    turned_rad = min(abs(steers.turn_rate_rad_s) * age, WIDEST_RAD)
    spread_mps = model.path_share * speed + model.path_floor_mps
    return math.hypot(
        LEAST_SIGMA_M,
        model.clock_sigma_s * speed,
        model.speed_sigma_mps * age,
        spread_mps * age * age / (age + model.path_time_s),
        model.turn_share * turned_rad * way_m,
        model.unsteady_share * unsteady_rad * way_m * age / (age + UNSTEADY_AFTER_S),
    )


def drift_sigma_m(age_s: float, model: AisModel) -> float:
    """Return the sigma per axis [m] of a ship whose speed or course is not known: it drifts at up to two knots."""
    return abs(age_s) + model.swing_sigma_m


def still_sigma_m(age_s: float, model: AisModel) -> float:
    """Return the sigma per axis [m] of a ship that lies still: it swings."""
    return min(model.still_sigma_mps * abs(age_s), 2.0 * model.swing_sigma_m)
