"""Solution separation and the protection level: against solving again, by hand, and where there is none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix import adjust, catalog
from navfix.adjustment.dense import minimise
from navfix.adjustment.reliability import assess
from navfix.adjustment.solve import solve
from navfix.errors import InputError
from navfix.integrity import with_integrity
from navfix.integrity.levels import (
    false_alarm_factor,
    level_of_risk,
    missed_detection_factor,
    separation_levels,
    slope_level,
)
from navfix.integrity.protection import blocks_of_fix, blocks_of_network, protection
from navfix.integrity.separation import Blocks, separate
from navfix.report.answer import Answer
from navfix.report.text import report_text
from navfix.types import AdjustedObservation, Fix, HeadingHint, PlanePosition
from tests.adjustment_scenes import epoch_scene, plane_scene

PROBABILITIES = {"probability_of_false_alarm": 1e-3, "probability_of_missed_detection": 1e-4}


def fixed(seed: int = 3, **scene: object) -> Fix:
    epoch, association = epoch_scene(np.random.default_rng(seed), **scene)  # type: ignore[arg-type]
    return adjust(epoch, association)


# ------------------------------------------------------------------------------------------------------- separation


def test_leaving_a_mark_out_is_what_solving_again_gives() -> None:
    """Least squares: shift within 1 % of its sigma (the problem is not quite linear), cofactors within 1 %."""
    network = plane_scene(np.random.default_rng(5), marks=8).network
    least_squares = catalog.kernel("none")
    solution = solve(network, least_squares, solver="dense")
    separation = separate(blocks_of_network(network, solution.pose, solution.weights))
    for k in range(8):
        rest = replace(network, mask=network.mark != k)
        again = solve(rest, least_squares, solver="dense", start=solution.pose)
        sigma = np.sqrt(np.diagonal(again.cofactor))
        assert np.all(np.abs(again.pose - solution.pose - separation.shift[k]) < 0.01 * sigma)
        assert np.all(np.abs(separation.without[k] - again.cofactor) < 0.01 * np.outer(sigma, sigma))


def test_a_set_of_marks_is_left_out_together() -> None:
    network = plane_scene(np.random.default_rng(6), marks=8).network
    solution = solve(network, catalog.kernel("none"), solver="dense")
    blocks = blocks_of_network(network, solution.pose, solution.weights)
    out = np.isin(np.arange(8), [1, 4])
    rest = Blocks(blocks.rows[~out], blocks.residual[~out], blocks.prior, tuple("abcdef"))
    separation = separate(blocks, out[None, :])
    assert separation.without[0] == pytest.approx(np.linalg.inv(rest.information.sum(axis=0)), rel=1e-9)
    single = minimise(replace(network, mask=~out[network.mark]), catalog.kernel("none"), "joint", solution.pose[None])
    assert single.pose[0, :2] - solution.pose[:2] == pytest.approx(separation.shift[0, :2], abs=0.3)


def test_the_record_of_a_fix_says_the_same_as_its_network() -> None:
    """The normal matrix put together from the record is the inverse of the cofactor matrix, outliers and all."""
    for scene in ({}, {"wrong": 5}):
        fix = fixed(**scene)
        blocks = blocks_of_fix(fix)
        normal = blocks.information.sum(axis=0) + blocks.prior
        assert np.linalg.inv(normal) == pytest.approx(fix.cofactor_matrix, rel=1e-6, abs=1e-12)
        assert np.all(blocks.prior == 0.0)


@pytest.mark.parametrize("sigma_deg", [0.0, 0.3, 1.0])
def test_the_error_that_all_true_bearings_share_is_an_unknown_with_its_prior(sigma_deg: float) -> None:
    epoch, association = epoch_scene(np.random.default_rng(3), bearing_reference="true")
    fix = adjust(epoch, association, compass_sigma_deg=sigma_deg)
    blocks = blocks_of_fix(fix)
    normal = blocks.information.sum(axis=0) + blocks.prior
    assert np.linalg.inv(normal)[:2, :2] == pytest.approx(fix.cofactor_matrix, rel=1e-4)
    assert len(normal) == (2 if sigma_deg == 0.0 else 3)
    if sigma_deg > 0.0:
        assert math.degrees(blocks.prior[2, 2] ** -0.5) == pytest.approx(sigma_deg, rel=0.02)


def test_the_information_of_a_heading_prior_is_found_in_the_record() -> None:
    epoch, association = epoch_scene(np.random.default_rng(3), marks=6)
    fix = adjust(epoch, association, heading_prior=HeadingHint(123.4, 0.5))
    assert blocks_of_fix(fix).prior[2, 2] == pytest.approx(math.radians(0.5) ** -2, rel=1e-3)


def test_an_outlier_that_was_given_up_is_no_hypothesis() -> None:
    fix = fixed(wrong=4)
    given_up = {o.mark for o in fix.observations if o.weight == 0.0}
    assert given_up
    assert set(blocks_of_fix(fix).taking_part().labels) == {o.mark for o in fix.observations} - given_up


# ----------------------------------------------------------------------------------------------------------- levels


def test_the_factors_are_normal_quantiles_of_the_split_probability() -> None:
    """Tail 1e-3 / 40 = 2.5e-5 and 1e-4 / 44: tabulated normal quantiles 4.0556 and 4.5855."""
    assert false_alarm_factor(1e-3, 10) == pytest.approx(4.0556, abs=1e-4)
    assert missed_detection_factor(1e-4, 10) == pytest.approx(4.5855, abs=1e-3)
    assert false_alarm_factor(0.05, 1, axes=1) == pytest.approx(1.95996, abs=1e-5)


def test_four_marks_around_by_hand() -> None:
    """Four ranges north, east, south, west of sigma 1: s_0^2 = 1/2 on each axis; without one, 1 on its axis."""
    rows = np.array([[[-1.0, 0.0]], [[0.0, -1.0]], [[1.0, 0.0]], [[0.0, 1.0]]])
    blocks = Blocks(rows, np.array([[0.1], [0.0], [0.1], [0.0]]), np.zeros((2, 2)), tuple("nesw"))
    separation = separate(blocks)
    assert np.diagonal(separation.cofactor) == pytest.approx([0.5, 0.5])
    assert np.diagonal(separation.without[0]) == pytest.approx([1.0, 0.5])
    assert separation.shift[0] == pytest.approx([-0.1, 0.0])
    levels = separation_levels(separation, scale=10.0, **PROBABILITIES)
    axis = 10.0 * (false_alarm_factor(1e-3, 4) * math.sqrt(0.5) + missed_detection_factor(1e-4, 4))
    assert levels.protection_m == pytest.approx(math.sqrt(2.0) * axis)
    assert levels.alarms == ()


def test_the_split_level_is_never_below_the_one_that_the_risk_allows() -> None:
    separation = separate(blocks_of_fix(fixed(marks=8)).taking_part())
    levels = separation_levels(separation, scale=1.0, **PROBABILITIES)
    threshold = false_alarm_factor(1e-3, 8) * np.sqrt(separation.variance)
    sigma = np.sqrt(np.diagonal(separation.without, axis1=1, axis2=2))
    whole = np.sqrt(np.diagonal(separation.cofactor))
    tight = [level_of_risk(whole[i], sigma[:, i], threshold[:, i], 1.0, 1e-4 / 2.0) for i in (0, 1)]
    assert 0.8 * levels.protection_m < math.hypot(*tight) <= levels.protection_m


def test_a_risk_outside_0_1_is_refused() -> None:
    with pytest.raises(InputError, match="risk must be within"):
        level_of_risk(1.0, 1.0, 1.0, 1.0, 0.0)


def test_the_slope_of_four_marks_by_hand() -> None:
    """An error f of the northern range moves the fix by f/2 and adds f^2/2: slope 1/sqrt(2), times the pbias."""
    rows = np.array([[[-1.0, 0.0]], [[0.0, -1.0]], [[1.0, 0.0]], [[0.0, 1.0]]])
    blocks = Blocks(rows, np.zeros((4, 1)), np.zeros((2, 2)), tuple("nesw"))
    level = slope_level(blocks, np.eye(2) / 2.0, scale=1.0, dof=2.0, **PROBABILITIES)
    from scipy.special import chndtr

    noncentrality = 2.0 * level**2
    assert chndtr(2.0 * math.log(1e3), 2.0, noncentrality) == pytest.approx(1e-4, rel=1e-3)


def test_without_redundancy_there_is_no_slope() -> None:
    blocks = Blocks(np.eye(2)[:, None, :], np.zeros((2, 1)), np.zeros((2, 2)), ("a", "b"))
    assert math.isinf(slope_level(blocks, np.eye(2), scale=1.0, dof=0.0, **PROBABILITIES))
    assert math.isinf(slope_level(blocks, np.eye(2), scale=1.0, dof=1.0, **PROBABILITIES))


# -------------------------------------------------------------------------------------------------- the level of a fix


def test_a_fix_of_twenty_marks_has_a_level_beyond_its_95_percent_radius() -> None:
    fix = with_integrity(fixed(wrong=3))
    assert fix.integrity is not None
    level, slope = fix.integrity.protection_level_m, fix.integrity.slope_level_m
    assert level is not None
    assert slope is not None
    assert 2.0 * fix.integrity.r95_m < level < 10.0 * fix.integrity.r95_m
    assert (fix.integrity.probability_of_false_alarm, fix.integrity.probability_of_missed_detection) == (1e-3, 1e-4)
    assert fix.integrity.reason == ""


def test_smaller_probabilities_make_a_larger_level() -> None:
    fix = fixed()
    strict = with_integrity(fix, probability_of_missed_detection=1e-9).integrity
    usual = with_integrity(fix).integrity
    assert strict is not None
    assert usual is not None
    assert strict.protection_level_m > usual.protection_level_m  # type: ignore[operator]


def test_two_marks_carry_no_level_and_the_report_says_why() -> None:
    fix = with_integrity(fixed(marks=2))
    assert fix.integrity is not None
    assert fix.integrity.protection_level_m is None
    assert "nothing would determine the fix" in fix.integrity.reason
    assert "protection level not available" in report_text(Answer(fix.epoch, fix))


def test_residuals_that_happen_to_be_small_promise_nothing() -> None:
    blocks = blocks_of_fix(fixed())
    levels = [protection(blocks, sigma0=s, dof=37.0, reach_m=5e3).level_m for s in (0.3, 1.0, 1.15)]
    assert levels[0] == levels[1]
    assert levels[2] == pytest.approx(1.15 * levels[1])  # type: ignore[operator]


def test_residuals_larger_than_chance_explains_make_the_level_hold_against_three_marks() -> None:
    """37 degrees of freedom: sigma0 1.15 passes the global test, 1.3 does not."""
    blocks = blocks_of_fix(fixed(marks=8))
    passed, failed = (protection(blocks, sigma0=s, dof=37.0, reach_m=2e4).level_m for s in (1.15, 1.3))
    assert passed is not None
    assert failed is not None
    assert failed > 1.5 * 1.3 / 1.15 * passed
    sets = np.array([[i in (0, 3, 5) for i in range(8)]])
    three = separation_levels(separate(blocks, sets), scale=1.3, **PROBABILITIES).protection_m
    assert failed >= three  # and with more hypotheses
    none = protection(blocks, sigma0=1.3, dof=37.0, reach_m=300.0)
    assert none.level_m is None
    assert "several marks may be wrong alike" in none.reason


def test_three_marks_shifted_alike_in_a_narrow_sector_do_not_pass_the_level_unnoticed() -> None:
    """20 deg, three near marks of eight shifted alike: turned by 3 deg, seven of them fit a place 300 m off.

    The fix is wrong and its loss is lower than that of the right place; the global test fails. Scenes 815, 5920 and
    9299 of the study, drawn in turn.
    """
    rng, found = np.random.default_rng(65), []
    for index in range(9300):
        scene = plane_scene(rng, marks=8, wrong=3, agreeing=True, sector_deg=20.0)
        if index not in (815, 5920, 9299):
            continue
        solution = solve(scene.network, catalog.kernel("hampel"), solver="dense")
        quality = assess(scene.network, solution.pose, solution.weights, solution.cofactor, "joint")
        blocks = blocks_of_network(scene.network, solution.pose, solution.weights)
        level_m = protection(blocks, sigma0=quality.sigma0, dof=quality.dof, reach_m=4000.0).level_m
        found.append((float(np.hypot(*solution.pose[:2])), level_m))
    assert all(error_m > 200.0 for error_m, _ in found)
    assert all(level_m is None or level_m > error_m for error_m, level_m in found)


def test_a_level_of_half_the_distance_to_the_marks_is_no_level() -> None:
    found = protection(blocks_of_fix(fixed(marks=4)), sigma0=1.0, dof=5.0, reach_m=100.0)
    assert found.level_m is None
    assert "too much beside the distance" in found.reason


def test_a_shift_beyond_chance_is_an_alarm_in_place_of_a_level() -> None:
    """A residual of the first target that no damping took out."""
    blocks = blocks_of_fix(fixed())
    residual = np.array(blocks.residual)
    residual[0] += 30.0
    found = protection(Blocks(blocks.rows, residual, blocks.prior, blocks.labels), sigma0=1.0, dof=37.0, reach_m=5e3)
    assert found.level_m is None
    assert found.reason.startswith("alarm: without m0 the fix would lie ")


def test_a_fix_without_its_marks_has_no_level() -> None:
    fix = fixed()
    for bare in (replace(fix, epoch=None), replace(fix, position=PlanePosition(0.0, 0.0))):
        integrity = with_integrity(bare).integrity
        assert integrity is not None
        assert integrity.protection_level_m is None
        assert "does not carry its marks" in integrity.reason
    stranger = AdjustedObservation("T", "nobody", "range", 1.0, 1.0, 0.0, 1.0, 0.0, 0.5, 1.0, None)
    with pytest.raises(InputError, match="nobody"):
        blocks_of_fix(replace(fix, observations=(stranger,)))


@pytest.mark.parametrize("name", ["probability_of_false_alarm", "probability_of_missed_detection"])
def test_probabilities_outside_0_1_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=name):
        with_integrity(fixed(), **{name: 1.0})


def test_blocks_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="do not fit"):
        Blocks(np.zeros((2, 2, 3)), np.zeros((2, 1)), np.zeros((3, 3)), ("a", "b"))


def ring(count: int) -> Blocks:
    """Targets all round, with ranges to 30 m and relative bearings to 1 deg, that fit."""
    rng = np.random.default_rng(1)
    azimuth, range_m = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(2000.0, 8000.0, count)
    rows = np.zeros((count, 2, 3))
    rows[:, 0, :2] = -np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1) / 30.0
    bearing = np.stack([np.sin(azimuth) / range_m, -np.cos(azimuth) / range_m, -np.ones(count)], axis=1)
    rows[:, 1] = bearing / np.radians(1.0)
    return Blocks(rows, np.zeros((count, 2)), np.zeros((3, 3)), tuple(map(str, range(count))))


@pytest.mark.parametrize("count", [8, 23, 64, 200])
def test_of_many_marks_too_the_level_of_suspicious_residuals_holds_against_several(count: int) -> None:
    """sigma0 = 2 alone would double the level."""
    calm = protection(ring(count), sigma0=1.0, dof=2.0 * count - 3.0, reach_m=5000.0).level_m
    suspect = protection(ring(count), sigma0=2.0, dof=2.0 * count - 3.0, reach_m=5000.0).level_m
    assert calm is not None
    assert suspect is not None
    assert suspect > 2.2 * calm
