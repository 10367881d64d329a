"""Lever arms and alignment: from the radar's antenna and zero mark to the ship's reference point and bow, and on."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.types import Fix, FloatArray, Position

Offset = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Alignment:
    """Direction of the radar's zero mark from the bow, clockwise [deg], and its 1 sigma: heading = zero mark - it."""

    offset_deg: float
    sigma_deg: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.offset_deg) and math.isfinite(self.sigma_deg) and self.sigma_deg >= 0.0):
            raise InputError(f"alignment: expected degrees and a sigma >= 0, got {self.offset_deg}, {self.sigma_deg}")


def checked_offset(offset_m: Offset, name: str) -> Offset:
    """Return (forward, starboard) [m] as given.

    Raises
    ------
    InputError : not two finite numbers
    """
    if len(offset_m) != 2 or not all(math.isfinite(value) for value in offset_m):
        raise InputError(f"{name} must be two finite distances (forward, starboard) in m, got {offset_m!r}")
    return float(offset_m[0]), float(offset_m[1])


def swung(offset_m: Offset, heading_rad: float) -> tuple[FloatArray, FloatArray]:
    """Return the offset in (north, east) [m] and its derivative by the heading [m/rad]; eq. (0.1)."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    forward, starboard = offset_m
    north, east = c * forward - s * starboard, s * forward + c * starboard
    return np.array([north, east]), np.array([-east, north])


def aligned(covariance: FloatArray, alignment: Alignment) -> FloatArray:
    """Return the covariance (3, 3) with the bow's heading in place of the zero mark's: more variance."""
    result = np.array(covariance)
    result[2, 2] += math.radians(alignment.sigma_deg) ** 2
    return result


def moved_covariance(covariance: FloatArray, by_heading: FloatArray, sign: float) -> FloatArray:
    """Propagate a covariance (3, 3) from a point to one that lies an offset away: p' = p + sign x offset(heading)."""
    jacobian = np.eye(3)
    jacobian[:2, 2] = sign * by_heading
    return np.asarray(jacobian @ covariance @ jacobian.T)


def antenna_of(fix: Fix, offset_m: Offset, *, heading_deg: float | None = None) -> tuple[Position, FloatArray]:
    """Return where an antenna is by the fix, and the covariance (2, 2) of that: for the comparison with its GNSS.

    Parameters
    ----------
    offset_m : forward and starboard of the ship's reference point
    heading_deg : needed where the fix has none (all bearings true); then taken as exact

    Raises
    ------
    InputError : an impossible offset, no heading anywhere, a fix in a plane frame
    """
    offset = checked_offset(offset_m, "the antenna's offset")
    turn_deg = fix.heading_deg if fix.heading_deg is not None else heading_deg
    if not isinstance(fix.position, Position):
        raise InputError("an antenna's place needs a fix on the ellipsoid, got one in a plane frame")
    if turn_deg is None:
        raise InputError("an antenna's place needs a heading: the fix has none, give heading_deg")
    away, by_heading = swung(offset, math.radians(turn_deg))
    place = LocalPlane(fix.position).to_position(float(away[0]), float(away[1]))
    if fix.heading_deg is None:
        return place, np.array(fix.covariance[:2, :2])
    return place, moved_covariance(fix.covariance, by_heading, 1.0)[:2, :2]
