"""From records to epochs: scans, carried positions, hulls, and what must never be a mark."""

import math
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from navfix.catalog import radar_model
from navfix.geodesy import direct, inverse
from navfix.nmea.records import AisPosition, AisStatic, OwnHeading, OwnPosition, OwnSpeed, TargetReport
from navfix.picture import Picture, epochs
from navfix.picture.picture import radar_target
from navfix.picture.scans import ScanBuilder, report_time
from navfix.picture.selection import why_never_a_mark
from navfix.picture.time_base import position_time
from navfix.picture.traffic import Traffic
from navfix.types import Hull, Position

T0 = datetime(2026, 3, 1, 12, 0, tzinfo=UTC).timestamp()
SHIP = AisPosition(T0, 211000001, 1, "ship", 54.0, 8.0, True, 10.0, 90.0, 85.0, None, None, 0, "A")
AID = AisPosition(T0, 992111001, 21, "aton", 54.1, 8.1, True, aid_type=25)


def target(number: int, time_s: float, range_m: float = 4000.0, bearing_deg: float = 30.0, **more) -> TargetReport:
    return TargetReport(time_s, number, range_m, bearing_deg, "relative", status=more.pop("status", "T"), **more)


def feed_all(builder: ScanBuilder, reports):
    return [scan for scan in map(builder.feed, reports) if scan is not None]


# ------------------------------------------------------------------------------------------------------------- scans


def test_a_scan_ends_when_a_target_comes_again():
    builder = ScanBuilder()
    scans = feed_all(builder, [target(n, T0 + 2.5 * turn) for turn in range(4) for n in (1, 2, 3)])
    assert [len(scan.reports) for scan in scans] == [3, 3, 3]
    assert scans[1].time_s == T0 + 2.5


def test_the_turn_is_the_median_time_between_reports_of_a_target():
    builder = ScanBuilder()
    scans = feed_all(builder, [target(n, T0 + 1.2 * turn + 0.3 * n) for turn in range(12) for n in range(3)])
    assert scans[-1].turn_s == pytest.approx(1.2)
    assert {len(scan.reports) for scan in scans} == {3}


def test_a_target_that_is_missed_does_not_join_two_scans():
    builder = ScanBuilder()
    reports = [target(n, T0 + 2.5 * turn) for turn in range(6) for n in (1, 2, 3) if not (turn == 3 and n == 1)]
    assert [len(scan.reports) for scan in feed_all(builder, reports)] == [3, 3, 3, 2, 3]


def test_the_last_scan_counts_only_when_it_is_complete():
    builder = ScanBuilder()
    feed_all(builder, [target(n, T0 + 2.5 * turn) for turn in range(3) for n in (1, 2, 3)])
    assert builder.flush() is not None
    cut = ScanBuilder()
    feed_all(cut, [target(n, T0 + 2.5 * turn) for turn in range(3) for n in (1, 2, 3)][:-1])
    assert cut.flush() is None


def test_a_log_with_every_report_twice_has_the_same_scans():
    reports = [target(n, T0 + 2.5 * turn, bearing_deg=30.0 + turn) for turn in range(4) for n in (1, 2, 3)]
    scans, twice = (feed_all(ScanBuilder(), [r for r in reports for _ in range(times)]) for times in (1, 2))
    assert scans == twice
    late = [(r, replace(r, time_s=r.time_s + 0.2, source="other listener")) for r in reports]
    assert feed_all(ScanBuilder(), [r for both in late for r in both]) == scans


def test_an_echo_that_stands_still_is_reported_anew_in_each_turn():
    still = [target(n, T0 + 1.2 * turn) for turn in range(5) for n in (1, 2)]
    assert [len(scan.reports) for scan in feed_all(ScanBuilder(), still)] == [2, 2, 2, 2]


def test_a_lost_target_is_dropped_only_when_it_stands_still():
    builder = ScanBuilder()
    still = [target(1, T0 + 2.5 * turn, status="L") for turn in range(4)]
    moving = [target(2, T0 + 2.5 * turn, range_m=4000.0 + 10.0 * turn, status="L") for turn in range(4)]
    scans = feed_all(builder, [r for pair in zip(still, moving, strict=True) for r in pair])
    assert {r.number for r in scans[-1].reports} == {2}


