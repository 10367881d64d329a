"""Where radar sees each mark of one fix, judged without that mark: eq. (7.11)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.geodesy import LocalPlane
from navfix.integrity.drift import ErrorModel
from navfix.integrity.protection import blocks_of_fix, marks_of
from navfix.integrity.separation import separate
from navfix.types import AdjustedObservation, Fix, FloatArray, Mark, Position, RadarTarget


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """Radar minus AIS of one mark: ``offset_m`` (2,) north, east; what of its covariance stays, and what averages."""

    mark: Mark
    target: str
    offset_m: FloatArray
    steady_m2: FloatArray
    fresh_m2: FloatArray


def sightings(fix: Fix, model: ErrorModel) -> tuple[Sighting, ...]:
    """Return a sighting of every pair with range and bearing.

    The place that radar gives to a mark is own position + range + bearing; own position and heading are those without
    this mark (`separate`), so that a wrong mark cannot pull the judge to its side. Stays: the mark's own sigma, own
    position and heading, and ``steady_share`` of radar's variance. Averages: the rest of radar's variance.

    Raises
    ------
    InputError : the fix does not carry its marks on earth
    """
    blocks, marks = blocks_of_fix(fix), marks_of(fix)
    separation = separate(blocks)
    scale = max(1.0, fix.sigma0) ** 2 if fix.covariance_scaling == "a_posteriori" else 1.0
    pairs = _by_mark(fix.observations)
    place = dict(zip(blocks.labels, offsets(fix, [marks[label] for label in blocks.labels]), strict=True))
    found = []
    for k, label in enumerate(blocks.labels):
        seen = pairs[label]
        if not separation.determined[k] or "range" not in seen or len(seen) != 2:
            continue
        bearing = next(o for kind, o in seen.items() if kind != "range")
        north_m, east_m = place[label]
        distance_m, azimuth_rad = math.hypot(north_m, east_m), math.atan2(east_m, north_m)
        along = np.array([math.cos(azimuth_rad), math.sin(azimuth_rad)])
        across = np.array([-along[1], along[0]])
        seen_m = distance_m - seen["range"].residual
        seen_rad = azimuth_rad - math.radians(bearing.residual)
        moved = np.zeros((2, separation.shift.shape[1]))
        moved[:, :2] = np.eye(2)
        turn = 2 if bearing.kind == "relative_bearing" else moved.shape[1] - 1
        if turn >= 2:
            moved[:, turn] = distance_m * across
        offset = seen_m * np.array([math.cos(seen_rad), math.sin(seen_rad)]) - [north_m, east_m]
        own = moved @ separation.without[k] @ moved.T
        sigma_along, sigma_across = seen["range"].sigma, math.radians(bearing.sigma) * distance_m
        both = sigma_along**2 * np.outer(along, along) + sigma_across**2 * np.outer(across, across)
        radar = both - marks[label].sigma_m ** 2 * np.eye(2)
        found.append(
            Sighting(
                mark=marks[label],
                target=bearing.target,
                offset_m=offset + moved @ separation.shift[k],
                steady_m2=scale * (both - (1.0 - model.steady_share) * radar + own),
                fresh_m2=scale * (1.0 - model.steady_share) * radar,
            )
        )
    return tuple(found)


def offsets(fix: Fix, marks: list[Mark]) -> FloatArray:
    """Return north, east [m] of marks from own ship, (n, 2)."""
    assert isinstance(fix.position, Position)
    if not marks:
        return np.zeros((0, 2))
    plane = LocalPlane(fix.position)
    return plane.all_to_plane([m.position.lat_deg for m in marks], [m.position.lon_deg for m in marks])


def echoes(fix: Fix, targets: list[RadarTarget]) -> FloatArray:
    """Return north, east [m] of targets from own ship, (n, 2), turned as the pairs of the fix were."""
    range_m = np.array([t.range_m for t in targets])
    bearing_rad = np.radians([t.bearing_deg + turn_deg(fix, t) for t in targets])
    return np.stack([range_m * np.cos(bearing_rad), range_m * np.sin(bearing_rad)], axis=-1)


def turn_deg(fix: Fix, target: RadarTarget) -> float:
    """Return what makes a true azimuth of a target's bearing: heading, or error of the compass."""
    if target.bearing_reference == "true":
        return fix.compass_error_deg or 0.0
    return fix.heading_deg or 0.0


def _by_mark(observations: tuple[AdjustedObservation, ...]) -> dict[str, dict[str, AdjustedObservation]]:
    pairs: dict[str, dict[str, AdjustedObservation]] = {}
    for o in observations:
        pairs.setdefault(o.mark, {})[o.kind] = o
    return pairs
