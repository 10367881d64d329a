"""From an epoch and its association to a fix: the problem, the search, the solution, the record."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from navfix.adjustment.checks import check_counts
from navfix.adjustment.compass import Located, border, bordered_cofactor, locate
from navfix.adjustment.lever_arm import Alignment, Offset, swung
from navfix.adjustment.mounting import Mounting
from navfix.adjustment.network import Network
from navfix.adjustment.observations import adjusted_observations, compass_notes, notes
from navfix.adjustment.pairs import Problem, mask_of, observation_sigmas, pairs_of, problem_of
from navfix.adjustment.reliability import Quality, assess
from navfix.adjustment.search import Placer, Search
from navfix.adjustment.solve import Solution, Solver, finish
from navfix.catalog import RadarModel, radar_model
from navfix.catalog import kernel as kernel_of
from navfix.geodesy import LocalPlane
from navfix.kernels import Damping, Kernel, Standardisation
from navfix.types import Alternative, Association, Epoch, Fix, FloatArray, HeadingHint, Integrity, Position


def adjust(
    epoch: Epoch,
    association: Association,
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    damping: Damping = "joint",
    standardise: Standardisation = "sigma",
    heading_prior: HeadingHint | None = None,
    range_sigma_m: float | None = None,
    bearing_sigma_deg: float | None = None,
    compass_sigma_deg: float | None = None,
    radar_antenna_m: Offset | None = None,
    alignment: Alignment | tuple[float, float] | None = None,
    mask: ArrayLike | None = None,
    start: tuple[Position, float | None] | None = None,
    solver: Solver = "auto",
) -> Fix:
    """Adjust own-ship position and heading from associated radar targets and marks.

    Each pair gives a range and a relative or true bearing. With any relative bearing the heading is an unknown. True
    bearings share the error of the compass that made them: it is an unknown with the prior (0, ``compass_sigma_deg``),
    given up where the data say so (`compass_error_deg` of the fix). When all bearings are true the own heading is not
    determined: the fix then has ``heading_deg`` None and a (2, 2) covariance, which contains the compass error.
    ``epoch.heading_hint`` is not used: what shall count as evidence is given as ``heading_prior``.

    Parameters
    ----------
    association : pairs (k, 2); its pose, where it has one, is one of the starts
    radar : sigma of one range [m] and one bearing [deg], by name or as a model; a target's own sigma overrides it,
        ``range_sigma_m`` and ``bearing_sigma_deg`` override both
    kernel : name in models/kernel, path of a TOML file, or a kernel; acts on the standardised residual
    damping : "joint" (one weight per target) or "separate" (one per observation)
    standardise : by what the kernel's argument is divided: the sigma of the observation, or that of its residual
        ("gdynia", from the a-priori weights, held fixed)
    heading_prior : heading of a compass with its sigma, an observation like the others; its standardised residual is
        judged in the notes of the fix
    compass_sigma_deg : 1 sigma of the error common to all true bearings; None: the radar model's; 0 holds it at zero
    radar_antenna_m : forward and starboard of the ship's reference point, None: the radar model's; the position is
        that of the reference point (with all bearings true the heading hint of the epoch turns the offset; without one
        the antenna's place stays)
    alignment : direction of the radar's zero mark from the bow, clockwise, and its sigma [deg], None: the radar
        model's; the heading is the bow's then (``heading_reference`` "bow"), the zero mark's where it is not known
    mask : (k,) or (k, 2) for (range, bearing): which observations take part
    start : position, and heading [deg] or None (then the one that most targets agree on there); the minimum reached
        from it is the fix and other minima are only listed
    solver : "gtsam", "dense", or "auto": GTSAM where it is installed

    Returns
    -------
    Fix - covariance (3, 3) in north [m], east [m], heading [rad]

    Raises
    ------
    TooFewPairs : fewer observations than unknowns; Unobservable : the geometry leaves a direction free;
    NoAgreement : the observations contradict each other; Ambiguous : another place explains them nearly as well;
    InputError : a mask of the wrong shape, an impossible offset or sigma; CatalogError : an unknown radar or kernel

    References
    ----------
    Knopp, thesis, 4.3; Gdynia stand (Czaplewski et al.), eq. 14-17; Huber, Robust Statistics, 1981.
    """
    model, damper = radar_model(radar), kernel_of(kernel)
    mounting = Mounting.of(model, radar_antenna_m, alignment)
    pairs = pairs_of(epoch, association)
    problem = problem_of(
        pairs,
        observation_sigmas(pairs, model, range_sigma_m, bearing_sigma_deg),
        mask_of(mask, len(pairs)),
        heading_prior=heading_prior,
        compass_sigma_deg=model.compass_sigma_deg if compass_sigma_deg is None else compass_sigma_deg,
    )
    check_counts(problem.network)
    search = Search(
        pairs, damper, damping, _given(association, start, problem, mounting), start is not None, standardise
    )
    located = locate(search, problem)
    solution = _finished(located, damper, damping, solver)
    fix = _fix(epoch, association, problem, located, damper, damping, solution, mounting)
    return replace(fix, damping=damping, standardise=standardise)


def _given(
    association: Association, start: tuple[Position, float | None] | None, problem: Problem, mounting: Mounting
) -> tuple[Position, float | None] | None:
    """Return the pose to begin from: of the radar's antenna and zero mark, or with the compass error for a turn."""
    if start is None:
        return None if association.position is None else (association.position, association.heading_deg)
    if problem.common:
        return start[0], 0.0
    return mounting.antenna_and_zero_mark(*start)


def _finished(located: Located, kernel: Kernel, damping: Damping, solver: Solver) -> Solution:
    found = located.found
    return finish(found.network, kernel, damping, found.minima[0], solver=solver)


# ------------------------------------------------------------------------------------------------------- the record


def _fix(
    epoch: Epoch,
    association: Association,
    problem: Problem,
    located: Located,
    kernel: Kernel,
    damping: Damping,
    solution: Solution,
    mounting: Mounting,
) -> Fix:
    found, network = located.found, located.found.network
    heading_known = network.heading_unknown and not problem.common
    quality = _quality(located, kernel, damping, solution)
    error_deg, error_sigma_deg = _compass_error(problem, located, solution, quality)
    place = Placer(found.plane, heading=heading_known)
    position, zero_mark_deg = place(solution.pose)
    covariance, said = quality.covariance[:2, :2], _said(problem, network, quality, solution)
    if heading_known and zero_mark_deg is not None:
        position, heading_deg = mounting.ship_of(position, zero_mark_deg)
        covariance = mounting.covariance_of_ship(quality.covariance[:3, :3], math.radians(heading_deg or 0.0))
    else:
        heading_deg = None
        position, added = _by_hint(epoch, mounting, position, said)
        covariance = covariance + added
    said += compass_notes(error_deg, error_sigma_deg, problem, located)
    scale = quality.sigma0**2 if quality.scaling == "a_posteriori" else 1.0
    labels = [(pair.target.label, pair.mark.label) for pair in problem.pairs]
    return Fix(
        position=position,
        heading_deg=heading_deg,
        covariance=covariance,
        sigma0=quality.sigma0,
        redundancy=network.redundancy - (located.eliminated_rad is not None and located.prior_rad is None),
        observations=adjusted_observations(
            network, solution, quality, labels, kind=problem.kind, observed=problem.network.value
        ),
        association=association,
        epoch=epoch,
        cofactor_matrix=covariance / scale,
        covariance_scaling=quality.scaling,
        dof=quality.dof,
        kernel=kernel.name,
        heading_reference="radar_zero_mark" if mounting.alignment is None else "bow",
        global_test=quality.global_test,
        integrity=Integrity(r95_m=quality.r95_m),
        alternatives=tuple(_of_ship(other, mounting) for other in located.alternatives),
        start=solution.start,
        notes=tuple(said),
        compass_error_deg=error_deg,
        compass_error_sigma_deg=error_sigma_deg,
    )


def _said(problem: Problem, network: Network, quality: Quality, solution: Solution) -> list[str]:
    prior = "compass prior" if problem.common or problem.mixed else "heading prior"
    return list(notes(network, quality, solution, prior=prior))


def _quality(located: Located, kernel: Kernel, damping: Damping, solution: Solution) -> Quality:
    network, pose = located.found.network, solution.pose
    if located.eliminated_rad is None:
        return assess(network, pose, solution.weights, solution.cofactor, damping, linear=solution.linear)
    edge = border(network, kernel, damping, pose, located.prior_rad)
    cofactor = bordered_cofactor(solution.cofactor, edge)
    compass = (located.eliminated_rad, located.prior_rad)
    return assess(network, pose, solution.weights, cofactor, damping, compass_rad=compass, linear=solution.linear)


def _compass_error(
    problem: Problem, located: Located, solution: Solution, quality: Quality
) -> tuple[float | None, float | None]:
    """Return the error of the compass and its sigma [deg], None where it is no unknown."""
    if not problem.common and located.eliminated_rad is None:
        return None, None
    error_rad = float(solution.pose[2]) if located.eliminated_rad is None else located.eliminated_rad
    return math.degrees(error_rad), math.degrees(math.sqrt(float(quality.covariance[-1, -1])))


def _by_hint(
    epoch: Epoch, mounting: Mounting, antenna: Position, said: list[str]
) -> tuple[Position, FloatArray | float]:
    """Return the reference point by the heading hint where the heading is not an unknown, and the variance added."""
    hint = epoch.heading_hint
    if not any(mounting.offset_m):
        return antenna, 0.0
    if hint is None:
        said.append("the position is that of the radar antenna: no heading turns its offset")
        return antenna, 0.0
    away, by_heading = swung(mounting.offset_m, math.radians(hint.heading_deg))
    position = LocalPlane(antenna).to_position(float(-away[0]), float(-away[1]))
    return position, math.radians(hint.sigma_deg) ** 2 * np.outer(by_heading, by_heading)


def _of_ship(other: Alternative, mounting: Mounting) -> Alternative:
    if not isinstance(other.position, Position):
        return other
    position, heading_deg = mounting.ship_of(other.position, other.heading_deg)
    return replace(other, position=position, heading_deg=heading_deg)
