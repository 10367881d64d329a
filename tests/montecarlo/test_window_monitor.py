"""The monitor of GNSS fed with fixes of sliding windows, every one of them adjusted: 15 pairs, gyro and log, 60 s."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

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


def gnss_at(one: Passage, epoch: int, error_m: np.ndarray, offset_m: float) -> GnssReport:
    north_m, east_m = (one.truth[epoch, :2] + error_m + [offset_m, 0.0]).tolist()
    return GnssReport(one.plane.to_position(north_m, east_m), 8.0)


def test_a_jump_of_200_m_alarms_at_the_second_turn() -> None:
    assert alarm_s(1, 6, 4, lambda since: 200.0 if since >= 0.0 else 0.0) == (STEP_S, 0)


@pytest.mark.study
def test_study_of_jump_and_drag_off_with_windows() -> None:
    jumps = [alarm_s(seed, 10, 6, lambda since: 200.0 if since >= 0.0 else 0.0) for seed in range(20)]
    drags = [alarm_s(seed, 100, 50, lambda since: max(0.0, since)) for seed in range(8)]
    for name, found in (("jump 200 m", jumps), ("drag 1 m/s", drags)):
        times = np.array([alarm for alarm, _ in found])
        print(
            f"{name}: median {np.median(times):.0f} s, most {times.max():.0f} s; before it {sum(e for _, e in found)}"
        )
    assert max(alarm for alarm, _ in jumps) <= STEP_S
    assert max(alarm for alarm, _ in drags) <= 120.0
    assert sum(early for _, early in (*jumps, *drags)) == 0


@pytest.mark.study
def test_study_of_hours_without_a_false_alarm() -> None:
    hours = 0.0
    for seed in range(12):
        found, early = alarm_s(500 + seed, 200, 0, lambda _: 0.0)
        hours += 200 * STEP_S / 3600.0
        assert math.isinf(found)
        assert early == 0
    print(f"{hours:.1f} simulated hours of windows without an alarm")
