"""Errors common to all observations over minutes: radar clock, range bias; found, refused, with an honest sigma."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix.adjustment import adjust
from navfix.geodesy import LocalPlane, direct, inverse
from navfix.integrity import with_integrity
from navfix.report.radar_errors import radar_errors_to_dict, radar_errors_words
from navfix.sequence.clock import with_offset
from navfix.sequence.radar_errors import RadarErrorsOverTime
from navfix.sequence.range_bias import with_bias
from navfix.types import Association, Epoch, Fix, GnssReport, Mark, Position, RadarErrors, RadarTarget

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
    step_s: float = 3.0,
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
            truth = direct(start, courses[i], speeds[i] * step_s * k)
            marks.append(Mark(f"M{i}", truth, 20.0, speed_mps=float(speeds[i]), course_deg=float(courses[i])))
            echo = direct(truth, courses[i] + 180.0, speeds[i] * clock_s)
            echo = direct(echo, math.degrees(math.atan2(hull[i, 1], hull[i, 0])), math.hypot(*hull[i]))
            range_m, azimuth_deg = inverse(OWN, echo)
            noise = rng.normal(size=2) * [15.0, 0.4]
            bearing = azimuth_deg - 30.0 + noise[1]
            targets.append(
                RadarTarget(f"{i:02d}", range_m + bias_m + noise[0], bearing, range_sigma_m=15.0, bearing_sigma_deg=0.4)
            )
        epoch = Epoch(START + timedelta(seconds=step_s * k), tuple(targets), tuple(marks))
        pairs = [(i, i) for i in range(len(azimuths))]
        found.append(adjust(epoch, Association.from_pairs(epoch, pairs)))
    return found


RING = np.arange(0.0, 360.0, 36.0)
SECTOR = np.linspace(-10.0, 10.0, 10)


def estimated(found: list[Fix]) -> RadarErrors:
    errors = RadarErrorsOverTime()
    for fix in found:
        errors.feed(fix)
    return errors.estimate()


def again(fix: Fix, epoch: Epoch) -> Fix:
    """Return the fix of the same pairs in a corrected epoch."""
    return adjust(epoch, Association.from_pairs(epoch, fix.association.pairs))


@pytest.mark.parametrize(("clock_s", "bias_m"), [(-7.0, 60.0), (6.0, -80.0)])
def test_a_ring_of_moving_ships_tells_clock_and_range_bias_together(clock_s: float, bias_m: float):
    found = estimated(fixes(3, azimuths_deg=RING, clock_s=clock_s, bias_m=bias_m, epochs=8))
    assert found.clock.value == pytest.approx(clock_s, abs=3.0 * found.clock.sigma)
    assert found.ranges.value == pytest.approx(bias_m, abs=3.0 * found.ranges.sigma)
    assert found.clock.significant
    assert found.ranges.significant
    assert found.clock.sigma < 2.0
    assert found.ranges.sigma < 20.0


def test_ships_that_lie_still_say_nothing_of_the_clock():
    found = estimated(fixes(4, azimuths_deg=RING, clock_s=-7.0, bias_m=100.0, epochs=3, speed_mps=0.2))
    assert not found.clock.observable
    assert "too few ships move" in found.clock.reason
    assert found.ranges.significant


def test_the_sigmas_hold_the_truth_as_often_as_they_say():
    """Offsets that stay with a ship are no fresh evidence in every scan: 40 runs without any error of the radar."""
    answers = [estimated(fixes(s, azimuths_deg=RING, epochs=2)) for s in range(40)]
    assert sum(a.clock.significant for a in answers) <= 2
    assert sum(a.ranges.significant for a in answers) <= 2
    for values in (
        [a.clock.value / a.clock.sigma for a in answers],
        [a.ranges.value / a.ranges.sigma for a in answers],
    ):
        assert 0.5 < np.std(values) < 1.3


def test_a_sector_tells_no_range_bias_and_says_so():
    found = estimated(fixes(6, azimuths_deg=SECTOR, bias_m=60.0, epochs=5)).ranges
    assert not found.observable
    assert found.separable < 0.1
    assert "position explains it" in found.reason


def test_three_ships_of_which_one_tells_nearly_all_are_too_few():
    found = estimated(fixes(5, azimuths_deg=[0.0, 120.0, 240.0], bias_m=60.0, epochs=3))
    assert not found.ranges.observable
    assert found.ranges.marks < 3.0


def test_an_error_that_changes_is_followed():
    """Half an hour without a range bias, half an hour with one: the memory fades."""
    errors = RadarErrorsOverTime()
    before = fixes(11, azimuths_deg=RING, epochs=15, step_s=120.0, speed_mps=0.0)
    after = fixes(11, azimuths_deg=RING, epochs=30, step_s=120.0, speed_mps=0.0, bias_m=90.0)[15:]
    for fix in [*before, *after]:
        errors.feed(fix)
    found = errors.estimate().ranges
    assert found.value == pytest.approx(90.0, abs=3.0 * found.sigma)
    assert found.sigma < 20.0


def test_ships_long_gone_are_dropped_and_what_they_said_is_not_missed():
    """Half a day of passing ships: other ones every hour."""
    errors, scenes = RadarErrorsOverTime(), fixes(11, azimuths_deg=RING, epochs=2, speed_mps=0.0, bias_m=90.0)
    for hour in range(12):
        for fix in scenes:
            renamed = tuple(replace(m, label=f"{hour}-{m.label}") for m in fix.epoch.marks)
            seen = tuple(replace(o, mark=f"{hour}-{o.mark}") for o in fix.observations)
            later = fix.epoch.time_utc + timedelta(hours=hour)
            errors.feed(replace(fix, observations=seen, epoch=replace(fix.epoch, marks=renamed, time_utc=later)))
    assert len(errors._errors._voices) == len(RING)
    found, alone = errors.estimate().ranges, estimated(scenes).ranges
    assert found.value == pytest.approx(alone.value, abs=0.1 * alone.sigma)
    assert found.sigma == pytest.approx(alone.sigma, rel=0.1)


def test_what_is_taken_off_is_counted_in_the_estimate_and_told():
    errors, off, applied = RadarErrorsOverTime(), [], []
    for fix in fixes(9, azimuths_deg=RING, clock_s=-6.0, bias_m=80.0, epochs=12):
        better = again(fix, errors.corrected(fix.epoch))
        off.append(inverse(OWN, better.position)[0])
        errors.feed(better)
        applied.append(errors.estimate().clock.applied)
    found = errors.estimate()
    assert found.clock.value == pytest.approx(-6.0, abs=3.0 * found.clock.sigma)
    assert found.ranges.value == pytest.approx(80.0, abs=3.0 * found.ranges.sigma)
    assert np.abs(np.diff(applied)).max() <= 1.5 + 1e-9, "the clock is slewed, time must not run backward"
    told = radar_errors_words(found)
    assert told[0].startswith("radar clock minus AIS clock: -")
    assert told[0].endswith("taken off")
    assert told[1].startswith("radar range bias: +")
    assert radar_errors_to_dict(found)["range"]["applied_m"] == pytest.approx(found.ranges.applied, rel=1e-6)


def test_windows_keep_their_own_clock_and_only_ranges_are_corrected():
    errors = RadarErrorsOverTime(windows=True)
    for fix in fixes(9, azimuths_deg=RING, clock_s=-6.0, bias_m=80.0, epochs=8):
        errors.feed(again(fix, errors.corrected(fix.epoch)))
    found = errors.estimate()
    assert found.clock.significant
    assert found.clock.applied == 0.0
    assert found.ranges.applied == pytest.approx(80.0, abs=30.0)
    assert "left to the windows" in radar_errors_words(found, windows=True)[0]


def test_only_reported_means_untouched():
    errors = RadarErrorsOverTime(correct=False)
    for fix in fixes(9, azimuths_deg=RING, clock_s=-6.0, bias_m=80.0, epochs=8):
        assert errors.corrected(fix.epoch) is fix.epoch
        errors.feed(fix)
    assert errors.estimate().ranges.significant


def test_the_bias_is_taken_off_all_ranges_and_nothing_else():
    epoch = fixes(7, azimuths_deg=RING, epochs=1)[0].epoch
    less = with_bias(epoch, 25.0)
    assert [t.range_m for t in less.targets] == pytest.approx([t.range_m - 25.0 for t in epoch.targets])
    assert with_bias(epoch, 0.0) is epoch


def test_the_clock_sets_moving_marks_back_and_makes_the_gnss_less_sure():
    epoch = replace(fixes(7, azimuths_deg=RING, epochs=1)[0].epoch, gnss=GnssReport(OWN, 5.0))
    mark, moved = epoch.marks[0], with_offset(epoch, 4.0)
    way_m, course_deg = inverse(moved.marks[0].position, mark.position)
    assert way_m == pytest.approx(4.0 * mark.speed_mps, rel=1e-6)
    assert course_deg % 360.0 == pytest.approx(mark.course_deg, abs=0.01)
    assert moved.time_utc == epoch.time_utc - timedelta(seconds=4.0)
    assert moved.gnss.sigma_m == pytest.approx(math.hypot(5.0, 32.0))
    assert with_offset(epoch, 0.0) is epoch


def test_before_any_fix_nothing_is_known_and_nothing_applied():
    errors = RadarErrorsOverTime()
    errors.feed(None)
    errors.feed(replace(fixes(8, azimuths_deg=RING, epochs=1)[0], epoch=None))
    found = errors.estimate()
    assert not found.clock.observable
    assert found.ranges.fixes == 0
    assert radar_errors_to_dict(found)["clock"]["value_s"] is None
    assert radar_errors_words(found)[1].startswith("radar range bias: not observable (too few marks")
    assert radar_errors_to_dict(None) is None


HALF = np.linspace(-100.0, 100.0, 11)


def corrected_and_plain(**truth: float) -> tuple[RadarErrorsOverTime, Fix]:
    """Return the estimator after a minute with ships on one side, and the newest fix with the errors taken off."""
    errors = RadarErrorsOverTime()
    for fix in fixes(9, azimuths_deg=HALF, epochs=12, **truth):
        plain = adjust(
            errors.corrected(fix.epoch), Association.from_pairs(fix.epoch, fix.association.pairs), kernel="none"
        )
        before = errors.estimate()
        errors.feed(plain)
    assert before.ranges.applied != 0.0
    return errors, with_integrity(plain)


def test_the_covariance_holds_the_doubt_about_a_range_bias_that_was_taken_off():
    """Two roads: the normal equations, and the fix with a metre more taken off."""
    errors, plain = corrected_and_plain(bias_m=80.0)
    doubted, sigma_m = errors.doubted(plain), errors.estimate().ranges.sigma
    assert errors.estimate().clock.applied == 0.0
    other = adjust(with_bias(plain.epoch, 1.0), plain.association, kernel="none")
    gain = np.array(LocalPlane(plain.position).to_plane(other.position))
    added = (doubted.covariance - plain.covariance)[:2, :2]
    assert np.linalg.norm(gain) > 0.3, "ships on one side: the bias moves the fix"
    assert added == pytest.approx(sigma_m**2 * np.outer(gain, gain), rel=0.05, abs=0.1 * sigma_m**2 * gain @ gain)
    assert doubted.position == plain.position
    assert doubted.ellipse().semi_major_m > plain.ellipse().semi_major_m
    assert doubted.integrity.r95_m > plain.integrity.r95_m
    assert (
        doubted.integrity.protection_level_m > plain.integrity.protection_level_m + 3.0 * np.linalg.norm(gain) * sigma_m
    )


def test_a_clock_that_is_not_yet_taken_off_as_a_whole_counts_with_what_is_left_of_it():
    errors, plain = corrected_and_plain(bias_m=80.0, clock_s=-8.0)
    assert errors.estimate().clock.applied != 0.0
    only_ranges = RadarErrorsOverTime()
    only_ranges._doubts = (0.0, errors._doubts[1])
    assert np.trace(errors.doubted(plain).covariance) > np.trace(only_ranges.doubted(plain).covariance)


def test_without_anything_taken_off_and_in_windows_the_fix_stays_as_it_is():
    errors = RadarErrorsOverTime(windows=True)
    for fix in fixes(9, azimuths_deg=RING, bias_m=80.0, epochs=8):
        errors.feed(again(fix, errors.corrected(fix.epoch)))
    assert errors.estimate().ranges.applied != 0.0
    assert errors.doubted(fix) is fix
    assert RadarErrorsOverTime().doubted(fix) is fix
