"""The residual report: every observation as a record, and what must be said about the whole in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navfix.adjustment import gnc
from navfix.adjustment.compass import Located
from navfix.adjustment.network import KIND_NAMES, RANGE, TRUE_BEARING, Network
from navfix.adjustment.pairs import Problem
from navfix.adjustment.reliability import CONSPICUOUS, Quality
from navfix.adjustment.solve import Solution
from navfix.types import AdjustedObservation, FloatArray, IntArray
from navfix.units import wrap_360

_DEG = math.degrees(1.0)


def adjusted_observations(
    network: Network,
    solution: Solution,
    quality: Quality,
    labels: Sequence[tuple[str, str]],
    *,
    kind: IntArray | None = None,
    observed: FloatArray | None = None,
) -> tuple[AdjustedObservation, ...]:
    """Return the report of every observation, in m and deg; ``labels`` (target, mark) by mark index.

    ``kind`` and ``observed`` (m,) as they were measured, where the network holds them otherwise (compass error).
    """
    kinds, values = network.kind if kind is None else kind, network.value if observed is None else observed
    unit = np.where(kinds == RANGE, 1.0, _DEG)
    adjusted, w, r = values + quality.residual, quality.standardized, quality.redundancy_number
    in_units = np.stack([values, adjusted, quality.residual, quality.sigma, quality.mdb]) * unit
    plain = np.stack([w, r, solution.weights, quality.external_m])
    rows = zip(
        kinds.tolist(),
        network.mark.tolist(),
        quality.testable.tolist(),
        *in_units.tolist(),
        *plain.tolist(),
        strict=True,
    )
    return tuple(
        AdjustedObservation(
            target=labels[mark][0],
            mark=labels[mark][1],
            kind=KIND_NAMES[kind_],
            observed=observed_ if kind_ == RANGE else wrap_360(observed_),
            adjusted=adjusted_ if kind_ == RANGE else wrap_360(adjusted_),
            residual=residual,
            sigma=sigma,
            standardized=standardized if testable else None,
            redundancy_number=redundancy,
            weight=weight,
            mdb=mdb if testable else None,
            external_m=external_m if testable else None,
        )
        for kind_, mark, testable, *in_m_or_deg, standardized, redundancy, weight, external_m in rows
        for observed_, adjusted_, residual, sigma, mdb in [in_m_or_deg]
    )


def notes(network: Network, quality: Quality, solution: Solution, *, prior: str = "heading prior") -> tuple[str, ...]:
    """Say in words what a reader of the numbers must know; ``prior`` is the word for what holds the turn."""
    said = [f"solved by {'GTSAM' if solution.solver == 'gtsam' else 'dense normal equations'}"]
    if not solution.settled:
        said.append("NOT SETTLED: the residuals are so large that the descent goes in circles; take a robust kernel")
    if solution.start == gnc.START:
        said.append("gnc goes down from least squares alone: other places that fit as well are not looked for")
    if quality.scaling == "a_priori":
        said.append(f"sigma0 not used: {quality.dof:.1f} degrees of freedom are too few to judge the noise")
    if quality.global_test is None:
        said.append("no redundancy: nothing checks these observations, and another place may fit them as exactly")
    if abs(quality.prior_standardized) > CONSPICUOUS:
        said.append(f"the {prior} disagrees with the marks: standardised residual {quality.prior_standardized:.1f}")
    if not network.heading_unknown and np.any(network.kind == TRUE_BEARING):
        said.append("all bearings are true: the heading is not an unknown")
    return tuple(said)


def compass_notes(
    error_deg: float | None, sigma_deg: float | None, problem: Problem, located: Located
) -> tuple[str, ...]:
    """Say in words what became of the compass in the true bearings; nothing where it is no unknown."""
    if error_deg is None or sigma_deg is None:
        return ()
    said = [f"compass error {error_deg:+.2f}° +- {sigma_deg:.2f} (1 sigma), to be added to the true bearings"]
    if problem.common:
        said.append("all bearings are true: own heading is not determined")
    if located.prior_rad is None:
        expected = f"{math.degrees(problem.compass_sigma_rad):.1f}° (1 sigma)"
        said.append(f"CHECK THE COMPASS: its error was estimated freely, {expected} do not explain it")
    return tuple(said)
