"""Hints are weighed and never believed; AIS shifted alike raises the alarm; a common speed proves little."""

from dataclasses import replace

import numpy as np
import pytest

import navfix
from navfix.association import scene as scenes
from navfix.association import second_group, seeded
from navfix.association.lengths import log_length_ratio
from navfix.association.proof import prove
from navfix.association.speeds import log_speed_ratio
from navfix.catalog import association_method, association_model, radar_model
from navfix.errors import Ambiguous, NoFix
from navfix.geodesy import LocalPlane, direct, inverse
from navfix.simulation.scenes import SceneRecipe, make_scene
from navfix.types import Epoch, HeadingHint, Hull, Mark, Position, PositionHint, RadarTarget
from navfix.units import NM_M

SPARSE = SceneRecipe(8, 40, 12.0, 24.0, clutter=0.4, false_ais=0.1)
BUSY = SceneRecipe(25, 80, 12.0, 20.0, clutter=0.25, false_ais=0.1)


def answered(epochs):
    """Return the associations of the epochs that have an answer, with their numbers."""
    found = {}
    for number, epoch in enumerate(epochs):
        try:
            found[number] = navfix.associate(epoch)
        except NoFix:
            continue
    return found


@pytest.fixture(scope="module")
def sparse():
    return [make_scene(SPARSE, seed) for seed in range(25)]


def test_right_hints_give_answers_where_the_echoes_alone_do_not(sparse):
    alone = answered(m.epoch for m in sparse)
    helped = answered(
        replace(
            m.epoch, heading_hint=HeadingHint(m.heading_deg + 1.0, 1.5), position_hint=PositionHint(m.position, 500.0)
        )
        for m in sparse
    )
    assert len(helped) >= len(alone) + 5
    assert all(inverse(found.position, sparse[k].position)[0] < 500.0 for k, found in helped.items())
    assert not any(found.notes for found in helped.values())


@pytest.mark.parametrize("what", ["gyro 90 deg off", "position 20 NM off"])
def test_a_wrong_hint_is_found_out_and_misleads_nobody(sparse, what: str):
    wrong = [
        replace(m.epoch, heading_hint=HeadingHint(m.heading_deg + 90.0, 1.5))
        if what.startswith("gyro")
        else replace(m.epoch, position_hint=PositionHint(direct(m.position, 45.0, 20.0 * NM_M), 500.0))
        for m in sparse
    ]
    found = answered(wrong)
    assert found
    for number, association in found.items():
        assert inverse(association.position, sparse[number].position)[0] < 500.0
        assert any("refuted" in note for note in association.notes)


def test_a_compass_error_in_true_bearings_is_found_out():
    made = make_scene(BUSY, 5)
    turned = tuple(
        replace(t, bearing_deg=t.bearing_deg + made.heading_deg - 90.0, bearing_reference="true")
        for t in made.epoch.targets
    )
    found = navfix.associate(replace(made.epoch, targets=turned))
    assert inverse(found.position, made.position)[0] < 200.0
    assert any("compass" in note for note in found.notes)


def test_ais_shifted_alike_raises_the_alarm_with_its_vector():
    alarms = answers = 0
    for seed in range(12):
        made = make_scene(SceneRecipe(40, 120, 12.0, 20.0, 0.2, 0.3, coherent_m=1500.0), seed)
        try:
            found = navfix.associate(made.epoch)
        except NoFix:
            continue
        answers += 1
        if found.second_group is not None:
            alarms += 1
            assert found.second_group.offset_m == pytest.approx(1500.0, abs=200.0)
            assert len(found.second_group.targets) >= 3
    assert answers >= 10
    assert alarms >= 0.9 * answers


def test_wrong_positions_that_do_not_agree_raise_no_alarm():
    assert not any(
        found.second_group for found in answered(make_scene(BUSY, seed).epoch for seed in range(15)).values()
    )


