"""Belief over minutes: what is a rival, what is forgotten, and what no single window can overrule."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from navfix.catalog import navigator_model
from navfix.sequence.acceptance import Acceptance, Blind
from navfix.sequence.bank import Bank, Hypothesis, Mean
from navfix.sequence.belief import Belief
from navfix.sequence.doubt import Former, Standing, against, by_lead
from navfix.sequence.places import Place
from navfix.sequence.track import Track
from navfix.sequence.yaw import YawLog
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
    belief = Belief(MODEL)
    belief.believed = [hypothesis(place(), 9.0)]
    plain = Blind(NOW_S - 60.0, NOW_S, place(55.0), 20.0, 20.0, 8)
    assert belief.decide(None, NOW_S, solved=False, fed=False, plain=plain) is None
    assert belief.reason.startswith("conflict")


def test_two_places_that_were_both_found_blind_are_none():
    acceptance, bank = Acceptance(MODEL), Bank(MODEL)
    bank.hypotheses = [hypothesis(place(), 6.0), hypothesis(place(55.0), 5.0)]
    for lat_deg in (54.0, 55.0):
        acceptance.note(Blind(NOW_S - 60.0, NOW_S, place(lat_deg), 20.0, 20.0, 8))
    assert acceptance.accepted(bank) == bank.hypotheses
    bank.hypotheses[1].score = 0.5
    assert acceptance.accepted(bank) == bank.hypotheses[:1]


def test_no_probability_is_stated_for_a_place_that_is_not_proven_or_has_lapsed():
    given = Track(place(), MODEL, NOW_S, proven=False)
    assert given.probability_wrong is None
    held = Track(place(), MODEL, NOW_S, standing=Standing(MODEL, NOW_S, 99.0))
    assert held.probability_wrong == MODEL.doubt_reached
    held.lapsed = True
    assert held.probability_wrong is None


def test_doubt_falls_with_the_lead_and_never_below_what_the_controls_carry():
    doubts = [by_lead(lead, MODEL) for lead in (0.0, 3.0, 5.0, 50.0)]
    assert doubts == sorted(doubts, reverse=True)
    assert doubts[1] == pytest.approx(MODEL.doubt_accepted)
    assert doubts[-1] == MODEL.doubt_reached
    assert by_lead(-100.0, MODEL) == 1.0


def test_doubt_grows_while_nothing_confirms_the_place_and_then_it_is_not_given_out():
    standing = Standing(MODEL, NOW_S, lead=50.0)
    fresh, later = standing.probability_wrong(NOW_S), standing.probability_wrong(NOW_S + 300.0)
    assert fresh == MODEL.doubt_reached < later < MODEL.most_doubt
    assert not standing.why_silent(NOW_S + 300.0)
    assert standing.why_silent(NOW_S + 3600.0).startswith("lapsed")
    standing.confirm(NOW_S + 3600.0)
    assert standing.probability_wrong(NOW_S + 3600.0) == pytest.approx(fresh)
    assert not standing.why_silent(NOW_S + 3600.0)


def test_a_place_that_another_overtakes_is_silent_until_its_lead_is_clear_again():
    standing = Standing(MODEL, NOW_S, lead=8.0)
    standing.note_lead(-0.5)
    assert standing.why_silent(NOW_S)
    standing.note_lead(MODEL.least_ahead - 0.5)
    assert standing.why_silent(NOW_S)
    assert not standing.given_up(NOW_S + MODEL.drop_after_s)
    assert standing.given_up(NOW_S + MODEL.drop_after_s + 1.0)
    standing.note_lead(MODEL.least_ahead + 5.0)
    assert not standing.why_silent(NOW_S)


def test_one_of_two_places_is_wrong_and_the_likelier_one_the_more():
    assert against(0.02, 0.02) == pytest.approx(0.5)
    assert against(0.02, 0.5) == pytest.approx(0.02)
    assert against(0.1, 0.3) + against(0.3, 0.1) == pytest.approx(1.0)


def after_a_former_place(other: Hypothesis, after_s: float) -> Belief:
    belief = Belief(MODEL)
    belief.former = Former(place(), MODEL.doubt_reached, NOW_S)
    other.place = replace(other.place, time_s=NOW_S + after_s)
    belief.bank.hypotheses = belief.believed = [other]
    return belief


@pytest.mark.parametrize("after_s", [1.0, 900.0])
def test_a_former_place_bars_one_that_appears_after_it_and_not_itself(after_s: float):
    belief = after_a_former_place(hypothesis(place(54.1), 30.0), after_s)
    assert belief.decide(None, NOW_S + after_s, solved=False, fed=False) is None
    assert belief.reason.startswith("conflict: another place was given out")
    belief = after_a_former_place(hypothesis(place(), 30.0), after_s)
    assert belief.decide(None, NOW_S + after_s, solved=False, fed=False) is not None


def test_a_rival_that_was_followed_long_before_is_no_jump_of_all_ais():
    rival = hypothesis(place(54.1), 30.0)
    rival.windows = 12
    assert after_a_former_place(rival, 60.0).decide(None, NOW_S + 60.0, solved=False, fed=False) is not None


def test_after_a_jump_of_all_ais_what_was_followed_before_is_no_older_for_it_jumped_too():
    rival = hypothesis(place(54.0 + 300.0 / 111e3), 30.0)
    rival.windows = 20
    belief = after_a_former_place(rival, 300.0)
    assert belief.former is not None
    belief.former = replace(belief.former, within_m=150.0)
    assert belief.decide(None, NOW_S + 300.0, solved=False, fed=False) is None
    assert belief.reason.startswith("conflict: another place was given out")


def test_a_jump_of_all_ais_counts_for_the_place_given_out_last_where_none_is_held():
    belief = after_a_former_place(hypothesis(place(54.0 + 300.0 / 111e3), 30.0), 60.0)
    belief.jumped(None, NOW_S + 30.0, 300.0)
    assert belief.decide(None, NOW_S + 60.0, solved=False, fed=False) is None
    assert belief.reason.startswith("conflict: another place was given out")


def test_a_former_place_moves_along_with_own_ship():
    other = hypothesis(replace(place(54.1), velocity_mps=5.0 + 0j), 30.0)
    belief = after_a_former_place(other, 600.0)
    belief.decide(None, NOW_S + 600.0, solved=False, fed=False)
    assert belief.former is not None
    assert belief.former.place.distance_m(replace(place(), time_s=NOW_S + 600.0)) == pytest.approx(3000.0, rel=1e-3)


def test_a_former_place_does_not_follow_a_jump_of_all_ais_that_the_bank_takes_for_speed():
    jumping = hypothesis(replace(place(54.1), velocity_mps=10.0 + 0j), 30.0)
    belief = after_a_former_place(jumping, 20.0)
    belief.jumped(None, NOW_S, 300.0)
    belief.decide(None, NOW_S + 20.0, solved=False, fed=False)
    assert belief.former is not None
    assert belief.former.place.distance_m(place()) < 1.0
    jumping.place = replace(jumping.place, time_s=NOW_S + MODEL.bank_every_s)
    belief.decide(None, NOW_S + 40.0, solved=False, fed=False)
    assert belief.former.place.distance_m(place()) == pytest.approx(200.0, rel=1e-3)


def test_a_velocity_turns_as_own_ship_was_seen_to_turn():
    class Turned(YawLog):
        def between_deg(self, from_s: float, to_s: float) -> float:
            return 90.0 * (to_s - from_s) / 60.0

    going = replace(place(), velocity_mps=5.0 + 0j, yaw=Turned())
    assert going.velocity_turned(NOW_S + 60.0) == pytest.approx(5.0j)


def test_a_place_that_ends_in_a_conflict_stays_in_mind_as_it_was_stated():
    belief = Belief(MODEL)
    held = Track(place(), MODEL, NOW_S)
    held.standing.stated = 0.03
    belief.believed = [hypothesis(place(54.1), 30.0)]
    assert belief.decide(held, NOW_S, solved=False, fed=False) is None
    assert belief.former is not None
    assert belief.former.doubt == 0.03
    assert belief.reason.startswith("conflict")


def test_a_place_is_lost_when_it_goes_unseen_for_long():
    held = Track(place(), MODEL, NOW_S)
    held.lose_at(NOW_S + 60.0)
    assert not held.given_up
    held.lose_at(NOW_S + 600.0)
    assert held.given_up.startswith("lost")


def test_where_there_is_a_compass_a_place_needs_a_larger_lead():
    leads = {}
    for price in (0.0, 3.0):
        acceptance, h = Acceptance(MODEL), replace(hypothesis(place(), 9.0), compass_price=price)
        acceptance.note(Blind(NOW_S - 60.0, NOW_S, place(), 20.0, 20.0, 8))
        leads[price] = acceptance._needed_lead(h)
    assert leads[0.0] == MODEL.least_ahead
    assert leads[3.0] == pytest.approx(MODEL.least_ahead + 3.0)


def test_a_blind_place_that_surprises_the_track_is_not_its_fix_and_three_in_a_row_end_it():
    track = Track(place(sigma_m=20.0), MODEL, NOW_S)
    near, far = place(lat_deg=54.0 + 60.0 / 111e3), place(lat_deg=54.0 + 300.0 / 111e3)
    assert track.agrees(near)
    assert not track.surprised_by(near)
    for _ in range(MODEL.surprises):
        assert not track.given_up
        assert not track.agrees(far)
        assert track.surprised_by(far)
    assert track.given_up.startswith("given up: three windows")


def test_a_place_of_long_ago_is_not_surprised():
    track = Track(place(sigma_m=20.0), MODEL, NOW_S)
    later = replace(place(lat_deg=54.0 + 300.0 / 111e3), time_s=NOW_S + 60.0)
    assert track.agrees(later)
    assert not track.surprised_by(later)


def test_after_a_jump_of_all_ais_only_what_lies_nearer_to_the_old_place_is_that():
    shifted = place(lat_deg=54.0 + 300.0 / 111e3)
    assert Former(place(), 0.01, NOW_S).agrees(shifted, MODEL)
    assert not Former(place(), 0.01, NOW_S, within_m=150.0).agrees(shifted, MODEL)
    assert Former(place(), 0.01, NOW_S, within_m=150.0).agrees(place(lat_deg=54.0005), MODEL)
