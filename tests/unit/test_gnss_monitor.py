"""The GNSS verdict over epochs: k of n, one alert for each change, silence, windows, and charted marks against AIS."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix import adjust, pipeline
from navfix.errors import InputError, NoAgreement
from navfix.geodesy import LocalPlane
from navfix.integrity import GnssMonitor, gnss_verdict
from navfix.integrity.drift import Difference, ErrorModel, slow_difference
from navfix.integrity.monitor import MonitorSettings
from navfix.report.answer import Answer
from navfix.types import Association, Epoch, Fix, GnssReport, GnssVerdict, Position
from tests.adjustment_scenes import epoch_scene

OWN = Position(54.5, 18.8)
START = datetime(2026, 5, 1, tzinfo=UTC)
SCENE = epoch_scene(np.random.default_rng(4), noise=0.0)


FOUND = adjust(*SCENE)


def fix_at(count: int) -> Fix:
    covariance = np.diag([36.0, 36.0, 1e-4])
    epoch = replace(SCENE[0], time_utc=START + timedelta(seconds=3 * count))
    return replace(
        FOUND, position=OWN, covariance=covariance, covariance_scaling="a_priori", epoch=epoch, global_test=None
    )


def gnss(north_m: float) -> GnssReport:
    return GnssReport(LocalPlane(OWN).to_position(north_m, 0.0), 8.0)


def fed(offsets_m: list[float | None], monitor: GnssMonitor | None = None, *, timed: bool = False) -> list[GnssVerdict]:
    """Feed one epoch for each offset (None: no fix); 10 m sigma together, threshold 37 m."""
    monitor = monitor or GnssMonitor(None if timed else MonitorSettings(windows_s=()))
    verdicts = []
    for count, north_m in enumerate(offsets_m):
        verdict = monitor.feed(None if north_m is None else fix_at(count), gnss(north_m or 0.0))
        assert verdict is not None
        verdicts.append(verdict)
    return verdicts


def test_three_of_five_make_an_alarm_and_five_quiet_ones_end_it() -> None:
    verdicts = fed([0, 0, 60, 0, 60, 0, 60, 0, 0, 0, 0, 0, 0])
    assert [v.verdict for v in verdicts] == ["ok"] * 6 + ["unsafe"] * 5 + ["ok"] * 2
    assert [v.instant for v in verdicts[:4]] == ["ok", "ok", "unsafe", "ok"]


def test_every_change_gives_one_alert() -> None:
    alerts = [v.alert for v in fed([0] * 5 + [60] * 10 + [0] * 10)]
    said = [alert for alert in alerts if alert]
    assert len(said) == 2
    assert said[0].startswith("GNSS ok -> unsafe: 3 of the last 5 comparisons are beyond the threshold")
    assert said[1].startswith("GNSS unsafe -> ok: ")


def test_two_comparisons_at_twice_the_threshold_are_enough() -> None:
    verdicts = fed([0] * 5 + [200] * 3)
    assert [v.verdict for v in verdicts] == ["ok"] * 6 + ["unsafe"] * 2
    assert (verdicts[6].alert or "").startswith("GNSS ok -> unsafe: 2 of the last 5 comparisons, far beyond")
    with pytest.raises(InputError, match="decisive"):
        MonitorSettings(decisive=0.5)


def test_one_bad_comparison_changes_nothing() -> None:
    assert {v.verdict for v in fed([0, 0, 200, 0, 0, 0, 0])} == {"ok"}
    assert fed([200.0])[0].verdict == "caution"


def test_five_in_a_row_just_below_the_threshold_are_a_caution() -> None:
    verdicts = [v.verdict for v in fed([0, *[30.0] * 6, 0, 0, 0])]
    assert verdicts == ["ok"] * 5 + ["caution"] * 4 + ["ok"]


def test_without_fixes_the_verdict_fades_but_an_alarm_stays() -> None:
    quiet = fed([0, 0, *[None] * 6])
    assert [v.verdict for v in quiet] == ["ok"] * 6 + ["not_available"] * 2
    assert [bool(v.alert) for v in quiet].count(True) == 1
    assert math.isnan(quiet[-1].distance_m)
    alarmed = fed([200, 200, 200, *[None] * 8])
    assert [v.verdict for v in alarmed][2:] == ["unsafe"] * 9
    assert "the alarm from before still stands" in alarmed[-1].reasons


def test_an_epoch_without_gnss_has_no_verdict() -> None:
    monitor = GnssMonitor()
    assert monitor.feed(fix_at(0), None) is None
    assert monitor.verdict is None


def test_a_slow_drag_is_found_before_a_single_comparison_could_and_said_in_words() -> None:
    """Five quiet minutes, then 0.2 m/s."""
    drag = fed([max(0.0, 0.2 * 3 * (count - 100)) for count in range(170)], timed=True)
    first = next(v for v in drag if v.verdict == "unsafe")
    assert first.distance_m < first.threshold_m
    assert first.alert is not None
    assert "GNSS leaves the fix at 0.1" in first.alert
    assert "m/s towards 000° over 300 s" in first.alert


def test_the_verdict_says_what_was_checked_over_time() -> None:
    verdicts = fed([0.0] * 6, timed=True)
    assert any(r.startswith("not checked yet: offset and drift") for r in verdicts[0].reasons)
    assert any(r.startswith("checked: over 15 s offset 0 m") for r in verdicts[-1].reasons)
    assert not any("this is one instant" in r for v in verdicts for r in v.reasons)


def test_time_that_runs_back_starts_the_windows_anew() -> None:
    monitor = GnssMonitor()
    fed([0.0] * 6, monitor, timed=True)
    verdict = monitor.feed(fix_at(0), gnss(0.0))
    assert verdict is not None
    assert verdict.drift_mps is None


def test_mean_and_trend_by_hand() -> None:
    """White errors (memory 0): sigma of the trend is sigma / sqrt(sum of squares), of the mean sigma / sqrt(n)."""
    times = np.arange(5.0)
    points = [Difference(t, np.array([3.0 * t, 0.0]), 100.0 * np.eye(2)) for t in times]
    slow = slow_difference(points, ErrorModel(steady_share=0.0, memory_s=1e-6, drift_sigma_mps=0.0), 0.05)
    assert slow is not None
    radius = math.sqrt(-2.0 * math.log(0.05))
    assert (slow.offset_m, slow.drift_mps) == (pytest.approx(6.0), pytest.approx(3.0))
    assert slow.drift_limit_mps == pytest.approx(radius * 10.0 / math.sqrt(10.0))
    assert slow.offset_limit_m == pytest.approx(radius * 10.0 / math.sqrt(5.0))
    assert slow_difference(points[:3], ErrorModel(), 0.05) is None


@pytest.mark.parametrize("settings", [{"needed": 0}, {"needed": 6}, {"slow_probability": 1.0}])
def test_settings_that_cannot_be_right_are_refused(settings: dict[str, float]) -> None:
    with pytest.raises(InputError):
        MonitorSettings(**settings)  # type: ignore[arg-type]


def test_the_answer_of_an_epoch_carries_the_lasting_verdict() -> None:
    monitor = GnssMonitor()
    epoch = replace(SCENE[0], gnss=gnss(0.0), time_utc=START)
    answered = pipeline.watched(Answer(epoch, fix_at(0), gnss=gnss_verdict(fix_at(0), gnss(0.0))), monitor)
    assert answered.gnss is not None
    assert (answered.gnss.verdict, answered.gnss.instant) == ("ok", "ok")
    silent = pipeline.watched(Answer(epoch, error=NoAgreement("nothing", evidence=0.0)), monitor)
    assert silent.gnss is not None
    assert silent.gnss.verdict == "ok"


# ------------------------------------------------------------------------------------------- charted marks against AIS


def charted_scene(charted: int, shift_m: float) -> tuple[Epoch, Association]:
    """Twelve marks, the first few from a chart, the AIS of all the others shifted northwards alike."""
    epoch, association = epoch_scene(np.random.default_rng(9), OWN, marks=12, noise=0.2)
    plane = LocalPlane(OWN)
    marks = []
    for index, mark in enumerate(epoch.marks):
        if index < charted:
            marks.append(replace(mark, kind="charted"))
            continue
        north_m, east_m = plane.to_plane(mark.position)
        marks.append(replace(mark, position=plane.to_position(north_m + shift_m, east_m)))
    return replace(epoch, marks=tuple(marks)), association


def reasons(charted: int, shift_m: float) -> tuple[str, str]:
    epoch, association = charted_scene(charted, shift_m)
    fix = adjust(epoch, association, start=(OWN, 123.4))
    assert isinstance(fix.position, Position)
    verdict = gnss_verdict(fix, GnssReport(fix.position, 8.0))
    return verdict.verdict, " ".join(verdict.reasons)


def test_a_shift_of_all_ais_fits_perfectly_and_the_verdict_says_so() -> None:
    verdict, words = reasons(0, 500.0)
    assert verdict == "ok"
    assert "not checked: an area-wide shift of all AIS positions" in words
    assert "only charted marks, dead reckoning" in words


def test_charted_marks_that_agree_bound_the_shift() -> None:
    verdict, words = reasons(4, 0.0)
    assert verdict == "ok"
    assert "checked: the 4 charted marks alone lie" in words
    assert "would have been noticed" in words


def test_charted_marks_that_disagree_raise_a_doubt() -> None:
    """Small enough to be kept by the kernel, or large enough to be given up as outliers: a caution both times."""
    for shift_m in (120.0, 800.0):
        verdict, words = reasons(5, shift_m)
        assert verdict in ("caution", "unsafe")
        assert "all AIS positions may be shifted alike" in words
