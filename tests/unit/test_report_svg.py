"""The picture: valid XML, a georeference that is true, everything drawn, labels that do not overlap."""

from __future__ import annotations

import math
from dataclasses import replace
from xml.etree import ElementTree as ET

import pytest

from navfix.geodesy import inverse
from navfix.report import Answer
from navfix.report.drawing.georeference import NAMESPACE
from navfix.report.drawing.labels import Labels
from navfix.report.drawing.view import Box, nice, view_of
from navfix.report.svg import svg_text
from navfix.types import Position
from tests.factories import every_fix, every_no_fix, make_answer, make_fix, make_no_fix, make_plane_fix

SVG = "{http://www.w3.org/2000/svg}"
GEO = f"{{{NAMESPACE}}}"
EVERY = every_fix() | every_no_fix() | {"plane": Answer(epoch=None, fix=make_plane_fix())}


def drawn(answer: Answer) -> ET.Element:
    """Return the parsed picture."""
    return ET.fromstring(svg_text(answer))


def group(root: ET.Element, name: str) -> ET.Element:
    """Return the group with an id."""
    found = root.find(f".//{SVG}g[@id='{name}']")
    assert found is not None
    return found


@pytest.mark.parametrize("name", list(EVERY))
def test_every_picture_is_xml_with_a_georeference(name: str) -> None:
    text = svg_text(EVERY[name])
    root = ET.fromstring(text)
    assert root.tag == f"{SVG}svg"
    reference = root.find(f"{SVG}metadata/{GEO}georeference")
    assert reference is not None
    assert float(reference.attrib["metresPerUnit"]) > 0.0
    assert len(reference.findall(f"{GEO}corner")) == 4
    numbers = {value.strip() for element in root.iter() for value in element.attrib.values()}
    assert not numbers & {"nan", "inf", "-inf", "None"}


@pytest.mark.parametrize("name", ["full", "date_line", "arctic"])
def test_the_corners_lie_where_the_georeference_says(name: str) -> None:
    answer = EVERY[name]
    assert answer.fix is not None
    assert isinstance(answer.fix.position, Position)
    reference = drawn(answer).find(f"{SVG}metadata/{GEO}georeference")
    assert reference is not None
    origin = reference.find(f"{GEO}origin")
    assert origin is not None
    scale = float(reference.attrib["metresPerUnit"])
    for corner in reference.findall(f"{GEO}corner"):
        east_m = (float(corner.attrib["x"]) - float(origin.attrib["x"])) * scale
        north_m = (float(origin.attrib["y"]) - float(corner.attrib["y"])) * scale
        place = Position(float(corner.attrib["lat_deg"]), float(corner.attrib["lon_deg"]))
        distance_m, azimuth_deg = inverse(answer.fix.position, place)
        assert distance_m == pytest.approx(math.hypot(north_m, east_m), abs=0.01)
        assert azimuth_deg == pytest.approx(math.degrees(math.atan2(east_m, north_m)) % 360.0, abs=1e-4)


def test_everything_is_drawn() -> None:
    root = drawn(make_answer())
    assert len(group(root, "targets")) == 20
    assert len(group(root, "marks")) >= 17
    sticks = group(root, "residuals")
    assert len([s for s in sticks.findall(f"{SVG}path") if "stroke-dasharray" in s.attrib]) == 1
    assert len(sticks.findall(f"{SVG}path")) == 17
    for name in ("own-ship", "ellipses", "north-arrow", "legend", "title", "inset", "range-rings", "graticule"):
        group(root, name)
    assert len(group(root, "ellipses")) == 2
    assert len(group(root, "places")) == 3


def test_the_heading_line_turns_with_the_heading() -> None:
    line = drawn(make_answer()).find(f".//{SVG}path[@id='heading-line']")
    assert line is not None
    assert line.attrib["transform"].startswith("rotate(123.460 ")


def test_echoes_are_transparent_and_the_background_can_be() -> None:
    root = drawn(make_answer())
    assert all(0.0 < float(echo.attrib["fill-opacity"]) < 1.0 for echo in group(root, "targets"))
    assert root.find(f".//{SVG}rect[@id='paper']") is not None
    assert ET.fromstring(svg_text(make_answer(), paper=False)).find(f".//{SVG}rect[@id='paper']") is None


def test_title_and_legend_say_position_time_and_stick_factor() -> None:
    text = svg_text(make_answer())
    assert "59°24.1241' N" in text
    assert "2026-03-04 05:06:07.2 UTC" in text
    assert "residual × 10" in text
    assert "05 NORDIC QUEEN: 581 m off" in text


def test_no_fix_shows_the_radar_head_up_with_the_reason() -> None:
    root = drawn(make_no_fix())
    assert len(group(root, "targets")) == 20
    text = svg_text(make_no_fix())
    assert "NO FIX · more than one place explains the data" in text
    assert "zero mark" in text
    assert "place is unknown" in text


def test_a_large_ellipse_needs_no_magnifier() -> None:
    fix = make_fix()
    wide = replace(fix, covariance=1e4 * fix.covariance)
    assert drawn(Answer(epoch=fix.epoch, fix=wide)).find(f".//{SVG}g[@id='inset']") is None


def test_names_are_escaped_and_lose_control_characters() -> None:
    answer = make_answer()
    assert answer.fix is not None
    assert answer.epoch is not None
    epoch = replace(answer.epoch, marks=tuple(replace(mark, name='<"&\x00\x1b>') for mark in answer.epoch.marks))
    shown = "".join(drawn(Answer(epoch=epoch, fix=replace(answer.fix, epoch=epoch))).itertext())
    assert '<"&  >' in shown


def test_labels_keep_clear_of_each_other_and_stay_inside() -> None:
    inside, parent = Box(0.0, 0.0, 400.0, 400.0), ET.Element("g")
    labels = Labels(inside)
    written = [labels.put(parent, 200.0 + 3.0 * i, 200.0, f"LABEL {i}") for i in range(30)]
    assert True in written
    assert False in written  # thirty labels do not fit around one point: some are left out
    boxes = labels._taken
    assert all(inside.contains(box) for box in boxes)
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])
    assert labels.put(parent, 201.0, 200.0, "MUST", must=True)


def test_the_view_holds_every_point_with_its_margin() -> None:
    points = [(0.0, 0.0), (900.0, -300.0), (-50.0, 4000.0)]
    view = view_of(points, Box(0.0, 0.0, 1000.0, 800.0), margin=50.0, smallest_m=1.0)
    assert all(view.box.holds(*view.point(*point), 49.999) for point in points)
    assert view.metres(*view.point(123.0, 456.0)) == pytest.approx((123.0, 456.0))


@pytest.mark.parametrize(
    ("value", "expected"), [(7.3, 5.0), (1.0, 1.0), (0.021, 0.02), (199.0, 100.0), (2000.0, 2000.0)]
)
def test_nice_numbers_are_1_2_5(value: float, expected: float) -> None:
    assert nice(value) == pytest.approx(expected)
