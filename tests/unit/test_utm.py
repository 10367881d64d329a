"""UTM to latitude and longitude, convergence and scale, against PROJ."""

from __future__ import annotations

import pyproj
import pytest

from navfix.adjustment.utm import from_utm, zone_of
from navfix.errors import InputError
from navfix.geodesy import inverse
from navfix.types import PlanePosition, Position


@pytest.mark.parametrize("zone", ["34N", "1N", "60S", "17S", "33N"])
@pytest.mark.parametrize("east_m", [166000.0, 360505.53, 500000.0, 834000.0])
@pytest.mark.parametrize("north_m", [1100000.0, 2500000.0, 6045147.73, 9200000.0])
def test_places_convergence_and_scale_are_those_of_proj(zone: str, east_m: float, north_m: float) -> None:
    number, north = zone_of(zone)
    projection = pyproj.Proj(proj="utm", zone=number, south=not north, ellps="WGS84")
    lon, lat = projection(east_m, north_m, inverse=True)
    found = from_utm(PlanePosition(north_m, east_m), zone)
    assert inverse(found.position, Position(lat, lon))[0] < 1e-4
    factors = projection.get_factors(lon, lat)
    assert found.convergence_deg == pytest.approx(factors.meridian_convergence, abs=1e-7)
    assert found.scale == pytest.approx(factors.meridional_scale, abs=1e-9)


def test_the_gdynia_stands_convergence() -> None:
    found = from_utm(PlanePosition(6045147.73, 360505.53), "34N")
    assert found.convergence_deg == pytest.approx(-1.75, abs=0.02)


@pytest.mark.parametrize("zone", ["0N", "61N", "34", "34X", "N34", ""])
def test_what_is_no_zone_is_refused(zone: str) -> None:
    with pytest.raises(InputError, match="utm_zone"):
        from_utm(PlanePosition(6e6, 4e5), zone)


def test_what_is_no_place_of_the_grid_is_refused() -> None:
    with pytest.raises(InputError, match="holds no place"):
        from_utm(PlanePosition(5e7, 4e5), "34N")
