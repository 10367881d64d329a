"""What the visible side of hulls brings on recordings whose echoes lie on the side that own ship sees."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from navfix import adjust, associate
from navfix.adjustment.visible_side import adjust_visible_side
from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.report.truth import TruthTrack
from navfix.types import Position


def test_marks_at_the_visible_side_lower_the_median_error_by_a_quarter(shared_data: Path) -> None:
    """The same pairs with hulls' centres and with their visible sides, from scans 50 s apart."""
    with (shared_data / "semi_real/dense_sf_truth.csv").open() as lines:
        track = TruthTrack.parse(lines)
    centre_m, side_m = [], []
    for epoch in epochs(read_log(shared_data / "semi_real/dense_sf.nmea").records, every=20):
        truth = track.at(epoch.time_utc.timestamp()) if epoch.time_utc else None
        if truth is None:
            continue
        try:
            pairs = associate(epoch)
            places = adjust(epoch, pairs).position, adjust_visible_side(epoch, pairs).position
        except NoFix:
            continue
        for place, errors_m in zip(places, (centre_m, side_m), strict=True):
            assert isinstance(place, Position)
            errors_m.append(inverse(truth.position, place)[0])
    assert len(side_m) >= 25
    assert np.median(side_m) <= 0.75 * np.median(centre_m)
