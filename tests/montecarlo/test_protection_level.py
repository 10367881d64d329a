"""Whether errors pass the protection level unnoticed, with wrong matches and with the worst error of one mark.

The quick runs are in every test run, the long ones are studies. All print what they measure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment.reliability import assess
from navfix.adjustment.solve import solve
from navfix.errors import NoFix
from navfix.integrity.levels import separation_levels, slope_level
from navfix.integrity.protection import Protection, blocks_of_network, protection
from navfix.integrity.separation import separate
from tests.adjustment_scenes import plane_scene

FALSE_ALARM, MISSED = 1e-3, 1e-4
DESIGNED = 1e-4


@dataclass(frozen=True)
class Figures:
    """Shares of all scenes; ``worst`` is the largest error over its protection level."""

    runs: int
    beyond: int
    beyond_slope: int
    without_level: float
    no_fix: float
    median_m: float
    median_slope_m: float
    worst: float


def measure(runs: int, seed: int, *, kernel: str = "hampel", **scene: object) -> Figures:
    """Solve ``runs`` scenes and count errors beyond the level where no alarm says so."""
    rng = np.random.default_rng(seed)
    errors, levels, slopes, none = [], [], [], 0
    for _ in range(runs):
        try:
            error_m, found = solved(rng, kernel, scene)
        except NoFix:
            none += 1
            continue
        errors.append(error_m)
        levels.append(math.inf if found.level_m is None else found.level_m)
        slopes.append(math.inf if found.slope_m is None or found.level_m is None else found.slope_m)
    error, level, slope = np.array(errors), np.array(levels), np.array(slopes)
    return Figures(
        runs,
        int(np.sum(error > level)),
        int(np.sum(error > slope)),
        float(np.mean(np.isinf(level))),
        none / runs,
        float(np.median(level)),
        float(np.median(slope)),
        float(np.max(error / level)),
    )


def solved(rng: np.random.Generator, kernel: str, scene: dict[str, object]) -> tuple[float, Protection]:
    """Return the error [m] of a drawn scene and its protection."""
    drawn = plane_scene(rng, **scene)  # type: ignore[arg-type]
    network = drawn.network
    solution = solve(network, catalog.kernel(kernel), solver="dense")
    quality = assess(network, solution.pose, solution.weights, solution.cofactor, "joint")
    found = protection(
        blocks_of_network(network, solution.pose, solution.weights),
        sigma0=quality.sigma0 if quality.scaling == "a_posteriori" else 1.0,
        dof=quality.dof,
        reach_m=float(np.median(np.hypot(*(network.mark_ne_m - solution.pose[:2]).T))),
        probability_of_false_alarm=FALSE_ALARM,
        probability_of_missed_detection=MISSED,
    )
    return float(np.hypot(*solution.pose[:2])), found


@pytest.mark.parametrize(("marks", "wrong", "agreeing"), [(8, 3, False), (20, 8, False), (8, 3, True)])
def test_no_error_beyond_the_level_goes_unnoticed(marks: int, wrong: int, agreeing: bool) -> None:
    """40 % wrong matches, 400 scenes (200 where they are wrong alike): none, and a level nearly always."""
    figures = measure(200 if agreeing else 400, 61, marks=marks, wrong=wrong, agreeing=agreeing)
    print(f"{marks} marks, {wrong} wrong: {figures}")
    assert figures.beyond == 0
    assert figures.without_level < 0.02
    assert figures.median_m < 300.0


def test_a_level_is_not_bought_by_being_endless() -> None:
    """20 good marks: the level is below 8 times the bound's sigma."""
    figures = measure(150, 62)
    print(f"20 good marks: {figures}")
    assert figures.without_level == 0.0
    assert figures.median_m < 80.0


def worst_fault(marks: int, seed: int, draws: int) -> tuple[float, float]:
    """Return how often an error beyond the level passes without an alarm: separation, slope.

    Least squares, linear, in scenes drawn at random: the mark with the worst slope has an error in its worst direction,
    of the size that passes most often (found by trying sizes).
    """
    rng = np.random.default_rng(seed)
    drawn = plane_scene(rng, marks=marks)
    network, pose = drawn.network, drawn.truth
    blocks = blocks_of_network(network, pose, np.ones(len(network.kind)))
    flat = blocks.rows.reshape(-1, 3)
    cofactor = np.linalg.inv(flat.T @ flat)
    separation = separate(blocks)
    options = {"probability_of_false_alarm": FALSE_ALARM, "probability_of_missed_detection": MISSED}
    dof = len(flat) - 3.0
    slope_m = slope_level(blocks, cofactor, scale=1.0, dof=dof, **options)
    level_m = separation_levels(separation, scale=1.0, **options).protection_m
    k, direction = _worst_direction(blocks.rows, cofactor)
    threshold = _thresholds(separation)
    chi_square = _chi_square_threshold(dof)
    noise = rng.normal(size=(draws, len(flat)))
    separation_rate = slope_rate = 0.0
    for size in np.arange(2.0, 14.0, 0.5):
        error = noise.copy()
        error[:, 2 * k : 2 * k + 2] += size * direction
        shift = error @ flat @ cofactor
        v = shift @ flat.T - error
        position_m = np.hypot(*shift[:, :2].T)
        gradients = np.einsum("gku,dgk->dgu", blocks.rows, v.reshape(draws, marks, 2))
        apart = np.einsum("guv,dgv->dgu", separation.without, gradients)[..., :2]
        quiet = ~np.any(np.abs(apart) > threshold, axis=(1, 2))
        separation_rate = max(separation_rate, float(np.mean(quiet & (position_m > level_m))))
        fits = np.sum(v**2, axis=1) <= chi_square
        slope_rate = max(slope_rate, float(np.mean(fits & (position_m > slope_m))))
    return separation_rate, slope_rate


