"""The residual report: every observation as a record, and what must be said about the whole in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navfix.adjustment.network import KIND_NAMES, RANGE, TRUE_BEARING, Network
from navfix.adjustment.reliability import CONSPICUOUS, Quality
from navfix.adjustment.solve import Solution
from navfix.types import AdjustedObservation
from navfix.units import wrap_360


def adjusted_observations(
    network: Network, solution: Solution, quality: Quality, labels: Sequence[tuple[str, str]]
) -> tuple[AdjustedObservation, ...]:
    """Return the report of every observation, in m and deg; ``labels`` (target, mark) by mark index."""
    rows = []
    for i, kind in enumerate(network.kind):
        unit = 1.0 if kind == RANGE else math.degrees(1.0)
        observed, residual = float(network.value[i]) * unit, float(quality.residual[i]) * unit
        adjusted = observed + residual
        target, mark = labels[network.mark[i]]
        testable = bool(quality.testable[i])
        rows.append(
            AdjustedObservation(
                target=target,
                mark=mark,
                kind=KIND_NAMES[kind],
                observed=observed if kind == RANGE else wrap_360(observed),
                adjusted=adjusted if kind == RANGE else wrap_360(adjusted),
                residual=residual,
                sigma=float(quality.sigma[i]) * unit,
                standardized=float(quality.standardized[i]) if testable else None,
                redundancy_number=float(quality.redundancy_number[i]),
                weight=float(solution.weights[i]),
                mdb=float(quality.mdb[i]) * unit if testable else None,
            )
        )
    return tuple(rows)


def notes(network: Network, quality: Quality, solution: Solution) -> tuple[str, ...]:
    """Say in words what a reader of the numbers must know."""
    said = [f"solved by {'GTSAM' if solution.solver == 'gtsam' else 'dense normal equations'}"]
    if quality.scaling == "a_priori":
        said.append(f"sigma0 not used: {quality.dof:.1f} degrees of freedom are too few to judge the noise")
    if abs(quality.prior_standardized) > CONSPICUOUS:
        said.append(
            f"the heading prior disagrees with the marks: standardised residual {quality.prior_standardized:.1f}"
        )
    if not network.heading_unknown and np.any(network.kind == TRUE_BEARING):
        said.append("all bearings are true: the heading is not an unknown")
    return tuple(said)
