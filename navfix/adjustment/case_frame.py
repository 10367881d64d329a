"""A case seen from a place: its observations as a plane network about it, in either frame."""

from __future__ import annotations

import math

import numpy as np

from navfix.adjustment.case import Case
from navfix.adjustment.network import KIND_CODES, Network
from navfix.geodesy import LocalPlane, centroid
from navfix.types import FloatArray, PlanePosition, Position
from navfix.units import wrap_360

Place = Position | PlanePosition


def network_about(case: Case, place: Place) -> Network:
    """Return the case as a network whose origin is ``place``: ranges and bearings from there are exact."""
    index = {mark.label: number for number, mark in enumerate(case.marks)}
    targets = {label: number for number, label in enumerate(dict.fromkeys(o.target for o in case.observations))}
    unit = np.array([1.0 if o.kind == "range" else math.radians(1.0) for o in case.observations])
    return Network.build(
        kind=[KIND_CODES[o.kind] for o in case.observations],
        mark=[index[o.mark] for o in case.observations],
        value=unit * [o.value for o in case.observations],
        sigma=unit * [o.sigma for o in case.observations],
        mark_ne_m=[offset_ne_m(place, mark.position) for mark in case.marks],
        mark_sigma_m=np.array([mark.sigma_m for mark in case.marks]),
        target=[targets[o.target] for o in case.observations],
        mask=[o.use for o in case.observations],
    )


def offset_ne_m(origin: Place, place: Place) -> FloatArray:
    """Return north and east [m] of ``place`` from ``origin``, both in the same frame."""
    if isinstance(origin, PlanePosition) and isinstance(place, PlanePosition):
        return np.array([place.north_m - origin.north_m, place.east_m - origin.east_m])
    if isinstance(origin, Position) and isinstance(place, Position):
        return LocalPlane(origin).to_plane(place)
    raise TypeError("a plane position and a position on the ellipsoid cannot be compared")


def moved(place: Place, north_m: float, east_m: float) -> Place:
    """Return the place that lies north and east [m] of another."""
    if isinstance(place, PlanePosition):
        return PlanePosition(place.north_m + north_m, place.east_m + east_m)
    return LocalPlane(place).to_position(north_m, east_m)


def true_heading_deg(origin: Place, place: Place, heading_deg: float) -> float:
    """Return the heading at ``place`` of a direction in the plane about ``origin``: meridians converge."""
    if isinstance(origin, Position) and isinstance(place, Position):
        heading_deg += LocalPlane(origin).convergence_deg(place)
    return wrap_360(heading_deg)


def middle_of_marks(case: Case) -> Place:
    """Return the mean place of all marks."""
    places = [mark.position for mark in case.marks]
    plane = [place for place in places if isinstance(place, PlanePosition)]
    if plane:
        return PlanePosition(
            sum(place.north_m for place in plane) / len(plane), sum(place.east_m for place in plane) / len(plane)
        )
    on_earth = [place for place in places if isinstance(place, Position)]
    return centroid([place.lat_deg for place in on_earth], [place.lon_deg for place in on_earth])
