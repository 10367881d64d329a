"""Chart files: CSV and GeoJSON under the names of many sources, what is passed over, objects in one place, sigmas."""

from __future__ import annotations

import json
import logging
import math
from pathlib import Path

import pytest

from navfix.catalog import chart_model
from navfix.chart import Chart, marks, read_chart, read_charts
from navfix.chart.marks import watch_circle_m
from navfix.errors import InputError
from navfix.types import Position

MODEL = chart_model()


def chart_of(tmp_path: Path, text: str, name: str = "c.csv") -> Chart:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return read_chart(path)


def feature(lon: float, lat: float, **properties: object) -> dict[str, object]:
    return {"type": "Feature", "geometry": {"type": "Point", "coordinates": [lon, lat]}, "properties": properties}


def geojson_of(tmp_path: Path, *features: object) -> Chart:
    text = json.dumps({"type": "FeatureCollection", "features": features})
    return chart_of(tmp_path, text, "c.geojson")


def test_every_column_of_the_contract_is_read(tmp_path: Path) -> None:
    header = "label,lat,lon,kind,type,sigma_m,depth_m,name,mmsi"
    chart = chart_of(tmp_path, f"{header}\nB1,54.1,7.2,floating,BOYLAT,12.5,18,Buoy 1,992001001\n")
    (item,) = chart.objects
    assert (item.label, item.position, item.kind) == ("B1", Position(54.1, 7.2), "floating")
    assert (item.chart_class.code, item.sigma_m, item.depth_m, item.name) == ("BOYLAT", 12.5, 18.0, "Buoy 1")
    assert (item.mmsi, item.line, chart.counts) == (992001001, 2, {"BOYLAT": 1})
    (mark,) = marks(chart.objects)
    assert (mark.kind, mark.sigma_m, mark.mmsi, mark.name) == ("charted", 12.5, 992001001, "Buoy 1")


@pytest.mark.parametrize(
    ("lat", "lon", "expected"),
    [
        ("54.5", "-7.25", (54.5, -7.25)),
        ("54-30.0N", "007-15.0W", (54.5, -7.25)),
        ("54°30'00\"N", "7°15'0\"W", (54.5, -7.25)),
        ("33 55.2 S", "18 24 E", (-33.92, 18.4)),
        ("-0-30.0", "0.0", (-0.5, 0.0)),
    ],
)
def test_positions_are_decimal_degrees_or_degrees_and_minutes(
    tmp_path: Path, lat: str, lon: str, expected: tuple[float, float]
) -> None:
    chart = chart_of(tmp_path, f"Latitude;Longitude\n{lat.replace(chr(34), '″')};{lon.replace(chr(34), '″')}\n")
    place = chart.objects[0].position
    assert (place.lat_deg, place.lon_deg) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_the_delimiter_is_told_by_the_header_and_comments_are_skipped(tmp_path: Path, delimiter: str) -> None:
    rows = [["lat", "lon", "name"], ["54.1", "7.2", "A"], ["54.2", "7.3", "B"]]
    text = "# from a list\n\n" + "\n".join(delimiter.join(row) for row in rows) + "\n# end\n"
    assert [item.name for item in chart_of(tmp_path, "\ufeff" + text).objects] == ["A", "B"]


