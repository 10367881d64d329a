"""What a station has reported lately: its reports, newest first, in a plane about the newest one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from navfix.errors import InputError
from navfix.geodesy import cloud_to_plane
from navfix.types import FloatArray, Position

SAME_REPORT_S = 0.5  # two reports of one station this near in time are one, heard twice


@dataclass(frozen=True, slots=True)
class Point:
    """One report of a moving thing: when it held [POSIX s], where, and how it said to move (None: not told)."""

    time_s: float
    lat_deg: float
    lon_deg: float
    speed_mps: float | None = None
    course_deg: float | None = None
    turn_rate_deg_per_min: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Reports of one station, newest first.

    ``north_m`` and ``east_m`` (n,) count from the newest position, ``origin``; ``speed_mps`` and ``course_rad`` (n,)
    are NaN where they were not told; courses are unwrapped from the newest one. ``lat_deg`` and ``lon_deg`` (n,) as
    reported. ``turn_rate_rad_s`` is the newest report's own.
    """

    origin: Position
    time_s: FloatArray
    north_m: FloatArray
    east_m: FloatArray
    speed_mps: FloatArray
    course_rad: FloatArray
    lat_deg: FloatArray
    lon_deg: FloatArray
    turn_rate_rad_s: float | None = None

    def __len__(self) -> int:
        return len(self.time_s)


def history(points: Iterable[Point]) -> History:
    """Return the history of reports in any order; of two that are the same one heard twice the first counts.

    Raises
    ------
    InputError : no report at all
    """
    kept: list[Point] = []
    for point in sorted(points, key=lambda p: p.time_s):
        if not kept or point.time_s - kept[-1].time_s >= SAME_REPORT_S:
            kept.append(point)
    if not kept:
        raise InputError("a history needs at least one report, got none")
    kept.reverse()
    newest = kept[0]
    origin = Position(newest.lat_deg, newest.lon_deg)
    plane = cloud_to_plane(origin, [p.lat_deg for p in kept], [p.lon_deg for p in kept])
    course = np.radians([math.nan if p.course_deg is None else p.course_deg for p in kept])
    rate = newest.turn_rate_deg_per_min
    return History(
        origin=origin,
        time_s=np.array([p.time_s for p in kept]),
        north_m=plane[:, 0],
        east_m=plane[:, 1],
        speed_mps=np.array([math.nan if p.speed_mps is None else p.speed_mps for p in kept], dtype=np.float64),
        course_rad=unwrapped(course),
        lat_deg=np.array([p.lat_deg for p in kept]),
        lon_deg=np.array([p.lon_deg for p in kept]),
        turn_rate_rad_s=None if rate is None else math.radians(rate) / 60.0,
    )


def since(past: History, earliest_s: float) -> History:
    """Return the part of a history that is not older than ``earliest_s`` [POSIX s]; the newest report always stays."""
    count = max(int(np.count_nonzero(past.time_s >= earliest_s)), 1)
    return History(
        past.origin,
        past.time_s[:count],
        past.north_m[:count],
        past.east_m[:count],
        past.speed_mps[:count],
        past.course_rad[:count],
        past.lat_deg[:count],
        past.lon_deg[:count],
        past.turn_rate_rad_s,
    )


def unwrapped(angle_rad: FloatArray) -> FloatArray:
    """Return angles [rad] without jumps of a whole turn, in their order; NaN stays and is stepped over."""
    told = np.isfinite(angle_rad)
    result = np.array(angle_rad, dtype=np.float64)
    result[told] = np.unwrap(angle_rad[told])
    return result
