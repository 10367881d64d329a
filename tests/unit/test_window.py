"""Windows of scans: yaw, tracks, basis, marks between reports, motion prior, and the answer for the newest epoch."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import navfix
from navfix.association.window import joint
from navfix.association.window.knots import Knots, motion_prior, placed, shape_of
from navfix.association.window.marks import paths_of
from navfix.association.window.tracks import since_silence, tracks_of
from navfix.association.window.yaw import common_yaw
from navfix.catalog import RadarModel, radar_model, window_model
from navfix.errors import InputError, NoFix, TooFewPairs
from navfix.geodesy import LocalPlane, inverse
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.report.truth import TruthTrack
from navfix.sequence.navigator import Navigator
from navfix.simulation import scenario
from navfix.simulation.files import truth_csv
from navfix.types import Epoch, Mark, Position, RadarTarget

LOGS = Path(__file__).resolve().parents[2] / "data" / "logs"
MODEL = window_model()
BEGIN = datetime(2026, 1, 1, tzinfo=UTC)


@cache
def recorded() -> tuple[Epoch, ...]:
    return tuple(epochs(read_log(LOGS / "approach.nmea").records))


def truth_at(epoch: Epoch):
    with (LOGS / "approach_truth.csv").open() as lines:
        return TruthTrack.parse(lines).at(epoch.time_utc.timestamp())


def scan(after_s: float, *targets: tuple[str, float, float], marks: tuple[Mark, ...] = ()) -> Epoch:
    time_utc = BEGIN + timedelta(seconds=after_s)
    made = tuple(RadarTarget(label, range_m, bearing, time_utc=time_utc) for label, range_m, bearing in targets)
    return Epoch(time_utc, made, marks)


# ------------------------------------------------------------------------------------------------ tracks and marks


def test_own_yaw_is_what_all_bearings_change_by_together():
    turned_deg = [0.0, 3.0, -2.0, 8.0]
    scans = []
    for k, turn in enumerate(turned_deg):
        targets = {f"{i:02d}": (40.0 * i - turn) % 360.0 for i in range(1, 8)}
        targets["01"] += 15.0 * k  # one target passes close by
        scans.append({label: (2.5 * k, RadarTarget(label, 3000.0, b)) for label, b in targets.items()})
    assert np.degrees(common_yaw(scans)) == pytest.approx(turned_deg, abs=1e-9)
    silent = [scans[0], {}, scans[1], {}, {}, *scans[2:]]  # own ship goes on while no echo is seen
    assert np.degrees(common_yaw(silent)) == pytest.approx([0.0, 0.0, 3.0, 3.0, 3.0, -2.0, 8.0], abs=1e-9)
    assert not common_yaw([{}, {}]).any()


@pytest.mark.parametrize("kept", [0, 4, 5])
def test_own_yaw_is_seen_through_a_restart_of_the_tracker(kept: int) -> None:
    rng = np.random.default_rng(5)
    ranges_m, bearings_deg = rng.uniform(800.0, 15e3, 12), rng.uniform(0.0, 360.0, 12)
    ranges_m[8:] = [5000.0, 9000.0, 5100.0, 9100.0]  # two of those that changed number lie as far off as those before
    renumbered = [*range(kept), *np.roll(np.arange(kept, 12), 2)]
    scans = [
        {f"{n}": (2.5 * k, RadarTarget(f"{n}", ranges_m[i], bearings_deg[i] - 7.0 * k)) for i, n in enumerate(numbers)}
        for k, numbers in enumerate((range(12), renumbered))
    ]
    assert np.degrees(common_yaw(scans)) == pytest.approx([0.0, 7.0], abs=1e-9)


def test_two_pictures_that_do_not_fit_tell_no_yaw() -> None:
    scans = [
        {f"{n}": (2.5 * k, RadarTarget(f"{n}", 1000.0 * (n + 1 + 20 * k), 37.0 * n + 90.0 * k)) for n in range(8)}
        for k in range(2)
    ]
    assert common_yaw(scans).tolist() == [0.0, 0.0]


def test_a_number_that_is_used_again_begins_a_new_track():
    far = [scan(2.5 * k, ("01", 5000.0, 10.0), ("02", 3000.0, 200.0)) for k in range(5)]
    again = [scan(2.5 * k, ("01", 1500.0, 10.0), ("02", 3000.0, 200.0)) for k in range(5, 10)]
    late = [scan(80.0 + 2.5 * k, ("02", 3000.0, 200.0)) for k in range(5)]
    tracks, _ = tracks_of([*far, *again, *late], "relative", MODEL)
    assert sorted(track.label for track in tracks) == ["01", "01", "02", "02"]
    assert [track.newest for track in tracks if track.label == "02" and track.time_s[0] > BEGIN.timestamp() + 60] == [0]
    assert all(track.newest == -1 for track in tracks if track.label == "01")


def test_a_mark_between_two_reports_lies_on_its_course():
    origin = Position(50.0, 0.0)
    plane = LocalPlane(origin)

    def carried(after_s: float, reported_s: float) -> Epoch:
        north_m = 6.0 * after_s
        mark = Mark(
            "1", plane.to_position(north_m, 100.0), 12.0, time_utc=BEGIN + timedelta(seconds=reported_s),
            speed_mps=6.0, course_deg=0.0, age_s=after_s - reported_s,
        )  # fmt: skip
        return scan(after_s, ("01", 900.0, 5.0), marks=(mark,))

    seen = [carried(2.5 * k, 20.0 if 2.5 * k >= 20.0 else 0.0) for k in range(16)]
    knot_s = BEGIN.timestamp() + np.array([5.0, 15.0, 25.0, 35.0])
    paths = paths_of(seen, origin, knot_s, MODEL)
    assert paths.z[0].real == pytest.approx([30.0, 90.0, 150.0, 210.0], abs=0.1)
    assert paths.v[0].real == pytest.approx([6.0] * 4, abs=0.01)
    assert paths.aged_m[0, 3] > paths.aged_m[0, 2]


# ------------------------------------------------------------------------------------------------ motion


def test_the_basis_of_every_track_is_orthonormal():
    scene = joint.prepare(recorded()[:24]).field.scene
    for row, used, bins in zip(scene.basis, scene.used, scene.bins, strict=True):
        assert row @ row.T == pytest.approx(np.diag(used.astype(float)), abs=1e-9)
        assert used.sum() == bins
        assert row[0].sum() == pytest.approx(math.sqrt(bins))


def test_the_prior_of_own_motion_knows_no_place_and_no_north():
    knot_s = np.arange(6) * 10.0
    prior = motion_prior(knot_s, 3, 20.0, MODEL)
    curved = Knots((4.0 * knot_s + 0.02j * knot_s**2)[None], 0.01 * np.arange(6.0)[None], np.zeros(1))
    shape = shape_of(curved, 3)
    moved = placed(shape, np.array([5000.0 - 300.0j]), np.array([2.0]), 3)
    assert prior.log_shape(moved) == pytest.approx(prior.log_shape(shape), rel=1e-9)
    straight = Knots((4.0 * knot_s + 0j)[None], np.zeros((1, 6)), np.zeros(1))
    assert prior.log_shape(straight)[0] > prior.log_shape(curved)[0]


# ------------------------------------------------------------------------------------------------ answers


def test_a_window_gives_the_place_of_its_newest_epoch():
    window = recorded()[8:32]
    association = navfix.associate(window)
    there = truth_at(window[-1])
    assert inverse(there.position, association.position)[0] <= 60.0
    targets, marks = association.pairs[:, 0], association.pairs[:, 1]
    assert len(association.pairs) >= 6
    assert targets.max() < len(window[-1].targets)
    assert marks.max() < len(window[-1].marks)
    assert association.evidence > 10.0
    assert association.probability_wrong >= 0.01

    found = navfix.fix(window)
    assert found.epoch is window[-1]
    assert found.ellipse(0.99).semi_major_m < 150.0
    assert {o.target for o in found.observations} >= {window[-1].targets[i].label for i in targets}
    assert found.integrity.r95_m > 0.0


@pytest.mark.parametrize("name", ["date_line", "high_latitude"])
def test_a_window_is_solved_across_180_e_and_near_the_pole(name: str):
    recording = scenario.simulate(scenario.load(name), 3, duration_s=70.0)
    scans = list(epochs(read_log(list(recording.lines), report=False).records))
    there = TruthTrack.parse(truth_csv(recording).splitlines()).at(scans[-1].time_utc.timestamp())
    assert inverse(there.position, navfix.fix(scans).position)[0] <= 100.0


def test_one_scan_is_a_window_of_one_bin():
    window = joint.prepare(recorded()[30:31])
    assert window.field.scene.knots == 1
    answers = joint.cold(window).answers
    assert len(answers) >= 1
    assert np.isfinite(answers.evidence).all()


COARSE = replace(radar_model("imo"), range_sigma_m=110.0, range_sigma_fraction=0.0, bearing_sigma_deg=2.2)


def telling(window: Iterable[Epoch], radar: RadarModel | None) -> list[Epoch]:
    """Return the epochs with targets that carry the sigmas of a radar, or none."""
    sigma_m, sigma_deg = (None, None) if radar is None else (radar.range_sigma_m, radar.bearing_sigma_deg)
    return [
        replace(e, targets=tuple(replace(t, range_sigma_m=sigma_m, bearing_sigma_deg=sigma_deg) for t in e.targets))
        for e in window
    ]


def test_targets_of_a_window_without_sigmas_have_those_of_the_radar():
    silent, told = telling(recorded()[8:32], None), telling(recorded()[8:32], COARSE)
    asked, as_told = navfix.associate(silent, radar=COARSE), navfix.associate(told)
    assert asked.evidence == pytest.approx(as_told.evidence, rel=1e-9)
    assert asked.covariance == pytest.approx(as_told.covariance, rel=1e-9)
    assert abs(asked.evidence - navfix.associate(silent).evidence) > 1.0, "the radar is asked in vain"
    fixed, as_told = navfix.fix(silent, radar=COARSE), navfix.fix(told, radar=COARSE)
    assert fixed.association.evidence == pytest.approx(as_told.association.evidence, rel=1e-9)


def test_the_navigator_takes_the_sigmas_of_its_radar_where_targets_bring_none():
    def scores(radar: RadarModel, told: RadarModel | None) -> list[float]:
        navigator = Navigator(radar=radar)
        for epoch in telling(recorded()[8:32], told):
            navigator.feed(epoch)
        navigator.step()
        return [place.score for place in navigator.alternatives()]

    assert len(scores(COARSE, None)) > 0
    assert scores(COARSE, None) == pytest.approx(scores(COARSE, COARSE), rel=1e-9)


def test_windows_that_cannot_be_are_refused_in_words():
    scans = recorded()
    with pytest.raises(InputError, match="at least one epoch"):
        navfix.associate([])
    with pytest.raises(InputError, match="order of time"):
        navfix.associate([scans[2], scans[0]])
    with pytest.raises(InputError, match="time of every epoch"):
        navfix.associate([replace(scans[0], time_utc=None)])
    with pytest.raises(InputError, match="jointly"):
        navfix.associate(scans[:4], method="cpd")
    with pytest.raises(TooFewPairs):
        navfix.associate([replace(epoch, marks=()) for epoch in scans[:4]])
    with pytest.raises(TooFewPairs):
        navfix.associate([replace(epoch, targets=()) for epoch in scans[:4]])
    with pytest.raises(NoFix):
        navfix.fix([replace(epoch, marks=epoch.marks[:2]) for epoch in scans[:8]])


def test_marks_in_one_point_and_targets_in_one_line_are_no_error():
    scans = recorded()[:12]
    one = scans[0].marks[0].position
    heaped = [replace(e, marks=tuple(replace(m, position=one) for m in e.marks)) for e in scans]
    lined = [replace(e, targets=tuple(replace(t, bearing_deg=45.0) for t in e.targets)) for e in scans]
    for window in (heaped, lined):
        with pytest.raises(NoFix):
            navfix.fix(window)


def test_a_window_begins_after_the_last_long_silence_of_radar():
    def scans(*times_s: float, echo: bool = True) -> tuple[Epoch, ...]:
        begin = datetime(2026, 5, 1, tzinfo=UTC)
        targets = (RadarTarget("1", 2000.0, 30.0),) if echo else ()
        return tuple(Epoch(begin + timedelta(seconds=t), targets, ()) for t in times_s)

    before, after = scans(0.0, 3.0, 6.0, 9.0), scans(29.0, 32.0, 35.0)
    assert since_silence((*before, *after)) == after
    assert since_silence((*before, *scans(14.0, 19.0, 24.0, echo=False), *after)) == after  # own ship alone is no echo
    assert since_silence((*before, *scans(20.0, 23.0))) == (*before, *scans(20.0, 23.0))
    slow = scans(0.0, 20.0, 40.0, 60.0)
    assert since_silence(slow) == slow
    assert since_silence(scans(5.0)) == scans(5.0)
    assert since_silence(()) == ()
