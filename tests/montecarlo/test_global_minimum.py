"""The lowest of many minima is found: against a descent from seventy starts, with wrong pairs and every kernel."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment.dense import minimise
from navfix.adjustment.start import find_minima
from tests.adjustment_scenes import Scene, plane_scene

STARTS = 70
KERNELS = ("huber", "hampel", "danish", "tukey", "igg3", "gdynia_linear")
KINDS = (
    {"marks": 20, "wrong": 9},
    {"marks": 20, "wrong": 8, "agreeing": True},
    {"marks": 20, "wrong": 6, "sector_deg": 20.0},
    {"marks": 8, "wrong": 3},
    {"marks": 8, "wrong": 2, "sector_deg": 40.0},
    {"marks": 5, "wrong": 1},
)


def lowest_of_many(scene: Scene, kernel: str, rng: np.random.Generator) -> float:
    """Return the lowest loss from seventy starts: the truth, places about it and about the marks, any heading."""
    near, far = STARTS // 2, STARTS - STARTS // 2 - 1
    starts = np.concatenate(
        [
            scene.truth[None, :],
            scene.truth + rng.normal(size=(near, 3)) * [800.0, 800.0, math.radians(10.0)],
            np.column_stack([rng.uniform(-2e4, 2e4, (far, 2)), rng.uniform(-math.pi, math.pi, far)]),
        ]
    )
    return float(minimise(scene.network, catalog.kernel(kernel), "joint", starts, tolerance=1e-6).loss.min())


def shortfall(seed: int, kernel: str) -> float:
    """Return by how much the loss that is found exceeds the lowest of many."""
    rng = np.random.default_rng([seed, 77])
    scene = plane_scene(rng, **KINDS[seed % len(KINDS)])  # type: ignore[arg-type]
    return find_minima(scene.network, catalog.kernel(kernel), "joint")[0].loss - lowest_of_many(scene, kernel, rng)


@pytest.mark.parametrize("kernel", KERNELS)
def test_the_global_minimum_is_found(kernel: str) -> None:
    """24 scenes with up to 45 % wrong pairs, independent and agreeing, wide and narrow."""
    missed = {seed: round(gap, 3) for seed in range(24) if (gap := shortfall(seed, kernel)) > 1e-5}
    assert not missed


def test_minima_a_few_sigma_apart_are_told_by_exchanging_targets() -> None:
    """IGG-III gives up targets that nearly agree: two of 300 scenes ended above the lowest of 70 starts."""
    assert all(shortfall(seed, "igg3") < 1e-5 for seed in (42, 53))


@pytest.mark.study
@pytest.mark.parametrize("kernel", KERNELS)
def test_study_the_global_minimum_is_found(kernel: str) -> None:
    missed = {seed: round(gap, 3) for seed in range(24, 324) if (gap := shortfall(seed, kernel)) > 1e-5}
    print(f"{kernel}: {len(missed)} of 300 scenes end above the lowest of {STARTS} starts: {missed}")
    assert len(missed) <= 3
