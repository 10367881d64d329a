"""The navigator on shipped logs: it finds its place, holds it, and is not led astray by what a hostile sea can do."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from datetime import timedelta
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from navfix import pipeline
from navfix.errors import InputError
from navfix.geodesy import LocalPlane, inverse
from navfix.nmea import read_log
from navfix.nmea.records import AisPosition, AisStatic, Record
from navfix.picture import epochs
from navfix.report.truth import TruthTrack
from navfix.sequence import Navigator, Outcome
from navfix.sequence.places import Place
from navfix.simulation import scenario
from navfix.types import Epoch, Fix, HeadingHint, SpeedHint

LOGS = Path(__file__).resolve().parents[2] / "data" / "logs"
STEP = 4  # scans: 10 s


@cache
def recorded(name: str) -> tuple[Epoch, ...]:
    return tuple(epochs(read_log(LOGS / f"{name}.nmea").records))


@cache
def truth(name: str) -> TruthTrack:
    with (LOGS / f"{name}_truth.csv").open() as lines:
        return TruthTrack.parse(lines)


def navigate(scans: Iterable[Epoch], navigator: Navigator | None = None) -> list[tuple[Epoch, Outcome]]:
    """Feed every scan, step at every ``STEP``-th one."""
    navigator = navigator or Navigator()
    outcomes = []
    for count, epoch in enumerate(scans):
        navigator.feed(epoch)
        if count % STEP == 0:
            outcomes.append((epoch, navigator.step()))
    return outcomes


def errors_m(outcomes: Sequence[tuple[Epoch, Outcome]], name: str = "approach") -> np.ndarray:
    found = []
    for epoch, outcome in outcomes:
        there = truth(name).at(epoch.time_utc.timestamp())
        if outcome.fix is not None and there is not None:
            found.append(inverse(there.position, outcome.fix.position)[0])
    return np.array(found)


def changed_from(scans: Sequence[Epoch], first: int, change: Callable[[Epoch], Epoch]) -> list[Epoch]:
    return [epoch if count < first else change(epoch) for count, epoch in enumerate(scans)]


def test_busy_traffic_gives_a_place_within_seconds_and_it_is_held():
    outcomes = navigate(recorded("approach")[:64])
    fixed = [outcome.fix is not None for _, outcome in outcomes]
    first = fixed.index(True)
    assert first * STEP * 2.5 <= 40.0
    assert np.mean(fixed[first:]) >= 0.95
    assert np.median(errors_m(outcomes)) <= 30.0
    assert errors_m(outcomes).max() <= 120.0
    assert all(o.track.probability_wrong >= 0.01 for _, o in outcomes if o.fix is not None)
    with_prior = [o.association for _, o in outcomes if o.fix is not None and o.track.source == "prior"]
    assert all(a is None or a.margin is None for a in with_prior)  # no other place was looked for


def test_a_restart_finds_the_place_again():
    outcomes = navigate(recorded("approach")[30:50])
    assert any(outcome.fix is not None for _, outcome in outcomes)
    assert errors_m(outcomes).max() <= 120.0


def test_a_wrong_place_from_outside_is_never_given_out():
    scans = recorded("approach")[:28]
    there = truth("approach").at(scans[0].time_utc.timestamp())
    wrong = LocalPlane(there.position).to_position(7000.0, -7000.0)
    navigator = Navigator()
    covariance = np.diag([50.0**2, 50.0**2, 0.02**2])
    navigator.start_at(Place(scans[0].time_utc.timestamp(), wrong, 100.0, 0j, covariance))
    outcomes = navigate(scans, navigator)
    assert len(errors_m(outcomes)) >= 2
    assert errors_m(outcomes).max() <= 120.0


def test_a_wrong_place_that_was_believed_does_not_survive():
    scans = recorded("approach")[:28]
    there = truth("approach").at(scans[0].time_utc.timestamp())
    navigator = Navigator()
    wrong = LocalPlane(there.position).to_position(-6000.0, 4000.0)
    navigator.start_at(Place(scans[0].time_utc.timestamp(), wrong, 10.0, 0j, np.diag([900.0, 900.0, 0.01**2])))
    navigator._track.proven = True  # as if it had been accepted
    outcomes = navigate(scans, navigator)
    given_out = [
        outcome
        for epoch, outcome in outcomes
        if outcome.fix is not None
        and inverse(truth("approach").at(epoch.time_utc.timestamp()).position, outcome.fix.position)[0] > 500.0
    ]
    assert not given_out
    assert any(outcome.track.status == "conflict" for _, outcome in outcomes)


def test_a_jump_of_all_ais_gives_no_fix_and_says_conflict():
    def jump(epoch: Epoch) -> Epoch:
        moved = tuple(replace(m, position=LocalPlane(m.position).to_position(0.0, 2500.0)) for m in epoch.marks)
        return replace(epoch, marks=moved)

    outcomes = navigate(changed_from(recorded("approach")[:60], 26, jump))
    assert errors_m(outcomes).max() <= 150.0
    assert outcomes[-1][1].fix is None
    first = next(k for k, (_, outcome) in enumerate(outcomes) if outcome.track.status == "conflict")
    assert first >= 6
    assert any(outcome.dead_reckoning is not None for _, outcome in outcomes[:first])
    assert all(outcome.dead_reckoning is None for _, outcome in outcomes[first:]), "the last fixes are in doubt too"


def test_a_swap_of_target_numbers_leaves_the_place_where_it_is():
    def swap(epoch: Epoch) -> Epoch:
        labels = sorted(t.label for t in epoch.targets)
        turned = dict(zip(labels, labels[1:] + labels[:1], strict=True))
        return replace(epoch, targets=tuple(replace(t, label=turned[t.label]) for t in epoch.targets))

    outcomes = navigate(changed_from(recorded("approach")[:48], 26, swap))
    assert errors_m(outcomes).max() <= 150.0
    assert np.mean([outcome.fix is not None for _, outcome in outcomes[6:]]) >= 0.8


def later(epoch: Epoch, by: timedelta) -> Epoch:
    def moved(record):
        return record if record.time_utc is None else replace(record, time_utc=record.time_utc + by)

    return replace(
        moved(epoch), targets=tuple(moved(t) for t in epoch.targets), marks=tuple(moved(m) for m in epoch.marks)
    )


def test_a_place_that_went_unseen_for_an_hour_is_lost_and_not_looked_for_where_it_would_be():
    scans = recorded("approach")[:18]
    navigator = Navigator()
    assert navigate(scans[:13], navigator)[-1][1].fix is not None
    outcome = navigate([later(epoch, timedelta(hours=1)) for epoch in scans[13:14]], navigator)[0][1]
    assert outcome.fix is None
    assert outcome.track.status == "cold"


def test_true_bearings_give_a_place_and_no_heading():
    def turned(epoch: Epoch) -> Epoch:
        heading_deg = truth("approach").at(epoch.time_utc.timestamp()).heading_deg
        return replace(
            epoch,
            targets=tuple(
                replace(t, bearing_reference="true", bearing_deg=(t.bearing_deg + heading_deg) % 360.0)
                for t in epoch.targets
            ),
        )

    outcomes = navigate([turned(epoch) for epoch in recorded("approach")[:20]])
    fixes = [outcome.fix for _, outcome in outcomes if outcome.fix is not None]
    assert len(fixes) >= 2
    assert errors_m(outcomes).max() <= 120.0
    assert all(fix.heading_deg is None and fix.covariance.shape == (2, 2) for fix in fixes)


def test_a_gyro_that_is_90_deg_off_is_found_out_and_moves_nothing():
    def turned(epoch: Epoch) -> Epoch:
        there = truth("approach").at(epoch.time_utc.timestamp())
        return replace(epoch, heading_hint=HeadingHint((there.heading_deg + 90.0) % 360.0, 1.5))

    outcomes = navigate([turned(epoch) for epoch in recorded("approach")[:20]])
    assert errors_m(outcomes).max() <= 120.0
    epoch, outcome = outcomes[-1]
    answer = pipeline.beside(outcome.fix, outcome.association, epoch)
    assert any("Check the compass" in caution for caution in answer.cautions)


def test_true_bearings_are_carried_along_the_gyro_and_tell_no_heading():
    def turned(epoch: Epoch) -> Epoch:
        there = truth("approach").at(epoch.time_utc.timestamp())
        targets = (
            replace(t, bearing_deg=(t.bearing_deg + there.heading_deg) % 360.0, bearing_reference="true")
            for t in epoch.targets
        )
        hints = {"heading_hint": HeadingHint(there.heading_deg, 1.5), "speed_hint": SpeedHint(7.0, 0.1)}
        return replace(epoch, targets=tuple(targets), **hints)

    outcomes = [outcome for _, outcome in every_scan(map(turned, recorded("approach")[:16]))]
    carried = [outcome.fix for outcome in outcomes if outcome.fix is not None and was_carried(outcome.fix)]
    assert carried
    assert all(fix.heading_deg is None and fix.covariance.shape == (2, 2) for fix in carried)


def test_until_a_new_window_is_long_enough_the_place_goes_on_by_the_log_and_a_gyro_that_is_90_deg_off():
    def with_sensors(epoch: Epoch) -> Epoch:
        there = truth("approach").at(epoch.time_utc.timestamp())
        hint = HeadingHint((there.heading_deg + 90.0) % 360.0, 1.5)
        return replace(epoch, heading_hint=hint, speed_hint=SpeedHint(5.5, 0.1))

    outcomes = every_scan(map(with_sensors, recorded("approach")[:16]))
    carried = [(epoch, o) for epoch, o in outcomes if o.fix is not None and was_carried(o.fix)]
    assert carried
    assert all("by log and gyro" in o.fix.notes[0] for _, o in carried)
    assert errors_m(carried).max() <= 40.0


def every_scan(scans: Iterable[Epoch]) -> list[tuple[Epoch, Outcome]]:
    navigator, outcomes = Navigator(), []
    for epoch in scans:
        navigator.feed(epoch)
        outcomes.append((epoch, navigator.step()))
    return outcomes


def was_carried(fix: Fix) -> bool:
    return any(note.startswith("Carried forward by") for note in fix.notes)


@cache
def simulated(name: str, seed: int) -> tuple[Record, ...]:
    lines = scenario.simulate(scenario.load(name), seed, duration_s=150.0).lines
    return tuple(read_log(list(lines), report=False).records)


def foreign(radar: Iterable[Record], ais: Iterable[Record]) -> list[Epoch]:
    """Return the radar of one place with the AIS of another, moved in time by whole minutes."""
    seen = [r for r in radar if not isinstance(r, AisPosition | AisStatic)]
    heard = [r for r in ais if isinstance(r, AisPosition | AisStatic)]
    shift_s = 60.0 * round((seen[0].time_s - heard[0].time_s) / 60.0)
    moved = [replace(r, time_s=r.time_s + shift_s) for r in heard]
    return list(epochs(sorted([*seen, *moved], key=lambda r: r.time_s)))


@pytest.mark.parametrize(("radar", "ais"), [("approach", "anchorage"), ("anchorage", "lane")])
def test_the_ais_of_another_place_is_never_accepted(radar: str, ais: str):
    scans = foreign(simulated(radar, 11), simulated(ais, 12))
    assert np.median([len(epoch.marks) for epoch in scans]) >= 10
    assert not any(outcome.fix is not None for _, outcome in navigate(scans))


def test_epochs_come_in_the_order_of_time():
    scans = recorded("approach")
    navigator = Navigator()
    navigator.feed(scans[3])
    assert navigator.follows(scans[4])
    assert not navigator.follows(scans[0])
    with pytest.raises(InputError, match="order of time"):
        navigator.feed(scans[0])
    with pytest.raises(InputError, match="time of every epoch"):
        navigator.feed(replace(scans[4], time_utc=None))


def test_nothing_to_go_by_is_cold_and_never_an_error():
    scans = recorded("approach")
    assert Navigator().step().status == "cold"
    for empty in (
        replace(scans[0], targets=()),
        replace(scans[0], marks=()),
        replace(scans[0], marks=scans[0].marks[:2]),
    ):
        navigator = Navigator()
        navigator.feed(empty)
        assert navigator.step().fix is None
