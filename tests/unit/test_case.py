"""The case file: what is read, what is refused, and with which words."""

from __future__ import annotations

import json
import logging
from typing import Any

import pytest

from navfix.adjustment.case import case_of, parse_case
from navfix.errors import InputError
from navfix.types import PlanePosition, Position

TOML = """
name = "two ranges and a bearing"
frame = "plane"
start = { north_m = 1.0, east_m = 2.0 }
[[marks]]
label = "A"
north_m = 1000
east_m = 0.0
[[marks]]
label = "B"
north_m = 0.0
east_m = 1000.0
sigma_m = 5.0
[[observations]]
mark = "A"
kind = "range"
value = 1000.0
sigma = 10.0
[[observations]]
mark = "B"
kind = "true_bearing"
value = 90.0
sigma = 0.5
"""


def content(**changes: Any) -> dict[str, Any]:
    table = {
        "frame": "wgs84",
        "marks": [
            {"label": "A", "lat_deg": 54.0, "lon_deg": 179.9},
            {"label": "B", "lat_deg": 54.1, "lon_deg": -179.9},
        ],
        "observations": [
            {"mark": "A", "kind": "range", "value": 5000.0, "sigma": 30.0},
            {"mark": "B", "kind": "relative_bearing", "value": -10.0, "sigma": 0.5},
        ],
        "start": {"lat_deg": 54.05, "lon_deg": 180.0, "heading_deg": 33.0},
    }
    return {key: value for key, value in (table | changes).items() if value is not ...}


def test_toml_is_read() -> None:
    case = parse_case(TOML)
    assert case.name == "two ranges and a bearing"
    assert [mark.label for mark in case.marks] == ["A", "B"]
    assert [mark.sigma_m for mark in case.marks] == [0.0, 5.0]
    assert case.marks[0].position == PlanePosition(1000.0, 0.0)
    assert [(o.mark, o.kind, o.value, o.sigma) for o in case.observations] == [
        ("A", "range", 1000.0, 10.0),
        ("B", "true_bearing", 90.0, 0.5),
    ]
    assert case.start == PlanePosition(1.0, 2.0)
    assert case.heading_deg is None
    assert not case.heading_unknown


def test_json_with_a_byte_order_mark_is_read() -> None:
    case = parse_case("\ufeff" + json.dumps(content()), source="a.json")
    assert case.name == "a.json"
    assert case.start == Position(54.05, 180.0)
    assert case.heading_deg == 33.0
    assert case.heading_unknown


def test_the_heading_may_stand_beside_the_start() -> None:
    start = {"lat_deg": 54.05, "lon_deg": 180.0}
    assert case_of(content(start=start, heading_deg=12.0)).heading_deg == 12.0
    alone = case_of(content(start=..., heading_deg=12.0))
    assert (alone.start, alone.heading_deg) == (None, 12.0)


def test_without_a_start_no_heading_is_needed() -> None:
    case = case_of(content(start=...))
    assert case.start is None
    assert case.heading_deg is None


def test_an_observation_can_be_left_out_and_belong_to_a_named_target() -> None:
    observations = content()["observations"]
    observations[0] |= {"use": False, "target": "echo 7"}
    case = case_of(content(observations=observations))
    assert [o.use for o in case.observations] == [False, True]
    assert [o.target for o in case.observations] == ["echo 7", "B"]


def test_a_key_that_nobody_knows_is_named_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, logger="navfix"):
        case_of(content(start=..., strat={"lat_deg": 54.05}))
    assert "unknown key 'strat'" in caplog.text


MARK = {"label": "A", "lat_deg": 54.0, "lon_deg": 10.0}
RANGE = {"mark": "A", "kind": "range", "value": 5000.0, "sigma": 30.0}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frame": "utm"}, "frame must be one of plane, wgs84, got 'utm'"),
        ({"frame": ...}, "frame must be one of plane, wgs84, got nothing"),
        ({"marks": []}, "marks must be a list of at least one table"),
        ({"marks": {"A": 1}}, "marks must be a list of at least one table"),
        ({"observations": ...}, "observations must be a list"),
        ({"frame": "plane"}, "mark A: north_m is missing; frame 'plane' needs north_m and east_m"),
        ({"marks": [MARK | {"lat_deg": "54N"}]}, "mark A: lat_deg must be a finite number, got '54N'"),
        ({"marks": [MARK | {"lat_deg": True}]}, "mark A: lat_deg must be a finite number, got True"),
        ({"marks": [MARK | {"lat_deg": 91.0}]}, "mark A: lat_deg must be within -90 .. 90, got 91.0"),
        ({"marks": [MARK | {"sigma_m": -1.0}]}, "mark A: sigma_m must be >= 0, got -1"),
        ({"marks": [MARK, MARK]}, "mark 'A' occurs more than once"),
        ({"marks": [MARK | {"label": ""}]}, "mark 1: label must be a name, got ''"),
        ({"observations": [RANGE | {"mark": "Z"}]}, "observation 1: no mark has the label 'Z'; there are A, B"),
        ({"observations": [RANGE | {"kind": "bearing"}]}, "observation 1: kind must be one of range, true_bearing"),
        ({"observations": [RANGE | {"value": 0.0}]}, "observation 1: a range must be > 0 m, got 0"),
        ({"observations": [RANGE | {"value": float("nan")}]}, "observation 1: value must be a finite number, got nan"),
        ({"observations": [RANGE | {"sigma": 0}]}, "observation 1: sigma must be > 0, got 0"),
        ({"observations": [{**RANGE, "sigma": None}]}, "observation 1: sigma must be a finite number, got nothing"),
        ({"observations": [RANGE | {"use": 1}]}, "observation 1: use must be true or false, got 1"),
        ({"start": {"lat_deg": 54.0}}, "start: lon_deg is missing"),
        ({"start": [54.0, 10.0]}, "start must be a table"),
        ({"start": {"lat_deg": 54.0, "lon_deg": 10.0}}, "start: heading_deg is needed when relative bearings occur"),
    ],
)
def test_what_cannot_be_right_is_refused_with_file_and_place(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        case_of(content(**changes), source="case.toml")
    assert f"case.toml: {message}" in str(caught.value)
    assert caught.value.source == "case.toml"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty; expected a case"),
        (" \n", "empty; expected a case"),
        ("$RATTM,01,1.0", "neither JSON nor TOML"),
        ('{"frame": "plane",', "not JSON"),
    ],
)
def test_text_that_is_no_case_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_case(text)


@pytest.mark.parametrize(
    ("where", "value", "said"),
    [("sigma", 1e-300, "sigma must be > 0"), ("value", 1e300, "within"), ("sigma", 1e300, "within")],
)
def test_numbers_whose_squares_would_overflow_are_refused(where: str, value: float, said: str) -> None:
    observation = {"mark": "A", "kind": "range", "value": 10.0, "sigma": 1.0} | {where: value}
    table = {"frame": "plane", "marks": [{"label": "A", "north_m": 0.0, "east_m": 0.0}], "observations": [observation]}
    with pytest.raises(InputError, match=said):
        case_of(table)
