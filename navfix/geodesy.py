"""Geodesy on WGS 84: direct and inverse problem, local plane, clouds of points, centroids that survive 180 E."""

from __future__ import annotations

import math

import numpy as np
from geographiclib.geodesic import Geodesic
from numpy.typing import ArrayLike

from navfix.errors import InputError
from navfix.types import FloatArray, Position
from navfix.units import wrap_180, wrap_pi

WGS84_A_M = 6378137.0
WGS84_F = 1.0 / 298.257223563
WGS84_B_M = WGS84_A_M * (1.0 - WGS84_F)
_E2 = WGS84_F * (2.0 - WGS84_F)
_INVERSE = Geodesic.DISTANCE | Geodesic.AZIMUTH
_DIRECT = Geodesic.LATITUDE | Geodesic.LONGITUDE
_DIRECT_AZIMUTH = _DIRECT | Geodesic.AZIMUTH


def inverse(start: Position, end: Position) -> tuple[float, float]:
    """Solve the inverse (second) geodetic problem: return distance [m] and azimuth at ``start`` [deg, 0 .. 360].

    Karney (2013), by geographiclib: accurate to nanometres at any distance.
    """
    line = Geodesic.WGS84.Inverse(start.lat_deg, start.lon_deg, end.lat_deg, end.lon_deg, _INVERSE)
    return line["s12"], line["azi1"] % 360.0


def direct(start: Position, azimuth_deg: float, distance_m: float) -> Position:
    """Solve the direct (first) geodetic problem: the place ``distance_m`` along the geodesic of this azimuth."""
    line = Geodesic.WGS84.Direct(start.lat_deg, start.lon_deg, azimuth_deg, distance_m, _DIRECT)
    return Position(line["lat2"], line["lon2"])


def observer_of(mark: Position, bearing_deg: float, range_m: float) -> Position:
    """Return the place from which ``mark`` is seen at ``bearing_deg`` (true, **at that place**) and ``range_m``.

    Meridians converge, so the way back from the mark is not exactly bearing + 180: at 60 N, 12 NM due east of the
    observer it is 20 arc minutes off, 134 m. The back azimuth is found by secant steps until the bearing fits to
    1e-10 deg or 1 micrometre.

    Raises
    ------
    InputError : no such place was found (a mark nearer to a pole than to the observer: there two places fit, or none)
    """
    back_deg, step_deg, last_misclosure_deg = bearing_deg + 180.0, 0.0, 0.0
    for _ in range(50):
        observer = direct(mark, back_deg, range_m)
        seen_range_m, seen_deg = inverse(observer, mark)
        misclosure_deg = wrap_180(bearing_deg - seen_deg)
        if abs(misclosure_deg) < 1e-10 or math.radians(abs(misclosure_deg)) * seen_range_m < 1e-6:
            return observer
        gained_deg = last_misclosure_deg - misclosure_deg
        rate = gained_deg / step_deg if step_deg * gained_deg > 0.0 else 1.0
        step_deg, last_misclosure_deg = max(-45.0, min(45.0, misclosure_deg / rate)), misclosure_deg
        back_deg += step_deg
    raise InputError(f"no place sees {mark} at {bearing_deg}° and {range_m} m: the mark is too near to a pole")


