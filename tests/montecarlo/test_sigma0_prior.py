"""Few degrees of freedom: the a-priori sigma0 below three, beside an inverse-chi-square prior on sigma0.

The prior says: sigma0^2 is 1, with the weight of ``PRIOR_DOF`` observations. Its posterior scale is
(PRIOR_DOF + v'Pv) / (PRIOR_DOF + dof), and the ellipse takes F with PRIOR_DOF + dof.
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
from navfix.types import confidence_radius
from tests.adjustment_scenes import plane_scene

PRIOR_DOF = 4.0
FULL = 2000


@dataclass(frozen=True)
class Coverage:
    """Share inside the 95 % ellipse and its mean semi-major axis [m]: the rule in use, and the prior."""

    rule: float
    prior: float
    rule_axis_m: float
    prior_axis_m: float


def measure(runs: int, marks: int, noise: float, *, wrong: int = 0) -> Coverage:
    rng = np.random.default_rng([41, marks, round(10 * noise), wrong])
    inside, axes = [], []
    for _ in range(runs):
        scene = plane_scene(rng, marks=marks, noise=noise, wrong=wrong)
        try:
            found = solve(scene.network, catalog.kernel("hampel"), solver="dense")
        except NoFix:
            continue
        quality = assess(scene.network, found.pose, found.weights, found.cofactor, "joint")
        dof = max(quality.dof, 0.0)
        posterior = (PRIOR_DOF + quality.sigma0**2 * dof) / (PRIOR_DOF + dof)
        ways = (
            (quality.covariance[:2, :2], dof if quality.scaling == "a_posteriori" else None),
            (posterior * quality.cofactor[:2, :2], PRIOR_DOF + dof),
        )
        offset = found.pose[:2]
        radii = [confidence_radius(0.95, dof=d) for _, d in ways]
        distance = [math.sqrt(offset @ np.linalg.solve(c, offset)) for c, _ in ways]
        inside.append([d < r for d, r in zip(distance, radii, strict=True)])
        axes.append([r * math.sqrt(np.linalg.eigvalsh(c)[1]) for (c, _), r in zip(ways, radii, strict=True)])
    (rule, prior), (rule_m, prior_m) = np.mean(inside, axis=0), np.median(axes, axis=0)
    return Coverage(float(rule), float(prior), float(rule_m), float(prior_m))


def test_both_ways_hold_where_the_sigmas_are_right() -> None:
    for marks in (2, 3, 5):
        found = measure(200, marks, 1.0)
        print(f"{marks} pairs: {found}")
        assert found.rule >= 0.90
        assert found.prior >= 0.92


@pytest.mark.study
@pytest.mark.parametrize("noise", [0.7, 1.0, 1.5])
@pytest.mark.parametrize("marks", [2, 3, 4, 5, 8])
def test_study_prior_on_sigma0(marks: int, noise: float) -> None:
    found = measure(FULL, marks, noise)
    rule = f"a priori below three dof {100 * found.rule:.1f} % ({found.rule_axis_m:.0f} m)"
    prior = f"prior of {PRIOR_DOF:.0f} dof {100 * found.prior:.1f} % ({found.prior_axis_m:.0f} m)"
    print(f"{marks} pairs, noise x {noise}: {rule}, {prior}")
    assert found.rule > 0.7
    assert found.prior > 0.7