def test_a_target_is_timed_by_its_own_utc_where_that_agrees_with_the_reception():
    noon = T0 % 86400.0
    assert report_time(target(1, T0 + 0.9, utc_of_day_s=noon + 0.41)) == pytest.approx(T0 + 0.41)
    assert report_time(target(1, T0 + 0.9, utc_of_day_s=noon - 600.0)) == T0 + 0.9
    midnight = T0 + 43200.0
    assert report_time(target(1, midnight + 0.2, utc_of_day_s=86399.5)) == pytest.approx(midnight - 0.5)


def test_rounding_of_the_sentences_is_added_to_the_radars_sigma():
    coarse = radar_target(target(1, T0, range_resolution_m=185.2, bearing_resolution_deg=1.0), radar_model("imo"))
    assert coarse.range_sigma_m == pytest.approx(math.hypot(25.5, 185.2 / math.sqrt(12.0)))
    assert coarse.bearing_sigma_deg == pytest.approx(math.hypot(1.02, 1.0 / math.sqrt(12.0)))


def test_a_speed_that_is_relative_to_own_ship_is_not_a_speed_over_ground():
    relative = target(1, T0, speed_mps=5.0, course_deg=90.0, course_reference="relative")
    assert radar_target(relative, radar_model("imo")).speed_mps is None


# --------------------------------------------------------------------------------------------------------- selection


@pytest.mark.parametrize(
    ("report", "reason"),
    [
        (SHIP, None),
        (replace(SHIP, own=True), "own ship"),
        (replace(SHIP, kind="base_station"), "base station"),
        (replace(SHIP, kind="aircraft"), "aircraft"),
        (replace(SHIP, kind="long_range"), "long-range report"),
        (replace(SHIP, lat_deg=None), "position not available"),
        (replace(SHIP, mmsi=970123456), "distress beacon"),
        (AID, None),
        (replace(AID, virtual=True), "virtual aid to navigation"),
        (replace(AID, mmsi=992116001), "virtual aid to navigation"),
        (replace(AID, off_position=True), "aid off position"),
        (replace(AID, aid_type=1), "aid of unspecified type"),
        (replace(AID, aid_type=0), "aid of unspecified type"),
    ],
)
def test_what_must_never_be_a_mark(report, reason):
    assert why_never_a_mark(report, frozenset()) == reason


def test_own_ship_is_known_by_its_mmsi_once_it_was_heard():
    traffic = Traffic()
    traffic.feed(replace(SHIP, own=True))
    traffic.feed(replace(SHIP, time_s=T0 + 5.0))
    marks, left_out = traffic.marks(T0 + 5.0)
    assert marks == ()
    assert left_out == {"own ship": 1}


# ----------------------------------------------------------------------------------------------------------- traffic


def test_a_mark_is_carried_to_the_instant_and_centred_on_its_hull():
    traffic = Traffic(motion="constant_velocity")
    traffic.feed(replace(SHIP, heading_deg=90.0))
    traffic.feed(AisStatic(T0, SHIP.mmsi, 5, Hull(150.0, 50.0, 10.0, 10.0), 70, "TANKER"))
    (mark,), _ = traffic.marks(T0 + 20.0)
    distance_m, azimuth_deg = inverse(Position(54.0, 8.0), mark.position)
    assert distance_m == pytest.approx(200.0 + 50.0, abs=0.01)
    assert azimuth_deg == pytest.approx(90.0, abs=0.01)
    assert (mark.name, mark.age_s, mark.kind) == ("TANKER", 20.0, "ship")


def test_stale_reports_are_dropped_by_what_their_class_sends():
    traffic = Traffic()
    traffic.feed(SHIP)
    traffic.feed(replace(SHIP, mmsi=211000002, speed_mps=0.0, navigation_status=1))
    traffic.feed(AID)
    assert len(traffic.marks(T0 + 60.0)[0]) == 3
    marks, left_out = traffic.marks(T0 + 300.0)
    assert {m.mmsi for m in marks} == {211000002, AID.mmsi}
    assert left_out == {"stale report": 1}
    assert traffic.marks(T0 + 7200.0)[0] == ()


def test_the_newest_report_counts_whatever_the_order_of_arrival():
    traffic = Traffic()
    traffic.feed(replace(SHIP, time_s=T0 + 10.0, lat_deg=54.5))
    traffic.feed(SHIP)
    (mark,), _ = traffic.marks(T0 + 10.0)
    assert mark.position.lat_deg == pytest.approx(54.5, abs=0.01)


def test_both_parts_of_static_data_are_kept():
    traffic = Traffic()
    traffic.feed(replace(SHIP, ais_class="B", message_type=18))
    traffic.feed(AisStatic(T0, SHIP.mmsi, 24, None, None, "YACHT"))
    traffic.feed(AisStatic(T0, SHIP.mmsi, 24, Hull(8.0, 4.0, 2.0, 2.0), 36, None))
    (mark,), _ = traffic.marks(T0)
    assert (mark.name, mark.hull.length_m, mark.ship_type) == ("YACHT", 12.0, 36)


