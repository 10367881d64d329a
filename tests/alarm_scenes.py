"""GNSS that goes wrong beside fixes of windows with known pairs, or of the navigator: 15 pairs, gyro, log, 60 s."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from navfix.adjustment.window import adjust_window
from navfix.integrity import GnssMonitor
from navfix.pipeline import watched
from navfix.sequence import Navigator
from navfix.sequence.answers import navigated
from navfix.types import GnssReport
from tests.window_scenes import Errors, Passage, passage

STEP_S, SCANS = 3.0, 20
COLD_SCANS = 60  # by then the navigator holds its place
ERRORS = Errors(bearing_deg=0.5, steady=0.3)
Offset = Callable[[float], float]
Alarm = Callable[[int, int, int, Offset], tuple[float, int]]


def alarm_s(seed: int, quiet: int, scans: int, offset_m: Offset) -> tuple[float, int]:
    """Return the seconds from the offset's beginning to "unsafe" (inf: none), and the alarms before it."""
    one, gnss_errors = _passage(seed, SCANS + quiet + scans)
    monitor, early = GnssMonitor(), 0
    pose = None
    for newest in range(SCANS - 1, len(one.epochs)):
        since_s = (newest - (SCANS - 1) - quiet) * STEP_S
        fix = adjust_window(one.epochs[newest - SCANS + 1 : newest + 1], one.pairs, start=pose, solver="dense")
        pose = (fix.position, fix.heading_deg)
        verdict = monitor.feed(fix, gnss_at(one, newest, gnss_errors[newest], offset_m(since_s)))
        assert verdict is not None
        if verdict.verdict == "unsafe":
            if since_s >= 0.0:
                return since_s, early
            early += 1
    return math.inf, early


def navigator_alarm_s(seed: int, quiet: int, scans: int, offset_m: Offset) -> tuple[float, int]:
    """Return the same of the whole navigator, which finds the pairs itself; quiet scans count once it has a place."""
    one, gnss_errors = _passage(seed, COLD_SCANS + quiet + scans)
    navigator, monitor, early = Navigator(), GnssMonitor(), 0
    for newest, scan in enumerate(one.epochs):
        since_s = (newest - COLD_SCANS - quiet) * STEP_S
        seen = replace(scan, gnss=gnss_at(one, newest, gnss_errors[newest], offset_m(since_s)))
        navigator.feed(seen)
        verdict = watched(navigated(navigator, seen), monitor).gnss
        if verdict is not None and verdict.verdict == "unsafe":
            if since_s >= 0.0:
                return since_s, early
            early += 1
    return math.inf, early


def _passage(seed: int, epochs: int) -> tuple[Passage, np.ndarray]:
    """Return a passage and the error of GNSS (epochs, 2) [m]: 4 m that wander within two minutes, and 2 m of noise."""
    rng = np.random.default_rng(seed)
    one = passage(rng, epochs=epochs, step_s=STEP_S, targets=15, errors=ERRORS)
    keeps = 1.0 - STEP_S / 120.0
    wander = 4.0 * rng.normal(size=2)
    found = []
    for _ in range(epochs):
        wander = keeps * wander + 4.0 * math.sqrt(1.0 - keeps**2) * rng.normal(size=2)
        found.append(wander + 2.0 * rng.normal(size=2))
    return one, np.array(found)


def jump(since_s: float) -> float:
    """Return the offset [m] of GNSS that jumps by 200 m."""
    return 200.0 if since_s >= 0.0 else 0.0


def drag_off(since_s: float) -> float:
    """Return the offset [m] of GNSS that is dragged off with 1 m/s."""
    return max(0.0, since_s)


def quiet_hours(seed: int, scans: int, alarm: Alarm = alarm_s) -> tuple[float, int]:
    """Return the hours of windows with GNSS as it should be, and the alarms in them."""
    return scans * STEP_S / 3600.0, alarm(seed, scans, 0, lambda _: 0.0)[1]


def gnss_at(one: Passage, epoch: int, error_m: np.ndarray, offset_m: float) -> GnssReport:
    """Return what GNSS says at an epoch: the truth, its own error, and the offset to north."""
    north_m, east_m = (one.truth[epoch, :2] + error_m + [offset_m, 0.0]).tolist()
    return GnssReport(one.plane.to_position(north_m, east_m), 8.0)
