"""The report that a navigator reads."""

from __future__ import annotations

from dataclasses import replace

import pytest

from navfix.errors import InputError, TooFewPairs
from navfix.report import Answer
from navfix.report.outliers import outlier_words
from navfix.report.rows import pair_rows
from navfix.report.tables import number
from navfix.report.text import report_text
from navfix.report.words import degrees_minutes, odds, plural
from navfix.types import GnssVerdict, Position
from tests.factories import OSLO, every_fix, every_no_fix, make_answer, make_fix, make_no_fix, make_plane_fix

EVERY = every_fix() | every_no_fix() | {"plane": Answer(epoch=None, fix=make_plane_fix())}


@pytest.mark.parametrize("name", list(EVERY))
def test_no_line_is_wider_than_100_columns(name: str) -> None:
    text = report_text(EVERY[name])
    assert max(len(line) for line in text.splitlines()) <= 100
    assert "nan" not in text.lower().split()
    assert text.endswith("\n")
    assert all(line == line.rstrip() for line in text.splitlines())


def test_the_first_lines_say_what_is_needed_first() -> None:
    lines = report_text(make_answer()).splitlines()
    assert lines[0].startswith("FIX ")
    assert "2026-03-04 05:06:07.2 UTC" in lines[0]
    assert lines[2] == "Position        59°24.1241' N   010°35.2359' E"
    assert "59.40206890   10.58726479" in lines[3]
    assert lines[4].startswith("Heading         123.5° +- 0.24° (95 %)")
    assert "zero mark" in lines[4]
    assert lines[5].startswith("Ellipse 95 %    23.1 m x 13.3 m")
    assert lines[6].startswith("R95             18.3 m   protection level 61.0 m")
    assert "at most 2 in a million that this is another place" in lines[7]
    assert "147 m from the fix along 049°" in lines[8]
    assert lines[9].startswith("GNSS            UNSAFE: 1481 m from the fix")


def test_the_outlier_is_named_with_its_distance_and_direction() -> None:
    fix = make_fix()
    row = next(row for row in pair_rows(fix) if row.outlier)
    # The mark was moved by 640 m along 045 deg; range and bearing noise of the echo change what is seen of it.
    assert row.offset_m == pytest.approx(640.0, abs=100.0)
    assert row.offset_azimuth_deg == pytest.approx(45.0, abs=8.0)
    assert outlier_words(row) == "target 05 / NORDIC QUEEN (257000104): AIS position about 580 m off along 048°"
    assert f"OUTLIER: {outlier_words(row)}" in report_text(Answer(epoch=fix.epoch, fix=fix))


def test_every_pair_has_its_line_and_outliers_a_star() -> None:
    lines = report_text(make_answer()).splitlines()
    table = [line for line in lines if line[2:4].isdigit() and line[:2] in ("  ", "* ")]
    assert len(table) == 17
    assert [line[2:4] for line in table if line.startswith("*")] == ["05"]
    assert table[0].split() == [
        "01", "257000100", "8552.4", "-22.2", "-1.1", "0.91", "1.00", "101.59R", "-0.01", "+0.0", "0.91", "1.00",
    ]  # fmt: skip


def test_a_large_residual_without_a_kernel_is_called_suspect() -> None:
    fix = make_fix()
    plain = replace(fix, kernel="none", observations=tuple(replace(o, weight=1.0) for o in fix.observations))
    text = report_text(Answer(epoch=fix.epoch, fix=plain))
    assert "SUSPECT: target 05" in text
    assert "OUTLIER" not in text


def test_targets_without_a_mark_are_listed() -> None:
    assert "Targets without a mark (3): 18 at 2.26 NM 202.1° R" in report_text(make_answer())


def test_no_fix_says_why_and_what_helps() -> None:
    text = report_text(make_no_fix())
    assert text.startswith("NO FIX ")
    assert "14 places explain the data nearly as well" in text
    assert "14 places fit" in text
    assert "and 4 more" in text
    assert "gyro heading" in text
    assert text.count("heading 0") + text.count("heading 1") + text.count("heading 2") + text.count("heading 3") == 10


def test_a_gnss_that_is_not_there_is_not_judged() -> None:
    gnss = GnssVerdict(OSLO, 0.0, "not_available", 0.0, 0.0, ("no GNSS in the log",))
    assert "GNSS            NOT AVAILABLE; no GNSS in the log" in report_text(make_answer(gnss=gnss))


def test_names_from_the_air_bring_no_control_characters() -> None:
    answer = make_answer()
    assert answer.fix is not None
    assert answer.epoch is not None
    marks = tuple(replace(mark, name="EVIL\x1b[2J\nNAME") for mark in answer.epoch.marks)
    epoch = replace(answer.epoch, marks=marks)
    text = report_text(Answer(epoch=epoch, fix=replace(answer.fix, epoch=epoch)))
    assert "\x1b" not in text
    assert "EVIL [2J NAME" in text


def test_the_report_is_the_same_every_time() -> None:
    assert report_text(make_answer()) == report_text(make_answer())


@pytest.mark.parametrize(
    ("probability", "words"),
    [
        (2e-6, "at most 2 in a million"),
        (1e-4, "at most 1 in ten thousand"),
        (2.34e-4, "at most 3 in ten thousand"),
        (2.34e-5, "at most 24 in a million"),
        (0.0017, "at most 2 in a thousand"),
        (0.25, "at most 25 in a hundred"),
        (0.999, "at most 99 in a hundred"),
        (3e-8, "at most 30 in a billion"),
        (0.0, "less than 1 in a million million"),
    ],
)
def test_odds_in_words(probability: float, words: str) -> None:
    assert odds(probability) == words


@pytest.mark.parametrize(
    ("position", "expected"),
    [
        (Position(59.5, -0.25), ("59°30.0000' N", "000°15.0000' W")),
        (Position(-0.9999999999, 179.9999999999), ("01°00.0000' S", "180°00.0000' E")),
        (Position(0.0, 0.0), ("00°00.0000' N", "000°00.0000' E")),
    ],
)
def test_degrees_and_minutes_carry_over(position: Position, expected: tuple[str, str]) -> None:
    assert degrees_minutes(position) == expected


@pytest.mark.parametrize("value", [0.04, -12.345, 99999.9, -123456.7, 1e12, -4e-9])
def test_a_number_never_bursts_its_column(value: float) -> None:
    assert len(number(value, 7, 1, sign=True)) <= 7


def test_an_answer_is_a_fix_or_an_error() -> None:
    with pytest.raises(InputError, match="exactly one"):
        Answer(epoch=None)
    with pytest.raises(InputError, match="exactly one"):
        Answer(epoch=None, fix=make_fix(), error=TooFewPairs("none", observations=0, unknowns=3))


def test_one_is_not_many() -> None:
    assert [plural(count, "fix") for count in range(3)] == ["0 fixes", "1 fix", "2 fixes"]
    assert plural(1, "scan") == "1 scan"
