"""GeoJSON after RFC 7946: closed rings, counter-clockwise, coordinates in range, cut at 180 E."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from itertools import pairwise

import pytest

from navfix.errors import InputError
from navfix.geodesy import direct, inverse
from navfix.report import Answer
from navfix.report.geojson import _area, _line, answer_to_geojson, ellipse_ring, geojson_text
from navfix.types import Ellipse, Position
from tests.factories import DATE_LINE, OSLO, every_fix, every_no_fix, make_answer, make_no_fix, make_plane_fix

EVERY = every_fix() | every_no_fix()


def features(answer: Answer, what: str) -> list[dict]:
    """Return the features of one sort, as another program reads them."""
    found = json.loads(geojson_text(answer))["features"]
    return [feature for feature in found if feature["properties"]["what"] == what]


def points_of(coordinates: list) -> Iterator[list[float]]:
    """Yield every (longitude, latitude) of nested coordinates."""
    if isinstance(coordinates[0], float):
        yield coordinates
    else:
        for part in coordinates:
            yield from points_of(part)


def rings_of(geometry: dict) -> list[list[list[float]]]:
    """Return the outer rings of a Polygon or MultiPolygon."""
    polygons = [geometry["coordinates"]] if geometry["type"] == "Polygon" else geometry["coordinates"]
    return [polygon[0] for polygon in polygons]


def area_of(ring: list[list[float]]) -> float:
    """Return the signed area in square degrees: positive counter-clockwise."""
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(ring)) / 2.0


@pytest.mark.parametrize("name", list(EVERY))
def test_every_collection_is_valid(name: str) -> None:
    collection = json.loads(geojson_text(EVERY[name]))
    assert collection["type"] == "FeatureCollection"
    for feature in collection["features"]:
        assert set(feature) == {"type", "geometry", "properties"}
        geometry = feature["geometry"]
        if geometry is None:
            assert feature["properties"]["status"] == "no_fix"
            continue
        for longitude, latitude in points_of(geometry["coordinates"]):
            assert -180.0 <= longitude <= 180.0
            assert -90.0 <= latitude <= 90.0
        if geometry["type"].endswith("Polygon"):
            for ring in rings_of(geometry):
                assert len(ring) >= 4
                assert ring[0] == ring[-1]
                assert area_of(ring) > 0.0


def test_a_fix_has_ship_heading_ellipses_marks_targets_and_sticks() -> None:
    answer = make_answer()
    counts = {
        what: len(features(answer, what))
        for what in (
            "own ship",
            "heading line",
            "confidence ellipse",
            "mark",
            "target",
            "residual",
            "plain_mean",
            "gnss",
        )
    }
    assert counts == {
        "own ship": 1, "heading line": 1, "confidence ellipse": 2, "mark": 60, "target": 20, "residual": 17,
        "plain_mean": 1, "gnss": 1,
    }  # fmt: skip


def test_outliers_are_flagged_on_target_mark_and_stick() -> None:
    answer = make_answer()
    assert [f["properties"]["label"] for f in features(answer, "target") if f["properties"]["outlier"]] == ["05"]
    assert [f["properties"]["name"] for f in features(answer, "mark") if f["properties"]["outlier"]] == ["NORDIC QUEEN"]
    assert [f["properties"]["target"] for f in features(answer, "residual") if f["properties"]["outlier"]] == ["05"]


def test_a_target_stands_where_range_and_true_bearing_from_the_fix_lead() -> None:
    answer = make_answer()
    fix = answer.fix
    assert fix is not None
    assert isinstance(fix.position, Position)
    assert answer.epoch is not None
    target = answer.epoch.targets[6]
    longitude, latitude = features(answer, "target")[6]["geometry"]["coordinates"]
    distance_m, azimuth_deg = inverse(fix.position, Position(latitude, longitude))
    assert distance_m == pytest.approx(target.range_m, abs=0.001)
    assert azimuth_deg == pytest.approx((target.bearing_deg + fix.heading_deg) % 360.0, abs=1e-6)


def test_a_stick_leads_from_the_mark_to_the_echo() -> None:
    answer = make_answer()
    stick = features(answer, "residual")[4]["geometry"]["coordinates"]
    mark, target = features(answer, "mark")[4], features(answer, "target")[4]
    for end, thing in zip(stick, (mark, target), strict=True):
        there = Position(*reversed(thing["geometry"]["coordinates"]))
        assert inverse(Position(*reversed(end)), there)[0] < 1.0


def test_the_ring_of_an_ellipse_has_its_axes() -> None:
    ring = ellipse_ring(OSLO, Ellipse(400.0, 100.0, 30.0, 0.95))
    distances = [inverse(OSLO, corner) for corner in ring]
    longest = max(distances)
    assert longest[0] == pytest.approx(400.0, abs=1e-6)
    assert longest[1] % 180.0 == pytest.approx(30.0, abs=1e-6)
    assert min(distances)[0] == pytest.approx(100.0, abs=1e-6)


def test_an_ellipse_across_180_east_is_cut_in_two() -> None:
    ring = [(p.lon_deg, p.lat_deg) for p in ellipse_ring(DATE_LINE, Ellipse(400.0, 300.0, 80.0, 0.95))]
    geometry = _area(ring)
    assert geometry["type"] == "MultiPolygon"
    east, west = sorted(rings_of(geometry), key=lambda part: -part[0][0])
    assert max(p[0] for p in east) == 180.0
    assert min(p[0] for p in west) == -180.0
    assert max(abs(p[0]) for p in east + west) - min(abs(p[0]) for p in east + west) < 0.01
    shifted = [((lon - 90.0 + 180.0) % 360.0 - 180.0, lat) for lon, lat in ring]
    whole = area_of([list(point) for point in shifted])
    assert area_of(east) + area_of(west) == pytest.approx(whole, rel=1e-6)


def test_an_ellipse_around_a_pole_reaches_the_pole() -> None:
    ring = [(p.lon_deg, p.lat_deg) for p in ellipse_ring(Position(89.9999, 12.0), Ellipse(400.0, 300.0, 80.0, 0.95))]
    rings = rings_of(_area(ring))
    points = [point for part in rings for point in part]
    assert max(lat for _, lat in points) == 90.0
    assert min(lon for lon, _ in points) == -180.0
    assert max(lon for lon, _ in points) == 180.0
    assert all(area_of(part) > 0.0 for part in rings)


def test_a_heading_line_across_180_east_is_cut_at_the_same_latitude() -> None:
    geometry = _line([(179.9, 10.0), (-179.8, 13.0)])
    assert geometry["type"] == "MultiLineString"
    (_, end), (start, _) = geometry["coordinates"]
    assert (end[0], start[0]) == (180.0, -180.0)
    assert end[1] == start[1] == pytest.approx(11.0)
    assert _line([(10.0, 1.0), (11.0, 1.0)])["type"] == "LineString"


def test_the_heading_line_points_along_the_heading() -> None:
    answer = make_answer()
    assert answer.fix is not None
    start, end = features(answer, "heading line")[0]["geometry"]["coordinates"]
    azimuth_deg = inverse(Position(*reversed(start)), Position(*reversed(end)))[1]
    assert azimuth_deg == pytest.approx(answer.fix.heading_deg, abs=1e-6)


def test_no_fix_shows_every_place_that_fits() -> None:
    assert len(features(make_no_fix(), "alternative")) == 14
    assert features(make_no_fix(), "own ship")[0]["geometry"] is None


def test_a_plane_fix_has_no_geojson() -> None:
    with pytest.raises(InputError, match="plane frame"):
        answer_to_geojson(Answer(epoch=None, fix=make_plane_fix()))


def test_direct_and_ring_agree_on_direction() -> None:
    ellipse = Ellipse(500.0, 200.0, 0.0, 0.95)
    north = direct(OSLO, 0.0, 500.0)
    assert ellipse_ring(OSLO, ellipse)[0].lat_deg == pytest.approx(north.lat_deg, abs=1e-12)
    assert math.isclose(ellipse_ring(OSLO, ellipse)[0].lon_deg, OSLO.lon_deg, abs_tol=1e-9)
