"""Adjust a case: from its file to a fix, in the plane or on the ellipsoid."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from navfix import catalog
from navfix.adjustment.case import Case
from navfix.adjustment.case_frame import Place, middle_of_marks, moved, network_about, true_heading_deg
from navfix.adjustment.checks import alternative, check_counts, check_solution, determined
from navfix.adjustment.network import Network
from navfix.adjustment.observations import adjusted_observations, notes
from navfix.adjustment.reliability import Quality, assess, by_residual_sigma
from navfix.adjustment.solve import Solution, Solver, finish, solve
from navfix.adjustment.start import Minimum, find_minima, follow
from navfix.adjustment.textbook import LinearStep, linear_step
from navfix.errors import Unobservable
from navfix.kernels import Damping, Kernel, Standardisation
from navfix.types import AdjustedObservation, Fix, FloatArray, Integrity, Position
from navfix.units import wrap_360

_STANDS_STILL_M = 1e-4
_RECENTRINGS = 20


def adjust_case(
    case: Case,
    *,
    kernel: Kernel | str = "hampel",
    damping: Damping = "joint",
    standardise: Standardisation = "sigma",
    solver: Solver = "auto",
) -> Fix:
    """Adjust a case; with relative bearings the heading is an unknown too.

    With a start, the minimum that is reached from it is the fix and every other one is an alternative. Without a start
    the lowest is the fix. On the ellipsoid the plane is re-centred on the fix until that stands still, so that ranges
    and bearings are exact.

    Parameters
    ----------
    kernel : acts on the standardised residual
    damping : "joint" damps what was measured to one target together, "separate" each observation by itself
    standardise : "sigma" of the observation, or "gdynia": that of its residual from the a-priori weights, held fixed

    Returns
    -------
    Fix - observations in the order of the case; covariance and cofactor matrix (2, 2), (3, 3) with a heading

    Raises
    ------
    TooFewPairs : fewer observations than unknowns; Unobservable : a direction stays free
    NoAgreement : the observations contradict each other; Ambiguous : without a start, two places fit alike
    """
    kernel = catalog.kernel(kernel)
    origin = case.start if case.start is not None else middle_of_marks(case)
    network = network_about(case, origin)
    check_counts(network)
    standard = _standard(case, network, kernel, damping) if standardise == "gdynia" else None
    network = replace(network, standard=standard)

    def place(pose: FloatArray) -> tuple[Place, float | None]:
        there = moved(origin, float(pose[0]), float(pose[1]))
        heading_deg = true_heading_deg(origin, there, math.degrees(float(pose[2]))) if network.heading_unknown else None
        return there, heading_deg

    solution = solve(network, kernel, damping, start=_start(case), solver=solver, place=place)
    others = tuple(alternative(minimum, place) for minimum in solution.others)
    own, network, solution = _recentred(case, origin, network, solution, kernel, damping, solver)
    quality = assess(network, solution.pose, solution.weights, solution.cofactor, damping)
    return Fix(
        position=own,
        heading_deg=wrap_360(math.degrees(float(solution.pose[2]))) if network.heading_unknown else None,
        covariance=quality.covariance,
        sigma0=quality.sigma0,
        redundancy=network.redundancy,
        observations=_adjusted(case, network, solution, quality),
        association=None,
        epoch=None,
        cofactor_matrix=quality.cofactor,
        covariance_scaling=quality.scaling,
        dof=quality.dof,
        kernel=kernel.name,
        global_test=quality.global_test,
        integrity=Integrity(quality.r95_m),
        alternatives=others,
        start=solution.start,
        damping=damping,
        standardise=standardise,
        notes=notes(network, quality, solution),
    )


def first_step(case: Case, fix: Fix) -> LinearStep | None:
    """Return the classical linear step (P = 1 / sigma^2) from the case's start; from the fix, where it has none.

    None where the start is singular, as on a mark or in line with all of them.
    """
    place = case.start if case.start is not None else fix.position
    heading_deg = case.heading_deg if case.start is not None else fix.heading_deg
    pose = np.array([0.0, 0.0, math.radians(heading_deg or 0.0)])
    try:
        return linear_step(network_about(case, place), pose)
    except Unobservable:
        return None


# -------------------------------------------------------------------------------------------------------- the steps


def _standard(case: Case, network: Network, kernel: Kernel, damping: Damping) -> FloatArray | None:
    """Return the a-priori sigma of the residuals, at the place found without it; None where nothing is determined."""
    start = _start(case)
    pose = find_minima(network, kernel, damping)[0].pose if start is None else start
    if not determined(network, pose, damping):
        return None
    return by_residual_sigma(network, pose, damping).standard


def _start(case: Case) -> FloatArray | None:
    """Return the pose (3,) to go down from, the origin of the plane; None for a case without a start."""
    return None if case.start is None else np.array([0.0, 0.0, math.radians(case.heading_deg or 0.0)])


def _recentred(
    case: Case,
    origin: Place,
    network: Network,
    solution: Solution,
    kernel: Kernel,
    damping: Damping,
    solver: Solver,
) -> tuple[Place, Network, Solution]:
    """Return the fix's place, and network and solution about it; a case in a plane needs no second look."""
    own, pose = moved(origin, float(solution.pose[0]), float(solution.pose[1])), solution.pose
    if not isinstance(own, Position):
        return own, network, solution
    for _ in range(_RECENTRINGS):
        network = replace(network_about(case, own), standard=network.standard)
        start = np.array([0.0, 0.0, math.radians(true_heading_deg(origin, own, math.degrees(float(pose[2]))))])
        found = follow(network, kernel, damping, start, solution.start)
        origin, pose = own, found.pose
        own = moved(origin, float(pose[0]), float(pose[1]))
        if math.hypot(pose[0], pose[1]) < _STANDS_STILL_M:
            break
    minimum = Minimum(pose, found.loss, solution.start, found.targets)
    check_solution(network, kernel, damping, [minimum], rivals=False)
    return own, network, finish(network, kernel, damping, minimum, solver=solver)


def _adjusted(case: Case, network: Network, solution: Solution, quality: Quality) -> tuple[AdjustedObservation, ...]:
    labels = [(mark.label, mark.label) for mark in case.marks]
    rows = adjusted_observations(network, solution, quality, labels)
    return tuple(replace(row, target=o.target) for row, o in zip(rows, case.observations, strict=True))
