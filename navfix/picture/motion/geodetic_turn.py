"""Coordinated turn in geodetic coordinates: the state (longitude, latitude, speed, course, rate) and how it moves on.

References
----------
[1] Correction of AIS tracks by the unscented Kalman filter, 3.2: filter in longitude and latitude, no local plane.
"""

from __future__ import annotations

import math

import numpy as np

from navfix.catalog import FilterModel
from navfix.geodesy import WGS84_A_M, WGS84_F
from navfix.types import FloatArray

LON, LAT, SPEED, COURSE, RATE = range(5)
_E2 = WGS84_F * (2.0 - WGS84_F)
_MOST_NORTH_DEG = 89.9  # nearer to a pole longitude is no coordinate to filter in


def metres_per_degree(lat_deg: FloatArray | float) -> tuple[FloatArray, FloatArray]:
    """Return metres per degree of latitude and of longitude on WGS 84."""
    lat = np.radians(np.clip(lat_deg, -_MOST_NORTH_DEG, _MOST_NORTH_DEG))
    root = np.sqrt(1.0 - _E2 * np.sin(lat) ** 2)
    degree = math.radians(1.0)
    return degree * WGS84_A_M * (1.0 - _E2) / root**3, degree * WGS84_A_M * np.cos(lat) / root


def propagate(state: FloatArray, time_s: float, persist_s: float = math.inf) -> FloatArray:
    """Move states (..., 5) [deg, deg, m/s, rad, rad/s] on by ``time_s`` along their arcs (theory, eq. 13.7).

    The rate of turn fades with the time constant ``persist_s``; the source's fades never.
    """
    lasting, left = fading(time_s, persist_s)
    half = 0.5 * lasting * state[..., RATE] * time_s
    chord_m = state[..., SPEED] * time_s * np.sinc(half / np.pi)
    mean_rad = state[..., COURSE] + half
    moved = np.array(state, dtype=np.float64)
    lat_m, _ = metres_per_degree(state[..., LAT])
    step_lat = chord_m * np.cos(mean_rad) / lat_m
    _, lon_m = metres_per_degree(state[..., LAT] + 0.5 * step_lat)
    moved[..., LAT] += step_lat
    moved[..., LON] += chord_m * np.sin(mean_rad) / lon_m
    moved[..., COURSE] += 2.0 * half
    moved[..., RATE] *= left
    return moved


def fading(time_s: float, persist_s: float) -> tuple[float, float]:
    """Return the mean of what fades over ``time_s``, and what is left of it in the end; back in time it grows not."""
    share = abs(time_s) / persist_s
    return (-math.expm1(-share) / share if share > 1e-9 else 1.0), math.exp(-share)


def jacobian(state: FloatArray, time_s: float, persist_s: float = math.inf) -> FloatArray:
    """Return d propagate / d state (5, 5) of one state; how metres per degree change is left out (below 1e-6)."""
    lasting, left = fading(time_s, persist_s)
    half = 0.5 * lasting * state[RATE] * time_s
    short = np.sinc(half / np.pi)
    slope = (math.cos(half) - short) / half if abs(half) > 1e-4 else -half / 3.0  # d short / d half
    mean, speed = state[COURSE] + half, state[SPEED]
    cos, sin = math.cos(mean), math.sin(mean)
    lat_m, _ = metres_per_degree(state[LAT])
    _, lon_m = metres_per_degree(state[LAT] + 0.5 * speed * time_s * short * cos / lat_m)
    F = np.eye(5)
    for row, along, across, metres in ((LAT, cos, -sin, lat_m), (LON, sin, cos, lon_m)):
        F[row, SPEED] = time_s * short * along / metres
        F[row, COURSE] = speed * time_s * short * across / metres
        F[row, RATE] = speed * time_s * 0.5 * lasting * time_s * (slope * along + short * across) / metres
    F[COURSE, RATE] = lasting * time_s
    F[RATE, RATE] = left
    return F


def process_noise(state: FloatArray, time_s: float, constants: FilterModel) -> FloatArray:
    """Return the covariance (5, 5) that ``abs(time_s)`` adds to a state."""
    lat_m, lon_m = metres_per_degree(float(state[LAT]))
    walk = np.array(
        [
            constants.position_walk_m / float(lon_m),
            constants.position_walk_m / float(lat_m),
            constants.speed_walk_mps,
            constants.course_walk_rad,
            constants.turn_walk_rad_s,
        ]
    )
    noise: FloatArray = np.diag(walk**2) * abs(time_s)
    return noise
