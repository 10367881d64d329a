"""A gyro beside a window of scans: evidence where it is right, found out where it is not, never simply believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import navfix
from navfix.adjustment.window import adjust_window
from navfix.association.window import gyro, joint
from navfix.catalog import navigator_model
from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.report.truth import TruthTrack
from navfix.sequence.acceptance import blind_of
from navfix.sequence.bank import Bank
from navfix.types import Association, Epoch, HeadingHint
from navfix.units import wrap_180
from tests.window_scenes import passage

LOGS = Path(__file__).resolve().parents[2] / "data" / "logs"
OFF_DEG = (None, 1.0, 90.0)


@cache
def recorded() -> tuple[Epoch, ...]:
    return tuple(epochs(read_log(LOGS / "approach.nmea").records))


def truth_at(epoch: Epoch):
    with (LOGS / "approach_truth.csv").open() as lines:
        return TruthTrack.parse(lines).at(epoch.time_utc.timestamp())


def with_gyro(window: Sequence[Epoch], off_deg: float | None, sigma_deg: float = 1.5) -> list[Epoch]:
    """Return the scans with a gyro that is so far off, or with none."""
    if off_deg is None:
        return [replace(epoch, heading_hint=None) for epoch in window]
    headings = [(truth_at(epoch).heading_deg + off_deg) % 360.0 for epoch in window]
    return [replace(e, heading_hint=HeadingHint(h, sigma_deg)) for e, h in zip(window, headings, strict=True)]


def few_ships(seed: int) -> list[Epoch]:
    """Return half a minute of scans in which a third of the ships, drawn at random, have AIS."""
    rng = np.random.default_rng(seed)
    first = int(rng.integers(4, len(recorded()) - 14))
    window = recorded()[first : first + 10]
    labels = sorted({mark.label for mark in window[-1].marks})
    kept = set(rng.choice(labels, len(labels) * 4 // 11, replace=False).tolist())
    return [replace(epoch, marks=tuple(m for m in epoch.marks if m.label in kept)) for epoch in window]


@pytest.fixture(scope="module")
def answers() -> dict[float | None, dict[int, Association]]:
    """Return the answers that there are, by how far the gyro is off and by seed."""
    found: dict[float | None, dict[int, Association]] = {off_deg: {} for off_deg in OFF_DEG}
    for seed in range(11):
        window = few_ships(seed)
        for off_deg in OFF_DEG:
            try:
                association = navfix.associate(with_gyro(window, off_deg))
            except NoFix:
                continue
            assert inverse(truth_at(window[-1]).position, association.position)[0] < 150.0
            found[off_deg][seed] = association
    return found


def test_a_right_gyro_gives_answers_where_few_common_ships_alone_do_not(answers):
    alone, helped = answers[None], answers[1.0]
    assert alone.keys() <= helped.keys()
    assert len(helped) >= len(alone) + 2
    assert not any(association.notes for association in helped.values())


def test_a_gyro_90_deg_off_is_found_out_in_a_window_and_moves_nothing(answers):
    alone, refuted = answers[None], answers[90.0]
    assert len(refuted) >= 3
    for seed, association in refuted.items():
        assert association.notes[0].startswith("The heading hint is refuted: it is +")
        assert abs(float(association.notes[0].split("+")[1].split("°")[0]) - 90.0) < 6.0
        assert inverse(alone[seed].position, association.position)[0] < 5.0
        assert association.evidence > alone[seed].evidence - 3.1  # ln 20: how rare a worthless gyro is, and no more


def test_the_fix_of_a_window_names_the_gyro_that_is_refuted():
    window = recorded()[8:32]
    plain, told = navfix.fix(with_gyro(window, None)), navfix.fix(with_gyro(window, 90.0))
    assert told.association is not None
    assert any("refuted" in note for note in told.association.notes)
    assert inverse(plain.position, told.position)[0] < 5.0
    assert abs(wrap_180(plain.heading_deg - told.heading_deg)) < 0.5


def test_the_newest_hint_counts_turned_by_what_was_seen_since():
    window = recorded()[8:32]
    silent = with_gyro(window, 1.0)
    silent[-6:] = with_gyro(window[-6:], None)
    hint = gyro.heading_prior(joint.prepare(silent))
    assert abs(wrap_180(np.degrees(hint.heading_rad) - truth_at(window[-1]).heading_deg - 1.0)) < 2.0
    assert not gyro.heading_prior(joint.prepare(with_gyro(window, None))).has_hint


def test_true_bearings_that_are_turned_are_a_refuted_compass():
    def turned(epoch: Epoch) -> Epoch:
        heading_deg = truth_at(epoch).heading_deg + 25.0
        targets = (
            replace(t, bearing_deg=(t.bearing_deg + heading_deg) % 360.0, bearing_reference="true")
            for t in epoch.targets
        )
        return replace(epoch, targets=tuple(targets))

    association = navfix.associate([turned(epoch) for epoch in recorded()[8:32]])
    assert any(note.startswith("The compass in the true bearings is refuted") for note in association.notes)


def test_a_turn_that_no_echo_shows_is_that_of_the_gyro():
    made = passage(np.random.default_rng(3), epochs=16, turn_deg_per_min=60.0)
    blanked = [replace(epoch, targets=()) if k >= 11 else epoch for k, epoch in enumerate(made.epochs)]
    plain = [replace(epoch, heading_hint=None) for epoch in blanked]
    errors_deg = [abs(made.heading_error_deg(adjust_window(s, made.pairs).heading_deg)) for s in (blanked, plain)]
    assert errors_deg[0] < 1.0
    assert errors_deg[1] > 3.0


@pytest.mark.parametrize(("off_deg", "least", "most"), [(0.5, 2.0, 4.5), (90.0, -3.1, -2.9)])
def test_a_place_over_minutes_counts_its_compass_once(off_deg: float, least: float, most: float):
    bank = Bank(navigator_model())
    for first in (4, 16, 28):  # windows that share no data
        window = joint.prepare(with_gyro(recorded()[first : first + 12], off_deg))
        bank.feed(window, [gyro.cold(window)])
    right = bank.hypotheses[0]
    assert inverse(truth_at(recorded()[39]).position, right.place.position)[0] < 150.0
    assert right.compass.count >= 2
    assert least < right.compass.value < most


def test_the_lead_that_a_wrong_compass_could_feign_is_asked_for_in_addition():
    window, without = (joint.prepare(with_gyro(few_ships(0), off_deg)) for off_deg in (0.0, None))
    assert gyro.price(window) == pytest.approx(np.log(20.0))
    assert gyro.price(without) == 0.0
    found = gyro.cold(window)
    assert blind_of(found, 30.0).margin == pytest.approx(found.answers.margin - np.log(20.0))
