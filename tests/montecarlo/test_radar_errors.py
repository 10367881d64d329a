"""The radar's clock and range bias over minutes, single scans of simulated logs: found where there, else left alone."""

from __future__ import annotations

import numpy as np
import pytest

from tests.radar_error_scenes import Passage, passage

LEARNT = 2  # scans that the estimate needs


def median_m(found: list[Passage]) -> float:
    return float(np.median([error for one in found for error in one.errors_m[LEARNT:]]))


def test_both_errors_are_found_together_and_the_fix_gains() -> None:
    left, taken = (passage(1, clock_s=7.0, bias_m=60.0, correct=correct, every=8) for correct in (False, True))
    assert taken.radar.clock.value == pytest.approx(7.0, abs=3.0 * taken.radar.clock.sigma)
    assert taken.radar.ranges.value == pytest.approx(60.0, abs=3.0 * taken.radar.ranges.sigma)
    assert taken.radar.ranges.applied != 0.0
    assert len(taken.errors_m) >= len(left.errors_m)
    assert median_m([taken]) < median_m([left])


@pytest.mark.study
@pytest.mark.parametrize(("clock_s", "bias_m"), [(0.0, 0.0), (7.0, 0.0), (0.0, 60.0), (7.0, 60.0)])
def test_study_of_gain_and_false_alarms(clock_s: float, bias_m: float) -> None:
    seeds = range(1, 9)
    left, taken = (
        [passage(s, clock_s=clock_s, bias_m=bias_m, correct=c, every=8) for s in seeds] for c in (False, True)
    )
    pulls = np.array(
        [
            (
                (t.radar.clock.value - clock_s) / t.radar.clock.sigma,
                (t.radar.ranges.value - bias_m) / t.radar.ranges.sigma,
            )
            for t in taken
        ]
    )
    applied = np.array([(t.radar.clock.applied != 0.0, t.radar.ranges.applied != 0.0) for t in taken]).sum(axis=0)
    held = [100.0 * np.mean([h for one in found for h in one.held]) for found in (left, taken)]
    fixes = [sum(len(one.errors_m) for one in found) for found in (left, taken)]
    print(
        f"clock {clock_s:+.0f} s, ranges {bias_m:+.0f} m: fixes {fixes[0]} -> {fixes[1]}, median error "
        f"{median_m(left):.1f} -> {median_m(taken):.1f} m, ellipse holds {held[0]:.0f} -> {held[1]:.0f} %, "
        f"taken off in {applied[0]} and {applied[1]} of {len(seeds)}, pulls: mean {pulls.mean(axis=0).round(2)}, "
        f"rms {np.sqrt(np.mean(pulls**2, axis=0)).round(2)}"
    )
    assert median_m(taken) <= median_m(left) + 1.0
    assert np.sqrt(np.mean(pulls**2, axis=0)).max() < 1.6
    if clock_s == bias_m == 0.0:
        assert applied.max() <= 1
