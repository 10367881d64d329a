"""Persisting motion, the default: turn and change of speed go on as they were lately, and fade."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from navfix.catalog import AisModel, PersistingModel, persisting_model
from navfix.picture.motion.constant_velocity import steered
from navfix.picture.motion.history import History
from navfix.picture.motion.outcome import Carried
from navfix.picture.motion.steering import Steering

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_FADED = 3.0  # after so many time constants the rest of the way is straight enough for one panel


def carry(past: History, at_s: float, model: AisModel) -> Carried:
    """Carry the newest report to an instant; a single report is carried straight on."""
    return steered(past, at_s, model, partial(faded, persisting_model()))


def faded(constants: PersistingModel, steers: Steering, age_s: float) -> tuple[float, float]:
    """Return the step (north, east) [m] (theory, eq. 13.1 to 13.3), by Gauss-Legendre quadrature in two panels."""
    bend_s = math.copysign(min(abs(age_s), _FADED * constants.speed_persist_s), age_s)
    north_m = east_m = 0.0
    for start_s, end_s in ((0.0, bend_s), (bend_s, age_s)):
        if start_s == end_s:
            continue
        half_s = 0.5 * (end_s - start_s)
        u = start_s + half_s * (1.0 + _NODES)
        reach = np.abs(u)
        turn = steers.turn_rate_rad_s * constants.turn_persist_s
        course = steers.course_rad + np.sign(u) * turn * -np.expm1(-reach / constants.turn_persist_s)
        course += steers.turn_rate_rad_s * constants.lag_s
        gain = steers.acceleration_mps2 * constants.speed_persist_s
        speed = steers.speed_mps + np.sign(u) * gain * -np.expm1(-reach / constants.speed_persist_s)
        speed = np.maximum(speed + steers.acceleration_mps2 * constants.lag_s, 0.0)
        way = half_s * _WEIGHTS * speed * np.exp(-reach / constants.way_persist_s)
        north_m += float(way @ np.cos(course))
        east_m += float(way @ np.sin(course))
    return north_m, east_m
