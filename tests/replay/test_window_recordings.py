"""Windows and the navigator on recordings of real radar: the bounds are floors, what is reached is in the study."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from navfix import pipeline
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.report.truth import TruthTrack, with_truth
from navfix.types import Epoch


def windows(folder: Path, name: str, length_s: float, begins_s: list[float]) -> list[list[Epoch]]:
    scans = list(epochs(read_log(folder / f"{name}.nmea", report=False).records))
    after_s = np.array([(epoch.time_utc - scans[0].time_utc).total_seconds() for epoch in scans])
    return [[e for e, s in zip(scans, after_s, strict=True) if b <= s <= b + length_s] for b in begins_s]


def test_a_minute_of_real_radar_gives_a_place_where_a_scan_gives_none(shared_data: Path):
    with (shared_data / "marce/marce_01_004_truth.csv").open() as lines:
        track = TruthTrack.parse(lines)
    cut = windows(shared_data, "marce/marce_01_004", 60.0, [0.0, 60.0, 120.0, 180.0, 240.0, 280.0])
    answers = [with_truth(pipeline.answer_of_window(window), track) for window in cut]
    fixed = [a for a in answers if a.fix is not None]
    assert len(fixed) >= 4
    assert max(a.truth.error_m for a in fixed) <= 150.0
    assert np.mean([a.truth.error_m <= a.fix.integrity.r95_m for a in fixed]) >= 0.6


def test_a_radar_that_sees_hardly_any_ais_ship_is_refused_however_long_it_looks(shared_data: Path):
    for length_s in (60.0, 120.0):
        for window in windows(shared_data, "marce/marce_01_001", length_s, [0.0, 110.0, 220.0]):
            assert pipeline.answer_of_window(window).fix is None
