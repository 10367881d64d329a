"""Every sentence that is read, with the values that its fields must give."""

from __future__ import annotations

import pynmea2
import pytest

from navfix.nmea.fields import Fields
from navfix.nmea.framing import Unreadable, checksum, frame
from navfix.nmea.records import (
    OtherMessage,
    OwnHeading,
    OwnPosition,
    OwnSpeed,
    OwnTurnRate,
    RadarSettings,
    Record,
    TargetReport,
    UtcTime,
)
from navfix.nmea.sentences import PARSERS, records_of
from navfix.units import KMH_MPS, KNOT_MPS, NM_M


def read(body: str) -> tuple[Record, ...]:
    found = frame(f"${body}*{checksum(body):02X}")
    assert found is not None
    return records_of(found, Fields(found.values), None)


def target(body: str) -> TargetReport:
    (record,) = read(body)
    assert isinstance(record, TargetReport)
    return record


# ------------------------------------------------------------------------------------------------------ TTM


def test_the_golden_ttm_with_blanks_empty_reference_and_extra_field() -> None:
    found = frame("$RATTM, 1,1.033854,237.500000,,5.76,176.3,T, , ,N,ARPA 1,T, *22")
    assert found is not None
    (report,) = records_of(found, Fields(found.values), 12.0)
    assert isinstance(report, TargetReport)
    assert report.number == 1
    assert report.range_m == pytest.approx(1914.697608)
    assert (report.bearing_deg, report.bearing_reference) == (237.5, "true")
    assert report.speed_mps == pytest.approx(5.76 * 1852.0 / 3600.0)
    assert (report.course_deg, report.course_reference) == (176.3, "true")
    assert (report.status, report.name, report.talker) == ("T", "ARPA 1", "RA")
    assert report.utc_of_day_s is None
    assert report.time_s == 12.0


@pytest.mark.parametrize(("letter", "reference"), [("R", "relative"), ("T", "true"), ("", "true"), (" ", "true")])
def test_an_empty_bearing_reference_is_true(letter: str, reference: str) -> None:
    assert target(f"RATTM,07,2.00,10.0,{letter},,,,,,N,,T,").bearing_reference == reference


@pytest.mark.parametrize(
    ("unit", "range_m", "speed_mps"),
    [("N", 3704.0, 5.144444), ("K", 2000.0, 2.777778), ("S", 3218.688, 4.4704), ("", 3704.0, 5.144444)],
)
def test_one_unit_field_holds_for_range_and_speed(unit: str, range_m: float, speed_mps: float) -> None:
    report = target(f"RATTM,07,2.0,10.0,R,10.0,20.0,T,,,{unit},,T,")
    assert report.range_m == pytest.approx(range_m)
    assert report.speed_mps == pytest.approx(speed_mps, abs=1e-6)


@pytest.mark.parametrize(
    ("distance", "bearing", "range_m", "bearing_deg"),
    [("1.07", "338.5", 18.52, 0.1), ("1.033854", "237.500000", 0.001852, 1e-6), ("2", "90", 1852.0, 1.0)],
)
def test_the_resolution_is_one_unit_of_the_last_digit(
    distance: str, bearing: str, range_m: float, bearing_deg: float
) -> None:
    report = target(f"RATTM,07,{distance},{bearing},R,,,,,,N,,T,")
    assert report.range_resolution_m == pytest.approx(range_m)
    assert report.bearing_resolution_deg == pytest.approx(bearing_deg)


@pytest.mark.parametrize(("letter", "status"), [("L", "L"), ("Q", "Q"), ("T", "T"), ("", None), ("x", None)])
def test_the_status_is_a_letter_or_none(letter: str, status: str | None) -> None:
    assert target(f"RATTM,07,2.00,10.0,R,,,,,,N,,{letter},").status == status


@pytest.mark.parametrize(
    ("utc", "seconds"), [("134601", 49561.0), ("134601.50", 49561.5), ("", None), ("256000", None), ("13460", None)]
)
def test_utc_with_and_without_decimals(utc: str, seconds: float | None) -> None:
    assert target(f"RATTM,07,2.00,10.0,R,,,,,,N,,T,,{utc},A").utc_of_day_s == seconds


@pytest.mark.parametrize("body", ["RATTM,07,,,R,,,,,,N,,L,", "RATTM,07,0.0,0.0,R,,,,,,N,,L,", "RATTM,,,,,,,,,,,,,"])
def test_a_target_without_echo_gives_no_report(body: str) -> None:
    assert read(body) == (OtherMessage(None, "TTM"),)


