"""GNSS that goes wrong beside fixes of sliding windows, every one of them adjusted: 15 pairs, gyro and log, 60 s."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from navfix.adjustment.window import adjust_window
from navfix.integrity import GnssMonitor
from navfix.types import GnssReport
from tests.window_scenes import Errors, Passage, passage

STEP_S, SCANS = 3.0, 20
ERRORS = Errors(bearing_deg=0.5, steady=0.3)
Offset = Callable[[float], float]


def alarm_s(seed: int, quiet: int, scans: int, offset_m: Offset) -> tuple[float, int]:
    """Return the seconds from the offset's beginning to "unsafe" (inf: none), and the alarms before it."""
    rng = np.random.default_rng(seed)
    one = passage(rng, epochs=SCANS + quiet + scans, step_s=STEP_S, targets=15, errors=ERRORS)
    monitor, early, wander = GnssMonitor(), 0, 4.0 * rng.normal(size=2)
    pose = None
    for newest in range(SCANS - 1, len(one.epochs)):
        since_s = (newest - (SCANS - 1) - quiet) * STEP_S
        wander += -wander * STEP_S / 120.0 + 4.0 * math.sqrt(2.0 * STEP_S / 120.0) * rng.normal(size=2)
        fix = adjust_window(one.epochs[newest - SCANS + 1 : newest + 1], one.pairs, start=pose, solver="dense")
        pose = (fix.position, fix.heading_deg)
        verdict = monitor.feed(fix, gnss_at(one, newest, wander + 2.0 * rng.normal(size=2), offset_m(since_s)))
        assert verdict is not None
        if verdict.verdict == "unsafe":
            if since_s >= 0.0:
                return since_s, early
            early += 1
    return math.inf, early


def jump(since_s: float) -> float:
    """Return the offset [m] of GNSS that jumps by 200 m."""
    return 200.0 if since_s >= 0.0 else 0.0


def drag_off(since_s: float) -> float:
    """Return the offset [m] of GNSS that is dragged off with 1 m/s."""
    return max(0.0, since_s)


def quiet_hours(seed: int, scans: int) -> tuple[float, int]:
    """Return the hours of windows with GNSS as it should be, and the alarms in them."""
    return scans * STEP_S / 3600.0, alarm_s(seed, scans, 0, lambda _: 0.0)[1]


def gnss_at(one: Passage, epoch: int, error_m: np.ndarray, offset_m: float) -> GnssReport:
    """Return what GNSS says at an epoch: the truth, its own error, and the offset to north."""
    north_m, east_m = (one.truth[epoch, :2] + error_m + [offset_m, 0.0]).tolist()
    return GnssReport(one.plane.to_position(north_m, east_m), 8.0)
