"""The verdict on GNSS: threshold, smallest detectable offset, verdicts and their reasons."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.integrity import gnss_verdict
from navfix.types import (
    AdjustedObservation,
    Association,
    Epoch,
    Fix,
    GlobalTest,
    GnssReport,
    Mark,
    PlanePosition,
    Position,
    SecondGroup,
)

OWN = Position(54.5, 180.0)
MARKS = tuple(Mark(label, OWN, 10.0, kind) for label, kind in (("A", "ship"), ("B", "aton"), ("C", "charted")))


def fix_with(covariance: object, *, dof: float | None = None, redundancy: int = 20, marks: str = "AB") -> Fix:
    observations = tuple(
        AdjustedObservation("T", label, "range", 1.0, 1.0, 0.0, 1.0, 0.0, 0.5, 1.0, None) for label in marks
    )
    return Fix(
        position=OWN,
        heading_deg=10.0,
        covariance=np.asarray(covariance, dtype=np.float64),
        sigma0=1.0,
        redundancy=redundancy,
        observations=observations,
        association=None,
        epoch=Epoch(None, (), MARKS),
        cofactor_matrix=np.asarray(covariance, dtype=np.float64),
        covariance_scaling="a_priori" if dof is None else "a_posteriori",
        dof=20.0 if dof is None else dof,
        kernel="hampel",
    )


def gnss_at(north_m: float, east_m: float, sigma_m: float = 8.0) -> GnssReport:
    return GnssReport(LocalPlane(OWN).to_position(north_m, east_m), sigma_m)


ROUND = np.diag([36.0, 36.0, 1e-4])  # 6 m in the fix and 8 m in GNSS: 10 m together


def test_the_threshold_is_the_chi_square_quantile_of_both_covariances() -> None:
    """10 m sigma and one false alarm in a thousand: 10 sqrt(2 ln 1000) = 37.17 m, across 180 E too."""
    verdict = gnss_verdict(fix_with(ROUND), gnss_at(0.0, -20.0))
    assert verdict.threshold_m == pytest.approx(37.169, abs=1e-3)
    assert verdict.distance_m == pytest.approx(20.0, abs=1e-6)
    assert verdict.verdict == "ok"


@pytest.mark.parametrize(
    ("distance_m", "expected"), [(24.0, "ok"), (25.0, "caution"), (37.0, "caution"), (37.3, "unsafe")]
)
def test_the_verdict_changes_at_5_percent_and_at_the_false_alarm(distance_m: float, expected: str) -> None:
    """10 sqrt(2 ln 20) = 24.48 m; 10 sqrt(2 ln 1000) = 37.17 m."""
    assert gnss_verdict(fix_with(ROUND), gnss_at(distance_m, 0.0)).verdict == expected


def test_the_threshold_follows_the_direction_of_the_difference() -> None:
    fix = fix_with(np.diag([10_000.0, 36.0, 1e-4]))
    along, across = gnss_verdict(fix, gnss_at(90.0, 0.0)), gnss_verdict(fix, gnss_at(0.0, 90.0))
    assert along.verdict == "ok"
    assert across.verdict == "unsafe"
    assert along.threshold_m == pytest.approx(math.sqrt(10_064.0 * 2.0 * math.log(1000.0)))
    assert across.threshold_m == pytest.approx(37.169, abs=1e-3)


def test_a_correlated_covariance_gives_the_same_as_its_turned_axes() -> None:
    """Ellipse 100 m x 6 m with the long axis towards the north-east."""
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / math.sqrt(2.0)
    fix = fix_with(turn @ np.diag([10_000.0, 36.0]) @ turn.T)
    assert gnss_verdict(fix, gnss_at(60.0, 60.0)).verdict == "ok"
    assert gnss_verdict(fix, gnss_at(60.0, -60.0)).verdict == "unsafe"


def test_no_difference_at_all_shows_the_worst_direction() -> None:
    verdict = gnss_verdict(fix_with(np.diag([36.0, 10_000.0])), GnssReport(OWN, 8.0))
    assert verdict.distance_m == 0.0
    assert verdict.verdict == "ok"
    assert verdict.threshold_m == pytest.approx(math.sqrt(10_064.0 * 2.0 * math.log(1000.0)))


@pytest.mark.parametrize(("dof", "alarm"), [(None, 0.05), (12.0, 0.05)])
def test_false_alarms_come_as_often_as_they_should(dof: float | None, alarm: float) -> None:
    """4000 right receivers; with a sigma0 of 12 degrees of freedom in the covariance of fix and receiver alike."""
    random = np.random.default_rng(7)
    shape = np.array([[90.0, 40.0], [40.0, 60.0]])
    hits = 0
    for north_m, east_m in random.multivariate_normal([0.0, 0.0], shape + np.eye(2), size=4000):
        scale = 1.0 if dof is None else random.chisquare(dof) / dof
        report = gnss_at(north_m, east_m, math.sqrt(scale))
        verdict = gnss_verdict(fix_with(scale * shape, dof=dof), report, probability_of_false_alarm=alarm)
        hits += verdict.verdict == "unsafe"
    assert hits / 4000 == pytest.approx(alarm, abs=0.011)  # 3 sigma of 4000 draws


@pytest.mark.parametrize("dof", [None, 12.0])
def test_the_smallest_detectable_offset_is_missed_as_rarely_as_stated(dof: float | None) -> None:
    random = np.random.default_rng(11)
    first = gnss_verdict(fix_with(ROUND, dof=dof), gnss_at(0.0, 0.0), probability_of_missed_detection=0.1)
    missed = 0
    for north_m, east_m in random.multivariate_normal([0.0, first.smallest_detectable_m], 100.0 * np.eye(2), size=3000):
        scale = 1.0 if dof is None else random.chisquare(dof) / dof
        verdict = gnss_verdict(fix_with(scale * ROUND, dof=dof), gnss_at(north_m, east_m, 8.0 * math.sqrt(scale)))
        missed += verdict.verdict != "unsafe"
    assert missed / 3000 == pytest.approx(0.1, abs=0.017)


def test_the_smallest_detectable_offset_counts_in_the_worst_direction() -> None:
    """Non-centrality 44.994 for 0.001 and 0.001: 6.708 sigmas."""
    verdict = gnss_verdict(fix_with(np.diag([36.0, 836.0])), gnss_at(0.0, 0.0))
    assert verdict.smallest_detectable_m == pytest.approx(30.0 * 6.7077, abs=0.01)
    assert verdict.smallest_detectable_m > verdict.threshold_m


def test_an_alert_limit_below_the_smallest_detectable_offset_is_not_available() -> None:
    fix, gnss = fix_with(ROUND), gnss_at(0.0, 0.0)
    assert gnss_verdict(fix, gnss, alert_limit_m=25.0).verdict == "not_available"
    assert gnss_verdict(fix, gnss, alert_limit_m=100.0).verdict == "ok"
    assert gnss_verdict(fix, gnss_at(500.0, 0.0), alert_limit_m=25.0).verdict == "unsafe"


def test_a_fix_without_redundancy_gives_no_verdict() -> None:
    fix = fix_with(ROUND, redundancy=0)
    assert gnss_verdict(fix, gnss_at(0.0, 0.0)).verdict == "not_available"
    assert gnss_verdict(fix, gnss_at(500.0, 0.0)).verdict == "caution"


def test_a_sigma0_of_two_degrees_of_freedom_detects_nothing_for_sure() -> None:
    verdict = gnss_verdict(fix_with(ROUND, dof=2.0, redundancy=2), gnss_at(0.0, 0.0))
    assert math.isinf(verdict.smallest_detectable_m)
    assert verdict.verdict == "not_available"


def test_a_second_group_is_a_caution_and_named() -> None:
    association = Association(
        np.array([[0, 0]]), np.array([1.0]), second_group=SecondGroup(1200.0, 45.0, ("T1", "T2", "T3"))
    )
    verdict = gnss_verdict(replace(fix_with(ROUND), association=association), gnss_at(0.0, 0.0))
    assert verdict.verdict == "caution"
    assert any("3 targets agree on another place, 1200 m towards 045°" in reason for reason in verdict.reasons)


def test_a_failed_global_test_is_a_caution_unless_the_covariance_was_scaled_by_it() -> None:
    failed = GlobalTest(80.0, 20.0, 31.4, False)
    assert gnss_verdict(replace(fix_with(ROUND), global_test=failed), gnss_at(0.0, 0.0)).verdict == "caution"
    scaled = replace(fix_with(ROUND, dof=20.0), global_test=failed)
    assert gnss_verdict(scaled, gnss_at(0.0, 0.0)).verdict == "ok"


def test_the_reasons_say_what_was_not_checked() -> None:
    from_ais = " ".join(gnss_verdict(fix_with(ROUND), gnss_at(0.0, 0.0)).reasons)
    assert "area-wide shift of all AIS positions" in from_ais
    assert "no mark comes from a chart" in from_ais
    with_chart = " ".join(gnss_verdict(fix_with(ROUND, marks="ABC"), gnss_at(0.0, 0.0)).reasons)
    assert "the 1 charted of 3 marks" in with_chart


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"probability_of_false_alarm": 0.0}, "probability_of_false_alarm must be within"),
        ({"probability_of_missed_detection": 1.5}, "probability_of_missed_detection must be within"),
        ({"probability_of_false_alarm": 0.6, "probability_of_missed_detection": 0.5}, "stay below 1"),
    ],
)
def test_probabilities_that_cannot_be_right_are_refused(options: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        gnss_verdict(fix_with(ROUND), gnss_at(0.0, 0.0), **options)


def test_a_plane_fix_and_a_gnss_without_sigma_are_refused() -> None:
    with pytest.raises(InputError, match="no place on earth"):
        gnss_verdict(replace(fix_with(ROUND), position=PlanePosition(0.0, 0.0)), gnss_at(0.0, 0.0))
    with pytest.raises(InputError, match="sigma_m must be > 0"):
        gnss_verdict(fix_with(ROUND), GnssReport(OWN, 0.0))
