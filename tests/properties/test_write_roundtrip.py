"""What is written reads back: parse(render(record)) says what the record said, to the resolution of the fields."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navfix.nmea import read_log, write, write_ais
from navfix.nmea.records import AisPosition, OwnHeading, OwnPosition, TargetReport
from navfix.types import Position
from navfix.units import KNOT_MPS, NM_M, wrap_180

START_S = 1772355600.0
angles = st.floats(-720.0, 720.0)
latitudes, longitudes = st.floats(-89.9, 89.9), st.floats(-180.0, 179.9999999)


def read(text: str, kind: type) -> object:
    """Read one line with a TAG block and return its only record of a kind."""
    log = read_log([write.tag_block(START_S, "XX0001") + text])
    assert log.problems == ()
    (record,) = [record for record in log.records if isinstance(record, kind)]
    return record


@settings(max_examples=60, deadline=None)
@given(
    number=st.integers(0, 99),
    range_m=st.floats(20.0, 80000.0),
    bearing_deg=angles,
    reference=st.sampled_from(["relative", "true"]),
    speed_mps=st.none() | st.floats(0.0, 40.0),
    course_deg=angles,
    status=st.sampled_from(["Q", "T", "L"]),
)
def test_a_target_reads_back(
    number: int,
    range_m: float,
    bearing_deg: float,
    reference: str,
    speed_mps: float | None,
    course_deg: float,
    status: str,
) -> None:
    report = TargetReport(
        time_s=START_S,
        number=number,
        range_m=range_m,
        bearing_deg=bearing_deg,
        bearing_reference=reference,  # type: ignore[arg-type]
        speed_mps=speed_mps,
        course_deg=None if speed_mps is None else course_deg,
        course_reference="true",
        status=status,
        utc_of_day_s=12.5,
    )
    back = read(write.ttm(report), TargetReport)
    assert isinstance(back, TargetReport)
    assert (back.number, back.bearing_reference, back.status, back.utc_of_day_s) == (number, reference, status, 12.5)
    assert back.range_m == pytest.approx(range_m, abs=0.005001 * NM_M)
    assert 0.0 <= back.bearing_deg < 360.0
    assert abs(wrap_180(back.bearing_deg - bearing_deg)) < 0.0501
    if speed_mps is None:
        assert back.speed_mps is None
    else:
        assert back.speed_mps == pytest.approx(speed_mps, abs=0.0501 * KNOT_MPS)
        assert back.course_deg is not None
        assert abs(wrap_180(back.course_deg - course_deg)) < 0.0501


@settings(max_examples=60, deadline=None)
@given(lat_deg=latitudes, lon_deg=longitudes, kind=st.sampled_from([1, 3, 18, 19, 21]))
def test_an_ais_position_reads_back(lat_deg: float, lon_deg: float, kind: int) -> None:
    report = AisPosition(
        time_s=START_S,
        mmsi=200100001,
        message_type=kind,
        kind="aton" if kind == 21 else "ship",
        lat_deg=lat_deg,
        lon_deg=lon_deg,
    )
    (text,) = write_ais.position_report(report)
    back = read(text, AisPosition)
    assert isinstance(back, AisPosition)
    assert back.lat_deg == pytest.approx(lat_deg, abs=1.5e-6)
    assert back.lon_deg is not None
    assert abs(wrap_180(back.lon_deg - lon_deg)) < 1.5e-6


@settings(max_examples=60, deadline=None)
@given(lat_deg=latitudes, lon_deg=longitudes)
def test_own_gnss_reads_back(lat_deg: float, lon_deg: float) -> None:
    for text in (write.rmc(START_S, Position(lat_deg, lon_deg)), write.gga(START_S, Position(lat_deg, lon_deg))):
        back = read(text, OwnPosition)
        assert isinstance(back, OwnPosition)
        assert back.lat_deg == pytest.approx(lat_deg, abs=2e-7)
        assert abs(wrap_180(back.lon_deg - lon_deg)) < 2e-7


@settings(max_examples=60, deadline=None)
@given(heading_deg=angles)
def test_a_heading_reads_back(heading_deg: float) -> None:
    for text in (write.hdt(heading_deg), write.ths(heading_deg)):
        back = read(text, OwnHeading)
        assert isinstance(back, OwnHeading)
        assert abs(wrap_180(back.heading_deg - heading_deg)) < 0.0501