@pytest.mark.parametrize(
    ("body", "kind"),
    [
        ("RATTM,01,1.07,33", "too_short"),
        ("RATTM", "too_short"),
        ("RATTM,01,-1.-5,33.0,R,,,,,,N,,T,", "field"),
        ("RATTM,01,1.0,nan,R,,,,,,N,,T,", "field"),
        ("RATTM,01,1.0,1_0,R,,,,,,N,,T,", "field"),
        ("RATTM,01,1.0,900.0,R,,,,,,N,,T,", "field"),
        ("RATTM,01,-1.0,90.0,R,,,,,,N,,T,", "field"),
        ("RATTM,,1.0,90.0,R,,,,,,N,,T,", "field"),
        ("RATTM,1.5,1.0,90.0,R,,,,,,N,,T,", "field"),
        ("RATTM,01,1.0,90.0,M,,,,,,N,,T,", "field"),
        ("RATTM,01,1.0,90.0,R,,,,,,X,,T,", "field"),
    ],
)
def test_half_or_impossible_targets_are_refused(body: str, kind: str) -> None:
    with pytest.raises(Unreadable) as caught:
        read(body)
    assert caught.value.kind == kind


def test_an_unreadable_optional_field_is_noted_and_none() -> None:
    fields = Fields(["RATTM", "01", "1.0", "90.0", "R", "-1.-5", "10.0", "T", "", "", "N", "", "T", ""])
    found = frame("$RATTM,01,1.0,90.0,R,-1.-5,10.0,T,,,N,,T,")
    assert found is not None
    (report,) = records_of(found, fields, None)
    assert isinstance(report, TargetReport)
    assert report.speed_mps is None
    assert fields.notes == ["field 5 is '-1.-5', expected a number"]


def test_tll_is_recognised_and_is_no_evidence() -> None:
    record = read("RATLL,01,5744.6000,N,01137.9000,E,BUOY 1,134601,T,")
    assert record == (OtherMessage(None, "TLL"),)


def test_rsd_gives_the_range_scale_and_the_rotation() -> None:
    assert read("RARSD,,,,,,,,,0.400,180.0,1.500,N,H") == (RadarSettings(None, 1.5 * NM_M, "H"),)


# --------------------------------------------------------------------------------------------- heading and speed


def test_headings() -> None:
    assert read("HEHDT,123.4,T") == (OwnHeading(None, 123.4, "true", "HDT"),)
    assert read("HETHS,123.4,A") == (OwnHeading(None, 123.4, "true", "THS"),)
    assert read("HCHDM,123.4,M") == (OwnHeading(None, 123.4, "magnetic", "HDM"),)
    assert read("HCHDG,220.3,1.0,W,2.9,E") == (OwnHeading(None, 220.3, "magnetic", "HDG", 2.9, -1.0),)
    assert read("HCHDG,220.3,,,12.5,W") == (OwnHeading(None, 220.3, "magnetic", "HDG", -12.5),)
    assert read("HEHDT,360.0,T") == (OwnHeading(None, 0.0, "true", "HDT"),)


@pytest.mark.parametrize(("mode", "valid"), [("A", True), ("E", True), ("M", False), ("S", False), ("V", False)])
def test_the_mode_of_ths_says_whether_it_is_valid(mode: str, valid: bool) -> None:
    (heading,) = read(f"HETHS,123.4,{mode}")
    assert isinstance(heading, OwnHeading)
    assert heading.valid is valid


@pytest.mark.parametrize(
    "body", ["HEHDT,,T", "HETHS,,V", "HCHDG,,,,,", "HCHDM,,M", "TIROT,,A", "TIROT,5.0,V", "VWVHW,,T,,M,,N,,K"]
)
def test_blank_or_not_valid_gives_nothing(body: str) -> None:
    assert read(body) == (OtherMessage(None, body[2:5]),)


def test_a_heading_beyond_a_circle_is_refused() -> None:
    with pytest.raises(Unreadable):
        read("HEHDT,1234.0,T")


