"""Constant speed and course: the plain model, with a sigma that grows with the age of the report."""

from __future__ import annotations

import math
from dataclasses import dataclass

from navfix.catalog import AisModel

STILL_MPS = 0.3  # below this a reported course is noise


@dataclass(frozen=True, slots=True)
class Carried:
    """A step (north, east) [m] from the reported position and the sigma per axis [m] that the step adds."""

    north_m: float
    east_m: float
    sigma_m: float


def carry(speed_mps: float | None, course_deg: float | None, age_s: float, model: AisModel) -> Carried:
    """Carry a report forward by ``age_s`` (backward where negative) with constant speed and course over ground.

    Sigma: speed and course error and an unknown acceleration grow with age; the clocks of radar and AIS differ.
    A ship without speed or course may have drifted at up to two knots.
    """
    age = abs(age_s)
    if speed_mps is None or (course_deg is None and speed_mps > STILL_MPS):
        return Carried(0.0, 0.0, 1.0 * age + model.swing_sigma_m)
    if speed_mps <= STILL_MPS or course_deg is None:
        return Carried(0.0, 0.0, min(STILL_MPS * age, 2.0 * model.swing_sigma_m))
    distance_m = speed_mps * age_s
    sigma_m = math.sqrt(
        (model.speed_sigma_mps * age) ** 2
        + (math.radians(model.course_sigma_deg) * speed_mps * age) ** 2
        + (0.5 * model.acceleration_mps2 * age**2) ** 2
        + (model.clock_sigma_s * speed_mps) ** 2
    )
    course_rad = math.radians(course_deg)
    return Carried(distance_m * math.cos(course_rad), distance_m * math.sin(course_rad), sigma_m)
