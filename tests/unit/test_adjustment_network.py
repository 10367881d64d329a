"""The plane network: predictions, derivatives, combined sigma, decorrelation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, Network
from navfix.adjustment.sights import curvature, effective_sigma, jacobian, predict, prior_residual, residuals, sight
from navfix.adjustment.whitening import block_covariance, target_norms, whitened
from navfix.errors import InputError
from tests.adjustment_scenes import mixed_network, plane_scene

POSE = np.array([120.0, -340.0, 0.7])


def small(**more: Any) -> Network:
    """One mark 3-4-5 km away, seen with every kind of observation."""
    kinds = [RANGE, RELATIVE_BEARING, TRUE_BEARING]
    return Network.build(kinds, [0, 0, 0], [5000.0, 0.5, 1.0], [10.0, 0.01, 0.02], [[3000.0, 4000.0]], **more)


def test_true_bearing_is_relative_plus_heading() -> None:
    distance, relative, true = predict(small(), np.array([0.0, 0.0, 0.3]))
    assert distance == pytest.approx(5000.0)
    assert true == pytest.approx(math.atan2(4.0, 3.0))
    assert relative + 0.3 == pytest.approx(true)


def test_residual_is_adjusted_minus_observed_and_bearings_wrap() -> None:
    network = Network.build([1, 0], [0, 0], [math.radians(359.9), 900.0], [0.01, 10.0], [[1000.0, 0.0]])
    v = residuals(network, np.zeros(3))
    assert math.degrees(v[0]) == pytest.approx(0.1)
    assert v[1] == pytest.approx(100.0)


def test_jacobian_is_the_slope_of_the_prediction() -> None:
    network = mixed_network(np.random.default_rng(1), POSE, noise=1.0, full_covariance=True)
    steps = np.diag([1e-3, 1e-3, 1e-7])
    slope = [(predict(network, POSE + s) - predict(network, POSE - s)) / (2.0 * s.max()) for s in steps]
    np.testing.assert_allclose(jacobian(network, POSE), np.array(slope).T, rtol=1e-6, atol=1e-9)


def test_curvature_is_the_slope_of_the_jacobian() -> None:
    rng = np.random.default_rng(2)
    network = mixed_network(rng, POSE, noise=1.0, full_covariance=False)
    factor = rng.normal(size=len(network.kind))
    by_steps = np.empty((2, 2))
    for axis in range(2):
        step = np.zeros(3)
        step[axis] = 0.05
        change = (jacobian(network, POSE + step) - jacobian(network, POSE - step)) / 0.1
        by_steps[axis] = factor @ change[:, :2]
    np.testing.assert_allclose(curvature(network, sight(network, POSE), factor), by_steps, rtol=1e-5, atol=1e-12)


def test_many_poses_at_once_are_the_same_as_one_by_one() -> None:
    network = mixed_network(np.random.default_rng(3), POSE, noise=1.0, full_covariance=True)
    poses = POSE + np.random.default_rng(4).normal(size=(5, 3)) * [100.0, 100.0, 0.1]
    v_all, a_all = whitened(network, poses)
    for pose, v, a in zip(poses, v_all, a_all, strict=True):
        v_one, a_one = whitened(network, pose)
        np.testing.assert_allclose(v_one, v, rtol=1e-12)
        np.testing.assert_allclose(a_one, a, rtol=1e-12)


def test_sigma_combines_radar_and_mark() -> None:
    network = small(mark_sigma_m=40.0)
    sigma = effective_sigma(network, jacobian(network, np.zeros(3)))
    expected = [math.hypot(10.0, 40.0), math.hypot(0.01, 40.0 / 5000.0), math.hypot(0.02, 40.0 / 5000.0)]
    np.testing.assert_allclose(sigma, expected)


def test_a_mark_uncertain_along_the_line_of_sight_spoils_only_the_range() -> None:
    along = np.array([0.6, 0.8])
    network = small(mark_covariance_m2=[40.0**2 * np.outer(along, along)])
    sigma = effective_sigma(network, jacobian(network, np.zeros(3)))
    np.testing.assert_allclose(sigma, [math.hypot(10.0, 40.0), 0.01, 0.02])


def test_range_and_bearing_correlate_only_through_a_mark_that_is_not_round() -> None:
    kinds, place = [RANGE, RELATIVE_BEARING], [[3000.0, 4000.0]]
    tilted = np.array([[900.0, 0.0], [0.0, 100.0]])
    oblique = Network.build(kinds, [0, 0], [5000.0, 0.5], [10.0, 0.01], place, mark_covariance_m2=[tilted])
    round_ = Network.build(kinds, [0, 0], [5000.0, 0.5], [10.0, 0.01], place, mark_sigma_m=20.0)
    assert round_.diagonal
    assert not oblique.diagonal
    covariance = block_covariance(oblique, jacobian(oblique, np.zeros(3)))[0]
    # by hand: range derivative (.6, .8), bearing derivative (-.8, .6) / 5000 with respect to the mark
    assert covariance[0, 1] == pytest.approx((0.6 * -0.8 * 900.0 + 0.8 * 0.6 * 100.0) / 5000.0)
    assert block_covariance(round_, jacobian(round_, np.zeros(3)))[0, 0, 1] == pytest.approx(0.0, abs=1e-12)


def test_decorrelated_residuals_have_the_mahalanobis_norm() -> None:
    network = mixed_network(np.random.default_rng(5), POSE, noise=2.0, full_covariance=True)
    v, a = residuals(network, POSE), jacobian(network, POSE)
    covariance = block_covariance(network, a)
    norms = target_norms(network, whitened(network, POSE)[0])
    for block, size, matrix, norm in zip(network.blocks, network.block_sizes, covariance, norms, strict=True):
        inside, part = matrix[:size, :size], v[block[:size]]
        assert norm == pytest.approx(math.sqrt(part @ np.linalg.solve(inside, part)))


def test_targets_that_share_an_uncertain_mark_are_one() -> None:
    shared: dict[str, Any] = {"kind": [0, 0], "mark": [0, 0], "value": [100.0, 100.0], "sigma": 1.0, "target": [0, 1]}
    assert len(Network.build(**shared, mark_ne_m=[[100.0, 0.0]], mark_sigma_m=5.0).blocks) == 1
    assert len(Network.build(**shared, mark_ne_m=[[100.0, 0.0]]).blocks) == 2


def test_what_is_masked_out_takes_no_part() -> None:
    network = small(mask=[True, False, True])
    assert network.observations == 2
    assert not network.heading_unknown
    v, a = whitened(network, np.zeros(3))
    assert v[1] == 0.0
    assert not a[1].any()


def test_unknowns_and_redundancy_are_counted() -> None:
    scene = plane_scene(np.random.default_rng(6), marks=4)
    assert (scene.network.unknowns, scene.network.redundancy) == (3, 5)
    true_only = Network.build([0, 2], [0, 0], [5000.0, 1.0], [10.0, 0.01], [[3000.0, 4000.0]], heading_prior_rad=(1, 1))
    assert (true_only.unknowns, true_only.redundancy, true_only.prior_counts) == (2, 0, False)


def test_heading_prior_is_measured_the_short_way_round() -> None:
    network = small(heading_prior_rad=(math.radians(359.0), math.radians(1.0)))
    assert prior_residual(network, np.array([0.0, 0.0, math.radians(1.0)])) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"sigma": [10.0, 0.0, 1.0]}, "sigma must be > 0"),
        ({"kind": [0, 1, 5]}, "kind must be"),
        ({"mark": [0, 0, 1]}, "mark must be within"),
        ({"value": [1.0, 2.0]}, "value must have 3 entries"),
        ({"value": [1.0, math.nan, 2.0]}, "must be finite"),
        ({"mark_covariance_m2": [[[1.0, 5.0], [5.0, 1.0]]]}, "positive semidefinite"),
        ({"heading_prior_rad": (0.0, 0.0)}, "heading prior"),
    ],
)
def test_wrong_input_is_named(change: dict[str, Any], says: str) -> None:
    arguments: dict[str, Any] = {
        "kind": [0, 1, 2],
        "mark": [0, 0, 0],
        "value": [5000.0, 0.5, 1.0],
        "sigma": 0.1,
        "mark_ne_m": [[3000.0, 4000.0]],
    }
    with pytest.raises(InputError, match=says):
        Network.build(**(arguments | change))
