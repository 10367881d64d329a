"""The compass in true bearings: one error common to all of them, with a prior, and when the prior is not believed.

A radar makes true bearings of relative ones with the heading of a compass. The error of that heading,
true = shown + error, is the same in every bearing of an epoch: it turns the whole picture and is an unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.adjustment import checks
from navfix.adjustment.damped import observation_weights
from navfix.adjustment.network import TRUE_BEARING, BoolArray, Network
from navfix.adjustment.pairs import Problem
from navfix.adjustment.search import Found, Placer, Search
from navfix.adjustment.sights import jacobian, residuals
from navfix.adjustment.whitening import normal_matrix, whiten_one, whitened, whitener
from navfix.errors import Ambiguous, NoFix
from navfix.kernels import Damping, Kernel
from navfix.types import Alternative, FloatArray, confidence_radius
from navfix.units import wrap_pi

FAILED_SHARE = 0.01  # of compasses that may point anywhere, before the data have spoken
_STANDS_STILL_RAD = 1e-10
_ROUNDS = 30


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """A solution that stands still, the other minima as places, and what became of the compass.

    ``prior_rad`` is the sigma of the prior that took part, None where it was not believed (or there is no such
    unknown). ``eliminated_rad`` is the error where it is an unknown beside the heading, already added to the values of
    the true bearings in the network; None elsewhere.
    """

    found: Found
    alternatives: tuple[Alternative, ...]
    prior_rad: float | None = None
    eliminated_rad: float | None = None


def failure_cost(sigma_rad: float) -> float:
    """Return by how much the logarithm of the prior falls from its middle to a compass that points anywhere.

    ln((1 - q) / q) + ln(2 pi / (sqrt(2 pi) sigma)): a compass with sigma 1.5 deg is given up beyond about 4.3 sigma.
    """
    return math.log((1.0 - FAILED_SHARE) / FAILED_SHARE) + 0.5 * math.log(2.0 * math.pi) - math.log(sigma_rad)


def locate(search: Search, problem: Problem) -> Located:
    """Find the minima of a problem with whatever the compass in its true bearings asks for.

    Raises
    ------
    Ambiguous : the compass believed and not believed lead to different places, and are nearly as likely;
    NoFix : as `checks.check_solution`
    """
    if problem.mixed:
        return _beside_the_heading(search, problem)
    if problem.common:
        return _in_every_bearing(search, problem)
    found = search.minima(problem.network)
    others = _checked(search, found, heading=problem.network.heading_unknown)
    return Located(search.stand_still(found), others)


def _checked(search: Search, found: Found, *, heading: bool, rivals: bool = True) -> tuple[Alternative, ...]:
    """Check the best minimum; return the others as places."""
    place = Placer(found.plane, heading=heading)
    rivals = rivals and not search.only_given
    checks.check_solution(found.network, search.kernel, search.damping, found.minima, place=place, rivals=rivals)
    return tuple(checks.alternative(minimum, place) for minimum in found.minima[1:])


# ------------------------------------------------------------------------------------------------ all bearings true


def _in_every_bearing(search: Search, problem: Problem) -> Located:
    """Search with the prior and without it; take what is more likely, a failed compass counting as rare."""
    believed, free = search.minima(problem.network), _free(search, problem)
    if free is None:
        others = _checked(search, believed, heading=False)
        return Located(search.stand_still(believed), others, problem.compass_sigma_rad)
    gap = free.minima[0].loss + failure_cost(problem.compass_sigma_rad) - believed.minima[0].loss
    chosen, other = (believed, free) if gap > 0.0 else (free, believed)
    others = _checked(search, chosen, heading=False)
    close = abs(gap) < checks.decisive_gap(search.kernel, search.damping)
    if close and not search.only_given and _apart(search, chosen, other):
        places = [checks.alternative(f.minima[0], Placer(f.plane, heading=False)) for f in (chosen, other)]
        raise Ambiguous(
            "the true bearings as shown and turned by a compass error lead to different places", alternatives=places
        )
    return Located(search.stand_still(chosen), others, problem.compass_sigma_rad if chosen is believed else None)


def _free(search: Search, problem: Problem) -> Found | None:
    """Return the minima without the prior, None where the data alone do not determine the compass error."""
    network = replace(problem.network, heading_prior_rad=None)
    try:
        checks.check_counts(network)
        found = search.minima(network)
        _checked(search, found, heading=False, rivals=False)
    except NoFix:
        return None
    return found


def _apart(search: Search, chosen: Found, other: Found) -> bool:
    """Tell whether the other place lies outside the 99.9 % ellipse of the chosen one."""
    network, pose = chosen.network, chosen.minima[0].pose
    weights = observation_weights(network, search.kernel, search.damping, pose)
    matrix = normal_matrix(network, whitened(network, pose, search.damping)[1], weights)
    covariance = np.linalg.inv(matrix)[:2, :2]
    there = other.plane.to_position(float(other.minima[0].pose[0]), float(other.minima[0].pose[1]))
    offset = chosen.plane.to_plane(there) - pose[:2]
    return float(offset @ np.linalg.solve(covariance, offset)) > confidence_radius(0.999) ** 2


# ------------------------------------------------------------------------------------- relative and true bearings


def _beside_the_heading(search: Search, problem: Problem) -> Located:
    """Search with sigmas that contain the compass error, then estimate it and bring it out of the true bearings.

    For each value of the error the network is adjusted as usual; a Newton step on the loss that is left leads to the
    next value (the error eliminated by its Schur complement), until it stands still.
    """
    network, sigma_rad = problem.network, problem.compass_sigma_rad
    true = (network.kind == TRUE_BEARING) & network.mask
    wide = replace(network, sigma=np.where(true, np.hypot(network.sigma, sigma_rad), network.sigma))
    found = search.minima(wide)
    others = _checked(search, found, heading=True)
    error_rad = _median_turn(found, true)
    believed = 0.5 * (error_rad / sigma_rad) ** 2 < failure_cost(sigma_rad)
    prior_rad = sigma_rad if believed else None
    for _ in range(_ROUNDS):
        shifted = replace(network, value=network.value + error_rad * true, mark_ne_m=found.network.mark_ne_m)
        found = search.stand_still(replace(found, network=shifted))
        bordered = border(found.network, search.kernel, search.damping, found.minima[0].pose, prior_rad)
        step_rad = -(bordered.slope + (0.0 if prior_rad is None else error_rad / prior_rad**2)) / bordered.schur
        if abs(step_rad) < _STANDS_STILL_RAD:
            break
        error_rad += step_rad
    return Located(found, others, prior_rad, error_rad)


def _median_turn(found: Found, true: BoolArray) -> float:
    """Return the median residual of the true bearings whose targets agree in range, of all where none does."""
    network, pose = found.network, found.minima[0].pose
    v = residuals(network, pose)
    off = np.zeros(len(network.mark_ne_m))
    np.maximum.at(off, network.mark, np.where(network.is_range, np.abs(v) / network.sigma, 0.0))
    good = true & (off[network.mark] < 5.0)
    return float(np.median(wrap_pi(v[good if np.any(good) else true])))


@dataclass(frozen=True, slots=True, eq=False)
class Border:
    """The row of the compass error beside a 3 x 3 normal matrix N: mixed terms, Schur complement s - n'Qn, slope."""

    mixed: FloatArray
    schur: float
    slope: float


