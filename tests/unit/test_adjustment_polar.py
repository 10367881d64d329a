"""Range and bearing in polar coordinates: the same landscape as that of any network, and its slope is a derivative."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment.dense import minimise
from navfix.adjustment.landscape import GeneralLandscape, PolarLandscape, landscape_of, norms_of_targets
from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, Network
from navfix.adjustment.whitening import target_norms, white_residuals
from tests.adjustment_scenes import mixed_network, plane_scene

KERNELS = ("none", "huber", "hampel", "danish", "tukey")


def network_and_poses(*, prior: bool = False, true_bearings: bool = False) -> tuple[Network, np.ndarray]:
    rng = np.random.default_rng(71)
    scene = plane_scene(rng, marks=9, wrong=2)
    network, pose = scene.network, scene.truth
    if prior:
        network = replace(network, heading_prior_rad=(float(pose[2]) + 0.01, 0.02))
    if true_bearings:  # some of them: the others stay relative
        turned = np.isin(np.arange(18), (1, 7, 9))
        network = replace(
            network,
            kind=np.where(turned, TRUE_BEARING, network.kind),
            value=network.value + np.where(turned, pose[2], 0.0),
        )
    near = pose + rng.normal(size=(4, 3)) * [60.0, 60.0, 0.01]
    far = pose + rng.normal(size=(3, 3)) * [900.0, 900.0, 2.0]
    return network, np.concatenate([near, far])


@pytest.mark.parametrize("options", [{}, {"prior": True}, {"true_bearings": True}])
@pytest.mark.parametrize("kernel", KERNELS)
def test_the_polar_landscape_is_the_general_one(kernel: str, options: dict[str, bool]) -> None:
    network, poses = network_and_poses(**options)
    damper = catalog.kernel(kernel)
    polar = landscape_of(network, damper, "joint")
    general = GeneralLandscape(network, damper, "joint")
    assert isinstance(polar, PolarLandscape)
    found, expected = polar.about(poses), general.about(poses)
    np.testing.assert_allclose(found.loss, expected.loss, rtol=1e-12)
    for name in ("gradient", "diagonal", "newton"):
        wanted = getattr(expected, name)
        largest = np.max(np.abs(wanted).reshape(len(poses), -1), axis=1).reshape(-1, *[1] * (wanted.ndim - 1))
        largest = np.maximum(largest, 1e-12)  # flat where a kernel has given up every target
        np.testing.assert_allclose(getattr(found, name) / largest, wanted / largest, atol=1e-11)
    moved = poses + [30.0, -20.0, 0.01]
    there = polar.loss(moved, polar.view(moved), found.scale)
    np.testing.assert_allclose(there, general.loss(moved, general.view(moved), expected.scale), rtol=1e-12)


def test_gradient_and_second_derivative_are_those_of_the_loss_at_fixed_sigmas() -> None:
    """By central differences, in units of 1 m and 1e-4 rad."""
    network, poses = network_and_poses(prior=True, true_bearings=True)
    unit = np.diag([1.0, 1.0, 1e-4])
    landscape = landscape_of(network, catalog.kernel("danish"), "joint")
    for pose in poses[:4]:
        about = landscape.about(pose[None, :])

        def loss(offset: np.ndarray, at: np.ndarray = pose, scale: np.ndarray = about.scale) -> float:
            moved = at[None, :] + offset
            return float(landscape.loss(moved, landscape.view(moved), scale)[0])

        slope = [(loss(step) - loss(-step)) / 2.0 for step in unit]
        np.testing.assert_allclose(slope, unit @ about.gradient[0], rtol=1e-3, atol=1e-3)
        bend = [[(loss(p + q) - loss(p - q) - loss(q - p) + loss(-p - q)) / 4.0 for q in unit] for p in unit]
        expected = unit @ about.newton[0] @ unit
        np.testing.assert_allclose(bend, expected, atol=0.02 * np.max(np.abs(expected)))


def test_only_pairs_of_range_and_bearing_are_polar() -> None:
    network, _ = network_and_poses()
    damper = catalog.kernel("hampel")
    assert network.polar
    assert not replace(network, mask=np.arange(18) != 3).polar
    assert not replace(network, kind=np.where(network.kind == RANGE, RELATIVE_BEARING, RANGE)).polar
    oblique = np.tile([[100.0, 40.0], [40.0, 100.0]], (9, 1, 1))
    assert not replace(network, mark_covariance_m2=oblique).polar
    assert not mixed_network(np.random.default_rng(1), np.zeros(3), noise=1.0, full_covariance=False).polar
    for other in (landscape_of(network, damper, "separate"), landscape_of(_standardised(network), damper, "joint")):
        assert isinstance(other, GeneralLandscape)


def _standardised(network: Network) -> Network:
    return replace(network, standard=np.full(18, 0.9))


def test_norms_of_targets_are_those_of_the_whitened_residuals() -> None:
    network, poses = network_and_poses()
    expected = target_norms(network, white_residuals(network, poses))
    np.testing.assert_allclose(norms_of_targets(network, poses), expected, rtol=1e-12)


def test_own_ship_on_a_mark_has_a_finite_landscape() -> None:
    network, _ = network_and_poses()
    on_a_mark = np.array([[*network.mark_ne_m[4], 0.3]])
    about = landscape_of(network, catalog.kernel("hampel"), "joint").about(on_a_mark)
    assert all(np.all(np.isfinite(array)) for array in about)


def test_a_descent_ends_with_the_landscape_of_its_end() -> None:
    network, poses = network_and_poses()
    damper = catalog.kernel("hampel")
    found = minimise(network, damper, "joint", poses, tolerance=1e-9, iterations=60)
    again = landscape_of(network, damper, "joint").about(found.pose)
    np.testing.assert_allclose(found.local.newton, again.newton, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.loss, again.loss, rtol=1e-12)
    assert math.isclose(float(found.take([0]).loss[0]), float(found.loss[0]))