def test_fewer_left_over_than_a_group_needs_are_no_group():
    made = make_scene(BUSY, 1)
    model = association_model()
    scene = scenes.build(made.epoch, radar_model("imo"), model)
    found = seeded.search(scene, model)
    everything = np.column_stack([np.arange(len(scene.rho)), np.arange(len(scene.rho))])
    assert second_group.find(found, model, everything) is None


def test_the_thesis_method_solves_complete_clouds_and_fails_on_partial_ones():
    complete = [make_scene(SceneRecipe(20, 24, 12.0, 12.0), seed) for seed in range(8)]
    partial = [make_scene(SceneRecipe(30, 150, 12.0, 24.0, 0.1, 0.05), seed) for seed in range(4)]
    right = [inverse(navfix.associate(m.epoch, method="cpd").position, m.position)[0] < 300.0 for m in complete]
    wrong = [inverse(navfix.associate(m.epoch, method="cpd").position, m.position)[0] > 300.0 for m in partial]
    assert np.mean(right) >= 0.9
    assert all(wrong)
    assert association_method("cpd").starts == 8


def test_with_a_heading_one_start_suffices_for_complete_clouds():
    made = make_scene(SceneRecipe(20, 24, 12.0, 12.0), 3)
    epoch = replace(made.epoch, heading_hint=HeadingHint(made.heading_deg + 5.0, 3.0))
    assert inverse(navfix.associate(epoch, method="cpd").position, made.position)[0] < 300.0


def test_an_exhaustive_search_finds_nothing_that_the_fast_one_missed():
    model = association_model()
    for seed in (0, 1):
        made = make_scene(SceneRecipe(10, 18, 3.0, 4.0, 0.1, 0.0), seed)
        found = seeded.search(scenes.build(made.epoch, radar_model("imo"), model), model)
        proved = prove(found, model)
        assert proved.complete
        assert proved.certified
        assert len(proved.answers.evidence) == 1
        assert proved.open_cells < 0.2 * proved.cells


def test_an_exhaustive_search_names_what_a_crippled_one_missed():
    model = association_model()
    made = make_scene(SceneRecipe(10, 18, 3.0, 4.0, 0.1, 0.0), 0)
    found = seeded.search(scenes.build(made.epoch, radar_model("imo"), model), model)
    wrong, right = found.answers.take(np.array([1])), found.answers.take(np.array([0]))
    crippled = replace(found, answers=replace(wrong, evidence=right.evidence))
    proved = prove(crippled, model)
    assert proved.complete
    assert not proved.certified
    assert proved.answers.evidence[proved.missed[0]] == pytest.approx(right.evidence[0], abs=2.0)


def test_a_regular_row_tells_its_step_and_direction():
    plane = LocalPlane(Position(54.0, 8.0))
    row = tuple(
        Mark(f"buoy {k}", plane.to_position(0.7 * k * NM_M, 0.7 * k * NM_M), 10.0, kind="aton") for k in range(10)
    )
    own = plane.to_position(2.0 * NM_M, 3.4 * NM_M)
    polar = [inverse(own, mark.position) for mark in row[2:7]]
    targets = tuple(
        RadarTarget(f"{k}", r, b - 77.0, range_sigma_m=20.0, bearing_sigma_deg=0.5) for k, (r, b) in enumerate(polar)
    )
    with pytest.raises(Ambiguous, match=r"0\.99 NM apart along 045°"):
        navfix.associate(Epoch(None, targets, row))


def test_a_common_speed_proves_little_and_a_rare_one_much():
    marks = np.array([0.0] * 8 + [7.3, 12.0])
    targets = np.array([0.0] * 5 + [7.3])
    ratio = log_speed_ratio(targets, marks)
    assert ratio[5, 8] > ratio[0, 0] + 0.5
    assert ratio[5, 0] < -1.0
    assert ratio[0, 0] < 0.6