def border(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray, prior_rad: float | None) -> Border:
    """Return the border of the normal equations at ``pose`` (3,) for the error common to all true bearings.

    ``slope`` is the derivative of the loss without the prior. An error that no bearing supports is held by a prior of
    half a turn.
    """
    factor = whitener(network, jacobian(network, pose), damping)
    v_white, a_white = whitened(network, pose, damping)
    column = whiten_one(network, factor, compass_column(network))
    weights = observation_weights(network, kernel, damping, pose)
    matrix = normal_matrix(network, a_white, weights)
    mixed = a_white.T @ (weights * column)
    own = float(weights @ column**2) + (1.0 / math.pi**2 if prior_rad is None else 1.0 / prior_rad**2)
    schur = own - float(mixed @ np.linalg.solve(matrix, mixed))
    return Border(mixed, schur, float((weights * v_white) @ column))


def compass_column(network: Network) -> FloatArray:
    """Return d prediction / d compass error (m,): -1 for what is observed as a true bearing."""
    return np.asarray(-1.0 * ((network.kind == TRUE_BEARING) & network.mask))


def bordered_cofactor(cofactor: FloatArray, edge: Border) -> FloatArray:
    """Return the cofactor matrix (4, 4) of (north, east, heading, compass error) from that of the first three."""
    k = cofactor @ edge.mixed
    result = np.empty((4, 4))
    result[:3, :3] = cofactor + np.outer(k, k) / edge.schur
    result[:3, 3] = result[3, :3] = -k / edge.schur
    result[3, 3] = 1.0 / edge.schur
    return result
