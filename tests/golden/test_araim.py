"""Solution separation against the published ARAIM examples: the same formulas, another geometry.

Ten satellites of two constellations. Three publications work the same geometry through: Blanch, Walter, Enge, Lee,
Pervan, Rippl, Spletter, Advanced RAIM user algorithm description (ION GNSS 2012, appendix: up to two satellites
faulty, 57 fault modes); the EU-US working group C's reference airborne algorithm description 3.0 and 3.1 (appendix D:
one satellite faulty, 12 fault modes). Levels are printed to 0.1 m and were iterated there to a tolerance of 0.05 m:
together 0.1 m here. That two satellites are looked at follows from a fault probability of 1e-4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pytest

from navfix.integrity.levels import false_alarm_factor, level_of_risk
from navfix.integrity.separation import Blocks, separate

EAST_NORTH_UP = np.array(
    [
        [0.0225, 0.9951, -0.0966],
        [0.6750, -0.6900, -0.2612],
        [0.0723, -0.6601, -0.7477],
        [-0.9398, 0.2553, -0.2269],
        [-0.5907, -0.7539, -0.2877],
        [-0.3236, -0.0354, -0.9455],
        [-0.6748, 0.4356, -0.5957],
        [0.0938, -0.7004, -0.7075],
        [0.5571, 0.3088, -0.7709],
        [0.6622, 0.6958, -0.2780],
    ]
)
SECOND = np.arange(10) >= 5
GEOMETRY = np.column_stack([EAST_NORTH_UP, ~SECOND, SECOND])
BIAS_M = 0.5
RISK_VERTICAL, RISK_HORIZONTAL = 9.8e-8, 2e-9
ALARM_VERTICAL, ALARM_HORIZONTAL = 3.9e-6, 9e-8
P_CONSTELLATION = 1e-4
TOLERANCE_M = 0.05 + 0.05


@dataclass(frozen=True)
class Published:
    """Variances [m^2] for integrity and for accuracy, and what is printed [m]."""

    integrity_m2: tuple[float, ...]
    accuracy_m2: tuple[float, ...]
    satellites_faulty: int
    p_satellite: float
    k_fa: float
    vpl_m: float
    hpl_m: float
    constellation_sigma_m: tuple[float, float]


OLDER = (
    (3.8865, 1.4377, 0.8604, 1.6383, 1.3229, 0.8434, 0.8963, 0.8669, 0.8573, 1.3616),
    (3.5740, 1.1252, 0.5479, 1.3258, 1.0104, 0.5309, 0.5838, 0.5544, 0.5448, 1.0491),
)
NEWER = (
    (3.2899, 1.2792, 0.7901, 1.4430, 1.1847, 0.7737, 0.8233, 0.7962, 0.7871, 1.2166),
    (2.9774, 0.9667, 0.4776, 1.1305, 0.8722, 0.4612, 0.5108, 0.4837, 0.4746, 0.9041),
)
CASES = {
    "Blanch 2012": Published(*OLDER, 2, 1e-4, 5.3953, 19.7, 14.9, (2.5760, 2.5577)),
    "reference algorithm 3.0": Published(*OLDER, 1, 1e-5, 5.1083, 19.2, 14.5, (2.5760, 2.5577)),
    "reference algorithm 3.1": Published(*NEWER, 1, 1e-5, 5.1083, 18.3, 13.45, (2.4600, 2.4359)),
}


@dataclass(frozen=True)
class Modes:
    """The fault modes: which satellites are left out, with what prior, and sigma, shift sigma, bias (modes, 3)."""

    prior: np.ndarray
    whole_m: np.ndarray
    whole_bias_m: np.ndarray
    sigma_m: np.ndarray
    shift_m: np.ndarray
    bias_m: np.ndarray
    count: int


def modes(case: Published) -> Modes:
    """Separate the published geometry by navfix; nominal biases and accuracy variances are of the example only."""
    out, prior = [], []
    for size in range(1, case.satellites_faulty + 1):
        for chosen in combinations(range(10), size):
            out.append(np.isin(np.arange(10), chosen))
            prior.append(case.p_satellite**size)
    out += [~SECOND, SECOND]
    prior += [P_CONSTELLATION] * 2
    hypotheses, integrity, accuracy = np.array(out), np.array(case.integrity_m2), np.array(case.accuracy_m2)
    clocks = np.diag([0.0, 0.0, 0.0, 1e-7, 1e-7])  # keeps the clock of a constellation that is left out defined
    blocks = Blocks(
        (GEOMETRY / np.sqrt(integrity)[:, None])[:, None, :], np.zeros((10, 1)), clocks, tuple("abcdefghij")
    )
    separation = separate(blocks, hypotheses)
    assert separation.determined.all()
    whole = separation.cofactor @ (GEOMETRY / integrity[:, None]).T
    without = separation.without @ (GEOMETRY / integrity[:, None]).T * ~hypotheses[:, None, :]
    return Modes(
        prior=np.array(prior),
        whole_m=np.sqrt(np.diagonal(separation.cofactor)[:3]),
        whole_bias_m=BIAS_M * np.abs(whole[:3]).sum(axis=1),
        sigma_m=np.sqrt(np.diagonal(separation.without, axis1=1, axis2=2)[:, :3]),
        shift_m=np.sqrt(((without - whole)[:, :3] ** 2 * accuracy).sum(axis=2)),
        bias_m=BIAS_M * np.abs(without[:, :3]).sum(axis=2),
        count=len(prior),
    )


def level(case: Published, found: Modes, axis: int, alarm: float, alarm_axes: int, risk: float) -> float:
    k_fa = false_alarm_factor(alarm, found.count, alarm_axes)
    return level_of_risk(
        float(found.whole_m[axis]),
        found.sigma_m[:, axis],
        k_fa * found.shift_m[:, axis],
        found.prior,
        risk * (1.0 - unmonitored(case) / (RISK_VERTICAL + RISK_HORIZONTAL)),
        bias=float(found.whole_bias_m[axis]),
        hypothesis_bias=found.bias_m[:, axis],
    )


def unmonitored(case: Published) -> float:
    """Return the probability of more faults than are looked at.

    One satellite more than that, both constellations, and - since version 3.0 of the reference algorithm, which counts
    satellites and constellations in one list - one of each.
    """
    more = case.satellites_faulty + 1
    satellites = math.comb(10, more) * case.p_satellite**more
    mixed = 10 * 2 * case.p_satellite * P_CONSTELLATION if case.satellites_faulty == 1 else 0.0
    return satellites + mixed + P_CONSTELLATION**2


@pytest.mark.parametrize("name", CASES)
def test_the_published_protection_levels_are_met(name: str) -> None:
    case = CASES[name]
    found = modes(case)
    vertical = level(case, found, 2, ALARM_VERTICAL, 1, RISK_VERTICAL)
    horizontal = math.hypot(*(level(case, found, axis, ALARM_HORIZONTAL, 2, RISK_HORIZONTAL / 2.0) for axis in (0, 1)))
    assert vertical == pytest.approx(case.vpl_m, abs=TOLERANCE_M)
    assert horizontal == pytest.approx(case.hpl_m, abs=TOLERANCE_M)


@pytest.mark.parametrize("name", CASES)
def test_the_published_false_alarm_factor_and_sigmas_are_met(name: str) -> None:
    """Printed to four decimals: 57 fault modes, 3.9e-6 both sides."""
    case, found = CASES[name], modes(CASES[name])
    assert false_alarm_factor(ALARM_VERTICAL, found.count, 1) == pytest.approx(case.k_fa, abs=5e-5)
    assert sorted(found.sigma_m[-2:, 2]) == pytest.approx(sorted(case.constellation_sigma_m), abs=6e-5)
