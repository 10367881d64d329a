"""A ship that manoeuvres by legs: straight, faster or slower, to starboard or to port; the scenario of a source."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.errors import InputError
from navfix.geodesy import direct
from navfix.types import FloatArray, Position
from navfix.units import KNOT_MPS

FASTEST_MPS = 60.0 * KNOT_MPS  # limits of the source: 60 knots, 2 g
STRONGEST_MPS2 = 2.0 * 9.80665
_SUBSTEP_S = 1.0


@dataclass(frozen=True, slots=True)
class Leg:
    """A piece of the way: how long [s], change of speed [m/s^2], rate of turn [rad/s, to starboard positive]."""

    duration_s: float
    acceleration_mps2: float = 0.0
    turn_rate_rad_s: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Truth at each period: arrays of one length; courses are not wrapped."""

    time_s: FloatArray
    lat_deg: FloatArray
    lon_deg: FloatArray
    speed_mps: FloatArray
    course_rad: FloatArray
    turn_rate_rad_s: FloatArray


_QUARTER = math.radians(90.0) / 300.0
# Correction of AIS tracks by the unscented Kalman filter, 3.1: 180 periods of 10 s.
SOURCE_LEGS = (
    Leg(350.0),
    Leg(100.0, acceleration_mps2=0.1),
    Leg(150.0, acceleration_mps2=-0.1),
    Leg(300.0, turn_rate_rad_s=_QUARTER),
    Leg(300.0, turn_rate_rad_s=-_QUARTER),
    Leg(100.0, acceleration_mps2=0.1),
    Leg(500.0),
)
SOURCE_START = Position(40.0, 100.0)


def run(
    legs: Sequence[Leg],
    *,
    period_s: float,
    start: Position = SOURCE_START,
    speed_mps: float = 10.0,
    course_deg: float = 45.0,
) -> Run:
    """Sail the legs on the ellipsoid; return the truth at the start and after each period.

    Raises
    ------
    InputError : faster than 60 knots, backward, or more than 2 g along and across together
    """
    place, speed, course, time_s = start, speed_mps, math.radians(course_deg), 0.0
    rows = [(time_s, place.lat_deg, place.lon_deg, speed, course, legs[0].turn_rate_rad_s if legs else 0.0)]
    for leg in legs:
        periods = round(leg.duration_s / period_s)
        for _ in range(periods):
            place, speed, course = _sail(leg, place, speed, course, period_s)
            time_s += period_s
            rows.append((time_s, place.lat_deg, place.lon_deg, speed, course, leg.turn_rate_rad_s))
        _check(leg, speed)
    return Run(*np.array(rows).T)


def _sail(leg: Leg, place: Position, speed: float, course: float, period_s: float) -> tuple[Position, float, float]:
    steps = max(1, round(period_s / _SUBSTEP_S))
    step_s = period_s / steps
    for _ in range(steps):
        middle_deg = math.degrees(course + 0.5 * leg.turn_rate_rad_s * step_s)
        place = direct(place, middle_deg, (speed + 0.5 * leg.acceleration_mps2 * step_s) * step_s)
        speed += leg.acceleration_mps2 * step_s
        course += leg.turn_rate_rad_s * step_s
    return place, speed, course


def _check(leg: Leg, speed_mps: float) -> None:
    strength = math.hypot(leg.acceleration_mps2, leg.turn_rate_rad_s * speed_mps)
    if not -1e-9 <= speed_mps <= FASTEST_MPS or strength > STRONGEST_MPS2:
        raise InputError(
            f"a ship makes 0 to 60 kn and at most 2 g, got {speed_mps / KNOT_MPS:.1f} kn and {strength:.2f} m/s^2"
        )
