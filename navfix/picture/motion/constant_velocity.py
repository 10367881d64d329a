"""Constant speed and course: the plain model."""

from __future__ import annotations

import math
from collections.abc import Callable

from navfix.catalog import AisModel, persisting_model
from navfix.picture.motion.growth import drift_sigma_m, step_sigma_m, still_sigma_m
from navfix.picture.motion.history import History
from navfix.picture.motion.outcome import Carried
from navfix.picture.motion.steering import STILL_MPS, Steering, steering

Step = Callable[[Steering, float], tuple[float, float]]


def carry(past: History, at_s: float, model: AisModel) -> Carried:
    """Carry the newest report to an instant (backward where it is younger) with its speed and course over ground."""
    return steered(past, at_s, model, straight)


def steered(past: History, at_s: float, model: AisModel, step: Step) -> Carried:
    """Carry a ship by ``step``, which makes (north, east) [m] of its steering and the age [s].

    A ship without speed or course may have drifted at up to two knots; one that lies still swings.
    """
    age_s = at_s - float(past.time_s[0])
    steers = steering(past, persisting_model())
    if steers is None:
        return Carried(0.0, 0.0, drift_sigma_m(age_s, model))
    if steers.speed_mps <= STILL_MPS:
        return Carried(0.0, 0.0, still_sigma_m(age_s, model))
    north_m, east_m = step(steers, age_s)
    return Carried(north_m, east_m, step_sigma_m(steers, age_s, model))


def straight(steers: Steering, age_s: float) -> tuple[float, float]:
    """Return the step (north, east) [m] of constant speed and course."""
    way_m = steers.speed_mps * age_s
    return way_m * math.cos(steers.course_rad), way_m * math.sin(steers.course_rad)
