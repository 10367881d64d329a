"""Whatever comes in, nothing is raised; what is written is read again."""

from __future__ import annotations

import math
from collections import Counter

from hypothesis import given, settings
from hypothesis import strategies as st

from navfix.nmea import Reader, write, write_ais
from navfix.nmea.clock import SentenceClock
from navfix.nmea.framing import checksum
from navfix.nmea.records import AisPosition, AisStatic, OwnHeading, OwnPosition, OwnSpeed, TargetReport
from navfix.types import Hull, Position
from navfix.units import KNOT_MPS, NM_M, wrap_180

ADDRESSES = [
    "RATTM", "RATLL", "RARSD", "RAOSD", "HEHDT", "HETHS", "HCHDG", "HCHDM", "VWVHW", "VDVBW", "GPVTG", "TIROT", "GPZDA",
    "GPRMC", "GPGGA", "GPGLL", "GNGNS", "AIVDM", "AIVDO", "BSVDM", "GPGSV", "PGRME",
]  # fmt: skip
FIELD = st.one_of(
    st.sampled_from(["", " ", "T", "R", "N", "S", "E", "W", "A", "V", "K", "M", "-1.-5", "nan", "1e5", "1_0", "٣"]),
    st.integers(-5, 400).map(str),
    st.floats(-1e4, 1e4).map(lambda value: f"{value:.3f}"),
    st.text(max_size=8),
    st.sampled_from(["134601", "134601.5", "270715", "5744.5125", "01138.2500", "1" + "0" * 27]),
)


def sealed(start: str, body: str) -> bytes:
    data = body.encode("utf-8", "replace")
    value = 0
    for byte in data:
        value ^= byte
    return start.encode() + data + f"*{value:02X}".encode()


@given(st.binary(max_size=200))
def test_no_line_of_bytes_is_ever_an_error(line: bytes) -> None:
    Reader().feed(line)


@given(st.text(max_size=200), st.none() | st.floats(0.0, 4e9))
def test_no_line_of_text_is_ever_an_error(line: str, at: float | None) -> None:
    Reader().feed(line, at)


@given(st.lists(st.tuples(st.sampled_from(ADDRESSES), st.lists(FIELD, max_size=16)), max_size=8), st.booleans())
@settings(max_examples=300)
def test_no_sentence_of_any_fields_is_ever_an_error_and_every_value_is_sane(
    sentences: list[tuple[str, list[str]]], tagged: bool
) -> None:
    reader = Reader()
    for address, fields in sentences:
        line = sealed("!" if address.endswith(("VDM", "VDO")) else "$", ",".join([address, *fields]))
        prefix = sealed("\\", f"s:X1,c:{','.join(fields[:2])}") + b"\\" if tagged else b""
        for record in reader.feed(prefix + line):
            if isinstance(record, TargetReport):
                assert 0.0 < record.range_m < math.inf
                assert 0.0 <= record.bearing_deg < 360.0
            if isinstance(record, OwnPosition):
                assert abs(record.lat_deg) <= 90.0
                assert abs(record.lon_deg) <= 180.0
            if isinstance(record, OwnHeading):
                assert 0.0 <= record.heading_deg < 360.0
    reader.close()


@given(st.integers(0, 27), st.integers(1, 70), st.integers(0, 5), st.randoms(use_true_random=False))
@settings(max_examples=300)
def test_no_payload_is_ever_an_error(kind: int, length: int, fill: int, random: object) -> None:
    alphabet = "0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVW`abcdefghijklmnopqrstuvw"
    payload = alphabet[kind] + "".join(random.choice(alphabet) for _ in range(length - 1))  # type: ignore[attr-defined]
    reader = Reader()
    for record in reader.feed(sealed("!", f"AIVDM,1,1,,A,{payload},{fill}")):
        if isinstance(record, AisPosition):
            assert (record.lat_deg is None) == (record.lon_deg is None)
            assert record.lat_deg is None or abs(record.lat_deg) <= 90.0
            assert record.heading_deg is None or 0.0 <= record.heading_deg < 360.0
            assert record.message_type == kind


@given(st.data())
def test_a_changed_character_is_counted_and_dropped(data: st.DataObject) -> None:
    body = "RATTM,01,1.07,338.5,R,11.7,49.5,T,,,N,,T,,134601,A"
    index = data.draw(st.integers(6, len(body) - 1))
    other = data.draw(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters=f"{body[index]}*$!"))
    reader = Reader()
    assert reader.feed(f"${body[:index]}{other}{body[index + 1 :]}*{checksum(body):02X}") == []
    assert Counter(problem.kind for problem in reader.problems) == {"checksum": 1}
    assert reader.counts == {}


TARGETS = st.builds(
    TargetReport,
    time_s=st.none(),
    number=st.integers(0, 999),
    range_m=st.integers(1, 9600).map(lambda hundredths: hundredths / 100.0 * NM_M),
    bearing_deg=st.integers(0, 3599).map(lambda tenths: tenths / 10.0),
    bearing_reference=st.sampled_from(["relative", "true"]),
    speed_mps=st.none() | st.integers(0, 600).map(lambda tenths: tenths / 10.0 * KNOT_MPS),
    course_deg=st.none() | st.integers(0, 3599).map(lambda tenths: tenths / 10.0),
    status=st.sampled_from([None, "L", "Q", "T"]),
    name=st.none()
    | st.text("ABCDEFGHIJKLMNOPQRSTUVWXYZ 0123456789", min_size=1, max_size=12).map(str.strip).filter(bool),
    utc_of_day_s=st.none() | st.integers(0, 8639999).map(lambda hundredths: hundredths / 100.0),
    range_resolution_m=st.just(0.01 * NM_M),
    bearing_resolution_deg=st.just(0.1),
    talker=st.just("RA"),
)


