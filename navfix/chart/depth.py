"""Charted depth at a place: the depth area or dredged area that it lies in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.chart.shapes import wkb_parts
from navfix.types import FloatArray, Position


@dataclass(frozen=True, slots=True, eq=False)
class DepthArea:
    """One area with its rings (n, 2) of longitude and latitude, the deepest depth that it holds [m], and its box."""

    rings: tuple[FloatArray, ...]
    deepest_m: float
    box: tuple[float, float, float, float]


def depth_areas(geometries: NDArray[np.object_], shallow_m: FloatArray, deep_m: FloatArray) -> list[DepthArea]:
    """Return the areas of WKB geometries; the deep limit counts, or the shallow one where that alone is charted."""
    areas = []
    for wkb, least, most in zip(geometries, shallow_m, deep_m, strict=True):
        deepest = most if np.isfinite(most) else least
        if wkb is None or not np.isfinite(deepest) or deepest <= 0.0:
            continue
        for rings in wkb_parts(wkb):
            low, high = rings[0].min(axis=0), rings[0].max(axis=0)
            areas.append(DepthArea(tuple(rings), float(deepest), (low[0], low[1], high[0], high[1])))
    return areas


def depth_at(areas: list[DepthArea], position: Position) -> float | None:
    """Return the charted depth [m] at a place, None outside of every area."""
    lon, lat = position.lon_deg, position.lat_deg
    for area in areas:
        west, south, east, north = area.box
        if west <= lon <= east and south <= lat <= north and _inside(area.rings, lon, lat):
            return area.deepest_m
    return None


def _inside(rings: tuple[FloatArray, ...], lon: float, lat: float) -> bool:
    """Tell whether a point lies inside: a ray to the east crosses outline and holes an odd number of times."""
    crossings = 0
    for ring in rings:
        x, y = ring[:, 0], ring[:, 1]
        x_next, y_next = np.roll(x, -1), np.roll(y, -1)
        straddles = (y > lat) != (y_next > lat)
        rise = np.where(straddles, y_next - y, 1.0)
        crossings += int(np.sum(straddles & (lon < x + (lat - y) * (x_next - x) / rise)))
    return crossings % 2 == 1
