"""The published tables of the Knopp thesis, and the figures that follow from its formulas."""

from __future__ import annotations

import itertools
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navfix.adjustment.mean import factor_ellipses, mean_fix
from navfix.geodesy import WGS84_A_M, WGS84_B_M, LocalPlane, centroid, direct, inverse
from navfix.types import Association, Epoch, Mark, Position, RadarTarget

GOLDEN = Path(__file__).resolve().parents[2] / "data" / "golden"


def read(name: str) -> dict[str, Any]:
    return tomllib.loads((GOLDEN / f"{name}.toml").read_text(encoding="utf-8"))


TABLE_2_1, TABLE_4_2, MEAN = read("knopp_table_2_1"), read("knopp_table_4_2"), read("knopp_mean")


@pytest.mark.parametrize("constant", read("wgs84_constants")["constant"], ids=lambda c: c["published_m"])
def test_the_half_axes_are_those_of_wgs84(constant: dict[str, Any]) -> None:
    ours_m = WGS84_A_M if "major" in constant["name"] else WGS84_B_M
    assert abs(ours_m - constant["published_m"]) <= constant["tolerance_m"]


# ------------------------------------------------------------------------------------------------------- table 2.1


def haversine_km(start: Position, end: Position, radius_km: float) -> float:
    """Return the great-circle distance on a sphere."""
    lat, lon, lat2, lon2 = map(math.radians, (start.lat_deg, start.lon_deg, end.lat_deg, end.lon_deg))
    half_chord_sq = math.sin((lat2 - lat) / 2) ** 2 + math.cos(lat) * math.cos(lat2) * math.sin((lon2 - lon) / 2) ** 2
    return 2.0 * radius_km * math.asin(math.sqrt(half_chord_sq))


@pytest.mark.parametrize("row", TABLE_2_1["row"], ids=lambda row: f"{row['distance_km']:g} km")
def test_table_2_1_flat_and_spherical_distances_against_the_ellipsoid(row: dict[str, Any]) -> None:
    given = TABLE_2_1["input"]
    start = Position(**given["start"])
    end = direct(start, given["azimuth_deg"], row["distance_km"] * 1000.0)
    deviations_km = {
        "euclid_km": abs(row["distance_km"] - given["degree_km"] * math.hypot(end.lat_deg, end.lon_deg)),
        "haversine_km": abs(row["distance_km"] - haversine_km(start, end, given["sphere_radius_km"])),
    }
    for column, deviation_km in deviations_km.items():
        assert deviation_km == pytest.approx(row[column]["expected"], abs=row[column]["tolerance"]), column
        if "unit" in row[column]:  # one printed figure does not follow and says so
            assert deviation_km == pytest.approx(row[column]["published"], abs=row[column]["unit"]), column


# ------------------------------------------------------------------------------------------------------- table 4.2


@pytest.mark.parametrize("row", TABLE_4_2["row"], ids=lambda row: f"{row['shift_deg']:g} deg")
def test_table_4_2_a_shift_in_degrees_changes_distances(row: dict[str, Any]) -> None:
    def shifted_distance_m(shift_deg: float) -> float:
        one, other = (Position(lat + shift_deg, lon + shift_deg) for lat, lon in TABLE_4_2["input"]["points_deg"])
        return inverse(one, other)[0]

    distance_m = shifted_distance_m(row["shift_deg"])
    assert distance_m == pytest.approx(row["distance_m"], abs=TABLE_4_2["tolerance"]["distance_m"])
    deviation_m = shifted_distance_m(0.0) - distance_m
    assert abs(deviation_m - row["deviation_m"]) <= row["deviation_tolerance_m"]


