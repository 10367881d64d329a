"""One epoch from end to end: what stands beside the fix, and what happens when a part of it fails."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from navfix import pipeline
from navfix.geodesy import direct, inverse
from navfix.nmea.records import AisPosition, TargetReport
from navfix.picture import epochs
from navfix.report.fix_json import answer_to_dict
from navfix.report.text import report_text
from navfix.types import Epoch, HeadingHint, Mark, Position, RadarTarget

OWN, HEADING_DEG = Position(54.4, 12.1), 33.0


def _epoch(own: Position = OWN, *, shifted: int = 0, compass_off_deg: float | None = None, count: int = 16) -> Epoch:
    """Return an epoch of ``count`` buoys seen by radar, the first of them ``shifted`` alike by 1500 m along 077 deg.

    With ``compass_off_deg`` the bearings are true, by a compass that is so much off.
    """
    rng = np.random.default_rng(7)
    targets, marks = [], []
    for index in range(count):
        place = direct(own, float(rng.uniform(0.0, 360.0)), float(rng.uniform(1000.0, 11000.0)))
        range_m, azimuth_deg = inverse(own, place)
        turn_deg = -HEADING_DEG if compass_off_deg is None else compass_off_deg
        targets.append(
            RadarTarget(
                f"{index + 1:02d}",
                range_m + float(rng.normal(0.0, 20.0)),
                azimuth_deg + turn_deg + float(rng.normal(0.0, 0.5)),
                "relative" if compass_off_deg is None else "true",
            )
        )
        claimed = direct(place, 77.0, 1500.0) if index < shifted else place
        marks.append(Mark(f"B{index + 1}", claimed, 10.0, "aton"))
    return Epoch(None, tuple(targets), tuple(marks))


def test_a_compass_that_the_echoes_refute_is_a_caution_above_the_residuals() -> None:
    wrong = replace(_epoch(), heading_hint=HeadingHint(HEADING_DEG + 90.0, 1.5))
    answer = pipeline.answer(wrong)
    assert answer.fix is not None
    assert inverse(OWN, answer.fix.position)[0] < 50.0  # type: ignore[arg-type]
    assert len(answer.cautions) == 1
    assert re.fullmatch(
        r"Check the compass: the heading in the log, 123.0°, is \+(89|90)\.\d° off.", answer.cautions[0]
    )
    text = report_text(answer)
    assert text.index("CAUTION         Check the compass") < text.index("How sure")
    assert answer.cautions[0] in answer_to_dict(answer)["notes"]


def test_a_compass_that_is_right_needs_no_caution() -> None:
    answer = pipeline.answer(replace(_epoch(), heading_hint=HeadingHint(HEADING_DEG + 2.0, 1.5)))
    assert answer.cautions == ()
    assert "differs by +2." in answer.notes[0] or "differs by +1." in answer.notes[0]


@pytest.mark.parametrize("off_deg", [3.0, 20.0])
def test_true_bearings_of_a_wrong_compass_are_a_caution_and_the_place_holds(off_deg: float) -> None:
    answer = pipeline.answer(_epoch(compass_off_deg=off_deg))
    assert len(answer.cautions) == 1
    assert "true bearings of the radar" in answer.cautions[0]
    assert "CAUTION" in report_text(answer)
    assert answer.fix is not None
    assert inverse(OWN, answer.fix.position)[0] < 50.0  # type: ignore[arg-type]


def test_true_bearings_of_a_good_compass_need_no_caution() -> None:
    answer = pipeline.answer(_epoch(compass_off_deg=0.3))
    assert answer.fix is not None
    assert answer.cautions == ()


def test_a_plain_mean_that_fails_near_the_pole_does_not_take_the_fix_with_it() -> None:
    pole = Position(89.999, 60.0)
    answer = pipeline.answer(_epoch(pole))
    assert answer.fix is not None
    assert inverse(pole, answer.fix.position)[0] < 50.0  # type: ignore[arg-type]
    assert answer.plain_mean is None
    assert answer_to_dict(answer)["plain_mean"] is None


def test_a_spoofed_majority_is_told_with_the_place_that_the_others_show() -> None:
    answer = pipeline.answer(_epoch(shifted=10))
    assert answer.fix is not None
    group = answer.fix.association.second_group  # type: ignore[union-attr]
    assert group is not None
    other = direct(answer.fix.position, group.azimuth_deg, group.offset_m)  # type: ignore[arg-type]
    assert inverse(OWN, other)[0] < 60.0
    assert "If it is that of the fix, own ship lies as far off, the same way" in " ".join(report_text(answer).split())


def test_every_step_is_timed_with_a_fix_and_without() -> None:
    records = [
        record
        for turn in range(3)
        for number in range(4)
        for record in (
            TargetReport(1e9 + 2.5 * turn, number, 3000.0 + 500.0 * number, 40.0 * number, "relative"),
            AisPosition(1e9 + 2.5 * turn, 211000000 + number, 1, "ship", 54.4 + 0.01 * number**2, 12.1, ais_class="A"),
        )
    ]
    (epoch,) = epochs(records, last=True)
    timing_ms = answer_to_dict(pipeline.answer(epoch))["timing_ms"]
    assert timing_ms["epoch"] > 0.0
    assert timing_ms["associate"] > 0.0
    fixed_ms = answer_to_dict(pipeline.answer(_epoch()))["timing_ms"]
    assert fixed_ms["epoch"] is None  # made by hand
    assert fixed_ms["associate"] > 0.0
    assert fixed_ms["adjust"] > 0.0