@given(TARGETS)
def test_a_target_that_is_written_is_read_again(report: TargetReport) -> None:
    (found,) = Reader().feed(write.ttm(report))
    assert isinstance(found, TargetReport)
    for name in ("number", "bearing_reference", "status", "name", "talker"):
        assert getattr(found, name) == getattr(report, name)
    for name in (
        "range_m",
        "bearing_deg",
        "speed_mps",
        "course_deg",
        "utc_of_day_s",
        "range_resolution_m",
        "bearing_resolution_deg",
    ):
        one, other = getattr(found, name), getattr(report, name)
        assert (one is None) == (other is None)
        assert one is None or math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9)


@given(st.floats(-89.9, 89.9), st.floats(-180.0, 179.99), st.integers(0, 4_000_000_000), st.integers(0, 99))
def test_a_position_that_is_written_is_read_again(lat_deg: float, lon_deg: float, second: int, hundredth: int) -> None:
    time_s = second + hundredth / 100.0
    for line in (write.rmc(time_s, Position(lat_deg, lon_deg)), write.gga(time_s, Position(lat_deg, lon_deg))):
        found = Reader().feed(line)[-1]
        assert isinstance(found, OwnPosition)
        assert abs(found.lat_deg - lat_deg) < 1e-7  # 1 cm: five decimals of a minute
        assert abs(wrap_180(found.lon_deg - lon_deg)) < 1e-7
        assert found.utc_of_day_s is not None
        assert abs(found.utc_of_day_s - time_s % 86400.0) < 0.006


@given(st.integers(0, 3599), st.integers(0, 4000))
def test_heading_and_log_that_are_written_are_read_again(tenths: int, hundredths: int) -> None:
    heading, speed = Reader().feed(write.vhw(heading_deg=tenths / 10.0, speed_mps=hundredths / 100.0 * KNOT_MPS))
    assert isinstance(heading, OwnHeading)
    assert isinstance(speed, OwnSpeed)
    assert heading.heading_deg == tenths / 10.0
    assert speed.speed_mps is not None
    assert math.isclose(speed.speed_mps, hundredths / 100.0 * KNOT_MPS, abs_tol=1e-9)


@given(
    st.sampled_from([(1, "A"), (2, "A"), (3, "A"), (18, "B"), (19, "B")]),
    st.integers(2_000_000, 799_999_999).filter(lambda mmsi: mmsi // 1_000_000 != 111),
    st.floats(-90.0, 90.0),
    st.floats(-180.0, 180.0),
    st.none() | st.integers(0, 1022),
    st.none() | st.integers(0, 3599),
    st.none() | st.integers(0, 359),
    st.none() | st.integers(0, 59),
)
def test_an_ais_position_that_is_written_is_read_again(
    kind: tuple[int, str], mmsi: int, lat_deg: float, lon_deg: float, speed: int | None, course: int | None,
    heading: int | None, second: int | None,
) -> None:  # fmt: skip
    report = AisPosition(
        None, mmsi, kind[0], "ship", lat_deg, lon_deg, True,
        speed_mps=None if speed is None else speed / 10.0 * KNOT_MPS,
        course_deg=None if course is None else course / 10.0,
        heading_deg=heading, utc_second=second, ais_class=kind[1],  # type: ignore[arg-type]
    )  # fmt: skip
    reader = Reader()
    found = next(
        r for line in write_ais.position_report(report) for r in reader.feed(line) if isinstance(r, AisPosition)
    )
    assert (found.mmsi, found.message_type, found.ais_class, found.accurate) == (mmsi, kind[0], kind[1], True)
    assert found.lat_deg is not None
    assert found.lon_deg is not None
    assert abs(found.lat_deg - lat_deg) < 2e-6
    assert abs(found.lon_deg - lon_deg) < 2e-6
    assert (found.heading_deg, found.utc_second) == (heading, second)
    assert found.course_deg == report.course_deg
    assert (found.speed_mps is None) == (speed is None)
    assert found.speed_mps is None or math.isclose(found.speed_mps, report.speed_mps or 0.0, abs_tol=1e-6)


@given(st.sampled_from([5, 24]), st.integers(0, 511), st.integers(0, 511), st.integers(0, 63), st.integers(0, 63))
def test_dimensions_that_are_written_are_read_again(kind: int, a: int, b: int, c: int, d: int) -> None:
    known = a + b + c + d > 0 and not (a == c == 0 and b and d)
    hull = Hull(float(a), float(b), float(c), float(d)) if known else None
    reader = Reader()
    lines = write_ais.static_report(AisStatic(None, 265547250, kind, hull, 70, "NORDIC STAR"))
    found = [record for line in lines for record in reader.feed(line)]
    statics = [record for record in found if isinstance(record, AisStatic)]
    assert next(record.name for record in statics if record.name) == "NORDIC STAR"
    assert next((record.hull for record in statics if record.hull), None) == hull


@given(st.lists(st.floats(0.0, 60.0), min_size=1, max_size=60), st.floats(86000.0, 86399.0))
def test_times_of_day_always_run_forward_as_far_as_they_were_told(steps: list[float], start: float) -> None:
    clock = SentenceClock()
    true_s = start
    clock.time_of_day(true_s, rank=1, speaker="GPGGA")
    for step in steps:
        true_s += step
        clock.time_of_day(true_s % 86400.0, rank=1, speaker="GPGGA")
        assert clock.now_s is not None
        assert abs(clock.now_s - true_s) < 1e-6
