"""Two roads to one answer: GTSAM's graph and dense normal equations; marginals in north and east."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment import graph
from navfix.adjustment.damped import observation_weights
from navfix.adjustment.dense import minimise, total_loss
from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, Network
from navfix.adjustment.solve import solve
from navfix.adjustment.whitening import normal_matrix, whitened
from navfix.errors import Unobservable
from tests.adjustment_scenes import mixed_network, plane_scene

KERNELS = ("none", "huber", "hampel", "danish", "tukey", "igg3", "gnc", "gdynia_linear")
TRUTH = np.array([0.0, 0.0, 0.4])


def dense_cofactor(network: Network, kernel: str, damping: str, pose: np.ndarray) -> np.ndarray:
    weights = observation_weights(network, catalog.kernel(kernel), damping, pose)
    u = network.unknowns
    return np.linalg.inv(normal_matrix(network, whitened(network, pose, damping)[1], weights)[:u, :u])


@pytest.mark.parametrize("damping", ["joint", "separate"])
@pytest.mark.parametrize("kernel", KERNELS)
def test_graph_and_dense_road_meet(kernel: str, damping: str) -> None:
    """The graph from 20 m off, to 0.1 mm; from the dense solution it must not move by a micrometre."""
    scene = plane_scene(np.random.default_rng(11), marks=12, wrong=1)
    damper, start = catalog.kernel(kernel), scene.truth + np.array([15.0, -12.0, 0.005])
    dense = minimise(scene.network, damper, damping, start[None, :])
    assert dense.step[0] < 1e-8
    from_afar = graph.solve(scene.network, damper, damping, start)
    np.testing.assert_allclose(from_afar.pose, dense.pose[0], atol=1e-4)
    near = graph.solve(scene.network, damper, damping, dense.pose[0])
    np.testing.assert_allclose(near.pose, dense.pose[0], atol=1e-6)
    assert near.chi2 / 2.0 == pytest.approx(dense.loss[0], rel=1e-9)
    expected = dense_cofactor(scene.network, kernel, damping, dense.pose[0])
    np.testing.assert_allclose(near.cofactor, expected, rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize("full_covariance", [False, True])
@pytest.mark.parametrize("damping", ["joint", "separate"])
@pytest.mark.parametrize("kernel", ["none", "hampel"])
def test_roads_meet_for_mixed_observations_and_oblique_marks(kernel: str, damping: str, full_covariance: bool) -> None:
    """Ranges, relative and true bearings, targets of one to three observations, marks with a full covariance."""
    for prior in (None, (0.41, 0.01)):
        network = mixed_network(np.random.default_rng(12), TRUTH, noise=1.0, full_covariance=full_covariance)
        network = replace(network, heading_prior_rad=prior)
        damper = catalog.kernel(kernel)
        dense = minimise(network, damper, damping, TRUTH[None, :])
        near = graph.solve(network, damper, damping, dense.pose[0])
        np.testing.assert_allclose(near.pose, dense.pose[0], atol=1e-6)
        expected = dense_cofactor(network, kernel, damping, dense.pose[0])
        np.testing.assert_allclose(near.cofactor, expected, rtol=1e-5, atol=1e-12)


def test_without_relative_bearings_both_roads_solve_two_unknowns() -> None:
    marks = np.array([[4000.0, 1000.0], [-2000.0, 5000.0], [1000.0, -6000.0]])
    kinds, mark = np.tile([RANGE, TRUE_BEARING], 3), np.repeat(np.arange(3), 2)
    exact = np.stack([np.hypot(*marks.T), np.arctan2(marks[:, 1], marks[:, 0])], axis=1).ravel()
    network = Network.build(kinds, mark, exact + [5.0, 0.001] * 3, np.tile([20.0, 0.01], 3), marks, mark_sigma_m=5.0)
    hampel = catalog.kernel("hampel")
    by_graph = solve(network, hampel, solver="gtsam")
    by_dense = solve(network, hampel, solver="dense")
    assert (by_graph.solver, by_dense.solver) == ("gtsam", "dense")
    np.testing.assert_allclose(by_graph.pose, by_dense.pose, atol=1e-6)
    assert by_graph.cofactor.shape == (2, 2)
    np.testing.assert_allclose(by_graph.cofactor, by_dense.cofactor, rtol=1e-6)


def test_marginals_are_turned_from_the_ships_axes() -> None:
    """Marks ahead in the north, ship heading east: without turning, north and east variances would change places."""
    rng = np.random.default_rng(13)
    scene = plane_scene(rng, marks=6, sector_deg=20.0, noise=0.0)
    kinds, marks = np.tile([RANGE, RELATIVE_BEARING], 6), scene.network.mark_ne_m
    heading = math.radians(90.0)
    seen = np.stack([np.hypot(*marks.T), np.arctan2(marks[:, 1], marks[:, 0]) - heading], axis=1).ravel()
    network = Network.build(kinds, np.repeat(np.arange(6), 2), seen, scene.network.sigma, marks, mark_sigma_m=10.0)
    found = graph.solve(network, catalog.kernel("none"), "joint", np.array([1.0, 1.0, heading]))
    expected = dense_cofactor(network, "none", "joint", np.array([0.0, 0.0, heading]))
    np.testing.assert_allclose(found.cofactor, expected, rtol=1e-4, atol=1e-9)
    assert found.cofactor[1, 1] > 1.4 * found.cofactor[0, 0]


@pytest.mark.parametrize("damping", ["joint", "separate"])
def test_huber_without_limit_is_least_squares(damping: str) -> None:
    scene = plane_scene(np.random.default_rng(14), marks=8, wrong=2)
    limitless = replace(catalog.kernel("huber"), separate=(math.inf,), joint=(math.inf,))
    start = scene.truth[None, :]
    squares = minimise(scene.network, catalog.kernel("none"), damping, start)
    huber = minimise(scene.network, limitless, damping, start)
    np.testing.assert_allclose(huber.pose, squares.pose, atol=1e-6)
    assert huber.loss[0] == pytest.approx(squares.loss[0])


@pytest.mark.parametrize("damping", ["joint", "separate"])
@pytest.mark.parametrize("kernel", KERNELS)
def test_the_minimum_is_a_minimum(kernel: str, damping: str) -> None:
    """Fixed marks: small steps in every direction raise the loss."""
    rng = np.random.default_rng(15)
    scene = plane_scene(rng, marks=10, wrong=2, mark_sigma_m=0.0)
    damper = catalog.kernel(kernel)
    found = minimise(scene.network, damper, damping, scene.truth[None, :])
    around = found.pose[0] + rng.normal(size=(200, 3)) * [1.0, 1.0, 1e-4]
    assert np.all(total_loss(scene.network, damper, damping, around) > found.loss[0])


def test_folding_the_mark_in_is_first_order_equal_to_a_free_mark() -> None:
    """Least squares with free marks and priors, by GTSAM itself: the same fix within 1 % of its sigma."""
    import gtsam

    scene = plane_scene(np.random.default_rng(16), marks=8, mark_sigma_m=20.0)
    network = scene.network
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    values.insert(0, gtsam.Pose2(*scene.truth))
    noise = gtsam.noiseModel.Diagonal.Sigmas(network.sigma[[1, 0]])
    for index, place in enumerate(network.mark_ne_m):
        values.insert(1 + index, place)
        factors.add(gtsam.PriorFactorPoint2(1 + index, place, gtsam.noiseModel.Isotropic.Sigma(2, 20.0)))
        distance, bearing = network.value[2 * index : 2 * index + 2]
        factors.add(gtsam.BearingRangeFactor2D(0, 1 + index, gtsam.Rot2(bearing), distance, noise))
    free = gtsam.LevenbergMarquardtOptimizer(factors, values).optimize().atPose2(0)
    folded = minimise(network, catalog.kernel("none"), "joint", scene.truth[None, :]).pose[0]
    sigma = np.sqrt(np.diag(dense_cofactor(network, "none", "joint", folded)))
    assert np.all(np.abs(folded - [free.x(), free.y(), free.theta()]) < 0.01 * sigma)


def test_a_kernel_alone_does_not_save_a_far_start() -> None:
    """A redescender started far away stays there: why the start is robust and everything is checked."""
    scene = plane_scene(np.random.default_rng(17), marks=10)
    tukey, far = catalog.kernel("tukey"), scene.truth + np.array([20000.0, 0.0, 1.0])
    stuck = minimise(scene.network, tukey, "joint", far[None, :])
    assert math.hypot(*stuck.pose[0][:2]) > 10000.0
    with pytest.raises(Unobservable, match="GTSAM cannot solve this graph: Indeterminate linear system"):
        graph.solve(scene.network, tukey, "joint", far)
    assert math.hypot(*solve(scene.network, tukey, candidates=[("far", far)]).pose[:2]) < 50.0
