"""Cubic spline through the reports on both sides of an instant: for replays, where the future is known."""

from __future__ import annotations

import math

import numpy as np

from navfix.catalog import AisModel
from navfix.picture.motion.growth import step_sigma_m
from navfix.picture.motion.history import History
from navfix.picture.motion.outcome import Carried, Declined
from navfix.picture.motion.steering import Steering
from navfix.types import FloatArray

LEAST_REPORTS = 4
NEIGHBOURS = 4  # reports on each side that shape the curve
FASTEST_MPS = 31.0  # 60 kn: between reports that would need more, one is wrong


def carry(past: History, at_s: float, model: AisModel) -> Carried | Declined:
    """Return the step from the newest report to the spline at an instant between reports.

    The curve is a natural cubic spline of north and east over time, twice continuously differentiable. Its sigma is
    that of a prediction from the report before and one from the report after, joined: 1/s^2 = 1/s1^2 + 1/s2^2.
    """
    if len(past) < LEAST_REPORTS:
        return Declined(f"a spline needs {LEAST_REPORTS} reports, there are {len(past)}")
    time_s = past.time_s[::-1]
    after = int(np.searchsorted(time_s, at_s))
    if after == 0 or after == len(time_s):
        return Declined("a spline needs a report on each side of the instant")
    near = slice(max(after - NEIGHBOURS, 0), after + NEIGHBOURS)
    knots_s, north_m, east_m = time_s[near], past.north_m[::-1][near], past.east_m[::-1][near]
    speeds_mps = np.hypot(np.diff(north_m), np.diff(east_m)) / np.diff(knots_s)
    if len(knots_s) < LEAST_REPORTS or speeds_mps.max() > FASTEST_MPS:
        return Declined("the reports about the instant do not belong to one track")
    north, east = curve(knots_s, np.column_stack([north_m, east_m]), at_s)
    steers = Steering(float(speeds_mps.mean()), 0.0, span_s=math.inf)
    sigmas = [step_sigma_m(steers, at_s - float(time_s[side]), model) for side in (after - 1, after)]
    return Carried(float(north), float(east), 1.0 / math.hypot(1.0 / sigmas[0], 1.0 / sigmas[1]))


def curve(knots_s: FloatArray, values: FloatArray, at_s: float) -> tuple[float, ...]:
    """Return the natural cubic spline through values (n, m) at a time: C2, and straight beyond its ends."""
    from scipy.interpolate import CubicSpline  # costs a third of a second to import

    return tuple(CubicSpline(knots_s, values, bc_type="natural")(at_s))
