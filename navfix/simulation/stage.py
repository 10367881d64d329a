"""The plane that the simulated world lives in, and the way between it and the ellipsoid, vectorised.

Things move in the tangent plane of the scenario's place and are dropped onto the ellipsoid. That stretches speeds by
2e-5 at 40 km, which nobody observes; what is observed - ranges, bearings, courses, headings - is computed on the
ellipsoid, so it is right at any latitude and across 180 E.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from navfix.geodesy import WGS84_A_M, WGS84_B_M, ecef
from navfix.types import FloatArray, Position
from navfix.units import wrap_360

_E2 = 1.0 - (WGS84_B_M / WGS84_A_M) ** 2
_EP2 = (WGS84_A_M / WGS84_B_M) ** 2 - 1.0


class Stage:
    """Tangent plane about ``origin``, axes (north, east) in metres."""

    def __init__(self, origin: Position) -> None:
        self.origin = origin
        self._centre = ecef(origin.lat_deg, origin.lon_deg)
        self._north, self._east = _axes(np.array(origin.lat_deg), np.array(origin.lon_deg))

    def places(self, north_m: ArrayLike, east_m: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return latitudes and longitudes [deg] of plane points, in the shape of the input."""
        north, east = np.asarray(north_m, dtype=np.float64), np.asarray(east_m, dtype=np.float64)
        xyz = self._centre + north[..., None] * self._north + east[..., None] * self._east
        return _geodetic(xyz)

    def convergence_rad(self, north_m: ArrayLike, east_m: ArrayLike) -> FloatArray:
        """Return what a plane direction needs to become a true direction at plane points [rad]."""
        lat, lon = self.places(north_m, east_m)
        north_axis, east_axis = _axes(lat, lon)
        return np.arctan2(east_axis @ self._north, north_axis @ self._north)


def range_and_bearing(
    from_lat_deg: ArrayLike, from_lon_deg: ArrayLike, to_lat_deg: ArrayLike, to_lon_deg: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return geodesic range [m] and true bearing [deg] at the first place, element by element.

    Chord and normal section: against the geodesic within 1e-6 of the range and 1e-5 deg below 100 km.
    """
    offset = ecef(to_lat_deg, to_lon_deg) - ecef(from_lat_deg, from_lon_deg)
    north_axis, east_axis = _axes(np.asarray(from_lat_deg, float), np.asarray(from_lon_deg, float))
    north, east = np.sum(offset * north_axis, axis=-1), np.sum(offset * east_axis, axis=-1)
    half_chord = np.minimum(np.linalg.norm(offset, axis=-1) / (2.0 * WGS84_A_M), 1.0)
    return 2.0 * WGS84_A_M * np.arcsin(half_chord), wrap_360(np.degrees(np.arctan2(east, north)))


def _axes(lat_deg: FloatArray, lon_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the unit vectors north and east of places, shape (..., 3)."""
    lat, lon = np.radians(lat_deg), np.radians(lon_deg)
    north = np.stack([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)], axis=-1)
    return north, np.stack([-np.sin(lon), np.cos(lon), np.zeros_like(lon)], axis=-1)


def _geodetic(xyz: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return latitude and longitude [deg] of points near the ellipsoid (Bowring 1976, below 1e-9 deg under 10 km)."""
    x, y, z = xyz[..., 0], xyz[..., 1], xyz[..., 2]
    p = np.hypot(x, y)
    theta = np.arctan2(z * WGS84_A_M, p * WGS84_B_M)
    lat = np.arctan2(z + _EP2 * WGS84_B_M * np.sin(theta) ** 3, p - _E2 * WGS84_A_M * np.cos(theta) ** 3)
    return np.degrees(lat), np.degrees(np.arctan2(y, x))