def test_bad_rows_are_counted_told_once_and_survived(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rows = ["54.1,7.2,", "91,7.2,", "95,7,", "x,7,", ",7,", "54.1,7.3,-5", "54.1,7.4,nan", "54.2,7.2,,extra", "54.3,7"]
    with caplog.at_level(logging.WARNING, logger="navfix"):
        chart = chart_of(tmp_path, "lat,lon,sigma_m\n" + "\n".join(rows) + "\n")
    assert len(chart.objects) == 2
    assert {p.reason: (p.count, p.line) for p in chart.passed_over} == {
        "position out of range": (2, 3),
        "position is no number": (1, 5),
        "no position": (1, 6),
        "sigma_m must be >= 0": (2, 7),
        "more cells than columns": (1, 9),
    }
    assert len(caplog.records) == 5
    assert "c.csv: 2 passed over: position out of range, first in 3" in caplog.text


@pytest.mark.parametrize(
    ("name", "text", "message", "line"),
    [
        ("c.csv", "", "is empty", None),
        ("c.csv", "name,east\nA,1\n", "no column for lat", 1),
        ("c.csv", "lat,lon\n95,7\n", "no charted object in it", None),
        ("c.geojson", '{"type": \n "FeatureCollection",,}', "not JSON", 2),
        ("c.geojson", '{"type": "Topology"}', "expected a FeatureCollection, got 'Topology'", None),
        ("c.geojson", "[1, 2]", "expected a FeatureCollection, got 'list'", None),
        ("c.geojson", "[" * 100_000, "not", None),
        ("c.shp", "x", r"unknown format \.shp", None),
        ("c.001", "x", "is an update; name the cell itself", None),
    ],
)
def test_a_file_that_is_no_chart_is_named_with_its_line(
    tmp_path: Path, name: str, text: str, message: str, line: int | None
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        chart_of(tmp_path, text, name)
    assert name in str(caught.value)
    assert caught.value.line == line


def test_missing_files_and_directories_are_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_chart(tmp_path / "none.csv")
    with pytest.raises(InputError, match="is a directory"):
        read_chart(tmp_path)


def test_names_of_other_sources_are_understood(tmp_path: Path) -> None:
    chart = geojson_of(
        tmp_path,
        feature(7.0, 54.0, **{"seamark:type": "buoy_lateral", "seamark:name": "Osm 1"}),
        feature(7.1, 54.0, **{"seamark:type": "beacon_cardinal", "@id": "node/7"}),
        feature(7.2, 54.0, OBJL=17, OBJNAM="Enc 1", CATLAM=1),
        feature(7.3, 54.0, BOYSHP=2, CATLAM=2, OBJNAM="Enc 2"),
        feature(7.4, 54.0, BCNSHP=1, OBJNAM="Enc 3"),
        feature(7.5, 54.0, tags={"seamark:type": "light_major", "seamark:name": "Tower"}),
        feature(7.6, 54.0, type="wind turbine", name="T 1"),
        feature(7.7, 54.0, **{"seamark:type": "mooring", "seamark:mooring:category": "buoy"}),
        feature(7.8, 54.0, **{"seamark:type": "mooring", "seamark:mooring:category": "dolphin"}),
        feature(7.9, 54.0),
    )
    found = [(item.name or item.label, item.chart_class.code, item.kind) for item in chart.objects]
    assert found == [
        ("Osm 1", "BOYLAT", "floating"),
        ("node/7", "BCNCAR", "fixed"),
        ("Enc 1", "BOYLAT", "floating"),
        ("Enc 2", "BOYLAT", "floating"),
        ("Enc 3", "BCNSPP", "fixed"),
        ("Tower", "LIGHTS", "fixed"),
        ("T 1", "", "fixed"),
        ("chart:8", "MORFAC", "floating"),
        ("chart:9", "MORFAC", "fixed"),
        ("chart:10", "", "floating"),
    ]


def test_what_is_no_mark_is_passed_over_without_a_warning(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, logger="navfix"):
        chart = geojson_of(
            tmp_path,
            feature(7.0, 54.0, type="buoy"),
            feature(7.1, 54.0, **{"seamark:type": "harbour"}),
            feature(7.2, 54.0, **{"seamark:type": "virtual_aton"}),
            feature(7.3, 54.0, **{"seamark:type": "landmark"}),
            feature(7.4, 54.0, **{"seamark:type": "fog_signal"}),
        )
    assert not caplog.records
    assert [p.reason for p in chart.passed_over] == ["type is no mark"]
    assert [mark.label for mark in marks(chart.objects)] == ["chart:1"]
    assert [mark.label for mark in marks(chart.objects, land=True)] == ["chart:1", "chart:4"]


def test_areas_and_lines_are_marks_where_they_are_small(tmp_path: Path) -> None:
    def square(size_deg: float) -> dict[str, object]:
        ring = [[7.0, 54.0], [7.0 + size_deg, 54.0], [7.0 + size_deg, 54.0 + size_deg], [7.0, 54.0]]
        return {
            "type": "Feature",
            "geometry": {"type": "Polygon", "coordinates": [ring]},
            "properties": {"type": "OFSPLF"},
        }

    bad = {"type": "Feature", "geometry": {"type": "Point", "coordinates": ["a"]}, "properties": {}}
    none = {"type": "Feature", "geometry": None, "properties": {"type": "buoy"}}
    chart = geojson_of(tmp_path, square(0.0005), square(0.1), bad, none, 17)
    (platform,) = chart.objects
    assert 20.0 < platform.extent_m < 60.0
    assert marks([platform])[0].sigma_m == pytest.approx(math.hypot(MODEL.fixed_sigma_m, platform.extent_m / 2.0))
    assert [p.reason for p in chart.passed_over] == ["too large for a mark", "no position", "no geometry", "no feature"]


def test_a_light_and_a_daymark_are_merged_into_their_carrier(tmp_path: Path) -> None:
    chart = geojson_of(
        tmp_path,
        feature(7.0, 54.0, type="LIGHTS", name="Light of 1"),
        feature(7.0, 54.0, type="BOYLAT"),
        feature(7.0, 54.00001, type="TOPMAR"),
        feature(7.1, 54.0, type="LIGHTS", name="Alone"),
        feature(7.2, 54.0, type="BCNLAT", name="B"),
        feature(7.2, 54.0, type="DAYMAR"),
        feature(7.2, 54.0, type="LNDMRK"),
    )
    found = [(item.name, item.chart_class.code, item.kind, item.equipment) for item in chart.objects]
    assert found == [
        ("Light of 1", "BOYLAT", "floating", ("LIGHTS", "TOPMAR")),
        ("Alone", "LIGHTS", "fixed", ()),
        ("B", "BCNLAT", "fixed", ("DAYMAR", "LNDMRK")),
    ]
    assert sum(chart.counts.values()) == 7


def test_two_buoys_with_their_own_mmsi_in_one_place_stay_two(tmp_path: Path) -> None:
    chart = chart_of(tmp_path, "lat,lon,type,mmsi\n54,7,buoy,992001001\n54,7,buoy,992001002\n")
    assert len(chart.objects) == 2
    labels = [mark.label for mark in marks(chart.objects)]
    assert len(set(labels)) == 2


def test_labels_are_unique_and_never_an_mmsi(tmp_path: Path) -> None:
    chart = chart_of(tmp_path, "label,lat,lon\nA,54,7\nA,54,7.1\n992001001,54,7.2\n")
    assert [mark.label for mark in marks(chart.objects)] == ["A", "A #2", "chart:992001001"]


def test_an_object_of_two_charts_is_taken_once(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("lat,lon,type,mmsi\n54,7,buoy,992001001\n54.1,7,buoy,\n")
    (tmp_path / "b.csv").write_text("lat,lon,type,mmsi\n54.3,7,buoy,992001001\n54.10001,7,buoy,\n54.2,7,pile,\n")
    chart = read_charts([tmp_path / "a.csv", tmp_path / "b.csv"])
    assert [(o.position.lat_deg, o.kind) for o in chart.objects] == [
        (54.0, "floating"),
        (54.1, "floating"),
        (54.2, "fixed"),
    ]


def test_tags_that_other_sources_use_for_something_else_do_no_harm(tmp_path: Path) -> None:
    tags = {"seamark:type": "buoy_lateral", "mooring": "yes", "layer": 1, "MMSI": 0, "seamark": {"a": 1}}
    (item,) = geojson_of(tmp_path, feature(7.0, 54.0, **tags)).objects
    assert (item.chart_class.code, item.kind, item.mmsi) == ("BOYLAT", "floating", None)


def test_a_floating_mark_has_its_watch_circle_and_a_fixed_one_is_tight(tmp_path: Path) -> None:
    chart = chart_of(tmp_path, "lat,lon,type,depth_m\n54,7,buoy,10\n54,7.1,buoy,\n54,7.2,beacon,\n54,7.3,buoy,500\n")
    shallow, unknown, fixed, deep = (mark.sigma_m for mark in marks(chart.objects))
    # 12 m of water on 36 m of chain: a circle of sqrt(36^2 - 12^2) = 33.94 m, half of it the sigma of a uniform disc
    assert watch_circle_m(10.0, MODEL) == pytest.approx(33.94, abs=0.01)
    assert shallow == pytest.approx(math.hypot(33.94 / 2.0, 8.0), abs=0.01)
    assert unknown > shallow > fixed == MODEL.fixed_sigma_m
    assert deep == pytest.approx(math.hypot(watch_circle_m(MODEL.largest_depth_m, MODEL) / 2.0, 8.0))


def test_the_sigma_of_a_uniform_disc_is_half_its_radius() -> None:
    import numpy as np

    rng = np.random.default_rng(3)
    radius = np.sqrt(rng.uniform(size=200_000))
    angle = rng.uniform(0.0, 2.0 * np.pi, 200_000)
    assert np.std(radius * np.cos(angle)) == pytest.approx(0.5, abs=0.005)
