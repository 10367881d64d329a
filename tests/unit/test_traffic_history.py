"""What the picture keeps of each station: bounded, ordered, without what was heard twice; marks that follow a turn."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime

import pytest

from navfix.errors import InputError
from navfix.geodesy import direct, inverse
from navfix.nmea.records import AisPosition, TargetReport
from navfix.picture import epochs
from navfix.picture.traffic import HISTORY_REPORTS, HISTORY_S, Traffic
from navfix.types import Position

T0 = datetime(2026, 3, 1, 12, 0, tzinfo=UTC).timestamp()
SHIP = AisPosition(T0, 211000001, 1, "ship", 54.0, 8.0, True, 6.0, 0.0, None, None, None, 0, "A")


def turning(count: int, *, rate_deg_s: float = 0.5, every_s: float = 10.0) -> list[AisPosition]:
    """Return reports of a ship that turns; the last one holds at T0."""
    place, reports = Position(54.0, 8.0), []
    for k in range(count):
        course = rate_deg_s * every_s * k
        time_s = T0 + every_s * (k - count + 1)
        reports.append(
            replace(SHIP, time_s=time_s, lat_deg=place.lat_deg, lon_deg=place.lon_deg, course_deg=course % 360.0)
        )
        for second in range(round(every_s)):
            place = direct(place, course + rate_deg_s * (second + 0.5), 6.0)
    return reports


def fed(reports) -> Traffic:
    traffic = Traffic()
    for report in reports:
        traffic.feed(report)
    return traffic


def test_a_history_is_bounded_in_number_and_time():
    assert len(fed(turning(40)).history(SHIP.mmsi)) == HISTORY_REPORTS
    old = fed([replace(SHIP, time_s=T0 - HISTORY_S - 1.0, lat_deg=53.9), SHIP])
    assert len(old.history(SHIP.mmsi)) == 1
    assert Traffic().history(SHIP.mmsi) is None


def test_reports_out_of_order_make_the_same_marks():
    reports = turning(9)
    (one,), _ = fed(reports).marks(T0 + 5.0)
    (other,), _ = fed([reports[8], *reports[3:8], *reports[:3]]).marks(T0 + 5.0)
    assert inverse(one.position, other.position)[0] < 1e-6
    assert one.sigma_m == pytest.approx(other.sigma_m)


def test_a_report_that_was_relayed_later_moves_nothing():
    reports = turning(9)
    (one,), _ = fed(reports).marks(T0 + 5.0)
    (other,), _ = fed([*reports, replace(reports[-1], time_s=T0 + 4.0), replace(reports[2], time_s=T0 + 4.5)]).marks(
        T0 + 5.0
    )
    assert one == other


def test_a_mark_follows_the_turn_that_its_reports_show():
    reports = turning(12)
    truth = Position(reports[-1].lat_deg, reports[-1].lon_deg)
    for second in range(15):
        truth = direct(truth, reports[-1].course_deg + 0.5 * (second + 0.5), 6.0)
    (mark,), _ = fed(reports).marks(T0 + 15.0)
    (straight,), _ = fed(reports[-1:]).marks(T0 + 15.0)
    assert inverse(mark.position, truth)[0] < 0.6 * inverse(straight.position, truth)[0]
    steady = turning(12, rate_deg_s=0.0)
    assert mark.sigma_m > fed(steady).marks(T0 + 15.0)[0][0].sigma_m


def test_the_clock_of_the_log_widens_moving_marks_only():
    late = [
        replace(r, time_s=r.time_s - 4.0 - 3.0 * (k % 3), utc_second=int(r.time_s % 60.0))
        for k, r in enumerate(turning(60))
    ]
    still = [replace(r, mmsi=2, speed_mps=0.0, lat_deg=54.1, lon_deg=8.1) for r in late]
    traffic = fed([r for pair in zip(late, still, strict=True) for r in pair])
    assert traffic.clock_offset_s == pytest.approx(-7.0)
    marks, _ = traffic.marks(T0)
    known = {mark.mmsi: mark.sigma_m for mark in marks}
    right = {
        m.mmsi: m.sigma_m
        for m in fed([*turning(60), replace(still[-1], time_s=T0 - 8.0, utc_second=None)]).marks(T0)[0]
    }
    assert known[SHIP.mmsi] > right[SHIP.mmsi]


def test_an_unknown_motion_model_is_refused_when_it_is_asked():
    traffic = Traffic(motion="clairvoyant")
    traffic.feed(SHIP)
    with pytest.raises(InputError, match="persisting"):
        traffic.marks(T0)


def test_epochs_are_made_with_the_motion_model_asked_for():
    reports = turning(12)
    targets = [TargetReport(T0 + 12.0 + 2.5 * turn, 1, 3000.0, 10.0, "relative") for turn in range(3)]
    places = {}
    for name in ("persisting", "constant_velocity"):
        *_, last = epochs([*reports, *targets], motion=name)
        places[name] = last.marks[0].position
    assert inverse(places["persisting"], places["constant_velocity"])[0] > 3.0
