"""The navigator in a hostile sea: nothing wrong is given out, and what is given out states its doubt."""

from __future__ import annotations

import pytest

from navfix.catalog import navigator_model
from tests import hostile_scenes as hostile

MODEL = navigator_model()


@pytest.mark.parametrize(("metres", "seed"), [(300.0, 1), (600.0, 6002), (1500.0, 1)])
def test_a_jump_of_all_ais_is_a_conflict_at_once_and_gives_no_shifted_place(metres: float, seed: int):
    scene = hostile.scene(seed, duration_s=180.0)
    told = hostile.tell(scene.changed(hostile.jump(0.6 * metres, -0.8 * metres), after_s=100.0))
    assert told.fixes >= 5
    assert told.worst_m < 100.0
    assert set(told.statuses[-7:]) == {"conflict"}  # no way to know which of the two is right


def test_after_a_jump_of_all_ais_the_shifted_place_is_not_given_out_when_the_hold_is_over():
    scene = hostile.scene(6000, duration_s=100.0 + MODEL.conflict_hold_s + 90.0)
    told = hostile.tell(scene.changed(hostile.jump(900.0, -1200.0), after_s=100.0), step_s=20.0)
    assert told.fixes >= 3
    assert told.wrong == 0
    assert set(told.statuses[-4:]) == {"conflict"}


def test_a_place_that_followed_a_small_jump_of_all_ais_is_not_given_out_when_the_hold_is_over():
    scene = hostile.scene(12, duration_s=460.0)  # a hypothesis of the bank goes along with the jump
    told = hostile.tell(scene.changed(hostile.jump(180.0, -240.0), after_s=150.0))
    assert told.fixes >= 10
    assert told.worst_m < 100.0
    assert set(told.statuses[-25:]) == {"conflict"}


def test_a_jump_of_120_m_is_told_and_not_followed():
    told = hostile.tell(hostile.scene(12, duration_s=200.0).changed(hostile.jump(72.0, -96.0), after_s=150.0))
    assert told.worst_m < 100.0
    assert set(told.statuses[-4:]) == {"conflict"}


def test_two_tracks_near_a_prior_that_all_scans_contradict_are_no_fix():
    told = hostile.tell(hostile.scene(16, duration_s=560.0).later(430.0))  # all ships move: own motion is misread once
    assert told.fixes >= 9
    assert told.worst_m < 100.0
    assert "conflict" not in told.statuses


def test_a_spoofed_cluster_does_not_move_the_place():
    scene = hostile.scene(2).changed(hostile.spoofed_cluster(0.35, 1500.0, 0.0), after_s=80.0)
    told = hostile.tell(scene)
    assert told.fixes >= 12
    assert told.wrong == 0


def test_swapped_target_numbers_move_nothing():
    told = hostile.tell(hostile.scene(3, duration_s=150.0).changed(hostile.swap_numbers, after_s=80.0))
    assert told.fixes >= 8
    assert told.wrong == 0


@pytest.mark.parametrize("believed", [False, True])
def test_a_wrong_state_that_was_injected_is_never_given_out(believed: bool):
    scene = hostile.scene(4, duration_s=100.0)
    told = hostile.tell(scene, hostile.wrong_state(scene, 4000.0, -3000.0, believed=believed))
    assert told.wrong == 0
    assert (told.fixes == 0) == believed  # what was given out before bars the right place, too, for a while


def test_a_restart_finds_the_place_again():
    told = hostile.tell(hostile.scene(5, duration_s=160.0).later(80.0))
    assert told.fixes >= 3
    assert told.wrong == 0


@pytest.mark.parametrize(("lat_deg", "lon_deg"), [(-16.8, 179.995), (80.0, 20.0)])
def test_across_180_east_and_at_80_north(lat_deg: float, lon_deg: float):
    told = hostile.tell(hostile.scene(6, lat_deg=lat_deg, lon_deg=lon_deg, duration_s=120.0))
    assert told.fixes >= 6
    assert told.worst_m < 150.0


def test_sparse_traffic_gives_nothing_wrong():
    told = hostile.tell(hostile.scene(7, ships=3, dumb=12))
    assert told.wrong == 0


def test_a_restart_of_the_tracker_costs_no_fix():
    told = hostile.tell(hostile.scene(6001).changed(hostile.renumber, after_s=100.0))
    assert told.fixes >= told.steps - 3
    assert told.wrong == 0
    assert told.worst_m < 150.0


@pytest.mark.parametrize("seed", [3, 4])
def test_a_ship_that_turned_while_radar_was_silent_is_found_again(seed: int):
    turning = hostile.scene(seed, duration_s=200.0, turn_degps=5.0, turn_deg=150.0)
    told = hostile.tell(turning.changed(hostile.lose_echoes(1.0), after_s=108.0, for_s=32.0))
    assert told.wrong == 0
    assert told.worst_m < 100.0
    assert told.inside >= told.fixes - 1
    assert "conflict" not in told.statuses
    assert set(told.statuses[-4:]) == {"tracking"}


@pytest.mark.parametrize(("silent_s", "missed"), [(45.0, 8), (12.0, 4)])
def test_fixes_after_a_turn_that_radar_did_not_show_go_on_from_the_first_of_them(silent_s: float, missed: int):
    turning = hostile.scene(3, duration_s=200.0, turn_degps=5.0, turn_deg=150.0).later(60.0)
    told = hostile.tell(turning.changed(hostile.lose_echoes(1.0), after_s=48.0, for_s=silent_s), step_s=3.0)
    assert told.fixes >= told.steps - missed
    assert told.inside >= told.fixes - 1
    assert told.worst_m < 100.0


def test_a_turn_between_two_steps_is_no_other_place():
    told = hostile.tell(hostile.scene(1, turn_degps=2.0, turn_deg=160.0), step_s=60.0)
    assert told.fixes == told.steps
    assert told.worst_m < 150.0


def test_a_gyro_90_deg_off_moves_nothing():
    scene = hostile.scene(8, duration_s=100.0)
    told = hostile.tell(scene.changed(hostile.gyro_off(scene.truth, 90.0)))
    assert told.fixes >= 5
    assert told.worst_m < 150.0


def test_every_place_that_is_given_out_states_a_doubt_within_its_limits():
    told = hostile.tell(hostile.scene(9, duration_s=120.0))
    assert told.fixes >= 5
    assert 0.999 * told.fixes * MODEL.doubt_reached <= told.expected_wrong <= told.fixes * MODEL.most_doubt
