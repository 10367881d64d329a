"""The choice of data: the source's table in its eight combinations, its three filters, and the reason that is told."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from itertools import product

import numpy as np
import pytest

from navfix.picture.choice import TABLE, aids_only, as_the_source_chooses, choose, decide, newest, standing
from navfix.report.data_used import data_entries
from navfix.types import Epoch, Mark, Position, RadarTarget, SpeedHint

NOW = datetime(2026, 1, 1, tzinfo=UTC)
HERE = Position(54.0, 8.0)


def target(
    label: str, speed_mps: float | None = None, course_deg: float | None = None, age_s: float = 0.0
) -> RadarTarget:
    return RadarTarget(
        label, 1000.0, 10.0, time_utc=NOW - timedelta(seconds=age_s), speed_mps=speed_mps, course_deg=course_deg
    )


def epoch_of(ships: bool, own_speed: bool, aids: int) -> Epoch:
    marks = [Mark("ship", HERE, 10.0)] if ships else []
    marks += [Mark(f"aid {k}", HERE, 10.0, "charted" if k % 2 else "aton") for k in range(aids)]
    speed = SpeedHint(5.0, 0.2) if own_speed else None
    return Epoch(NOW, (target("01"),), tuple(marks), speed_hint=speed)


@pytest.mark.parametrize(("ships", "own_speed", "three"), list(product((True, False), repeat=3)))
def test_the_decision_and_the_choice_of_the_source_in_all_eight_cases(
    ships: bool, own_speed: bool, three: bool
) -> None:
    choice = choose(epoch_of(ships, own_speed, 3 if three else 0))
    assert (choice.ships, choice.own_speed, choice.three_aids) == (ships, own_speed, three)
    filters = {
        (True, True, True): ("aids", "standing"),
        (True, True, False): ("newest",),
        (True, False, True): ("newest",),
        (True, False, False): ("newest",),
        (False, True, True): ("aids", "standing"),
        (False, False, True): ("aids",),
    }
    assert choice.filters == filters.get((ships, own_speed, three), ())
    assert choice.decision == ("all" if ships or three else "none")
    for said, word in ((ships, "AIS of ships"), (own_speed, "own speed")):
        assert (f"no {word}" not in choice.reason) == said
    assert ("three aids or more" in choice.reason) == three
    text = dict(data_entries(replace(epoch_of(ships, own_speed, 3), choice=choice)))["Choice"]
    assert choice.reason in text
    assert choice.source in text


def test_two_aids_are_not_three() -> None:
    assert not decide(ships=True, own_speed=True, aids=2).three_aids
    assert decide(ships=False, own_speed=False, aids=2).decision == "all"


def test_every_case_stands_in_the_table() -> None:
    assert set(TABLE) == set(product((True, False), repeat=3))


def test_stale_duplicates_are_dropped_by_the_first_filter() -> None:
    old = Mark("a", HERE, 10.0, mmsi=1, time_utc=NOW - timedelta(seconds=60))
    new = Mark("b", HERE, 10.0, mmsi=1, time_utc=NOW)
    other = Mark("c", HERE, 10.0, mmsi=2)
    epoch = Epoch(NOW, (target("01", age_s=5.0), target("02"), target("01")), (new, old, other))
    kept = newest(epoch)
    assert [mark.label for mark in kept.marks] == ["b", "c"]
    assert [(t.label, t.time_utc) for t in kept.targets] == [("02", NOW), ("01", NOW)]


def test_the_second_filter_keeps_aids_of_ais_and_chart() -> None:
    assert [mark.kind for mark in aids_only(epoch_of(True, False, 2)).marks] == ["aton", "charted"]


@pytest.mark.parametrize("drift_mps", [0.0, 1.4])
def test_the_third_filter_finds_what_stands_still_on_a_ground_and_on_a_sea_stabilised_radar(drift_mps: float) -> None:
    rng = np.random.default_rng(4)
    current = drift_mps * np.exp(1j * np.radians(70.0))

    def moving(label: str, velocity: complex) -> RadarTarget:
        seen = velocity - current + 0.15 * complex(*rng.normal(size=2))
        return target(label, abs(seen), float(np.degrees(np.angle(seen))) % 360.0)

    still = [moving(f"s{k}", 0.0) for k in range(5)]
    ships = [moving(f"m{k}", 6.0 * np.exp(1j * k)) for k in range(6)]
    slow = [moving("slow", 2.0 * np.exp(2j))]
    kept = standing(Epoch(NOW, (*ships, *still, *slow, target("blank")), ()))
    assert {t.label for t in kept.targets} == {f"s{k}" for k in range(5)}


def test_without_speeds_the_third_filter_keeps_every_target() -> None:
    epoch = Epoch(NOW, (target("01"), target("02", 0.0, None), target("03", 5.0, 90.0)), ())
    assert standing(epoch).targets == epoch.targets


def test_a_target_at_rest_needs_no_course() -> None:
    epoch = Epoch(NOW, tuple(target(f"{k}", 0.0) for k in range(3)) + (target("m", 8.0, 10.0),), ())
    assert [t.label for t in standing(epoch).targets] == ["0", "1", "2"]


def test_the_source_can_be_asked_to_choose() -> None:
    epoch = as_the_source_chooses(epoch_of(True, True, 3))
    assert {mark.kind for mark in epoch.marks} == {"aton", "charted"}
    assert epoch.choice is not None
    assert (epoch.choice.decision, epoch.choice.filters) == ("source", ("aids", "standing"))
    assert epoch.choice.reason.endswith("as asked for")
