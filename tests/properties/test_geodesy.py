"""Geodesy for any place: round trips, and two roads to one answer."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod

from navfix.geodesy import LocalPlane, centroid, cloud_to_plane, direct, inverse, observer_of
from navfix.types import Position

GEOD = Geod(ellps="WGS84")

latitudes = st.floats(-89.9, 89.9)
longitudes = st.floats(-180.0, 180.0)
places = st.builds(Position, latitudes, longitudes)
sailed_places = st.builds(Position, st.floats(-85.0, 85.0), longitudes)
azimuths_deg = st.floats(0.0, 360.0, exclude_max=True)
radar_ranges_m = st.floats(10.0, 90_000.0)


def plane_distance_m(one: Position, other: Position) -> float:
    return inverse(one, other)[0]


@given(places, azimuths_deg, radar_ranges_m)
def test_direct_then_inverse_returns_distance_and_azimuth(own: Position, azimuth_deg: float, range_m: float) -> None:
    distance_m, back_deg = inverse(own, direct(own, azimuth_deg, range_m))
    assert abs(distance_m - range_m) < 1e-3
    sideways_m = math.radians((back_deg - azimuth_deg + 180.0) % 360.0 - 180.0) * range_m
    assert abs(sideways_m) < 1e-3


@given(places, azimuths_deg, radar_ranges_m)
def test_plane_and_back_returns_the_place(origin: Position, azimuth_deg: float, range_m: float) -> None:
    plane, place = LocalPlane(origin), direct(origin, azimuth_deg, range_m)
    assert plane_distance_m(plane.to_position(*plane.to_plane(place)), place) < 1e-3


@given(sailed_places, azimuths_deg, radar_ranges_m)
def test_the_observer_of_a_mark_is_own_ship(own: Position, bearing_deg: float, range_m: float) -> None:
    mark = direct(own, bearing_deg, range_m)
    assert plane_distance_m(observer_of(mark, bearing_deg, range_m), own) < 1e-3


@given(places, azimuths_deg, radar_ranges_m)
def test_inverse_agrees_with_pyproj(own: Position, azimuth_deg: float, range_m: float) -> None:
    there = direct(own, azimuth_deg, range_m)
    _, _, distance_m = GEOD.inv(own.lon_deg, own.lat_deg, there.lon_deg, there.lat_deg)
    assert abs(distance_m - plane_distance_m(own, there)) < 1e-6


@given(places, azimuths_deg, st.floats(10.0, 50_000.0))
def test_a_cloud_agrees_with_the_local_plane(origin: Position, azimuth_deg: float, range_m: float) -> None:
    place = direct(origin, azimuth_deg, range_m)
    cloud = cloud_to_plane(origin, [place.lat_deg], [place.lon_deg])[0]
    assert np.hypot(*(cloud - LocalPlane(origin).to_plane(place))) < 0.05


@given(sailed_places, azimuths_deg, st.floats(10.0, 20_000.0))
def test_the_centroid_of_two_places_is_halfway_between(own: Position, azimuth_deg: float, range_m: float) -> None:
    """Within 1 m: normals of the ellipsoid are averaged, and its curvature changes a little along 20 km."""
    there = direct(own, azimuth_deg, range_m)
    middle = centroid([own.lat_deg, there.lat_deg], [own.lon_deg, there.lon_deg])
    assert plane_distance_m(middle, direct(own, azimuth_deg, range_m / 2.0)) < 1.0
