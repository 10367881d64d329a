"""AIS sentences out: every type reads back through pyais to the same values, blanks become "not available"."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pyais
import pytest
from pyais.messages import ANY_MESSAGE

from navfix.errors import InputError
from navfix.nmea import write_ais
from navfix.nmea.records import AisPosition, AisStatic
from navfix.types import Hull
from navfix.units import KNOT_MPS

HULL = Hull(bow_m=120.0, stern_m=30.0, port_m=8.0, starboard_m=17.0)


def report(message_type: int, **changes: Any) -> AisPosition:
    values: dict[str, Any] = {
        "time_s": None, "mmsi": 200100001, "message_type": message_type, "kind": "ship",
        "lat_deg": 54.123456, "lon_deg": -12.654321, "speed_mps": 12.3 * KNOT_MPS, "course_deg": 201.7,
        "heading_deg": 199.6, "utc_second": 17, "accurate": True,
    }  # fmt: skip
    return AisPosition(**(values | changes))


def decoded(lines: list[str]) -> ANY_MESSAGE:
    return pyais.decode(*lines)


@pytest.mark.parametrize("message_type", [1, 2, 3, 18, 19])
def test_a_ship_report_reads_back(message_type: int) -> None:
    message = decoded(write_ais.position_report(report(message_type)))
    assert (message.msg_type, message.mmsi, message.second, message.accuracy) == (message_type, 200100001, 17, True)
    assert (message.lat, message.lon) == pytest.approx((54.123456, -12.654321), abs=1.5e-6)
    assert (message.speed, message.course, message.heading) == (12.3, 201.7, 200)


def test_class_a_reports_status_and_turn_rate() -> None:
    message = decoded(write_ais.position_report(report(1, navigation_status=1, turn_rate_deg_per_min=-30.0)))
    assert message.status == 1
    assert message.turn == pytest.approx(-30.0, abs=1.5)  # the field's own resolution at this rate


@pytest.mark.parametrize("rate", [-900.0, -128.0, -127.0, 127.0, 128.0, 127.5, 708.0, 5000.0])
def test_no_turn_rate_becomes_one_of_the_special_values(rate: float) -> None:
    message = decoded(write_ais.position_report(report(1, turn_rate_deg_per_min=rate)))
    assert isinstance(message.turn, float)
    assert message.turn == pytest.approx(max(-708.0, min(708.0, rate)), rel=0.03)


def test_blanks_are_sent_as_not_available() -> None:
    blank = report(
        1,
        lat_deg=None,
        lon_deg=None,
        speed_mps=None,
        course_deg=None,
        heading_deg=None,
        utc_second=None,
        accurate=False,
    )
    message = decoded(write_ais.position_report(blank))
    assert (message.lat, message.lon, message.speed, message.course) == (91.0, 181.0, 102.3, 360.0)
    assert (message.heading, message.second, message.status, float(message.turn)) == (511, 60, 15, -128.0)


@pytest.mark.parametrize(("course_deg", "sent"), [(359.96, 0.0), (-0.01, 0.0), (359.94, 359.9)])
def test_a_course_wraps_and_never_reads_as_not_available(course_deg: float, sent: float) -> None:
    assert decoded(write_ais.position_report(report(1, course_deg=course_deg))).course == sent


def test_a_heading_that_rounds_to_360_is_0() -> None:
    assert decoded(write_ais.position_report(report(1, heading_deg=359.7))).heading == 0


def test_a_speed_beyond_the_field_is_sent_as_its_largest() -> None:
    assert decoded(write_ais.position_report(report(1, speed_mps=80.0))).speed == 102.2


def test_own_ships_report_is_an_aivdo() -> None:
    assert write_ais.position_report(report(1, own=True))[0].startswith("!AIVDO,1,1,,A,")


def test_a_base_station_sends_its_time() -> None:
    utc = datetime(2026, 3, 1, 12, 34, 56, tzinfo=UTC)
    message = decoded(write_ais.position_report(report(4, kind="base_station", mmsi=2000001, time_s=utc.timestamp())))
    assert (message.year, message.month, message.day, message.hour, message.minute, message.second) == (
        2026,
        3,
        1,
        12,
        34,
        56,
    )


def test_a_base_station_without_time_is_refused() -> None:
    with pytest.raises(InputError, match="give time_s"):
        write_ais.position_report(report(4, kind="base_station"))


def test_an_aircraft_sends_whole_knots() -> None:
    assert decoded(write_ais.position_report(report(9, kind="aircraft", speed_mps=110.4 * KNOT_MPS))).speed == 110


@pytest.mark.parametrize("virtual", [True, False])
def test_an_aid_says_whether_it_is_virtual(virtual: bool) -> None:
    aid = report(21, kind="aton", virtual=virtual, aid_type=24, name="BUOY 17", hull=Hull(1.0, 1.0, 2.0, 2.0))
    message = decoded(write_ais.position_report(aid))
    assert (bool(message.virtual_aid), message.aid_type, message.name) == (virtual, 24, "BUOY 17")
    assert (message.to_bow, message.to_stern, message.to_port, message.to_starboard) == (1, 1, 2, 2)
    assert (message.off_position, message.second) == (False, 17)


def test_a_long_name_of_an_aid_goes_into_its_extension() -> None:
    name = "NORTHERN APPROACH FAIRWAY 12"
    assert decoded(write_ais.position_report(report(21, kind="aton", name=name))).full_name == name


def test_a_long_range_report_is_coarse() -> None:
    message = decoded(write_ais.position_report(report(27, kind="long_range", course_deg=359.7)))
    assert (message.lat, message.lon) == pytest.approx((54.123456, -12.654321), abs=0.5 / 600.0 + 1e-6)
    assert (message.speed, message.course) == (12, 0)


def test_static_data_of_class_a_come_in_two_parts_tied_by_their_number() -> None:
    lines = write_ais.static_report(AisStatic(None, 200100001, 5, HULL, 70, "Cargo 001"), channel="B", sequence=7)
    assert [line[:16] for line in lines] == ["!AIVDM,2,1,7,B,5", "!AIVDM,2,2,7,B,0"]
    message = decoded(lines)
    assert (message.shipname, message.ship_type) == ("CARGO 001", 70)
    assert (message.to_bow, message.to_stern, message.to_port, message.to_starboard) == (120, 30, 8, 17)


def test_static_data_of_class_b_are_two_messages() -> None:
    part_a, part_b = write_ais.static_report(AisStatic(None, 200100002, 24, HULL, 37, "SAIL 002"))
    assert decoded([part_a]).shipname == "SAIL 002"
    message = decoded([part_b])
    assert (message.ship_type, message.to_bow, message.to_starboard) == (37, 120, 17)


def test_an_unknown_hull_is_four_zeros() -> None:
    message = decoded(write_ais.static_report(AisStatic(None, 200100001, 5)))
    assert (message.to_bow, message.to_stern, message.to_port, message.to_starboard) == (0, 0, 0, 0)


def test_a_hull_beyond_the_fields_is_cut() -> None:
    message = decoded(write_ais.static_report(AisStatic(None, 200100001, 5, Hull(600.0, 10.0, 80.0, 2.0))))
    assert (message.to_bow, message.to_port) == (511, 63)


def test_letters_that_six_bit_ascii_lacks_become_question_marks() -> None:
    assert decoded(write_ais.static_report(AisStatic(None, 200100001, 5, name="Bø{@}"))).shipname == "B????"


@pytest.mark.parametrize("message_type", [5, 8])
def test_a_position_report_of_another_type_is_refused(message_type: int) -> None:
    with pytest.raises(InputError, match="not written"):
        write_ais.position_report(report(message_type))


def test_static_data_of_another_type_are_refused() -> None:
    with pytest.raises(InputError, match="type 5 or 24"):
        write_ais.static_report(AisStatic(None, 200100001, 19))
