"""Belief over minutes: what is a rival, what is forgotten, and what no single window can overrule."""

from __future__ import annotations

import numpy as np
import pytest

from navfix.catalog import navigator_model
from navfix.sequence import Navigator
from navfix.sequence.acceptance import Acceptance, Blind
from navfix.sequence.bank import Bank, Hypothesis, Mean
from navfix.sequence.places import Place
from navfix.sequence.track import Track
from navfix.types import Position

NOW_S = 1000.0
MODEL = navigator_model()


def place(lat_deg: float = 54.0, heading_deg: float = 0.0, sigma_m: float = 20.0) -> Place:
    covariance = np.diag([sigma_m**2, sigma_m**2, 0.01**2])
    return Place(NOW_S, Position(lat_deg, 18.0), heading_deg, 0j, covariance)


def hypothesis(at: Place, score: float) -> Hypothesis:
    return Hypothesis(at, score=score)


def test_the_same_place_found_the_wrong_way_round_is_a_rival():
    bank = Bank(MODEL)
    bank.hypotheses = [hypothesis(place(), 9.0), hypothesis(place(heading_deg=180.0), 8.0)]
    assert bank.rival_ahead(bank.hypotheses[0]) == pytest.approx(1.0)
    assert bank.near(place(heading_deg=179.0)) is bank.hypotheses[1]
    assert not Track(place(), MODEL, NOW_S).agrees(place(heading_deg=180.0))


def test_a_place_of_nearly_the_same_heading_is_no_rival():
    bank = Bank(MODEL)
    bank.hypotheses = [hypothesis(place(heading_deg=359.0), 9.0), hypothesis(place(heading_deg=4.0), 8.0)]
    assert bank.rival_ahead(bank.hypotheses[0]) == np.inf


def test_a_ship_left_behind_is_forgotten_as_its_echo_is():
    bank, h = Bank(MODEL), hypothesis(place(), 0.0)
    h.detection = {"old": Mean(0.5, 1, NOW_S - MODEL.memory_s - 1.0), "new": Mean(0.5, 1, NOW_S)}
    bank._forget(h, NOW_S)
    assert list(h.detection) == ["new"]


def test_every_blind_solve_that_ends_now_is_heard_and_not_only_the_last_noted():
    acceptance = Acceptance(MODEL)
    sure = Blind(NOW_S - 60.0, NOW_S, place(), 20.0, 20.0, 8)
    doubtful = Blind(NOW_S - 120.0, NOW_S, place(55.0), 0.0, 1.0, 3)
    acceptance.note(sure)
    acceptance.note(doubtful)
    assert acceptance.ended_at(NOW_S) == [sure, doubtful]


def test_a_window_without_doubt_does_not_overrule_the_minutes_that_speak_for_another_place():
    navigator = Navigator()
    navigator._plain = Blind(NOW_S - 60.0, NOW_S, place(55.0), 20.0, 20.0, 8)
    navigator._believed = [hypothesis(place(), 9.0)]
    navigator._accept(navigator._believed, NOW_S)
    assert navigator._track is None
    assert navigator._reason.startswith("conflict")


def test_no_probability_is_stated_for_a_place_that_is_not_proven_or_has_lapsed():
    given = Track(place(), MODEL, NOW_S, proven=False)
    assert given.probability_wrong is None
    held = Track(place(), MODEL, NOW_S)
    assert held.probability_wrong == MODEL.least_probability_wrong
    held.lapsed = True
    assert held.probability_wrong is None


def test_a_place_is_lost_when_it_goes_unseen_for_long():
    held = Track(place(), MODEL, NOW_S)
    held.lose_at(NOW_S + 60.0)
    assert not held.given_up
    held.lose_at(NOW_S + 600.0)
    assert held.given_up.startswith("lost")
