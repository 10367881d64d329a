"""Errors common to all observations over minutes: radar clock, range bias; found, refused, with an honest sigma."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix.adjustment import adjust
from navfix.geodesy import direct, inverse
from navfix.sequence.clock import ClockOffset, with_offset
from navfix.sequence.radar_errors import RadarErrors
from navfix.sequence.range_bias import RangeBias, with_bias
from navfix.types import Association, Epoch, Fix, Mark, Position, RadarTarget

OWN = Position(54.0, 8.0)
START = datetime(2026, 3, 1, tzinfo=UTC)


def fixes(
    seed: int,
    *,
    azimuths_deg,
    clock_s: float = 0.0,
    bias_m: float = 0.0,
    epochs: int = 40,
    ship_sigma_m: float = 15.0,
    speed_mps: float = 7.0,
) -> list[Fix]:
    """Fix own ship from the same ships again and again; each ship's echo keeps its own offset (hull)."""
    rng = np.random.default_rng(seed)
    azimuths = np.asarray(azimuths_deg, dtype=float)
    ranges, courses = rng.uniform(2000.0, 8000.0, len(azimuths)), rng.uniform(0.0, 360.0, len(azimuths))
    speeds = rng.uniform(0.5, 1.5, len(azimuths)) * speed_mps
    hull = rng.normal(0.0, ship_sigma_m, (len(azimuths), 2))
    found = []
    for k in range(epochs):
        marks, targets = [], []
        for i in range(len(azimuths)):
            start = direct(OWN, azimuths[i], ranges[i])
            truth = direct(start, courses[i], speeds[i] * 3.0 * k)
            marks.append(Mark(f"M{i}", truth, 20.0, speed_mps=float(speeds[i]), course_deg=float(courses[i])))
            echo = direct(truth, courses[i] + 180.0, speeds[i] * clock_s)
            echo = direct(echo, math.degrees(math.atan2(hull[i, 1], hull[i, 0])), math.hypot(*hull[i]))
            range_m, azimuth_deg = inverse(OWN, echo)
            noise = rng.normal(size=2) * [15.0, 0.4]
            bearing = azimuth_deg - 30.0 + noise[1]
            targets.append(
                RadarTarget(f"{i:02d}", range_m + bias_m + noise[0], bearing, range_sigma_m=15.0, bearing_sigma_deg=0.4)
            )
        epoch = Epoch(START + timedelta(seconds=3.0 * k), tuple(targets), tuple(marks))
        pairs = [(i, i) for i in range(len(azimuths))]
        found.append(adjust(epoch, Association.from_pairs(epoch, pairs)))
    return found


RING = np.arange(0.0, 360.0, 36.0)
SECTOR = np.linspace(-10.0, 10.0, 10)


def estimated(kind, found: list[Fix]):
    estimator = kind()
    for fix in found:
        estimator.feed(fix)
    return estimator


@pytest.mark.parametrize("clock_s", [-7.0, 4.0])
def test_moving_ships_tell_the_radar_clock_and_the_marks_are_set_back(clock_s: float):
    found = fixes(3, azimuths_deg=RING, clock_s=clock_s, epochs=8)
    clock = estimated(ClockOffset, found)
    answer = clock.estimate()
    assert answer.value == pytest.approx(clock_s, abs=3.0 * answer.sigma)
    assert answer.significant
    assert answer.sigma < 1.5
    before = [inverse(OWN, f.position)[0] for f in found]
    again = []
    for fix in found:
        epoch = with_offset(fix.epoch, clock.offset_s)
        again.append(inverse(OWN, adjust(epoch, Association.from_pairs(epoch, fix.association.pairs)).position)[0])
    assert np.median(again) < np.median(before)


def test_ships_that_lie_still_say_nothing_of_the_clock():
    answer = estimated(ClockOffset, fixes(4, azimuths_deg=RING, clock_s=-7.0, epochs=3, speed_mps=0.2)).estimate()
    assert not answer.significant
    assert answer.sigma == math.inf


def test_the_sigma_of_the_clock_holds_the_truth_as_often_as_it_says():
    """Offsets that stay with a ship are no fresh evidence in every scan: 30 runs without any clock offset."""
    answers = [estimated(ClockOffset, fixes(s, azimuths_deg=RING, epochs=2)).estimate() for s in range(30)]
    assert sum(a.significant for a in answers) <= 4
    spread = np.std([a.value / a.sigma for a in answers])
    assert 0.6 < spread < 1.6


def test_a_ring_of_marks_tells_the_range_bias_from_the_position():
    answer = estimated(RangeBias, fixes(5, azimuths_deg=RING, bias_m=60.0, epochs=8)).estimate()
    assert answer.significant
    assert answer.separable > 0.5
    assert answer.value == pytest.approx(60.0, abs=3.0 * answer.sigma)


def test_a_sector_does_not_and_says_so():
    estimator = estimated(RangeBias, fixes(6, azimuths_deg=SECTOR, bias_m=60.0, epochs=5))
    answer = estimator.estimate()
    assert not answer.significant
    assert answer.separable < 0.1
    assert "position explains it" in answer.reason
    assert estimator.bias_m == 0.0


def test_the_bias_is_taken_off_all_ranges_and_nothing_else():
    epoch = fixes(7, azimuths_deg=RING, epochs=1)[0].epoch
    less = with_bias(epoch, 25.0)
    assert [t.range_m for t in less.targets] == pytest.approx([t.range_m - 25.0 for t in epoch.targets])
    assert with_bias(epoch, 0.0) is epoch
    assert with_offset(epoch, 0.0) is epoch


def test_before_any_fix_there_is_no_estimate_and_nothing_is_applied():
    assert ClockOffset().estimate() is None
    assert ClockOffset().offset_s == 0.0
    assert RangeBias().bias_m == 0.0
    lone = RangeBias()
    lone.feed(replace(fixes(8, azimuths_deg=RING, epochs=1)[0], epoch=None))
    assert lone.estimate() is None


def test_what_is_taken_off_is_counted_in_the_estimate_and_told():
    errors, off = RadarErrors(), []
    for fix in fixes(9, azimuths_deg=RING, clock_s=-6.0, bias_m=80.0, epochs=8):
        epoch = errors.corrected(fix.epoch)
        again = adjust(epoch, Association.from_pairs(epoch, fix.association.pairs))
        off.append(inverse(OWN, again.position)[0])
        errors.feed(again)
    clock, ranges = errors.clock.estimate(), errors.ranges.estimate()
    assert clock.value == pytest.approx(-6.0, abs=3.0 * clock.sigma)
    assert ranges.value == pytest.approx(80.0, abs=3.0 * ranges.sigma)
    assert errors.clock.offset_s == clock.value
    told = errors.notes()
    assert "radar clock minus AIS: -" in told[0]
    assert told[0].endswith("applied")
    assert "range bias: +" in told[1]
    assert RadarErrors().notes()[0] == "radar clock minus AIS: no fix yet"


def test_an_error_that_cannot_be_seen_is_told_as_such():
    errors = RadarErrors()
    for fix in fixes(6, azimuths_deg=SECTOR, bias_m=60.0, epochs=2):
        errors.feed(fix)
    assert errors.notes()[1].startswith("range bias: not observable (the position explains it")
