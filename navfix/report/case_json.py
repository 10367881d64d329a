"""The textbook's matrices as JSON, beside the object of the fix."""

from __future__ import annotations

from typing import Any

from navfix.adjustment.case import Case
from navfix.adjustment.textbook import LinearStep
from navfix.adjustment.utm import from_utm
from navfix.report.json_parts import position_to_dict
from navfix.report.numbers import plain, plain_matrix
from navfix.types import Fix, FloatArray, PlanePosition

KEYS = ("design_matrix", "free_terms", "weights", "increments", "cofactors", "first_step")


def textbook_to_dict(step: LinearStep | None) -> dict[str, Any]:
    """Return the keys of the textbook report, all null for None.

    ``design_matrix`` A (m rows; north m, east m, heading rad), ``free_terms`` L, ``weights`` P and ``increments`` dx
    belong to the classical linear step from the start (from the fix of a case without one): dx = -(A'PA)^-1 A'PL,
    P = 1 / sigma^2, rows in m or deg. ``cofactors`` holds the matrices
    of the unknowns, of the adjusted observations (A Q A') and of the residuals (P^-1 - A Q A'; null for an observation
    without weight); ``first_step`` what follows at once: residuals V, sigma0, the standard deviations of the adjusted
    observations and the mean position error.
    """
    if step is None:
        return dict.fromkeys(KEYS)
    adjusted = step.observation_cofactors
    return {
        "design_matrix": plain_matrix(step.design_matrix),
        "free_terms": _numbers(step.free_terms),
        "weights": _numbers(step.weights),
        "increments": _numbers(step.increments),
        "cofactors": {
            "unknowns": plain_matrix(step.cofactors),
            "adjusted_observations": plain_matrix(adjusted),
            "residuals": plain_matrix(step.residual_cofactors),
        },
        "first_step": {
            "residuals": _numbers(step.residuals),
            "sigma0": plain(step.sigma0),
            "adjusted_sigma": _numbers(step.adjusted_sigma),
            "position_sigma_m": plain(step.position_sigma_m),
        },
    }


def utm_to_dict(case: Case, fix: Fix) -> dict[str, Any] | None:
    """Return where a fix in a UTM plane is on WGS 84, with convergence and scale; None for every other case."""
    if case.utm_zone is None or not isinstance(fix.position, PlanePosition):
        return None
    found = from_utm(fix.position, case.utm_zone)
    return {
        "zone": case.utm_zone,
        "position": position_to_dict(found.position),
        "convergence_deg": plain(found.convergence_deg),
        "scale": plain(found.scale, 12),
    }


def _numbers(values: FloatArray) -> list[float | None]:
    return [plain(float(value)) for value in values]