def test_vhw_gives_heading_and_speed_through_the_water() -> None:
    heading, speed = read("IIVHW,123.0,T,120.0,M,6.00,N,11.11,K")
    assert heading == OwnHeading(None, 123.0, "true", "VHW")
    assert speed == OwnSpeed(None, "water", "VHW", 6.0 * KNOT_MPS)
    heading, speed = read("IIVHW,,T,25.0,M,,N,10.9,K")
    assert heading == OwnHeading(None, 25.0, "magnetic", "VHW")
    assert speed == OwnSpeed(None, "water", "VHW", 10.9 * KMH_MPS)


def test_vbw_gives_what_its_status_letters_allow() -> None:
    water, ground = read("VDVBW,10.0,-0.5,A,9.0,0.7,A,,V,,V")
    assert isinstance(water, OwnSpeed)
    assert isinstance(ground, OwnSpeed)
    assert (water.reference, ground.reference) == ("water", "ground")
    assert (water.forward_mps, water.starboard_mps) == (10.0 * KNOT_MPS, -0.5 * KNOT_MPS)
    assert not ground.from_gnss
    (water,) = read("VDVBW,10.0,-0.5,A,9.0,0.7,V")
    assert water == OwnSpeed(None, "water", "VBW", forward_mps=10.0 * KNOT_MPS, starboard_mps=-0.5 * KNOT_MPS)


def test_vtg_is_marked_as_own_gnss() -> None:
    assert read("GPVTG,310.0,T,305.0,M,8.0,N,14.8,K,A") == (
        OwnSpeed(None, "ground", "VTG", 8.0 * KNOT_MPS, 310.0, from_gnss=True),
    )
    assert read("GPVTG,310.0,T,305.0,M,8.0,N,14.8,K,N") == (OtherMessage(None, "VTG"),)


@pytest.mark.parametrize(
    ("letter", "reference", "from_gnss"), [("W", "water", False), ("B", "ground", False), ("P", "ground", True)]
)
def test_osd_gives_heading_course_and_speed(letter: str, reference: str, from_gnss: bool) -> None:
    heading, speed = read(f"RAOSD,35.1,A,36.0,{letter},10.2,{letter},15.3,0.1,N")
    assert heading == OwnHeading(None, 35.1, "true", "OSD")
    assert isinstance(speed, OwnSpeed)
    assert (speed.reference, speed.from_gnss) == (reference, from_gnss)
    assert (speed.speed_mps, speed.course_deg) == (10.2 * KNOT_MPS, 36.0)


def test_a_manual_speed_of_osd_is_no_measurement() -> None:
    (heading,) = read("RAOSD,35.1,V,36.0,M,10.2,M,15.3,0.1,N")
    assert heading == OwnHeading(None, 35.1, "true", "OSD", valid=False)


def test_rot_is_positive_to_starboard() -> None:
    assert read("TIROT,-12.5,A") == (OwnTurnRate(None, -12.5),)


# ---------------------------------------------------------------------------------------------- position and time

LAT_DEG, LON_DEG = 57.0 + 44.5125 / 60.0, -(11.0 + 38.25 / 60.0)


def test_positions_of_own_gnss() -> None:
    time, rmc = read("GPRMC,134601,A,5744.5125,N,01138.2500,W,2.0,67.0,270715,2.9,E,A")
    assert time == UtcTime(None, 1438004761.0, "RMC")
    assert isinstance(rmc, OwnPosition)
    assert (rmc.lat_deg, rmc.lon_deg) == (pytest.approx(LAT_DEG), pytest.approx(LON_DEG))
    assert (rmc.valid, rmc.quality, rmc.course_deg) == (True, "A", 67.0)
    assert rmc.speed_mps == pytest.approx(2.0 * KNOT_MPS)
    assert rmc.utc_of_day_s == 49561.0
    for body in (
        "GPGGA,134601.00,5744.5125,N,01138.2500,W,1,08,1.6,1.0,M,40.0,M,,",
        "GPGLL,5744.5125,N,01138.2500,W,134601.00,A,A",
        "GNGNS,134601.00,5744.5125,N,01138.2500,W,AN,08,1.6,1.0,40.0,,",
    ):
        (record,) = read(body)
        assert isinstance(record, OwnPosition)
        assert (record.lat_deg, record.lon_deg) == (rmc.lat_deg, rmc.lon_deg)
        assert record.valid
        assert record.utc_of_day_s == 49561.0


