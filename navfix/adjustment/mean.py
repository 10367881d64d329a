"""The plain-mean fix: own ship seen back from every mark, and the mean of these places. Our baseline."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from navfix.errors import InputError, TooFewPairs, Unobservable
from navfix.geodesy import LocalPlane, centroid, cloud_to_plane, direct, observer_of
from navfix.types import Association, Ellipse, Epoch, FloatArray, Mark, MeanFix, Position, RadarTarget
from navfix.units import wrap_360

FEWEST_FOR_REJECTION = 5
REJECTION_DISTANCE = 3.0  # Mahalanobis; holds 98.9 % in two dimensions (99.865 % is the figure of one dimension)
_STANDS_STILL_M = 1e-3
_KINDS = ("ship", "aton", "charted")

Pairs = Sequence[tuple[RadarTarget, Mark]]
Weights = Mapping[str, float] | ArrayLike | None


def mean_fix(
    epoch: Epoch,
    association: Association,
    *,
    weights: Weights = None,
    reject: bool = False,
    rejection_distance: float = REJECTION_DISTANCE,
    heading_deg: float | None = None,
    literal: bool = False,
) -> MeanFix:
    """Return the (weighted) mean of the places from which each mark is seen as its target.

    Parameters
    ----------
    association : pairs (k, 2), k >= 1
    weights : None for all alike; a mapping of mark kinds ("ship", "aton", "charted"; 1 for a kind not named); or one
        weight for each pair, shape (k,)
    reject : leave out places farther than ``rejection_distance`` (Mahalanobis) from the others, see `outlying`
    heading_deg : turns relative bearings into true ones; without it the association's heading, else the epoch's
        heading hint, else the heading that fits all pairs best (`heading_of_pairs`). True bearings need none.
    literal : go back from each mark along bearing + 180 in one step, as the thesis describes it. Meridians converge,
        so this misses own ship by 134 m at 60 N for a mark 12 NM due east.

    Returns
    -------
    MeanFix - its covariance (2, 2) [m2] is the spread of the single places, not that of their mean

    Raises
    ------
    InputError : weights that are negative, not finite, all zero, of another shape, or of an unknown kind
    TooFewPairs : no pairs; one pair with a relative bearing and no heading
    Unobservable : all targets or all marks in one point, and no heading

    References
    ----------
    [1] Knopp, thesis, 4.3.1 (back-calculation, mean) and 4.3.2 (leave-one-out rejection). Two things are mended: true
    bearing = relative bearing + heading (a minus is printed there), and places are compared in metres, not degrees.
    """
    pairs = [(epoch.targets[target], epoch.marks[mark]) for target, mark in association.pairs.tolist()]
    if not pairs:
        raise TooFewPairs("a mean needs at least one pair of target and mark, got none", observations=0, unknowns=2)
    weight = _weights(pairs, weights)
    heading = _heading(epoch, association, pairs, weight, heading_deg)
    places = [_place_of_own_ship(target, mark, heading, literal=literal) for target, mark in pairs]

    used = weight > 0.0
    if reject:
        candidates = np.flatnonzero(used)
        far = outlying(_about_centroid([places[index] for index in candidates]), distance=rejection_distance)
        used[candidates[far]] = False
    position, individual_ne_m = _mean_on_the_ellipsoid(places, weight * used)
    return MeanFix(
        position=position,
        heading_deg=heading,
        individual_ne_m=individual_ne_m,
        used=used,
        covariance=_spread(individual_ne_m[used], weight[used]),
        weights=weight,
    )


def outlying(places_ne_m: FloatArray, *, distance: float = REJECTION_DISTANCE) -> NDArray[np.bool_]:
    """Tell which places lie farther than ``distance`` (Mahalanobis) from the mean of all others.

    Mean and covariance are taken without the place that is judged (leave one out), all places are judged once.
    Nothing is rejected among fewer than five places, nor where the others lie on one line (their covariance has no
    inverse).

    Parameters
    ----------
    places_ne_m : (k, 2)

    Returns
    -------
    array (k,) of bool

    References
    ----------
    [1] Knopp, thesis, 4.3.2.
    """
    k = len(places_ne_m)
    if k < FEWEST_FOR_REJECTION:
        return np.zeros(k, dtype=np.bool_)
    others = [np.delete(places_ne_m, index, axis=0) for index in range(k)]
    return np.array([_mahalanobis(place, rest) > distance for place, rest in zip(places_ne_m, others, strict=True)])


def factor_ellipses(fix: MeanFix, factors: Sequence[float] = (1.0, 2.0, 3.0, 4.0)) -> tuple[Ellipse, ...]:
    """Return the ellipses of the spread at Mahalanobis distances ``factors``, each with the probability that it holds.

    In two dimensions the factors 1, 2, 3, 4 hold 39.3, 86.5, 98.9 and 99.97 %; 2.33 holds 93.4 % (99 % needs 3.035).

    Raises
    ------
    InputError : a factor outside 0 .. 8; TooFewPairs : fewer than three places have no spread
    """
    if fix.covariance is None:
        used = int(np.count_nonzero(fix.used))
        raise TooFewPairs(f"a spread needs at least 3 places, got {used}", observations=used, unknowns=3)
    return tuple(Ellipse.from_covariance(fix.covariance, probability_of_factor(factor)) for factor in factors)


def probability_of_factor(factor: float) -> float:
    """Return the probability that an ellipse at this Mahalanobis distance holds: 1 - exp(-factor^2 / 2).

    Raises
    ------
    InputError : a factor outside 0 .. 8
    """
    if not 0.0 < factor <= 8.0:
        raise InputError(f"an ellipse's factor must be within 0 .. 8, got {factor!r}")
    return -math.expm1(-0.5 * factor * factor)


def heading_of_pairs(pairs: Pairs, weight: FloatArray | None = None) -> float:
    """Return the heading [deg] that turns the targets onto their marks with the least squared distances.

    Closed form in the plane (targets and marks as complex numbers, rotation = phase of their cross covariance);
    targets with a true bearing are not turned and only help to find the place. The plane is re-centred on own ship
    until it stands still, so that exact data give the exact heading at any latitude.

    Raises
    ------
    TooFewPairs : fewer than two pairs; Unobservable : all targets or all marks in one point
    """
    if len(pairs) < 2:
        raise TooFewPairs("a heading from the pairs needs at least 2 of them, got 1", observations=2, unknowns=3)
    share = np.ones(len(pairs)) if weight is None else weight
    targets = np.array([cmath.rect(target.range_m, math.radians(target.bearing_deg)) for target, _ in pairs])
    turns = np.array([target.bearing_reference == "relative" for target, _ in pairs])
    origin = centroid([m.position.lat_deg for _, m in pairs], [m.position.lon_deg for _, m in pairs])
    for _ in range(20):
        plane = LocalPlane(origin)
        marks = np.array([complex(*plane.to_plane(mark.position)) for _, mark in pairs])
        heading_rad, own = _turn_and_place(targets, turns, marks, share)
        if abs(own) < _STANDS_STILL_M:
            break
        origin = plane.to_position(own.real, own.imag)
    return wrap_360(math.degrees(heading_rad))


# -------------------------------------------------------------------------------------------------------- the steps


def _weights(pairs: Pairs, weights: Weights) -> FloatArray:
    """Return one weight for each pair, shape (k,)."""
    if isinstance(weights, Mapping):
        unknown = sorted(set(weights) - set(_KINDS))
        if unknown:
            raise InputError(f"weights: unknown kind {unknown[0]!r}; kinds of marks are {', '.join(_KINDS)}")
        weights = [weights.get(mark.kind, 1.0) for _, mark in pairs]
    weight = np.ones(len(pairs)) if weights is None else np.array(weights, dtype=np.float64)
    if weight.shape != (len(pairs),):
        raise InputError(f"weights: one for each of the {len(pairs)} pairs is needed, got shape {weight.shape}")
    if not (np.all(np.isfinite(weight)) and np.all(weight >= 0.0) and np.any(weight > 0.0)):
        raise InputError(f"weights: must be finite, >= 0 and not all zero, got {weight.tolist()}")
    return weight


def _heading(
    epoch: Epoch, association: Association, pairs: Pairs, weight: FloatArray, heading_deg: float | None
) -> float | None:
    """Return the heading to use; None where all bearings are true and nothing tells a heading."""
    hint = epoch.heading_hint
    for known in (heading_deg, association.heading_deg, None if hint is None else hint.heading_deg):
        if known is not None:
            return wrap_360(float(known))
    if all(target.bearing_reference == "true" for target, _ in pairs):
        return None
    return heading_of_pairs(pairs, weight)


def _turn_and_place(
    targets: NDArray[np.complex128], turns: NDArray[np.bool_], marks: NDArray[np.complex128], share: FloatArray
) -> tuple[float, complex]:
    """Solve mark = own + e^(i heading) target in least squares; where ``turns`` is false the target is not turned."""
    turned, rest = np.where(turns, targets, 0.0), marks - np.where(turns, 0.0, targets)
    mean_turned, mean_rest = np.average(turned, weights=share), np.average(rest, weights=share)
    spread_turned, spread_rest = turned - mean_turned, rest - mean_rest
    cross = np.sum(share * np.conj(spread_turned) * spread_rest)
    if not abs(cross) > 1e-12 * max(np.sum(share * np.abs(turned) ** 2), 1.0):
        raise Unobservable("all targets or all marks lie in one point: no heading follows", direction="heading")
    heading_rad = cmath.phase(cross)
    return heading_rad, complex(mean_rest - cmath.exp(1j * heading_rad) * mean_turned)


def _place_of_own_ship(target: RadarTarget, mark: Mark, heading_deg: float | None, *, literal: bool) -> Position:
    """Return the place from which ``mark`` is seen as ``target``."""
    turn_deg = heading_deg if target.bearing_reference == "relative" and heading_deg is not None else 0.0
    bearing_deg = wrap_360(target.bearing_deg + turn_deg)
    if literal:
        return direct(mark.position, bearing_deg + 180.0, target.range_m)
    return observer_of(mark.position, bearing_deg, target.range_m)


def _about_centroid(places: Sequence[Position]) -> FloatArray:
    lat_deg, lon_deg = [place.lat_deg for place in places], [place.lon_deg for place in places]
    return cloud_to_plane(centroid(lat_deg, lon_deg), lat_deg, lon_deg)


def _mean_on_the_ellipsoid(places: Sequence[Position], weight: FloatArray) -> tuple[Position, FloatArray]:
    """Return the place from which the weighted geodesic offsets cancel out, and the offsets (k, 2) from there."""
    mean = centroid([place.lat_deg for place in places], [place.lon_deg for place in places], weight)
    for _ in range(20):
        plane = LocalPlane(mean)
        offsets_ne_m = np.array([plane.to_plane(place) for place in places])
        north_m, east_m = np.average(offsets_ne_m, axis=0, weights=weight)
        if math.hypot(north_m, east_m) < 1e-6:
            break
        mean = plane.to_position(north_m, east_m)
    return mean, offsets_ne_m


def _mahalanobis(place_ne_m: FloatArray, others_ne_m: FloatArray) -> float:
    """Return the distance of a place from the mean of others in their own covariance; 0 where that is singular."""
    covariance = np.cov(others_ne_m, rowvar=False)
    if not np.linalg.det(covariance) > 1e-12 * np.trace(covariance) ** 2:
        return 0.0
    offset = place_ne_m - others_ne_m.mean(axis=0)
    return math.sqrt(float(offset @ np.linalg.solve(covariance, offset)))


def _spread(places_ne_m: FloatArray, weight: FloatArray) -> FloatArray | None:
    """Return the (weighted, unbiased) covariance (2, 2) of the places, None with fewer than three."""
    return None if len(places_ne_m) < 3 else np.cov(places_ne_m, rowvar=False, aweights=weight)
