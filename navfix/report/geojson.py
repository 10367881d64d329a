"""The fix as GeoJSON (RFC 7946): own ship, heading line, ellipses, marks, targets, residual sticks.

Lines and areas that cross 180 E are cut there (section 3.1.9); the outer rings run counter-clockwise (3.1.6).
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

from navfix.errors import InputError
from navfix.geodesy import direct
from navfix.report.answer import Answer
from navfix.report.fix_json import no_fix_to_dict
from navfix.report.json_parts import ELLIPSE_PROBABILITIES, ellipse_to_dict
from navfix.report.numbers import degrees, iso_utc, plain
from navfix.report.scene import Scene, polar, scene_of
from navfix.types import Alternative, Ellipse, Fix, Position
from navfix.units import NM_M

Point = tuple[float, float]  # longitude, latitude [deg]
Feature = dict[str, Any]
_CORNERS = 72


def geojson_text(answer: Answer) -> str:
    """Return the FeatureCollection as text, ending in a line feed.

    Raises
    ------
    InputError : the fix lies in a plane frame, not on the globe
    """
    return json.dumps(answer_to_geojson(answer), ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def answer_to_geojson(answer: Answer) -> dict[str, Any]:
    """Return the FeatureCollection of an answer; for no fix the marks and the places that were found, if any."""
    features = list(_no_fix_features(answer) if answer.fix is None else _fix_features(answer, answer.fix))
    return {"type": "FeatureCollection", "features": features}


# ------------------------------------------------------------------------------------------------------- features


def _fix_features(answer: Answer, fix: Fix) -> Iterator[Feature]:
    if not isinstance(fix.position, Position):
        raise InputError("GeoJSON needs a place on the globe, the fix lies in a plane frame: write .json or .svg")
    scene = scene_of(answer)
    yield _own_ship(answer, fix, fix.position)
    if fix.heading_deg is not None:
        reach_m = max((target.range_m for target in scene.targets), default=NM_M)
        ahead = _place(fix.position, *polar(reach_m, fix.heading_deg))
        line = _line([_point(fix.position), _point(ahead)])
        yield _feature(
            line, what="heading line", heading_deg=plain(fix.heading_deg), heading_reference=fix.heading_reference
        )
    for probability in ELLIPSE_PROBABILITIES:
        ellipse = fix.ellipse(probability)
        ring = [_point(corner) for corner in ellipse_ring(fix.position, ellipse)]
        yield _feature(_area(ring), what="confidence ellipse", **ellipse_to_dict(ellipse))
    yield from _mark_features(fix.position, scene)
    yield from _target_features(fix.position, scene)
    yield from _residual_features(fix.position, scene)
    for place in scene.places:
        apart_m = math.hypot(place.north_m, place.east_m)
        where = _at(_place(fix.position, place.north_m, place.east_m))
        yield _feature(where, what=place.kind, caption=place.caption, distance_m=plain(apart_m))


def _own_ship(answer: Answer, fix: Fix, position: Position) -> Feature:
    return _feature(
        _at(position),
        what="own ship",
        status="fix",
        time_utc=iso_utc(answer.time_utc),
        heading_deg=plain(fix.heading_deg),
        heading_reference=fix.heading_reference,
        sigma0=plain(fix.sigma0),
        r95_m=None if fix.integrity is None else plain(fix.integrity.r95_m),
        gnss_verdict=None if answer.gnss is None else answer.gnss.verdict,
    )


def _mark_features(origin: Position, scene: Scene) -> Iterator[Feature]:
    for shown in scene.marks:
        mark = shown.mark
        yield _feature(
            _at(_place(origin, shown.north_m, shown.east_m) if mark is None else mark.position),
            what="mark",
            label=shown.label,
            name=shown.name,
            kind=shown.kind,
            mmsi=None if mark is None else mark.mmsi,
            status=shown.status,
            outlier=shown.status == "outlier",
        )


def _target_features(origin: Position, scene: Scene) -> Iterator[Feature]:
    for target in scene.targets:
        yield _feature(
            _at(_place(origin, target.north_m, target.east_m)),
            what="target",
            label=target.label,
            range_m=plain(target.range_m),
            true_bearing_deg=plain(target.bearing_deg),
            status=target.status,
            outlier=target.status == "outlier",
        )


def _residual_features(origin: Position, scene: Scene) -> Iterator[Feature]:
    for stick in scene.sticks:
        start = _place(origin, stick.north_m, stick.east_m)
        end = _place(origin, stick.north_m + stick.to_north_m, stick.east_m + stick.to_east_m)
        yield _feature(
            _line([_point(start), _point(end)]),
            what="residual",
            target=stick.row.target,
            mark=stick.row.mark_label,
            length_m=plain(stick.length_m),
            outlier=stick.row.outlier,
        )


def _no_fix_features(answer: Answer) -> Iterator[Feature]:
    content = no_fix_to_dict(answer.error)
    why = {"reason": content["reason"], "message": content["message"]}
    yield _feature(None, what="own ship", status="no_fix", time_utc=iso_utc(answer.time_utc), **why)
    for mark in answer.epoch.marks if answer.epoch is not None else ():
        name = mark.name or mark.label
        yield _feature(_at(mark.position), what="mark", label=mark.label, name=name, kind=mark.kind, mmsi=mark.mmsi)
    others: Sequence[Alternative] = getattr(answer.error, "alternatives", ())
    for number, other in enumerate(others, 1):
        if isinstance(other.position, Position):
            found = {"score": plain(other.score), "heading_deg": plain(other.heading_deg)}
            yield _feature(_at(other.position), what="alternative", caption=f"place {number}", **found)


# ------------------------------------------------------------------------------------------------------- geometry


def _feature(geometry: dict[str, Any] | None, **properties: Any) -> Feature:
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def _place(origin: Position, north_m: float, east_m: float) -> Position:
    return direct(origin, math.degrees(math.atan2(east_m, north_m)), math.hypot(north_m, east_m))


def ellipse_ring(centre: Position, ellipse: Ellipse) -> list[Position]:
    """Return the closed geodesic ring of an ellipse, counter-clockwise, 73 places."""
    ring = []
    for corner in range(_CORNERS):
        angle_rad = -2.0 * math.pi * corner / _CORNERS
        along_m, across_m = ellipse.semi_major_m * math.cos(angle_rad), ellipse.semi_minor_m * math.sin(angle_rad)
        azimuth_deg = ellipse.azimuth_deg + math.degrees(math.atan2(across_m, along_m))
        ring.append(direct(centre, azimuth_deg, math.hypot(along_m, across_m)))
    return [*ring, ring[0]]


def _point(position: Position) -> Point:
    return position.lon_deg, position.lat_deg


def _at(position: Position) -> dict[str, Any]:
    return {"type": "Point", "coordinates": _rounded(_point(position))}


def _rounded(point: Point) -> list[float]:
    return [degrees(point[0]), degrees(point[1])]


def unwrapped(points: Sequence[Point]) -> list[Point]:
    """Return the points with continuous longitudes: no step of more than 180 deg from one to the next."""
    shifted = [points[0]]
    for longitude, latitude in points[1:]:
        step = (longitude - shifted[-1][0] + 180.0) % 360.0 - 180.0
        shifted.append((shifted[-1][0] + step, latitude))
    return shifted


def _line(points: Sequence[Point]) -> dict[str, Any]:
    """Return a LineString, or a MultiLineString cut at 180 E."""
    parts: list[list[Point]] = [[]]
    continuous = unwrapped(points)
    for start, end in pairwise(continuous):
        parts[-1].append(start)
        edge = _edge_between(start[0], end[0])
        if edge is not None:
            crossing = _at_longitude(start, end, edge)
            parts[-1].append(crossing)
            parts.append([crossing])
    parts[-1].append(continuous[-1])
    lines = [[_rounded(point) for point in _into_range(part)] for part in parts]
    if len(lines) == 1:
        return {"type": "LineString", "coordinates": lines[0]}
    return {"type": "MultiLineString", "coordinates": lines}


def _edge_between(start_deg: float, end_deg: float) -> float | None:
    """Return the odd multiple of 180 deg that lies strictly between two continuous longitudes."""
    low, high = min(start_deg, end_deg), max(start_deg, end_deg)
    edge = 180.0 + 360.0 * math.floor((high - 180.0) / 360.0)
    return edge if low < edge < high else None


def _at_longitude(start: Point, end: Point, longitude: float) -> Point:
    share = (longitude - start[0]) / (end[0] - start[0])
    return longitude, start[1] + share * (end[1] - start[1])


def _area(ring: Sequence[Point]) -> dict[str, Any]:
    """Return a Polygon, or a MultiPolygon cut at 180 E, of a closed counter-clockwise ring."""
    continuous = unwrapped(ring)
    turn_deg = continuous[-1][0] - continuous[0][0]
    if abs(turn_deg) > 180.0:  # the ring goes around a pole: close it along the pole's line
        pole = math.copysign(90.0, continuous[0][1])
        continuous += [(continuous[-1][0], pole), (continuous[0][0], pole), continuous[0]]
    low = math.floor((min(lon for lon, _ in continuous) + 180.0) / 360.0)
    high = math.floor((max(lon for lon, _ in continuous) + 180.0) / 360.0)
    parts = []
    for turn in range(low, high + 1):
        part = _clipped(continuous[:-1], 360.0 * turn - 180.0, 360.0 * turn + 180.0)
        if len(part) >= 3:
            parts.append([_rounded(point) for point in _into_range([*part, part[0]])])
    if len(parts) == 1:
        return {"type": "Polygon", "coordinates": parts}
    return {"type": "MultiPolygon", "coordinates": [[part] for part in parts]}


def _clipped(ring: Sequence[Point], west_deg: float, east_deg: float) -> list[Point]:
    """Clip an open ring between two meridians (Sutherland and Hodgman)."""
    for edge, sign in ((west_deg, 1.0), (east_deg, -1.0)):
        kept: list[Point] = []
        for previous, current in zip([ring[-1], *ring[:-1]], ring, strict=True):
            was_in, is_in = sign * (previous[0] - edge) >= 0.0, sign * (current[0] - edge) >= 0.0
            if was_in != is_in:
                kept.append(_at_longitude(previous, current, edge))
            if is_in:
                kept.append(current)
        ring = kept
        if not ring:
            return []
    return list(ring)


def _into_range(part: Sequence[Point]) -> list[Point]:
    """Shift a part that lies within one turn of longitudes into -180 .. 180."""
    middle = (min(lon for lon, _ in part) + max(lon for lon, _ in part)) / 2.0
    shift = 360.0 * math.floor((middle + 180.0) / 360.0)
    return [(min(180.0, max(-180.0, lon - shift)), lat) for lon, lat in part]