def _worst_direction(rows: np.ndarray, cofactor: np.ndarray) -> tuple[int, np.ndarray]:
    gain = (rows @ cofactor)[:, :, :2]
    seen = np.eye(2) - rows @ cofactor @ np.swapaxes(rows, 1, 2)
    values, vectors = np.linalg.eig(np.linalg.solve(seen, gain @ np.swapaxes(gain, 1, 2)))
    k, j = np.unravel_index(np.argmax(values.real), values.shape)
    direction = vectors[k][:, j].real
    return int(k), direction / np.linalg.norm(direction)


def _thresholds(separation: object) -> np.ndarray:
    from navfix.integrity.levels import false_alarm_factor

    variance = separation.variance[:, :2]  # type: ignore[attr-defined]
    return false_alarm_factor(FALSE_ALARM, len(variance)) * np.sqrt(variance)


def _chi_square_threshold(dof: float) -> float:
    from scipy.special import gammaincinv

    return 2.0 * float(gammaincinv(dof / 2.0, 1.0 - FALSE_ALARM))


def test_the_worst_error_of_one_mark_stays_within_the_level_or_alarms() -> None:
    """8 marks, 40 000 draws of noise for each size of the error; the slope method's rate beside it."""
    rates = [worst_fault(8, seed, 40_000) for seed in (1, 2)]
    for separation_rate, slope_rate in rates:
        print(f"worst single error, designed {MISSED:g}: separation {separation_rate:.1e}, slope {slope_rate:.1e}")
        assert separation_rate <= MISSED


@pytest.mark.study
@pytest.mark.parametrize(
    ("marks", "wrong", "sector_deg"), [(8, 0, 360.0), (8, 3, 360.0), (8, 3, 20.0), (20, 4, 360.0), (20, 8, 360.0)]
)
def test_study_errors_beyond_the_level(marks: int, wrong: int, sector_deg: float) -> None:
    """20 000 fixes a cell, wrong matches 200 m to 3 km off: at most one in 10 000 beyond the level unnoticed."""
    figures = measure(20_000, 63, marks=marks, wrong=wrong, sector_deg=sector_deg)
    print(f"{marks} marks, {wrong} wrong, sector {sector_deg:.0f} deg: {figures}")
    assert figures.beyond <= DESIGNED * figures.runs


@pytest.mark.study
def test_study_errors_that_agree_and_sigmas_that_are_too_small() -> None:
    for scene in ({"wrong": 8, "agreeing": True}, {"marks": 8, "wrong": 2, "noise": 1.5}):  # 20 and 8 marks
        figures = measure(10_000, 64, **scene)
        print(f"{scene}: {figures}")
        assert figures.beyond <= DESIGNED * figures.runs


@pytest.mark.study
@pytest.mark.parametrize(("wrong", "sector_deg"), [(2, 360.0), (3, 360.0), (3, 20.0)])
def test_study_errors_that_agree_among_eight_marks(wrong: int, sector_deg: float) -> None:
    """20 000 fixes a cell, two or three of eight wrong by the same vector: at most one in 10 000 beyond, unnoticed."""
    figures = measure(20_000, 65, marks=8, wrong=wrong, agreeing=True, sector_deg=sector_deg)
    print(f"8 marks, {wrong} wrong alike, sector {sector_deg:.0f} deg: {figures}")
    assert figures.beyond <= DESIGNED * figures.runs


@pytest.mark.study
@pytest.mark.parametrize("marks", [6, 8, 20])
def test_study_worst_error_of_one_mark(marks: int) -> None:
    rates = np.array([worst_fault(marks, seed, 200_000) for seed in range(6)])
    print(f"{marks} marks, worst single error: separation {rates[:, 0].max():.1e}, slope {rates[:, 1].max():.1e}")
    assert rates[:, 0].max() <= MISSED
