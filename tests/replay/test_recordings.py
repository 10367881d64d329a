"""Cold starts on recordings of real traffic and real radar: how often, how well, and never wrong.

One scan alone, no own position, no heading. The bounds are floors, not what is reached: `docs/validation.md` has that.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from navfix import pipeline
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.report.truth import TruthTrack, with_truth


@dataclass(frozen=True)
class Outcome:
    scans: int
    fixes: int
    errors_m: np.ndarray
    held: float


def replayed(folder: Path, name: str, every: int) -> Outcome:
    """Solve every n-th scan alone, from nothing."""
    with (folder / f"{name}_truth.csv").open() as lines:
        track = TruthTrack.parse(lines)
    records = read_log(folder / f"{name}.nmea").records
    answers = [with_truth(pipeline.answer(epoch), track) for epoch in epochs(records, every=every)]
    known = [a for a in answers if a.truth is not None]
    fixed = [a for a in known if a.fix is not None]
    errors_m = np.array([a.truth.error_m for a in fixed if a.truth is not None])
    held = [
        e <= a.fix.integrity.r95_m if a.fix and a.fix.integrity else False for a, e in zip(fixed, errors_m, strict=True)
    ]
    return Outcome(len(known), len(fixed), errors_m, float(np.mean(held)) if held else 1.0)


@pytest.mark.parametrize(
    ("name", "every"),
    [("semi_real/dense_sf", 10), ("semi_real/coastal_hakefjord", 10), ("semi_real/moored_harlingen_atons", 2)],
)
def test_busy_traffic_is_solved_from_nearly_every_scan(shared_data: Path, name: str, every: int):
    outcome = replayed(shared_data, name, every)
    assert outcome.fixes >= 0.9 * outcome.scans
    assert np.median(outcome.errors_m) <= 30.0
    assert outcome.errors_m.max() <= 500.0


@pytest.mark.parametrize(("name", "every"), [("marce/marce_01_010", 3), ("marce/marce_01_004", 2)])
def test_real_radar_gives_few_fixes_and_none_that_is_wrong(shared_data: Path, name: str, every: int):
    outcome = replayed(shared_data, name, every)
    assert outcome.fixes > 0
    assert np.median(outcome.errors_m) <= 100.0
    assert outcome.errors_m.max() <= 1000.0


def test_a_radar_that_sees_hardly_any_ais_ship_is_always_refused(shared_data: Path):
    outcome = replayed(shared_data, "marce/marce_01_001", 2)
    assert outcome.scans >= 50
    assert outcome.fixes == 0
