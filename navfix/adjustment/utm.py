"""Universal Transverse Mercator to latitude and longitude, with the grid's convergence and scale."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from navfix.errors import InputError
from navfix.geodesy import WGS84_A_M, WGS84_F
from navfix.types import PlanePosition, Position

_CENTRAL_SCALE, _FALSE_EAST_M, _FALSE_NORTH_M = 0.9996, 500_000.0, 10_000_000.0
_WIDEST_M = 1_000_000.0  # from the central meridian: beyond it the grid is no map any more
_N = WGS84_F / (2.0 - WGS84_F)  # third flattening
_RECTIFYING_M = WGS84_A_M / (1.0 + _N) * (1.0 + _N**2 / 4.0 + _N**4 / 64.0)
_BETA = (
    _N / 2.0 - 2.0 * _N**2 / 3.0 + 37.0 * _N**3 / 96.0 - _N**4 / 360.0,
    _N**2 / 48.0 + _N**3 / 15.0 - 437.0 * _N**4 / 1440.0,
    17.0 * _N**3 / 480.0 - 37.0 * _N**4 / 840.0,
    4397.0 * _N**4 / 161280.0,
)


@dataclass(frozen=True, slots=True)
class GridPlace:
    """A place of the grid: where it is, grid convergence (grid bearing = true bearing - it) [deg] and point scale."""

    position: Position
    convergence_deg: float
    scale: float


def zone_of(text: str) -> tuple[int, bool]:
    """Return number and whether it is the northern half of a zone like "34N".

    Raises
    ------
    InputError : no such zone
    """
    match = re.fullmatch(r"\s*(\d{1,2})\s*([NSns])\s*", text)
    if match is None or not 1 <= int(match[1]) <= 60:
        raise InputError(f"utm_zone must be a number 1 .. 60 and N or S, like '34N', got {text!r}")
    return int(match[1]), match[2].upper() == "N"


def from_utm(place: PlanePosition, zone: str) -> GridPlace:
    """Return where a place of a UTM zone (WGS 84) is, by Krueger's series to the fourth order (below 0.1 mm).

    Raises
    ------
    InputError : no such zone; a place that no UTM grid holds

    References
    ----------
    C. F. F. Karney, Transverse Mercator with an accuracy of a few nanometers, Journal of Geodesy 85 (2011).
    """
    number, north = zone_of(zone)
    east_m, north_m = place.east_m - _FALSE_EAST_M, place.north_m - (0.0 if north else _FALSE_NORTH_M)
    if abs(east_m) > _WIDEST_M or abs(north_m) > 1.0e7:
        raise InputError(f"UTM zone {zone} holds no place at north {place.north_m:.0f} m, east {place.east_m:.0f} m")
    xi, eta = north_m / (_CENTRAL_SCALE * _RECTIFYING_M), east_m / (_CENTRAL_SCALE * _RECTIFYING_M)
    xi_, eta_, p, q = xi, eta, 1.0, 0.0
    for j, beta in enumerate(_BETA, start=1):
        sin, cos, sinh, cosh = (
            math.sin(2 * j * xi),
            math.cos(2 * j * xi),
            math.sinh(2 * j * eta),
            math.cosh(2 * j * eta),
        )
        xi_, eta_ = xi_ - beta * sin * cosh, eta_ - beta * cos * sinh
        p, q = p - 2 * j * beta * cos * cosh, q + 2 * j * beta * sin * sinh
    lengthening = math.hypot(math.sinh(eta_), math.cos(xi_))
    tan_lat = _geographic_tangent(math.sin(xi_) / lengthening)
    longitude_deg = 6.0 * number - 183.0 + math.degrees(math.atan2(math.sinh(eta_), math.cos(xi_)))
    turn = math.tan(xi_) * math.tanh(eta_)
    convergence_deg = math.degrees(math.atan2(q + p * turn, p - q * turn))
    stretch = math.hypot(1.0, (1.0 - _N) / (1.0 + _N) * tan_lat) * lengthening / math.hypot(p, q)
    scale = _CENTRAL_SCALE * _RECTIFYING_M / WGS84_A_M * stretch
    return GridPlace(Position(math.degrees(math.atan(tan_lat)), longitude_deg), convergence_deg, scale)


def _geographic_tangent(conformal: float) -> float:
    """Return tan(latitude) from the tangent of the conformal latitude, by Newton's method (Karney 2011, eq. 19-21)."""
    e = math.sqrt(WGS84_F * (2.0 - WGS84_F))
    tau = conformal / (1.0 - e * e)
    for _ in range(8):
        sigma = math.sinh(e * math.atanh(e * tau / math.hypot(1.0, tau)))
        guess = tau * math.hypot(1.0, sigma) - sigma * math.hypot(1.0, tau)
        slope = (1.0 + (1.0 - e * e) * tau * tau) / ((1.0 - e * e) * math.hypot(1.0, tau))
        change = (conformal - guess) / math.hypot(1.0, guess) * slope
        tau += change
        if abs(change) < 1e-14 * max(1.0, abs(tau)):
            break
    return tau
