"""Reliability: redundancy numbers, tests, detectable errors, sigma0, R95."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment.dense import minimise
from navfix.adjustment.network import RANGE, TRUE_BEARING, Network
from navfix.adjustment.reliability import DELTA0, Quality, assess, global_test, radius_of_probability
from navfix.adjustment.sights import residuals
from navfix.adjustment.solve import Solution, solve
from navfix.types import confidence_radius
from tests.adjustment_scenes import mixed_network, plane_scene

NONE = catalog.kernel("none")


def assessed(network: Network, kernel: str = "none") -> tuple[Solution, Quality]:
    solution = solve(network, catalog.kernel(kernel), solver="dense")
    return solution, assess(network, solution.pose, solution.weights, solution.cofactor, "joint")


def test_redundancy_numbers_add_up_to_the_redundancy() -> None:
    _, quality = assessed(plane_scene(np.random.default_rng(1), marks=7).network)
    assert quality.redundancy_number.sum() == pytest.approx(14 - 3)
    assert quality.dof == pytest.approx(11.0)


@pytest.mark.parametrize("full_covariance", [False, True])
def test_redundancy_numbers_add_up_with_correlations_and_a_prior(full_covariance: bool) -> None:
    network = mixed_network(np.random.default_rng(2), np.zeros(3), noise=1.0, full_covariance=full_covariance)
    network = replace(network, heading_prior_rad=(0.0, 0.02))
    solution, quality = assessed(network)
    of_prior = 1.0 - solution.cofactor[2, 2] / 0.02**2
    assert quality.redundancy_number.sum() + of_prior == pytest.approx(network.redundancy)


def test_redundancy_number_is_the_share_of_an_error_that_shows() -> None:
    """Move one observation by a little, adjust again: its own residual changes by -r times that."""
    network = plane_scene(np.random.default_rng(3), marks=6, noise=0.1).network
    solution, quality = assessed(network)
    for index in range(4):
        push = 1e-3 * network.sigma[index]
        value = network.value.copy()
        value[index] += push
        again = minimise(replace(network, value=value), NONE, "joint", solution.pose[None, :]).pose[0]
        change = residuals(replace(network, value=value), again)[index] - residuals(network, solution.pose)[index]
        assert change / push == pytest.approx(-quality.redundancy_number[index], abs=5e-3)


def test_an_error_of_the_size_of_the_mdb_shifts_the_fix_by_the_external_reliability() -> None:
    network = plane_scene(np.random.default_rng(4), marks=8, noise=0.0).network
    solution, quality = assessed(network)
    for index in (0, 1, 6, 7):
        value = network.value.copy()
        value[index] += 0.01 * quality.mdb[index]
        again = minimise(replace(network, value=value), NONE, "joint", solution.pose[None, :]).pose[0]
        shift = math.hypot(*(again - solution.pose)[:2])
        assert shift == pytest.approx(0.01 * quality.external_m[index], rel=0.02)


def test_mdb_by_hand() -> None:
    """A distance measured twice from a fixed line: r = 1/2 each, MDB = sigma delta0 sqrt 2."""
    kinds, marks = [RANGE, RANGE, TRUE_BEARING], [[1000.0, 0.0]]
    network = Network.build(kinds, [0, 0, 0], [999.0, 1001.0, 0.0], [2.0, 2.0, 0.001], marks)
    _, quality = assessed(network)
    np.testing.assert_allclose(quality.redundancy_number[:2], 0.5, atol=1e-9)
    np.testing.assert_allclose(quality.mdb[:2], 2.0 * DELTA0 * math.sqrt(2.0))
    np.testing.assert_allclose(quality.standardized[:2], [0.5 * math.sqrt(2.0), -0.5 * math.sqrt(2.0)], atol=1e-6)
    assert not quality.testable[2]
    assert math.isinf(quality.mdb[2])


def test_delta0_is_that_of_alpha_001_and_power_80() -> None:
    from scipy.special import ndtri

    assert pytest.approx(ndtri(1.0 - 0.0005) + ndtri(0.80), abs=5e-5) == DELTA0


def test_standardised_residuals_of_good_data_are_standard_normal() -> None:
    rng, collected = np.random.default_rng(5), []
    for _ in range(150):
        scene = plane_scene(rng, marks=5)
        found = minimise(scene.network, NONE, "joint", scene.truth[None, :]).pose[0]
        solution = solve(scene.network, NONE, solver="dense", start=found)
        collected.append(assess(scene.network, found, solution.weights, solution.cofactor, "joint").standardized)
    w = np.concatenate(collected)
    assert np.mean(w) == pytest.approx(0.0, abs=0.08)
    assert np.std(w) == pytest.approx(1.0, abs=0.05)
    assert np.mean(np.abs(w) > 1.96) == pytest.approx(0.05, abs=0.02)


def test_sigma0_counts_only_what_the_kernel_has_left() -> None:
    scene = plane_scene(np.random.default_rng(6), marks=12, wrong=3)
    solution, quality = assessed(scene.network, "hampel")
    assert solution.weights[np.isin(scene.network.mark, scene.wrong)].max() < 1e-6
    assert quality.dof == pytest.approx(solution.weights.sum() - 3.0)
    assert quality.dof < 18.0 + 1e-9
    assert 0.5 < quality.sigma0 < 1.6
    np.testing.assert_allclose(quality.covariance, quality.sigma0**2 * quality.cofactor)


def test_below_three_degrees_of_freedom_sigma0_is_not_used() -> None:
    _, two = assessed(plane_scene(np.random.default_rng(7), marks=2).network)
    assert (two.scaling, round(two.dof)) == ("a_priori", 1)
    np.testing.assert_array_equal(two.covariance, two.cofactor)
    _, three = assessed(plane_scene(np.random.default_rng(7), marks=3).network)
    assert (three.scaling, round(three.dof)) == ("a_posteriori", 3)


def test_global_test_has_the_chi_square_threshold() -> None:
    assert global_test(10.0, 5.0).threshold == pytest.approx(11.0705, abs=1e-4)  # tables: chi-square, 5 dof, 95 %
    assert global_test(11.0, 5.0).passed
    assert not global_test(11.1, 5.0).passed
    assert global_test(0.0, 0.0) is None  # nothing to test


def test_global_test_fails_when_sigmas_are_far_too_small() -> None:
    network = plane_scene(np.random.default_rng(8), marks=15, mark_sigma_m=0.0).network
    assert assessed(network)[1].global_test.passed
    assert not assessed(replace(network, sigma=network.sigma / 3.0))[1].global_test.passed


def test_r95_of_a_circle_a_line_and_an_ellipse() -> None:
    assert radius_of_probability(np.eye(2) * 4.0, 0.95) == pytest.approx(2.0 * confidence_radius(0.95))
    assert radius_of_probability(np.diag([9.0, 0.0]), 0.95) == pytest.approx(3.0 * 1.959964, rel=1e-4)
    assert radius_of_probability(np.eye(2), 0.95, dof=7.0) == pytest.approx(confidence_radius(0.95, dof=7.0))
    assert radius_of_probability(np.zeros((2, 2)), 0.95) == 0.0


def test_r95_holds_95_percent_of_an_oblique_ellipse() -> None:
    rng = np.random.default_rng(9)
    root = np.array([[30.0, 0.0], [18.0, 5.0]])
    drawn = rng.normal(size=(200_000, 2)) @ root.T
    radius = radius_of_probability(root @ root.T, 0.95)
    assert np.mean(np.hypot(*drawn.T) < radius) == pytest.approx(0.95, abs=0.0015)
