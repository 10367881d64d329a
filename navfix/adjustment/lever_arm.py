"""Lever arms and alignment: from the radar's antenna and zero mark to the ship's reference point and bow, and on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.types import Fix, FloatArray, GnssReport

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


def gnss_at_reference_point(gnss: GnssReport, antenna_m: Offset, fix: Fix) -> GnssReport:
    """Return own GNSS as it would be at the ship's reference point, its antenna ``antenna_m`` (forward, starboard) off.

    The heading is that of the fix, else the heading hint of its epoch. The heading's sigma adds to that of the GNSS;
    without any heading the antenna's whole distance does.

    Raises
    ------
    InputError : not two finite numbers
    """
    offset = checked_offset(antenna_m, "gnss antenna")
    reach_m = math.hypot(*offset)
    hint = None if fix.epoch is None else fix.epoch.heading_hint
    if fix.heading_deg is not None:
        heading_deg, sigma_rad = fix.heading_deg, math.sqrt(float(fix.covariance[2, 2]))
    elif hint is not None:
        heading_deg, sigma_rad = hint.heading_deg, math.radians(hint.sigma_deg)
    else:
        return replace(gnss, sigma_m=math.hypot(gnss.sigma_m, reach_m))
    north_m, east_m = (-swung(offset, math.radians(heading_deg))[0]).tolist()
    position = LocalPlane(gnss.position).to_position(north_m, east_m)
    return replace(gnss, position=position, sigma_m=math.hypot(gnss.sigma_m, reach_m * min(sigma_rad, 1.0)))