class LocalPlane:
    """Azimuthal equidistant plane about ``origin``, axes (north, east) in metres.

    Distances and azimuths from the origin are exact geodesics at any latitude, also across 180 E and near the poles.
    """

    def __init__(self, origin: Position) -> None:
        self.origin = origin

    def to_plane(self, position: Position) -> FloatArray:
        """Return (north, east) [m] of one place, shape (2,)."""
        distance_m, azimuth_deg = inverse(self.origin, position)
        azimuth_rad = math.radians(azimuth_deg)
        return np.array([distance_m * math.cos(azimuth_rad), distance_m * math.sin(azimuth_rad)])

    def all_to_plane(self, lat_deg: ArrayLike, lon_deg: ArrayLike) -> FloatArray:
        """Return (n, 2) north, east [m] of many places at once, within 1e-4 m of `to_plane` (1e-6 m within 300 km).

        Within 4000 km by Vincenty's formulas (1975), vectorised; what is farther goes one by one.
        """
        lat, lon = np.atleast_1d(np.asarray(lat_deg, np.float64)), np.atleast_1d(np.asarray(lon_deg, np.float64))
        distance_m, azimuth_rad = _vincenty_inverse(self.origin, lat, lon)
        plane = np.stack([distance_m * np.cos(azimuth_rad), distance_m * np.sin(azimuth_rad)], axis=-1)
        for index in np.flatnonzero(~(distance_m < 4e6)):
            plane[index] = self.to_plane(Position(float(lat[index]), float(lon[index])))
        return plane

    def to_position(self, north_m: float, east_m: float) -> Position:
        """Return the place at (north, east) [m]."""
        return direct(self.origin, math.degrees(math.atan2(east_m, north_m)), math.hypot(north_m, east_m))

    def place(self, north_m: float, east_m: float) -> tuple[Position, float]:
        """Return the place at (north, east) [m], and the convergence there as `convergence_deg` does."""
        azimuth_deg = math.degrees(math.atan2(east_m, north_m))
        line = Geodesic.WGS84.Direct(
            self.origin.lat_deg, self.origin.lon_deg, azimuth_deg, math.hypot(north_m, east_m), _DIRECT_AZIMUTH
        )
        return Position(line["lat2"], line["lon2"]), wrap_180(line["azi2"] - azimuth_deg)

    def convergence_deg(self, position: Position) -> float:
        """Return true minus plane direction [deg] at a place: meridians converge; zero at the origin.

        Exact for the direction of the origin; other directions are turned a little more (0.0003 deg 50 km from it).
        """
        north_m, east_m = self.to_plane(position)
        distance_m, azimuth_deg = inverse(position, self.origin)
        if distance_m < 1.0:
            return 0.0
        return wrap_180(azimuth_deg - math.degrees(math.atan2(-east_m, -north_m)))


def convergence(origin: Position, plane: ArrayLike) -> FloatArray:
    """Return true minus plane direction [rad] (n,) at places (n,) [m, complex: north + i east] about ``origin``.

    What `LocalPlane.convergence_deg` is for one place, vectorised: the turn of the great circle from the origin, on a
    sphere with the origin's prime vertical radius (within 0.0001 deg of it at 100 km).
    """
    place = np.atleast_1d(np.asarray(plane, dtype=np.complex128))
    lat = math.radians(origin.lat_deg)
    radius_m = WGS84_A_M / math.sqrt(1.0 - _E2 * math.sin(lat) ** 2)
    arc, azimuth = np.abs(place) / radius_m, np.angle(place)
    sin, cos = np.sin(arc), np.cos(arc)
    arriving = np.arctan2(np.sin(azimuth) * math.cos(lat), math.cos(lat) * cos * np.cos(azimuth) - math.sin(lat) * sin)
    turned: FloatArray = wrap_pi(arriving - azimuth)
    return turned


