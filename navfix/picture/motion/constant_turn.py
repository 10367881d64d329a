"""Constant rate of turn as the ship reports it (ROT): an arc."""

from __future__ import annotations

import math
from functools import partial

from navfix.catalog import AisModel, persisting_model
from navfix.picture.motion.constant_velocity import steered
from navfix.picture.motion.history import History
from navfix.picture.motion.outcome import Carried, Declined
from navfix.picture.motion.steering import Steering

LARGEST_TURN_RAD = math.pi


def carry(past: History, at_s: float, model: AisModel) -> Carried | Declined:
    """Carry the newest report along the arc of its rate of turn.

    Declines where the report tells no rate, one that no ship turns at (a saturated sensor), or where the ship would
    have turned round.
    """
    rate = past.turn_rate_rad_s
    if rate is None:
        return Declined("the report tells no rate of turn")
    if abs(rate) > persisting_model().fastest_turn_rad_s:
        return Declined(f"no ship turns at {math.degrees(rate) * 60.0:.0f}°/min")
    if abs(rate * (at_s - float(past.time_s[0]))) > LARGEST_TURN_RAD:
        return Declined("the ship would have turned by more than 180°: no turn lasts so long")
    return steered(past, at_s, model, partial(_arc_of, rate))


def arc(speed_mps: float, course_rad: float, rate_rad_s: float, age_s: float) -> tuple[float, float]:
    """Return the step (north, east) [m] along an arc: the chord 2 v/w sin(w t/2) along the mean course."""
    half_rad = 0.5 * rate_rad_s * age_s
    shortened = math.sin(half_rad) / half_rad if abs(half_rad) > 1e-9 else 1.0
    chord_m, mean_rad = speed_mps * age_s * shortened, course_rad + half_rad
    return chord_m * math.cos(mean_rad), chord_m * math.sin(mean_rad)


def _arc_of(rate_rad_s: float, steers: Steering, age_s: float) -> tuple[float, float]:
    return arc(steers.speed_mps, steers.course_rad, rate_rad_s, age_s)
