"""How near the adjustment comes to what is possible, and whether its ellipse holds what it says.

The quick runs are in every test run; the full ones (2000 runs a cell) are studies. Both print what they measure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment import adjust, mean_fix
from navfix.adjustment.reliability import assess
from navfix.adjustment.solve import solve
from navfix.errors import Ambiguous, NoFix
from navfix.geodesy import inverse
from navfix.types import Ellipse, confidence_radius
from tests.adjustment_scenes import GDYNIA_BAY, Scene, epoch_scene, plane_scene

FULL = 2000


@dataclass(frozen=True)
class Figures:
    """RMSE over the Cramer-Rao bound, share of runs inside the 95 % and 99 % ellipse, share without a fix."""

    ratio: float
    inside_95: float
    inside_99: float
    no_fix: float


def measure(runs: int, seed: int, *, kernel: str = "hampel", sigma_factor: float = 1.0, **scene: object) -> Figures:
    """Solve ``runs`` scenes; ``sigma_factor`` is by how much the true noise exceeds the sigmas that are stated."""
    rng = np.random.default_rng(seed)
    squares, bounds, inside, none = [], [], [], 0
    for _ in range(runs):
        drawn = plane_scene(rng, noise=sigma_factor, **scene)  # type: ignore[arg-type]
        try:
            pose, covariance, dof = solved(drawn, kernel)
        except NoFix:
            none += 1
            continue
        squares.append(float(pose @ pose))
        bounds.append(float(np.trace(drawn.bound()[:2, :2])) * sigma_factor**2)
        distance = math.sqrt(pose @ np.linalg.solve(covariance, pose))
        inside.append([distance < confidence_radius(p, dof=dof) for p in (0.95, 0.99)])
    share = np.mean(inside, axis=0)
    return Figures(math.sqrt(np.sum(squares) / np.sum(bounds)), float(share[0]), float(share[1]), none / runs)


def solved(scene: Scene, kernel: str) -> tuple[np.ndarray, np.ndarray, float | None]:
    """Return position, covariance (2, 2) and its degrees of freedom, by the dense road (the graph agrees with it)."""
    solution = solve(scene.network, catalog.kernel(kernel), solver="dense")
    quality = assess(scene.network, solution.pose, solution.weights, solution.cofactor, "joint")
    dof = quality.dof if quality.scaling == "a_posteriori" else None
    return solution.pose[:2], quality.covariance[:2, :2], dof


@pytest.mark.parametrize("sector_deg", [360.0, 20.0])
def test_good_pairs_reach_the_bound_and_the_ellipse_holds(sector_deg: float) -> None:
    """20 pairs, right association: RMSE within 5 % of the bound, 95 +- 3 % inside (quick: 600 runs)."""
    figures = measure(600, 21, sector_deg=sector_deg)
    print(f"sector {sector_deg:.0f} deg, no errors: {figures}")
    assert figures.ratio <= 1.05
    assert 0.92 <= figures.inside_95 <= 0.98
    assert figures.no_fix == 0.0


@pytest.mark.parametrize("sector_deg", [360.0, 20.0])
def test_a_fifth_of_wrong_positions_costs_a_tenth_at_most(sector_deg: float) -> None:
    figures = measure(400, 22, wrong=4, sector_deg=sector_deg)
    print(f"sector {sector_deg:.0f} deg, 20 % wrong: {figures}")
    assert figures.ratio <= 1.10
    assert 0.92 <= figures.inside_95 <= 0.98
    assert figures.no_fix == 0.0


def against_the_mean(runs: int, seed: int) -> tuple[float, float]:
    """Return the RMSE [m] of fix and plain-mean fix in the same scenes with 20 % wrong, on the globe."""
    rng = np.random.default_rng(seed)
    errors = []
    for _ in range(runs):
        epoch, association = epoch_scene(rng, wrong=4)
        plain = mean_fix(epoch, association, heading_deg=123.4)  # a kindness: it is told the true heading
        errors.append([inverse(GDYNIA_BAY, f.position)[0] for f in (adjust(epoch, association), plain)])
    fix_m, mean_m = np.sqrt(np.mean(np.square(errors), axis=0))
    return float(fix_m), float(mean_m)


def test_ten_times_better_than_the_plain_mean() -> None:
    fix_m, mean_m = against_the_mean(60, 23)
    print(f"20 pairs, 20 % wrong: fix {fix_m:.1f} m, plain mean (true heading given) {mean_m:.1f} m")
    assert mean_m >= 10.0 * fix_m


def test_agreeing_errors_do_not_carry_the_day() -> None:
    """40 % of 20 marks shifted alike by 200 m to 3 km."""
    figures = measure(150, 24, wrong=8, agreeing=True)
    print(f"40 % agreeing errors: {figures}")
    assert figures.ratio <= 1.30
    assert figures.no_fix <= 0.02


def test_ambiguity_is_not_cried_without_need() -> None:
    """Few pairs, one wrong: nearly always a fix, and the right one."""
    figures = measure(200, 25, marks=6, wrong=1)
    print(f"6 pairs, one wrong: {figures}")
    assert figures.no_fix <= 0.02
    assert figures.ratio <= 1.3


def test_an_even_split_is_always_ambiguous() -> None:
    rng = np.random.default_rng(26)
    for _ in range(20):
        with pytest.raises(Ambiguous):
            solve(plane_scene(rng, marks=8, wrong=4, agreeing=True).network, catalog.kernel("hampel"))


@pytest.mark.study
@pytest.mark.parametrize("sector_deg", [360.0, 20.0])
@pytest.mark.parametrize(("wrong", "limit"), [(0, 1.05), (4, 1.10), (9, 1.15)])
def test_study_bound_and_coverage(sector_deg: float, wrong: int, limit: float) -> None:
    figures = measure(FULL, 31, wrong=wrong, sector_deg=sector_deg)
    print(f"20 pairs, sector {sector_deg:.0f} deg, {wrong} wrong, {FULL} runs: {figures}")
    assert figures.ratio <= limit
    assert 0.92 <= figures.inside_95 <= 0.98
    assert 0.98 <= figures.inside_99 <= 0.998


@pytest.mark.study
@pytest.mark.parametrize("sigma_factor", [1.0, 1.5])
@pytest.mark.parametrize("sector_deg", [360.0, 20.0])
@pytest.mark.parametrize(("marks", "wrong"), [(8, 0), (8, 1), (8, 2), (20, 0), (20, 6)])
def test_study_coverage_with_sigmas_that_are_wrong(
    sigma_factor: float, sector_deg: float, marks: int, wrong: int
) -> None:
    figures = measure(FULL, 32, marks=marks, wrong=wrong, sector_deg=sector_deg, sigma_factor=sigma_factor)
    print(f"{marks} pairs, {wrong} wrong, sector {sector_deg:.0f}, noise x {sigma_factor}: {figures}")
    assert 0.925 <= figures.inside_95 <= 0.975
    assert 0.98 <= figures.inside_99 <= 0.998


@pytest.mark.study
def test_study_ten_times_better_than_the_plain_mean() -> None:
    fix_m, mean_m = against_the_mean(FULL, 33)
    print(f"20 pairs, 20 % wrong, {FULL} runs: fix {fix_m:.1f} m, plain mean {mean_m:.1f} m")
    assert mean_m >= 10.0 * fix_m


def test_ellipse_and_mahalanobis_distance_say_the_same() -> None:
    """`measure` counts by Mahalanobis distance: the same as lying inside the drawn ellipse."""
    covariance, point = np.array([[900.0, 500.0], [500.0, 400.0]]), np.array([40.0, 5.0])
    for dof in (None, 6.0):
        ellipse = Ellipse.from_covariance(covariance, 0.95, dof=dof)
        azimuth = math.radians(ellipse.azimuth_deg)
        along = (point @ [math.cos(azimuth), math.sin(azimuth)]) / ellipse.semi_major_m
        across = (point @ [-math.sin(azimuth), math.cos(azimuth)]) / ellipse.semi_minor_m
        inside = math.sqrt(point @ np.linalg.solve(covariance, point)) < confidence_radius(0.95, dof=dof)
        assert (math.hypot(along, across) < 1.0) == inside
