"""Plots from CSV: columns and units by the words of the header, bad rows counted and survived."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navfix.errors import InputError
from navfix.nmea.plots import RadarPlot, parse_plots, read_plots

HEADER = "unix,range_m,bearing_deg"


def test_columns_are_found_by_name_and_extra_ones_passed_over() -> None:
    found = parse_plots(["var_range_m2,bearing_deg,note,unix,range_m", "9,45.5,x,1000.25,1852"])
    assert found.plots == (RadarPlot(1000.25, 1852.0, 45.5),)
    assert found.reference == "relative"
    assert found.bad_rows == ()


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("time_utc;Range [NM];Bearing (deg)", "2026-03-01T00:00:10Z;0.5;90"),
        ("timestamp_ms\trange_km\tbearing_rad", "1772323210000\t0.926\t1.5707963267948966"),
        ("UNIX,DISTANCE_M,BRG", "1772323210,926,-270"),
        ("utc,rng,az", "2026-03-01T01:00:10+01:00,926.0,90"),
    ],
)
def test_units_and_times_are_what_the_header_says(header: str, row: str) -> None:
    (plot,) = parse_plots([header, row]).plots
    assert (plot.time_s, plot.range_m) == (1772323210.0, pytest.approx(926.0))
    assert plot.bearing_deg == pytest.approx(90.0)


@pytest.mark.parametrize("name", ["azimuth_deg_northup", "true_bearing_deg", "Bearing true (deg)"])
def test_a_bearing_that_is_called_true_or_north_is_true(name: str) -> None:
    assert parse_plots([f"unix,range_m,{name}", "1,2,3"]).reference == "true"


def test_bad_rows_are_counted_by_reason_and_reported_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rows = [
        "1,100,10",
        "2,-5,10",
        "3,nan,10",
        "x,100,10",
        "4,100",
        "5,100,400",
        "6,100,20",
        "6,100,20",
        "1e99,100,1",
        '"',
    ]
    path = tmp_path / "plots.csv"
    path.write_text("\n".join([HEADER, *rows]))
    with caplog.at_level(logging.WARNING):
        found = read_plots(path)
    assert [plot.time_s for plot in found.plots] == [1.0, 6.0]  # the same plot told twice is one
    assert sum(count for _, count in found.bad_rows) == 7
    assert len(caplog.records) == 1
    assert "range is not a number" in caplog.text


def test_plots_are_sorted_by_time() -> None:
    found = parse_plots([HEADER, "3,1,1", "1,1,1", "2,1,1"])
    assert [plot.time_s for plot in found.plots] == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], "is empty"),
        (["unix,range_m", "1,2"], "missing bearing"),
        (["unix,var_range_m2,bearing_deg", "1,2,3"], "missing range"),
        ([HEADER], "no rows below the header"),
        ([HEADER, "a,b,c"], "not one plot: 1 x time neither"),
    ],
)
def test_what_cannot_be_used_says_why(lines: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_plots(lines)


def test_a_missing_file_and_a_folder_are_input_errors(tmp_path: Path) -> None:
    for path in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(InputError):
            read_plots(path)


@given(st.lists(st.text(max_size=40), max_size=8))
def test_no_text_below_a_header_is_anything_but_plots_or_an_input_error(rows: list[str]) -> None:
    try:
        found = parse_plots([HEADER, *rows])
    except InputError:
        return
    assert all(plot.range_m > 0.0 and 0.0 <= plot.bearing_deg < 360.0 for plot in found.plots)
