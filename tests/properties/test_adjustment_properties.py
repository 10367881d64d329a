"""Properties of the adjustment: exact on exact data, and unmoved by what must not matter."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navfix import catalog
from navfix.adjustment import adjust
from navfix.adjustment.network import Network
from navfix.adjustment.solve import solve
from navfix.geodesy import inverse
from navfix.types import Association, Position
from navfix.units import wrap_180, wrap_pi
from tests.adjustment_scenes import epoch_scene, plane_scene

SEEDS = st.integers(0, 2**31)
HAMPEL = catalog.kernel("hampel")
few = settings(max_examples=25, deadline=None, derandomize=True)


@few
@given(heading_deg=st.floats(0.0, 360.0, exclude_max=True), seed=SEEDS, marks=st.integers(2, 12))
def test_any_heading_is_solved_exactly_on_exact_data(heading_deg: float, seed: int, marks: int) -> None:
    epoch, association = epoch_scene(np.random.default_rng(seed), heading_deg=heading_deg, marks=marks, noise=0.0)
    fix = adjust(epoch, association)
    assert inverse(Position(54.5, 18.8), fix.position)[0] < 1e-3
    assert fix.heading_deg is not None
    assert abs(wrap_180(fix.heading_deg - heading_deg)) < 1e-5


@few
@given(
    lat_deg=st.sampled_from([0.0, -33.0, 60.0, 85.0, 89.0, -89.5]),
    lon_deg=st.sampled_from([179.999, -179.999, 0.0, 37.0]),
    reference=st.sampled_from(["relative", "true"]),
    seed=SEEDS,
)
def test_exact_data_are_solved_across_180_east_and_near_the_poles(
    lat_deg: float, lon_deg: float, reference: str, seed: int
) -> None:
    own = Position(lat_deg, lon_deg)
    epoch, association = epoch_scene(np.random.default_rng(seed), own, marks=6, noise=0.0, bearing_reference=reference)
    fix = adjust(epoch, association)
    assert inverse(own, fix.position)[0] < 1e-3
    if reference == "relative":
        assert fix.heading_deg == pytest.approx(123.4, abs=1e-4)


@few
@given(seed=SEEDS)
def test_noise_near_the_pole_is_the_same_as_elsewhere(seed: int) -> None:
    """The same scene at 54.5 N and at 89 N: the same residuals to 5 mm and the same ellipse."""
    there = [
        adjust(*epoch_scene(np.random.default_rng(seed), own, marks=8))
        for own in (Position(54.5, 18.8), Position(89.0, -179.99))
    ]
    first, second = (np.array([o.residual for o in fix.observations[::2]]) for fix in there)
    np.testing.assert_allclose(first, second, atol=0.005)
    # north itself turns: the meridian of a fix 20 m beside own ship by 0.01 deg at 89 N
    assert there[0].heading_deg == pytest.approx(there[1].heading_deg, abs=0.03)
    lengths = [(fix.ellipse().semi_major_m, fix.ellipse().semi_minor_m) for fix in there]
    np.testing.assert_allclose(*lengths, rtol=1e-3)


@few
@given(seed=SEEDS, shift=st.tuples(st.floats(-1e5, 1e5), st.floats(-1e5, 1e5)))
def test_shifting_the_marks_shifts_the_fix(seed: int, shift: tuple[float, float]) -> None:
    network = plane_scene(np.random.default_rng(seed), marks=8, wrong=2).network
    first, second = solve(network, HAMPEL), solve(network.with_marks(network.mark_ne_m + np.array(shift)), HAMPEL)
    np.testing.assert_allclose(second.pose[:2] - first.pose[:2], shift, atol=1e-4)
    assert abs(wrap_pi(second.pose[2] - first.pose[2])) < 1e-7
    np.testing.assert_allclose(second.weights, first.weights, atol=1e-6)


@few
@given(seed=SEEDS, turn=st.floats(-math.pi, math.pi))
def test_turning_the_marks_turns_position_heading_and_covariance(seed: int, turn: float) -> None:
    network = plane_scene(np.random.default_rng(seed), marks=8, wrong=2, sector_deg=40.0).network
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    first, second = solve(network, HAMPEL), solve(network.with_marks(network.mark_ne_m @ rotation.T), HAMPEL)
    np.testing.assert_allclose(second.pose[:2], rotation @ first.pose[:2], atol=1e-4)
    assert abs(wrap_pi(second.pose[2] - first.pose[2] - turn)) < 1e-7
    turned = rotation @ first.cofactor[:2, :2] @ rotation.T
    np.testing.assert_allclose(second.cofactor[:2, :2], turned, rtol=1e-4, atol=1e-4)


@few
@given(seed=SEEDS, turn_deg=st.floats(-180.0, 180.0))
def test_turning_the_ship_turns_only_the_heading(seed: int, turn_deg: float) -> None:
    epoch, association = epoch_scene(np.random.default_rng(seed), marks=6)
    turned = replace(epoch, targets=tuple(replace(t, bearing_deg=t.bearing_deg - turn_deg) for t in epoch.targets))
    first, second = adjust(epoch, association), adjust(turned, association)
    assert inverse(first.position, second.position)[0] < 1e-3
    assert first.heading_deg is not None
    assert second.heading_deg is not None
    assert abs(wrap_180(second.heading_deg - first.heading_deg - turn_deg)) < 1e-5
    np.testing.assert_allclose(first.covariance, second.covariance, rtol=1e-4, atol=1e-9)


@few
@given(seed=SEEDS, order=st.permutations(range(8)))
def test_the_order_of_the_pairs_does_not_matter(seed: int, order: list[int]) -> None:
    epoch, association = epoch_scene(np.random.default_rng(seed), marks=8, wrong=2)
    shuffled = Association.from_pairs(epoch, [(i, i) for i in order])
    first, second = adjust(epoch, association), adjust(epoch, shuffled)
    assert inverse(first.position, second.position)[0] < 1e-3
    by_target = {(o.target, o.kind): o for o in second.observations}
    for o in first.observations:
        assert by_target[o.target, o.kind].residual == pytest.approx(o.residual, abs=1e-3)


@few
@given(seed=SEEDS, factor=st.floats(0.2, 5.0))
def test_least_squares_does_not_depend_on_the_unit_of_sigma(seed: int, factor: float) -> None:
    """All sigmas times f: the same place, sigma0 divided by f, the same covariance a posteriori."""
    network = plane_scene(np.random.default_rng(seed), marks=6, mark_sigma_m=0.0).network
    scaled = replace(network, sigma=network.sigma * factor)
    first, second = (solve(n, catalog.kernel("none"), solver="dense") for n in (network, scaled))
    np.testing.assert_allclose(first.pose, second.pose, atol=1e-5)
    np.testing.assert_allclose(second.cofactor, factor**2 * first.cofactor, rtol=1e-5, atol=1e-12)


@few
@given(seed=SEEDS)
def test_a_true_covariance_given_as_matrix_or_as_sigma_is_the_same(seed: int) -> None:
    network = plane_scene(np.random.default_rng(seed), marks=5, wrong=1).network
    as_matrix = Network.build(
        network.kind, network.mark, network.value, network.sigma, network.mark_ne_m,
        mark_covariance_m2=[[[100.0, 1e-9], [1e-9, 100.0]]] * 5,
    )  # fmt: skip
    assert network.diagonal
    assert not as_matrix.diagonal
    first, second = solve(network, HAMPEL), solve(as_matrix, HAMPEL)
    np.testing.assert_allclose(first.pose, second.pose, atol=1e-4)
    np.testing.assert_allclose(first.weights, second.weights, atol=1e-6)
