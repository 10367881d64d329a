"""Sentences out: every rendered sentence says the same to pynmea2, with wraps, carries and blanks."""

from __future__ import annotations

from datetime import UTC, date, datetime, time

import pynmea2
import pytest

from navfix.errors import InputError
from navfix.nmea import write
from navfix.nmea.records import TargetReport
from navfix.types import Position
from navfix.units import KNOT_MPS, NM_M

NOON_S = datetime(2026, 3, 1, 12, 0, 0, tzinfo=UTC).timestamp()


def target(**changes: object) -> TargetReport:
    values = {
        "time_s": None,
        "number": 7,
        "range_m": 3.21 * NM_M,
        "bearing_deg": 123.4,
        "bearing_reference": "relative",
    }
    return TargetReport(**(values | changes))  # type: ignore[arg-type]


def fields(text: str) -> list[str]:
    """Split a sentence after a look at its checksum."""
    assert write.checksum(text[1:-3]) == text[-2:]
    return text[1:].split("*")[0].split(",")


def test_checksum_is_that_of_a_published_sentence() -> None:
    assert write.checksum("GPGLL,3751.65,S,14507.36,E") == "77"


def test_tag_block_holds_source_whole_seconds_and_its_own_checksum() -> None:
    # As printed by real receivers for this source and time.
    assert write.tag_block(1392820473.9, "AI0001") == "\\s:AI0001,c:1392820473*36\\"


def test_ttm_fields_stand_where_the_standard_puts_them() -> None:
    report = target(speed_mps=9.7 * KNOT_MPS, course_deg=201.4, status="T", utc_of_day_s=33938.5, name="TUG")
    assert fields(write.ttm(report, cpa_m=0.55 * NM_M, tcpa_s=390.0)) == [
        "RATTM", "07", "3.21", "123.4", "R", "9.7", "201.4", "T", "0.55", "6.5", "N", "TUG", "T", "", "092538.50", "A",
    ]  # fmt: skip


def test_ttm_is_understood_by_pynmea2() -> None:
    message = pynmea2.parse(write.ttm(target(speed_mps=5.0 * KNOT_MPS, course_deg=10.0, status="Q")))
    assert (message.target_number, message.status, message.brg_ref, message.dist_unit) == (7, "Q", "R", "N")
    assert [float(f) for f in (message.distance, message.bearing, message.speed, message.cog)] == [
        3.21,
        123.4,
        5.0,
        10.0,
    ]


def test_ttm_without_speed_leaves_speed_course_and_reference_blank() -> None:
    assert fields(write.ttm(target()))[5:8] == ["", "", ""]


@pytest.mark.parametrize(("decimals", "printed"), [(1, "3.2"), (2, "3.21"), (3, "3.210")])
def test_ttm_prints_as_many_decimals_as_the_range_resolution_asks(decimals: int, printed: str) -> None:
    assert fields(write.ttm(target(range_resolution_m=10.0**-decimals * NM_M)))[2] == printed


@pytest.mark.parametrize(
    ("bearing_deg", "printed"), [(359.96, "0.0"), (359.94, "359.9"), (-0.04, "0.0"), (360.0, "0.0")]
)
def test_a_printed_bearing_never_reads_360(bearing_deg: float, printed: str) -> None:
    assert fields(write.ttm(target(bearing_deg=bearing_deg)))[3] == printed


def test_a_heading_wraps_after_rounding() -> None:
    assert pynmea2.parse(write.hdt(359.97)).heading == 0.0


def test_a_blank_heading_is_a_blank_field() -> None:
    assert fields(write.hdt(None)) == ["HEHDT", "", "T"]


def test_ths_says_its_mode() -> None:
    assert fields(write.ths(12.34, mode="E")) == ["HETHS", "12.3", "E"]


def test_vhw_prints_knots_and_kilometres_per_hour() -> None:
    message = pynmea2.parse(write.vhw(heading_deg=90.0, speed_mps=10.0 * KNOT_MPS))
    assert [float(f) for f in (message.heading_true, message.water_speed_knots, message.water_speed_km)] == [
        90,
        10,
        18.52,
    ]


def test_rmc_is_understood_by_pynmea2() -> None:
    text = write.rmc(NOON_S, Position(-33.5, -70.25), speed_mps=5.0 * KNOT_MPS, course_deg=359.999)
    message = pynmea2.parse(text)
    assert (message.latitude, message.longitude) == pytest.approx((-33.5, -70.25), abs=1e-7)
    assert (message.spd_over_grnd, message.true_course, message.status) == (5.0, 0.0, "A")
    assert (message.datestamp, message.timestamp.replace(tzinfo=None)) == (date(2026, 3, 1), time(12))


def test_rmc_without_a_position_is_not_valid() -> None:
    assert fields(write.rmc(NOON_S, None))[2:7] == ["V", "", "", "", ""]


def test_rmc_carries_the_navigational_status_only_when_asked() -> None:
    assert len(fields(write.rmc(NOON_S, None))) + 1 == len(fields(write.rmc(NOON_S, None, navigation_status="S")))


def test_a_time_that_rounds_up_takes_the_date_along() -> None:
    midnight_s = datetime(2026, 3, 2, tzinfo=UTC).timestamp()
    assert fields(write.zda(midnight_s - 0.001)) == ["GPZDA", "000000.00", "02", "03", "2026", "00", "00"]
    assert fields(write.rmc(midnight_s - 0.001, None))[1::8] == ["000000.00", "020326"]


def test_utc_of_day_of_seconds_below_and_above_a_minute() -> None:
    assert [write.utc_of_day(s) for s in (59.994, 59.996, 86399.999, None)] == [
        "000059.99",
        "000100.00",
        "000000.00",
        "",
    ]


@pytest.mark.parametrize(
    ("lat_deg", "printed"),
    [(54.9999999999, ("5500.00000", "N")), (-0.00000001, ("0000.00000", "N")), (-0.5, ("0030.00000", "S"))],
)
def test_minutes_carry_into_degrees(lat_deg: float, printed: tuple[str, str]) -> None:
    assert tuple(fields(write.rmc(NOON_S, Position(lat_deg, 0.0)))[3:5]) == printed


@pytest.mark.parametrize("lon_deg", [179.99999999, -179.99999999, -180.0, 179.123456])
def test_longitudes_near_the_date_line_read_back(lon_deg: float) -> None:
    message = pynmea2.parse(write.gga(NOON_S, Position(-16.0, lon_deg)))
    assert abs((message.longitude - lon_deg + 180.0) % 360.0 - 180.0) < 1e-7
    assert abs(message.longitude) <= 180.0


def test_gga_quality_satellites_and_blanks() -> None:
    message = pynmea2.parse(write.gga(NOON_S, Position(1.0, 2.0), quality=6, satellites=0, hdop=None))
    assert (message.gps_qual, message.num_sats, message.horizontal_dil) == (6, "00", "")


def test_gst_prints_the_ellipse() -> None:
    text = write.gst(
        NOON_S, semi_major_m=12.25, semi_minor_m=6.0, orientation_deg=179.98, sigma_north_m=11.0, sigma_east_m=7.5
    )
    assert fields(text) == ["GPGST", "120000.00", "", "12.25", "6.00", "180.0", "11.00", "7.50", ""]


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_number_that_is_not_finite_is_refused(value: float) -> None:
    with pytest.raises(InputError, match="finite"):
        write.hdt(value)


def test_a_target_number_that_has_no_field_is_refused() -> None:
    with pytest.raises(InputError, match="target number"):
        write.ttm(target(number=1000))