@pytest.mark.parametrize(
    "body",
    [
        "GPRMC,134601,V,5744.5125,N,01138.2500,W,2.0,67.0,,2.9,E,A",
        "GPGGA,134601.00,5744.5125,N,01138.2500,W,0,00,,,M,,M,,",
        "GPGLL,5744.5125,N,01138.2500,W,134601.00,V,N",
        "GNGNS,134601.00,5744.5125,N,01138.2500,W,NN,08,1.6,1.0,40.0,,",
    ],
)
def test_a_position_that_calls_itself_not_valid_says_so(body: str) -> None:
    (record,) = read(body)
    assert isinstance(record, OwnPosition)
    assert not record.valid


@pytest.mark.parametrize(
    "body", ["GPGGA,,,,,,0,,,,M,,M,,", "GPGLL,,,,,,V,N", "GPRMC,,V,,,,,,,,,,N", "GPZDA,,,,,,", "GPGLL"]
)
def test_blank_positions_are_never_zero_zero(body: str) -> None:
    assert read(body) == (OtherMessage(None, body[2:5]),)


@pytest.mark.parametrize(
    "place", ["-1.-5,N,01138.2500,W", "9112.0,N,01132.0,W", "5812.0,X,01132.0,W", "5812.0,N,18132.0,W", "7,N,8,E"]
)
def test_positions_that_cannot_be_are_refused(place: str) -> None:
    with pytest.raises(Unreadable):
        read(f"GPGLL,{place},134601.00,A")


def test_zda_gives_posix_seconds_and_ignores_its_zone() -> None:
    assert read("ECZDA,120000,01,06,2020,,") == (UtcTime(None, 1591012800.0, "ZDA"),)
    assert read("GPZDA,120000.50,01,06,2020,-1.-5,00") == (UtcTime(None, 1591012800.5, "ZDA"),)
    assert read("GPZDA,170948.50,31,02,2022,00,00") == (OtherMessage(None, "ZDA"),)


def test_the_short_year_of_rmc_is_1980_to_2079() -> None:
    for year, utc_s in (("94", 764380800.0), ("15", 1427068800.0)):
        (record, *_) = read(f"GPRMC,000000,A,,,,,,,2303{year},,,A")
        assert record == UtcTime(None, utc_s, "RMC")


def test_every_formatter_survives_any_number_of_blank_fields() -> None:
    for formatter in PARSERS:
        for fields in range(20):
            try:
                records = read(f"XX{formatter}" + "," * fields)
            except Unreadable as problem:
                assert problem.kind == "too_short"  # noqa: PT017
            else:
                assert all(isinstance(record, OtherMessage | RadarSettings) for record in records)


# ---------------------------------------------------------------------------------- a second road: pynmea2


@pytest.mark.parametrize(
    "body",
    [
        "GPRMC,134601,A,5744.5125,N,01138.2500,E,0.5,67.0,270715,2.9,E,A",
        "GPGGA,092725.00,4717.11399,N,00833.91590,W,1,08,1.01,499.6,M,48.0,M,,",
        "GPGLL,4717.11364,S,00833.91565,E,092321.00,A,A",
        "GNGNS,103600.01,5114.51176,N,00012.29380,W,ANNN,07,1.18,111.5,45.6,,",
    ],
)
def test_pynmea2_reads_the_same_position(body: str) -> None:
    theirs = pynmea2.parse(f"${body}*{checksum(body):02X}")
    ours = read(body)[-1]
    assert isinstance(ours, OwnPosition)
    assert ours.lat_deg == pytest.approx(theirs.latitude, abs=1e-12)
    assert ours.lon_deg == pytest.approx(theirs.longitude, abs=1e-12)
    time = theirs.timestamp
    assert ours.utc_of_day_s == pytest.approx(
        time.hour * 3600 + time.minute * 60 + time.second + time.microsecond / 1e6
    )


def test_pynmea2_numbers_the_fields_of_ttm_the_same_way() -> None:
    body = "RATTM,11,11.4,13.6,T,7.0,20.0,T,0.0,0.0,N,NAME,Q,,154125.82,A"
    theirs = pynmea2.parse(f"${body}*{checksum(body):02X}")
    ours = target(body)
    assert ours.number == int(theirs.target_number)
    assert ours.range_m == float(theirs.distance) * NM_M
    assert ours.bearing_deg == float(theirs.bearing)
    assert ours.speed_mps == float(theirs.speed) * KNOT_MPS
    assert ours.course_deg == float(theirs.cog)
    assert (ours.name, ours.status) == (theirs.name, theirs.status)
