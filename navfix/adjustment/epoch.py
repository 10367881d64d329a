"""From an epoch and its association to a fix: the plane about own ship, the network on it, the record."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from navfix.adjustment import solve as solving
from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, Network
from navfix.adjustment.observations import adjusted_observations, notes
from navfix.adjustment.reliability import assess
from navfix.adjustment.solve import Solution, Solver
from navfix.adjustment.start import Minimum, find_minima, follow, follow_given
from navfix.adjustment.trials import with_heading
from navfix.catalog import RadarModel, radar_model
from navfix.catalog import kernel as kernel_of
from navfix.errors import InputError, TooFewPairs
from navfix.geodesy import LocalPlane, centroid
from navfix.kernels import Damping, Kernel
from navfix.types import (
    Alternative,
    Association,
    Epoch,
    Fix,
    FloatArray,
    HeadingHint,
    Integrity,
    Mark,
    Position,
    RadarTarget,
)
from navfix.units import wrap_360

_STANDS_STILL_M = 1e-3
_TURNED_DEG = 0.02  # convergence between search planes that is small beside any radar's bearing sigma
_PLANES = 12


class Pair(NamedTuple):
    """A target and the mark that it is."""

    target: RadarTarget
    mark: Mark


def adjust(
    epoch: Epoch,
    association: Association,
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    damping: Damping = "joint",
    heading_prior: HeadingHint | None = None,
    range_sigma_m: float | None = None,
    bearing_sigma_deg: float | None = None,
    mask: ArrayLike | None = None,
    start: tuple[Position, float | None] | None = None,
    solver: Solver = "auto",
) -> Fix:
    """Adjust own-ship position and heading from associated radar targets and marks.

    Each pair gives a range and a relative or true bearing. With any relative bearing the heading is an unknown; when
    all bearings are true it is not: the fix then has ``heading_deg`` None and a (2, 2) covariance.
    ``epoch.heading_hint`` is not used: what shall count as evidence is given as ``heading_prior``.

    Parameters
    ----------
    association : pairs (k, 2); its pose, where it has one, is one of the starts
    radar : sigma of one range [m] and one bearing [deg], by name or as a model; a target's own sigma overrides it,
        ``range_sigma_m`` and ``bearing_sigma_deg`` override both
    kernel : name in models/kernel, path of a TOML file, or a kernel; acts on the standardised residual
    damping : "joint" (one weight per target) or "separate" (one per observation)
    heading_prior : heading of a compass with its sigma, an observation like the others; its standardised residual is
        judged in the notes of the fix
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
    InputError : a mask of the wrong shape; CatalogError : an unknown radar or kernel

    References
    ----------
    Knopp, thesis, 4.3; Gdynia stand (Czaplewski et al.), eq. 14-17; Huber, Robust Statistics, 1981.
    """
    pairs = [Pair(epoch.targets[t], epoch.marks[m]) for t, m in association.pairs]
    if not pairs:
        raise TooFewPairs("no pairs: nothing to adjust", observations=0, unknowns=3)
    damper = kernel_of(kernel)
    sigmas = observation_sigmas(pairs, radar_model(radar), range_sigma_m, bearing_sigma_deg)
    network = _network(pairs, sigmas, _mask(mask, len(pairs)), heading_prior)
    solving.check_counts(network)
    plane, network, minima = _search(network, pairs, association, damper, damping, start)
    place = _Placer(plane)
    solving.check_solution(network, damper, damping, minima, place=place, rivals=start is None)
    plane, network, best = _stand_still(plane, network, pairs, damper, damping, minima[0])
    solution = solving.finish(network, damper, damping, best, others=tuple(minima[1:]), solver=solver)
    alternatives = tuple(solving.alternative(minimum, place) for minimum in minima[1:])
    return _fix(epoch, association, pairs, network, plane, damper, damping, solution, alternatives)


# ------------------------------------------------------------------------------------------------------ the network


def observation_sigmas(
    pairs: Sequence[Pair], radar: RadarModel, range_sigma_m: float | None, bearing_sigma_deg: float | None
) -> FloatArray:
    """Return (k, 2): sigma of range [m] and bearing [rad]; an explicit one, else the target's, else the radar's."""
    for name, value in (("range_sigma_m", range_sigma_m), ("bearing_sigma_deg", bearing_sigma_deg)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} must be > 0, got {value}")
    by_model = radar.sigma_of_range_m(np.array([pair.target.range_m for pair in pairs]))
    rows = [
        (
            range_sigma_m or pair.target.range_sigma_m or by_model[row],
            math.radians(bearing_sigma_deg or pair.target.bearing_sigma_deg or radar.bearing_sigma_deg),
        )
        for row, pair in enumerate(pairs)
    ]
    return np.array(rows, np.float64)


def _mask(mask: ArrayLike | None, count: int) -> FloatArray:
    if mask is None:
        return np.ones((count, 2), bool)
    given = np.asarray(mask, bool)
    if given.shape not in ((count,), (count, 2)):
        raise InputError(f"mask must have shape ({count},) or ({count}, 2), got {given.shape}")
    return np.repeat(given[:, None], 2, axis=1) if given.ndim == 1 else given


def _network(pairs: Sequence[Pair], sigmas: FloatArray, mask: FloatArray, heading_prior: HeadingHint | None) -> Network:
    """Make the network with all marks at the origin: `Network.with_marks` puts them on a plane."""
    bearing_kind = [TRUE_BEARING if p.target.bearing_reference == "true" else RELATIVE_BEARING for p in pairs]
    values = [(p.target.range_m, math.radians(p.target.bearing_deg)) for p in pairs]
    prior = heading_prior
    return Network.build(
        kind=np.column_stack([np.full(len(pairs), RANGE), bearing_kind]).ravel(),
        mark=np.repeat(np.arange(len(pairs)), 2),
        value=np.array(values).ravel(),
        sigma=sigmas.ravel(),
        mark_ne_m=np.zeros((len(pairs), 2)),
        mark_sigma_m=[p.mark.sigma_m for p in pairs],
        mask=mask.ravel(),
        heading_prior_rad=None if prior is None else (math.radians(prior.heading_deg), math.radians(prior.sigma_deg)),
    )


# -------------------------------------------------------------------------------------------------- the local plane


def _search(
    network: Network,
    pairs: Sequence[Pair],
    association: Association,
    kernel: Kernel,
    damping: Damping,
    start: tuple[Position, float | None] | None,
) -> tuple[LocalPlane, Network, list[Minimum]]:
    """Find the minima on a plane whose north is that of the best one.

    Directions in a plane are true only at its origin. The first origin is a given pose or the middle of the marks;
    where true bearings or a heading prior make north matter, the search moves to where it led until north stays.
    """
    lat, lon = _coordinates(pairs)
    origin = start[0] if start is not None else association.position or centroid(lat, lon)
    given = start or ((association.position, association.heading_deg) if association.position is not None else None)
    north_matters = network.prior_counts or bool(np.any((network.kind == TRUE_BEARING) & network.mask))
    for _ in range(_PLANES):
        plane = LocalPlane(origin)
        network = network.with_marks(plane.all_to_plane(lat, lon))
        minima = _minima(network, plane, kernel, damping, given, only_given=start is not None)
        north_m, east_m = (float(x) for x in minima[0].pose[:2])
        there = plane.to_position(north_m, east_m)
        if not north_matters or abs(plane.convergence_deg(there)) < _TURNED_DEG:
            break
        origin = there
    return plane, network, minima


def _minima(
    network: Network,
    plane: LocalPlane,
    kernel: Kernel,
    damping: Damping,
    given: tuple[Position, float | None] | None,
    *,
    only_given: bool,
) -> list[Minimum]:
    if given is None:
        return find_minima(network, kernel, damping)
    position, heading_deg = given
    pose = with_heading(network, plane.to_plane(position)[None, :])[0]
    if heading_deg is not None and network.heading_unknown:
        pose[2] = math.radians(heading_deg - plane.convergence_deg(position))
    minima = find_minima(network, kernel, damping, given=(("association", pose),))
    if not only_given:
        return minima
    best = follow_given(network, kernel, damping, pose)
    return [best, *(m for m in minima if not solving.same_place(network, m.pose, best.pose))]


def _coordinates(pairs: Sequence[Pair]) -> tuple[list[float], list[float]]:
    return [p.mark.position.lat_deg for p in pairs], [p.mark.position.lon_deg for p in pairs]


class _Placer:
    """Turns a pose on a plane into a position and a true heading [deg]."""

    def __init__(self, plane: LocalPlane) -> None:
        self._plane = plane

    def __call__(self, pose: FloatArray) -> tuple[Position, float | None]:
        position = self._plane.to_position(float(pose[0]), float(pose[1]))
        return position, wrap_360(math.degrees(float(pose[2])) + self._plane.convergence_deg(position))


def _stand_still(
    plane: LocalPlane, network: Network, pairs: Sequence[Pair], kernel: Kernel, damping: Damping, best: Minimum
) -> tuple[LocalPlane, Network, Minimum]:
    """Re-centre the plane on the estimate until it stands still: then ranges and bearings are exact geodesics."""
    lat, lon = _coordinates(pairs)
    for _ in range(_PLANES):
        before = network.mark_ne_m - best.pose[:2]
        plane = LocalPlane(plane.to_position(float(best.pose[0]), float(best.pose[1])))
        network = network.with_marks(plane.all_to_plane(lat, lon))
        turn_rad = cmath.phase(complex(np.sum(_complex(network.mark_ne_m) * np.conj(_complex(before)))))
        start = np.array([0.0, 0.0, best.pose[2] + turn_rad * network.heading_unknown])
        best = replace(follow(network, kernel, damping, start, best.start), start=best.start)
        if math.hypot(best.pose[0], best.pose[1]) < _STANDS_STILL_M:
            break
    return plane, network, best


def _complex(north_east: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    return north_east[:, 0] + 1j * north_east[:, 1]


# ------------------------------------------------------------------------------------------------------- the record


def _fix(
    epoch: Epoch,
    association: Association,
    pairs: Sequence[Pair],
    network: Network,
    plane: LocalPlane,
    kernel: Kernel,
    damping: Damping,
    solution: Solution,
    alternatives: tuple[Alternative, ...],
) -> Fix:
    quality = assess(network, solution.pose, solution.weights, solution.cofactor, damping)
    heading_deg = float(wrap_360(math.degrees(solution.pose[2]))) if network.heading_unknown else None
    return Fix(
        position=plane.to_position(float(solution.pose[0]), float(solution.pose[1])),
        heading_deg=heading_deg,
        covariance=quality.covariance,
        sigma0=quality.sigma0,
        redundancy=network.redundancy,
        observations=adjusted_observations(network, solution, quality, [(p.target.label, p.mark.label) for p in pairs]),
        association=association,
        epoch=epoch,
        cofactor_matrix=quality.cofactor,
        covariance_scaling=quality.scaling,
        dof=quality.dof,
        kernel=kernel.name,
        global_test=quality.global_test,
        integrity=Integrity(r95_m=quality.r95_m),
        alternatives=alternatives,
        start=solution.start,
        notes=notes(network, quality, solution),
    )
