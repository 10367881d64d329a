"""Objects in one place are one mark: lights, daymarks and topmarks go to the buoy or beacon that carries them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from navfix.chart.records import ChartObject
from navfix.geodesy import ecef
from navfix.types import FloatArray

_RANK = {"structure": 0, "land": 1, "equipment": 2, "appendage": 3, "virtual": 4}


def merge(objects: Sequence[ChartObject], within_m: float) -> list[ChartObject]:
    """Return one object for each place: that of the highest rank, with the codes of the others as its equipment.

    A name, MMSI or depth that the carrier lacks is taken from what it carries. Virtual objects stay alone.
    """
    places = _places(objects)
    order = sorted(range(len(objects)), key=lambda i: (_RANK[objects[i].chart_class.role], i))
    carriers: dict[int, list[int]] = {}
    near = _neighbours(places, within_m)
    taken: set[int] = set()
    for i in order:
        if i in taken:
            continue
        virtual = objects[i].chart_class.role == "virtual"
        group = (
            []
            if virtual
            else [j for j in near(places[i]) if j not in taken and j != i and _joins(objects[i], objects[j])]
        )
        taken.update(group, (i,))
        carriers[i] = group
    return [_carrying(objects[i], [objects[j] for j in carriers[i]]) for i in sorted(carriers)]


def same_objects(kept: Sequence[ChartObject], more: Sequence[ChartObject], within_m: float) -> list[ChartObject]:
    """Return those of ``more`` that none of the ``kept`` is already, by MMSI or by place and kind."""
    if not kept:
        return list(more)
    known_mmsi = {item.mmsi for item in kept if item.mmsi is not None}
    near = _neighbours(_places(kept), within_m)
    fresh = []
    for item, place in zip(more, _places(more), strict=True):
        doubled = item.mmsi in known_mmsi or any(kept[j].kind == item.kind for j in near(place))
        if not doubled:
            fresh.append(item)
    return fresh


def _joins(carrier: ChartObject, other: ChartObject) -> bool:
    if other.chart_class.role == "virtual":
        return False
    if carrier.mmsi is not None and other.mmsi is not None and carrier.mmsi != other.mmsi:
        return False
    return other.chart_class.role != "structure" or other.kind == carrier.kind


def _carrying(carrier: ChartObject, carried: list[ChartObject]) -> ChartObject:
    if not carried:
        return carrier

    everything = (carrier, *carried)
    codes = tuple(item.chart_class.code or item.chart_class.words for item in carried)
    return replace(
        carrier,
        name=next((item.name for item in everything if item.name is not None), None),
        mmsi=next((item.mmsi for item in everything if item.mmsi is not None), None),
        depth_m=next((item.depth_m for item in everything if item.depth_m is not None), None),
        equipment=(*carrier.equipment, *codes),
    )


def _places(objects: Sequence[ChartObject]) -> FloatArray:
    return ecef([o.position.lat_deg for o in objects], [o.position.lon_deg for o in objects])


def _neighbours(places: FloatArray, within_m: float) -> Callable[[FloatArray], list[int]]:
    """Return a function that gives the indices of the places within a distance of a place (3,)."""
    from scipy.spatial import cKDTree

    tree = cKDTree(places.reshape(-1, 3))

    def near(place: FloatArray) -> list[int]:
        return sorted(int(i) for i in tree.query_ball_point(place, within_m))

    return near