def test_unknown_speeds_say_nothing():
    ratio = log_speed_ratio(np.array([np.nan, 3.0, 4.0]), np.array([2.0, np.nan, 5.0]))
    assert np.all(ratio[0] == 0.0)
    assert np.all(ratio[:, 1] == 0.0)


def test_speeds_carry_no_evidence_on_the_average_of_wrong_pairs():
    random = np.random.default_rng(1)
    marks = np.abs(random.normal(0.0, 5.0, 60)) * (random.uniform(size=60) > 0.4)
    targets = marks[random.integers(60, size=30)] + 0.3 * random.normal(size=30)
    assert np.mean(np.exp(log_speed_ratio(targets, marks))) < 1.0


def test_speeds_that_are_all_wrong_cost_no_more_than_the_doubt_about_them():
    model, radar = association_model(), radar_model("imo")
    made = make_scene(BUSY, 3)
    random = np.random.default_rng(4)
    targets = tuple(replace(t, speed_mps=abs(9.0 * random.normal())) for t in made.epoch.targets)
    marks = tuple(replace(m, speed_mps=abs(3.0 * random.normal())) for m in made.epoch.marks)

    def evidence(epoch, model):
        return seeded.search(scenes.build(epoch, radar, model), model).answers.evidence[0]

    told = replace(made.epoch, targets=targets, marks=marks)
    without = evidence(made.epoch, model)
    assert evidence(told, model) > without - np.log(2.0) - 0.1
    target, mark = np.array(made.pairs).T
    believed = seeded.search(scenes.build(told, radar, model), model).field.log_pair_ratio[target, mark]
    assert believed.sum() < -5.0  # what it would cost to believe them


def test_the_size_of_an_echo_tells_a_tanker_from_coasters_and_nothing_among_coasters():
    marks = np.array([80.0] * 8 + [300.0, np.nan])
    targets = np.array([70.0] * 5 + [240.0, np.nan])
    ratio = log_length_ratio(targets, marks)
    assert ratio[5, 8] > ratio[0, 0] + 0.5
    assert ratio[5, 0] < -0.5
    assert abs(ratio[0, 0]) < 0.6
    assert np.all(ratio[:, 9] == 0.0)
    assert np.all(ratio[6] == 0.0)


def test_lengths_raise_the_evidence_of_right_places_and_can_be_switched_off():
    model, gains = association_model(), []
    for seed in range(12):
        made = make_scene(SceneRecipe(14, 60, 12.0, 20.0, 0.2, 0.1, lengths=True), seed)
        scene = scenes.build(made.epoch, radar_model("imo"), model)
        told, untold = (seeded.search(scene, replace(model, use_length=use)) for use in (True, False))
        if inverse(scenes.position_of(scene, complex(told.answers.poses.p[0])), made.position)[0] < 300.0:
            gains.append(told.answers.evidence[0] - untold.answers.evidence[0])
    assert len(gains) >= 10
    assert np.mean(gains) > 0.5


def test_a_long_ship_close_by_without_an_echo_speaks_against_a_place_and_one_of_unknown_length_hardly():
    made = make_scene(BUSY, 2)
    model = association_model()

    def evidence_with(*more: Mark) -> float:
        epoch = replace(made.epoch, marks=made.epoch.marks + more)
        scene = scenes.build(epoch, radar_model("imo"), model)
        return float(seeded.search(scene, model).answers.log_ratio[0])

    places = [direct(made.position, azimuth_deg, 2000.0) for azimuth_deg in (40.0, 160.0, 280.0)]
    known = [Mark(f"{k}", p, 10.0, mmsi=k, hull=Hull(120.0, 60.0, 12.0, 12.0)) for k, p in enumerate(places)]
    small = [Mark(f"{k}", p, 10.0, mmsi=k, ais_class="B") for k, p in enumerate(places)]
    assert evidence_with(*known) < evidence_with() - 2.0
    assert evidence_with(*small) > evidence_with() - 1.0