def test_the_second_of_the_minute_times_a_position_where_the_reception_allows_it():
    assert position_time(T0 + 3.0, 1) == T0 + 1.0
    assert position_time(T0 + 3.0, 5) == T0 + 5.0
    assert position_time(T0 + 3.0, 58) == T0 - 2.0
    assert position_time(T0 + 3.0, 40) == T0 + 3.0
    assert position_time(T0 + 3.0, None) == T0 + 3.0


# ------------------------------------------------------------------------------------------------------------ epochs


def records():
    yield SHIP
    yield AID
    for turn in range(5):
        for number in (1, 2, 3):
            yield target(number, T0 + 2.5 * turn + 0.1 * number)


def test_an_epoch_for_each_scan_and_only_the_last_where_asked():
    assert len(list(epochs(records()))) == 5
    (last,) = epochs(records(), last=True)
    assert last.time_utc.timestamp() == pytest.approx(T0 + 10.3)
    assert len(last.targets) == 3
    assert len(last.marks) == 2


def test_the_last_scan_is_that_at_the_end_of_the_log_where_time_goes_back():
    earlier = [replace(r, time_s=r.time_s - 3600.0) for r in records()]
    (last,) = epochs([*records(), *earlier], last=True)
    assert last.time_utc.timestamp() == pytest.approx(T0 + 10.3 - 3600.0)


def test_the_scan_of_a_time_is_the_newest_that_was_complete_by_then():
    (chosen,) = epochs(records(), at=datetime.fromtimestamp(T0 + 6.0, UTC))
    assert chosen.time_utc.timestamp() == pytest.approx(T0 + 5.3)
    assert list(epochs(records(), at=datetime.fromtimestamp(T0 - 60.0, UTC))) == []
    assert list(epochs(records(), at=datetime.fromtimestamp(T0 + 600.0, UTC))) == []


def test_own_sensors_become_hints_and_the_gnss_is_only_set_beside():
    picture = Picture()
    picture.feed(OwnHeading(T0, 100.0, "true", "HDT"))
    picture.feed(OwnPosition(T0, 54.0, 8.0, "RMC", speed_mps=10.0, course_deg=0.0))
    scan = None
    for turn in range(2):
        for number in (1, 2):
            scan = picture.feed(target(number, T0 + 2.5 * turn)) or scan
    epoch = picture.epoch(scan)
    assert epoch.heading_hint.heading_deg == 100.0
    assert epoch.position_hint is None
    assert inverse(epoch.gnss.position, direct(Position(54.0, 8.0), 0.0, 10.0 * (scan.time_s - T0)))[0] < 0.01


def test_a_magnetic_heading_needs_its_variation():
    picture = Picture()
    picture.feed(OwnHeading(T0, 100.0, "magnetic", "HDM"))
    assert picture._heading_hint(T0) is None
    picture.feed(OwnHeading(T0, 100.0, "magnetic", "HDG", variation_deg=3.0))
    assert picture._heading_hint(T0).heading_deg == 103.0


def test_an_old_heading_is_no_hint():
    picture = Picture()
    picture.feed(OwnHeading(T0, 100.0, "true", "HDT"))
    assert picture._heading_hint(T0 + 60.0) is None


def test_the_log_gives_a_speed_hint_bottom_track_first_and_never_from_gnss():
    picture = Picture()
    assert picture._speed_hint(T0) is None
    picture.feed(OwnSpeed(T0, "ground", "VTG", speed_mps=9.0, from_gnss=True))
    assert picture._speed_hint(T0) is None
    picture.feed(OwnSpeed(T0, "ground", "VBW", forward_mps=5.0, starboard_mps=0.2))
    picture.feed(OwnSpeed(T0 + 1.0, "water", "VHW", speed_mps=6.0))
    assert picture._speed_hint(T0 + 2.0).speed_mps == 5.0
    assert picture._speed_hint(T0 + 2.0).reference == "ground"
    picture.feed(OwnSpeed(T0 + 30.0, "water", "VHW", speed_mps=6.0))
    hint = picture._speed_hint(T0 + 31.0)
    assert (hint.speed_mps, hint.reference) == (6.0, "water")
    assert hint.sigma_mps == pytest.approx(0.12)
    assert picture._speed_hint(T0 + 60.0) is None