@pytest.mark.parametrize("ring", TABLE_4_2["moved_ring"], ids=lambda ring: f"{ring['radius_m']:g} m")
def test_a_shift_along_geodesics_about_the_centroid_keeps_distances(ring: dict[str, Any]) -> None:
    own = Position(ring["lat_deg"], 10.0)
    marks = [direct(own, azimuth, ring["radius_m"]) for azimuth in range(0, 360, 15)]
    middle = centroid([m.lat_deg for m in marks], [m.lon_deg for m in marks])
    plane = LocalPlane(middle)
    flat = [plane.to_plane(mark) for mark in marks]
    moved = [
        direct(Position(0.0, 0.0), azimuth_deg, distance_m)
        for distance_m, azimuth_deg in (inverse(middle, mark) for mark in marks)
    ]
    on_ellipsoid, in_plane = [], []
    for one, other in itertools.combinations(range(len(marks)), 2):
        distance_m = inverse(marks[one], marks[other])[0]
        on_ellipsoid.append(abs(inverse(moved[one], moved[other])[0] - distance_m))
        in_plane.append(abs(math.dist(flat[one], flat[other]) - distance_m))
    assert max(on_ellipsoid) < ring["ellipsoid_m"]
    assert 10.0 * ring["ellipsoid_m"] < max(in_plane) < ring["plane_m"]


# ------------------------------------------------------------------------------------------------- the plain mean


def scene(own: Position, range_m: float, bearings_deg: list[float]) -> tuple[Epoch, Association]:
    targets = tuple(RadarTarget(f"{b:g}", range_m, b, "true") for b in bearings_deg)
    marks = tuple(Mark(f"{b:g}", direct(own, b, range_m), 0.0) for b in bearings_deg)
    epoch = Epoch(None, targets, marks)
    return epoch, Association.from_pairs(epoch, [(index, index) for index in range(len(targets))])


@pytest.mark.parametrize("case", MEAN["back_projection"], ids=lambda case: f"{case['lat_deg']:g} N")
def test_the_literal_way_back_misses_own_ship(case: dict[str, Any]) -> None:
    own, range_m = Position(case["lat_deg"], 5.0), case["range_m"]
    east, ring = scene(own, range_m, [90.0]), scene(own, range_m, [float(b) for b in range(0, 360, 5)])
    assert inverse(own, mean_fix(*east, literal=True).position)[0] == pytest.approx(
        case["due_east_miss_m"], abs=case["tolerance_m"]
    )
    assert -LocalPlane(own).to_plane(mean_fix(*ring, literal=True).position)[0] == pytest.approx(
        case["ring_south_m"], abs=case["tolerance_m"]
    )
    on_a_sphere_m = range_m**2 * math.tan(math.radians(case["lat_deg"])) / 6371e3
    assert on_a_sphere_m == pytest.approx(case["due_east_miss_m"], rel=0.01)
    for exact in (mean_fix(*east), mean_fix(*ring)):
        assert inverse(own, exact.position)[0] < 1e-3


def test_the_ellipses_at_given_factors_hold_what_two_dimensions_say() -> None:
    """Counted in 200 000 seeded draws of the spread itself, and by the closed form."""
    random = np.random.default_rng(1)
    own = Position(0.0, 0.0)
    epoch, association = scene(own, 5000.0, [float(b) for b in range(0, 360, 30)])
    blurred = Epoch(
        None,
        tuple(
            RadarTarget(t.label, t.range_m + random.normal(0.0, 40.0), t.bearing_deg + random.normal(0.0, 0.5), "true")
            for t in epoch.targets
        ),
        epoch.marks,
    )
    fix = mean_fix(blurred, association)
    assert fix.covariance is not None
    draws = random.multivariate_normal([0.0, 0.0], fix.covariance, size=200_000)
    ellipses = factor_ellipses(fix, [row["factor"] for row in MEAN["ellipse"]])
    for row, ellipse in zip(MEAN["ellipse"], ellipses, strict=True):
        assert ellipse.probability == pytest.approx(row["probability"], abs=row["tolerance"])
        azimuth_rad = math.radians(ellipse.azimuth_deg)
        along = draws @ np.array([math.cos(azimuth_rad), math.sin(azimuth_rad)]) / ellipse.semi_major_m
        across = draws @ np.array([-math.sin(azimuth_rad), math.cos(azimuth_rad)]) / ellipse.semi_minor_m
        assert np.mean(along**2 + across**2 <= 1.0) == pytest.approx(row["probability"], abs=0.004)