def _vincenty_inverse(origin: Position, lat_deg: FloatArray, lon_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distances [m] and azimuths at ``origin`` [rad]; for places that are not nearly antipodal."""
    f, b = WGS84_F, WGS84_B_M
    u1, u2 = (
        math.atan((1.0 - f) * math.tan(math.radians(origin.lat_deg))),
        np.arctan((1.0 - f) * np.tan(np.radians(lat_deg))),
    )
    s1, c1, s2, c2 = math.sin(u1), math.cos(u1), np.sin(u2), np.cos(u2)
    longitude = np.radians(wrap_180(lon_deg - origin.lon_deg))
    lam = longitude
    for _ in range(8):  # the longitude on the auxiliary sphere, eq. (11); four rounds suffice within 4000 km
        sin_lam, cos_lam = np.sin(lam), np.cos(lam)
        across, along = c2 * sin_lam, c1 * s2 - s1 * c2 * cos_lam
        sin_sigma, cos_sigma = np.hypot(across, along), s1 * s2 + c1 * c2 * cos_lam
        sigma = np.arctan2(sin_sigma, cos_sigma)
        sin_alpha = c1 * across / np.maximum(sin_sigma, 1e-300)
        cos2_alpha = np.maximum(1.0 - sin_alpha**2, 1e-300)
        middle = np.where(cos2_alpha > 1e-15, cos_sigma - 2.0 * s1 * s2 / cos2_alpha, 0.0)
        C = f / 16.0 * cos2_alpha * (4.0 + f * (4.0 - 3.0 * cos2_alpha))
        bend = sigma + C * sin_sigma * (middle + C * cos_sigma * (2.0 * middle**2 - 1.0))
        before, lam = lam, longitude + (1.0 - C) * f * sin_alpha * bend
        if np.all(np.abs(lam - before) < 1e-14):
            break
    u = cos2_alpha * (WGS84_A_M**2 - b**2) / b**2
    A = 1.0 + u / 16384.0 * (4096.0 + u * (-768.0 + u * (320.0 - 175.0 * u)))
    B = u / 1024.0 * (256.0 + u * (-128.0 + u * (74.0 - 47.0 * u)))
    cubic = B / 6.0 * middle * (4.0 * sin_sigma**2 - 3.0) * (4.0 * middle**2 - 3.0)
    correction = B * sin_sigma * (middle + B / 4.0 * (cos_sigma * (2.0 * middle**2 - 1.0) - cubic))
    return b * A * (sigma - correction), np.arctan2(across, along)


def ecef(lat_deg: ArrayLike, lon_deg: ArrayLike) -> FloatArray:
    """Return earth-centred coordinates [m] of places on the ellipsoid, shape (..., 3)."""
    lat, lon = np.radians(np.asarray(lat_deg, dtype=np.float64)), np.radians(np.asarray(lon_deg, dtype=np.float64))
    prime_vertical_m = WGS84_A_M / np.sqrt(1.0 - _E2 * np.sin(lat) ** 2)
    return np.stack(
        [
            prime_vertical_m * np.cos(lat) * np.cos(lon),
            prime_vertical_m * np.cos(lat) * np.sin(lon),
            prime_vertical_m * (1.0 - _E2) * np.sin(lat),
        ],
        axis=-1,
    )


def cloud_to_plane(origin: Position, lat_deg: ArrayLike, lon_deg: ArrayLike) -> FloatArray:
    """Return (n, 2) north, east [m] about ``origin`` of a cloud, vectorised.

    Tangent plane of the earth-centred coordinates, its horizontal distance lengthened from the sine of the arc to the
    arc: within 0.05 m of the azimuthal equidistant plane at 50 km. For association; the adjustment uses `LocalPlane`.
    """
    lat, lon = math.radians(origin.lat_deg), math.radians(origin.lon_deg)
    offset = ecef(lat_deg, lon_deg) - ecef(origin.lat_deg, origin.lon_deg)
    outwards = math.cos(lon) * offset[..., 0] + math.sin(lon) * offset[..., 1]  # from the axis of the earth
    north = math.cos(lat) * offset[..., 2] - math.sin(lat) * outwards
    east = -math.sin(lon) * offset[..., 0] + math.cos(lon) * offset[..., 1]
    radius_m = WGS84_A_M
    half_chord = np.minimum(np.linalg.norm(offset, axis=-1) / (2.0 * radius_m), 1.0)
    arc = 2.0 * np.arcsin(half_chord)
    stretch = np.where(arc > 1e-9, arc / np.maximum(np.sin(arc), 1e-300), 1.0)
    return np.stack([north * stretch, east * stretch], axis=-1)


def centroid(lat_deg: ArrayLike, lon_deg: ArrayLike, weights: ArrayLike | None = None) -> Position:
    """Return the (weighted) centroid of places, computed from unit vectors: right across 180 E and at the poles.

    Raises
    ------
    InputError : no places, or places that cancel out (spread over the whole globe)
    """
    lat = np.radians(np.atleast_1d(np.asarray(lat_deg, dtype=np.float64)))
    lon = np.radians(np.atleast_1d(np.asarray(lon_deg, dtype=np.float64)))
    if lat.size == 0:
        raise InputError("a centroid needs at least one place, got none")
    share = np.ones(lat.shape) if weights is None else np.asarray(weights, dtype=np.float64)
    vector = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)]) @ share
    length = float(np.linalg.norm(vector))
    if not length > 1e-6 * float(np.sum(np.abs(share))):
        raise InputError("the places have no centroid: they are spread around the whole globe")
    x, y, z = vector.tolist()
    return Position(math.degrees(math.atan2(z, math.hypot(x, y))), math.degrees(math.atan2(y, x)))
