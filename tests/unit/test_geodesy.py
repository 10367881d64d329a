"""Geodesy by hand: constants, direct and inverse problem, local plane, clouds, centroids."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pyproj import Geod, Transformer

from navfix.errors import InputError
from navfix.geodesy import (
    WGS84_A_M,
    WGS84_B_M,
    LocalPlane,
    centroid,
    cloud_to_plane,
    convergence,
    direct,
    ecef,
    inverse,
    observer_of,
)
from navfix.types import Position

GEOD = Geod(ellps="WGS84")
NM_12_M = 12 * 1852.0


def angle_between_deg(one: float, other: float) -> float:
    return abs((one - other + 180.0) % 360.0 - 180.0)


def test_one_degree_of_longitude_on_the_equator_is_the_arc_of_the_major_axis() -> None:
    distance_m, azimuth_deg = inverse(Position(0.0, 10.0), Position(0.0, 11.0))
    assert distance_m == pytest.approx(math.radians(1.0) * WGS84_A_M, abs=1e-6)
    assert azimuth_deg == pytest.approx(90.0, abs=1e-12)


def test_a_meridian_quadrant_is_10001966_m() -> None:
    distance_m, azimuth_deg = inverse(Position(0.0, 0.0), Position(90.0, 0.0))
    assert distance_m == pytest.approx(10_001_965.729, abs=1e-3)
    assert azimuth_deg == pytest.approx(0.0, abs=1e-12)


def test_inverse_gives_azimuths_from_0_to_360() -> None:
    _, azimuth_deg = inverse(Position(50.0, 1.0), Position(50.0, 0.0))
    assert 270.0 < azimuth_deg < 271.0


def test_inverse_and_direct_cross_180_east_the_short_way() -> None:
    distance_m, azimuth_deg = inverse(Position(0.0, 179.9), Position(0.0, -179.9))
    assert distance_m == pytest.approx(math.radians(0.2) * WGS84_A_M, abs=1e-6)
    assert azimuth_deg == pytest.approx(90.0)
    assert direct(Position(0.0, 179.9), 90.0, distance_m).lon_deg == pytest.approx(-179.9, abs=1e-9)


def test_over_the_pole_the_longitude_changes_by_180_degrees() -> None:
    there = direct(Position(89.9, 30.0), 0.0, 2 * inverse(Position(89.9, 30.0), Position(90.0, 0.0))[0])
    assert there.lat_deg == pytest.approx(89.9, abs=1e-9)
    assert there.lon_deg == pytest.approx(-150.0, abs=1e-6)


@pytest.mark.parametrize(("lat_deg", "short_m"), [(60.0, 134.0), (70.0, 212.0)])
def test_the_way_back_from_a_mark_due_east_is_not_bearing_plus_180(lat_deg: float, short_m: float) -> None:
    """Meridians converge: at 12 NM one direct problem with bearing + 180 misses own ship by this much."""
    own = Position(lat_deg, 5.0)
    mark = direct(own, 90.0, NM_12_M)
    assert inverse(own, direct(mark, 270.0, NM_12_M))[0] == pytest.approx(short_m, abs=0.5)
    assert inverse(own, observer_of(mark, 90.0, NM_12_M))[0] < 1e-5


@pytest.mark.parametrize("bearing_deg", range(0, 360, 15))
def test_the_observer_is_found_while_the_mark_is_nearer_to_him_than_to_the_pole(bearing_deg: float) -> None:
    mark = Position(89.5, 0.0)  # 55.8 km from the pole
    own = observer_of(mark, bearing_deg, 44_000.0)
    distance_m, azimuth_deg = inverse(own, mark)
    assert distance_m == pytest.approx(44_000.0, abs=1e-6)
    assert angle_between_deg(azimuth_deg, bearing_deg) < 1e-8


def test_an_observer_across_the_pole_is_refused_with_a_reason() -> None:
    with pytest.raises(InputError, match="too near to a pole"):
        observer_of(Position(89.99, 0.0), 90.0, 22_000.0)


@pytest.mark.parametrize("lat_deg", [-89.0, -54.0, 0.0, 54.5, 85.0])
def test_distances_and_azimuths_agree_with_pyproj(lat_deg: float) -> None:
    own = Position(lat_deg, 179.95)
    for azimuth_deg in range(0, 360, 30):
        lon, lat, _ = GEOD.fwd(own.lon_deg, own.lat_deg, azimuth_deg, 40_000.0)
        ours = direct(own, azimuth_deg, 40_000.0)
        assert inverse(ours, Position(lat, lon))[0] < 1e-6
        assert inverse(own, Position(lat, lon))[0] == pytest.approx(40_000.0, abs=1e-6)


def test_the_local_plane_is_the_azimuthal_equidistant_projection_of_pyproj() -> None:
    origin = Position(54.5, 18.8)
    aeqd = Transformer.from_crs("EPSG:4326", f"+proj=aeqd +lat_0={origin.lat_deg} +lon_0={origin.lon_deg} +ellps=WGS84")
    plane = LocalPlane(origin)
    for azimuth_deg in range(0, 360, 40):
        place = direct(origin, azimuth_deg, 20_000.0)
        east_m, north_m = aeqd.transform(place.lat_deg, place.lon_deg)
        assert plane.to_plane(place) == pytest.approx([north_m, east_m], abs=1e-4)


def test_north_comes_first_in_the_local_plane() -> None:
    plane = LocalPlane(Position(0.0, 0.0))
    assert plane.to_plane(Position(0.0, 0.01)) == pytest.approx([0.0, math.radians(0.01) * WGS84_A_M], abs=1e-6)
    assert plane.to_plane(Position(0.01, 0.0))[0] > 1100.0


@pytest.mark.parametrize("bearing_deg", range(0, 360, 30))
def test_a_plane_direction_plus_convergence_is_the_true_direction(bearing_deg: float) -> None:
    plane = LocalPlane(Position(70.0, 179.9))
    here = plane.to_position(10_000.0, 40_000.0)
    assert plane.convergence_deg(here) > 0.9
    north_m, east_m = plane.to_plane(direct(here, bearing_deg, 10.0)) - plane.to_plane(here)
    seen_deg = math.degrees(math.atan2(east_m, north_m)) + plane.convergence_deg(here)
    assert angle_between_deg(seen_deg, bearing_deg) < 0.0003


@pytest.mark.parametrize("lat_deg", [0.0, 54.0, -70.0, 80.0])
def test_the_convergence_of_many_places_is_that_of_each(lat_deg: float) -> None:
    plane = LocalPlane(Position(lat_deg, 179.9))
    places = np.array([40e3j, 50e3 + 50e3j, -60e3 + 10e3j, 70e3 - 70e3j, 0.0])
    one_by_one = [plane.convergence_deg(plane.to_position(p.real, p.imag)) for p in places]
    assert np.degrees(convergence(plane.origin, places)) == pytest.approx(one_by_one, abs=1e-4)


def test_there_is_no_convergence_at_the_origin() -> None:
    assert LocalPlane(Position(70.0, 179.9)).convergence_deg(Position(70.0, 179.9)) == 0.0


def test_ecef_of_the_equator_and_the_pole_are_the_half_axes() -> None:
    assert ecef(0.0, 0.0) == pytest.approx([WGS84_A_M, 0.0, 0.0], abs=1e-9)
    assert ecef(90.0, 0.0) == pytest.approx([0.0, 0.0, WGS84_B_M], abs=1e-6)


def test_ecef_agrees_with_pyproj() -> None:
    lat, lon = np.array([54.0, -33.0, 71.5]), np.array([18.0, -120.0, 179.9])
    geocentric = Transformer.from_crs("EPSG:4979", "EPSG:4978")
    expected = np.stack(geocentric.transform(lat, lon, np.zeros(3)), axis=-1)
    assert ecef(lat, lon) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("lat_deg", [0.0, 54.0, -75.0, 89.9])
def test_a_cloud_of_50_km_lies_within_5_cm_of_the_local_plane(lat_deg: float) -> None:
    """The vectorised conversion is an approximation: its curvature radius is one for all azimuths."""
    origin = Position(lat_deg, 179.9)
    places = [direct(origin, azimuth, distance) for azimuth in range(0, 360, 20) for distance in (500.0, 20e3, 50e3)]
    cloud = cloud_to_plane(origin, [p.lat_deg for p in places], [p.lon_deg for p in places])
    exact = np.array([LocalPlane(origin).to_plane(p) for p in places])
    assert np.hypot(*(cloud - exact).T).max() < 0.05


def test_the_origin_of_a_cloud_is_zero() -> None:
    assert cloud_to_plane(Position(54.0, 10.0), [54.0], [10.0]) == pytest.approx(np.zeros((1, 2)), abs=1e-9)


def test_a_centroid_across_180_east_lies_between_the_places() -> None:
    """The mean of the longitudes would be 0, on the other side of the earth."""
    middle = centroid([10.0, 10.0], [179.0, -179.0])
    assert abs(middle.lon_deg) == pytest.approx(180.0, abs=1e-9)
    assert middle.lat_deg == pytest.approx(10.0, abs=0.002)


def test_a_centroid_around_the_pole_is_the_pole() -> None:
    assert centroid([89.0, 89.0, 89.0], [0.0, 120.0, 240.0]).lat_deg == pytest.approx(90.0, abs=1e-6)


def test_weights_draw_the_centroid_to_the_heavier_place() -> None:
    assert centroid([0.0, 0.0], [0.0, 0.04], [1.0, 3.0]).lon_deg == pytest.approx(0.03, abs=1e-8)


def test_no_places_and_places_that_cancel_have_no_centroid() -> None:
    with pytest.raises(InputError, match="at least one"):
        centroid([], [])
    with pytest.raises(InputError, match="no centroid"):
        centroid([0.0, 0.0], [0.0, 180.0])
