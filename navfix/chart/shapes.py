"""Points, lines and areas -> one place and how far the shape reaches from it; GeoJSON geometry and WKB."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np

from navfix.chart.records import BadRow
from navfix.errors import InputError
from navfix.geodesy import centroid, cloud_to_plane
from navfix.types import FloatArray, Position

_POINTS = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}


def place_and_extent(lon_lat: FloatArray) -> tuple[Position, float]:
    """Return the middle of points (n, 2) and the distance [m] of the farthest from it.

    Raises
    ------
    BadRow : no points, or points out of range
    """
    if len(lon_lat) == 0 or not np.all(np.isfinite(lon_lat)):
        raise BadRow("no position")
    try:
        if len(lon_lat) == 1:
            return Position(float(lon_lat[0, 1]), float(lon_lat[0, 0])), 0.0
        middle = centroid(lon_lat[:, 1], lon_lat[:, 0])
    except InputError as error:
        raise BadRow("position out of range", str(error)) from error
    offsets = cloud_to_plane(middle, lon_lat[:, 1], lon_lat[:, 0])
    return middle, float(np.hypot(offsets[:, 0], offsets[:, 1]).max())


def geojson_points(geometry: Any) -> FloatArray:
    """Return all points (n, 2) of a GeoJSON geometry, longitude first.

    Raises
    ------
    BadRow : no geometry, or one that is malformed
    """
    if not isinstance(geometry, dict) or geometry.get("type") not in _POINTS:
        raise BadRow("no geometry", str(geometry)[:60])
    nested = geometry.get("coordinates")
    points: Any = [nested]
    try:
        for _ in range(_POINTS[geometry["type"]]):
            points = list(chain.from_iterable(points))
        return np.array([[float(p[0]), float(p[1])] for p in points], dtype=np.float64).reshape(-1, 2)
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise BadRow("no position", str(geometry)[:60]) from error


def wkb_points(wkb: bytes | None) -> FloatArray:
    """Return all points (n, 2) of a well-known-binary geometry, longitude first; holes of areas are left out.

    Raises
    ------
    BadRow : no geometry, or one of a type that has no place here
    """
    if not wkb:
        raise BadRow("no geometry")
    rings = [ring for polygon in wkb_parts(wkb) for ring in polygon[:1]]
    return np.concatenate(rings) if rings else np.empty((0, 2))


def wkb_parts(wkb: bytes) -> list[list[FloatArray]]:
    """Return the parts of a geometry: for each point, line or area its rings (n, 2), the outer one first."""
    return list(_Wkb(wkb).parts())


class _Wkb:
    """A cursor over well-known binary (OGC 06-103r4, 8.2), 2-D and 3-D, both byte orders."""

    def __init__(self, wkb: bytes) -> None:
        self._wkb, self._at = wkb, 0

    def parts(self) -> Iterator[list[FloatArray]]:
        order = "<" if self._take("B", "<") == 1 else ">"
        code = self._take("I", order)
        plain = code & 0x0FFFFFFF
        kind, dimensions = plain % 1000, 3 if code & 0x80000000 or 1000 <= plain < 2000 else 2
        if kind == 1:
            yield [self._points(1, dimensions, order)]
        elif kind == 2:
            yield [self._points(self._take("I", order), dimensions, order)]
        elif kind == 3:
            yield [self._points(self._take("I", order), dimensions, order) for _ in range(self._take("I", order))]
        elif kind in (4, 5, 6, 7):
            for _ in range(self._take("I", order)):
                yield from self.parts()
        else:
            raise BadRow("no geometry", f"WKB type {code}")

    def _take(self, code: str, order: str) -> int:
        try:
            value: int = struct.unpack_from(order + code, self._wkb, self._at)[0]
        except struct.error as error:
            raise BadRow("no geometry", "cut off") from error
        self._at += struct.calcsize(code)
        return value

    def _points(self, count: int, dimensions: int, order: str) -> FloatArray:
        size = 8 * dimensions * count
        if self._at + size > len(self._wkb):
            raise BadRow("no geometry", "cut off")
        flat = np.frombuffer(self._wkb, dtype=f"{order}f8", count=dimensions * count, offset=self._at)
        self._at += size
        return flat.reshape(-1, dimensions)[:, :2].astype(np.float64)
