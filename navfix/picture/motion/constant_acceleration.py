"""Constant change of speed along a constant course, until the ship has stopped."""

from __future__ import annotations

import math

import numpy as np

from navfix.catalog import AisModel
from navfix.picture.motion.constant_velocity import steered
from navfix.picture.motion.history import History
from navfix.picture.motion.outcome import Carried, Declined
from navfix.picture.motion.steering import Steering
from navfix.units import KNOT_MPS

FASTEST_MPS = 60.0 * KNOT_MPS


def carry(past: History, at_s: float, model: AisModel) -> Carried | Declined:
    """Carry the newest report with the change of speed of the last seconds; declines without two reported speeds."""
    if np.count_nonzero(np.isfinite(past.speed_mps)) < 2:
        return Declined("a change of speed needs two reports with a speed")
    return steered(past, at_s, model, accelerated)


def accelerated(steers: Steering, age_s: float) -> tuple[float, float]:
    """Return the step (north, east) [m] with constant acceleration, the speed staying within 0 and 60 knots."""
    speed, growth = steers.speed_mps, steers.acceleration_mps2
    until_s = age_s
    if growth * age_s < 0.0:
        until_s = math.copysign(min(abs(age_s), speed / abs(growth)), age_s)  # it has stopped, or had not started yet
    elif growth != 0.0:
        until_s = math.copysign(min(abs(age_s), max(FASTEST_MPS - speed, 0.0) / abs(growth)), age_s)
    way_m = speed * until_s + 0.5 * growth * until_s**2
    if growth * age_s > 0.0:
        way_m += FASTEST_MPS * (age_s - until_s)
    return way_m * math.cos(steers.course_rad), way_m * math.sin(steers.course_rad)
