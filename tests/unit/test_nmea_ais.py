"""AIS: values, not-available values, multi-part messages. The bits are packed here, field by field, without pyais."""

from __future__ import annotations

import pytest

from navfix.nmea import Reader
from navfix.nmea.framing import checksum
from navfix.nmea.records import AisPosition, AisStatic, OtherMessage, Record
from navfix.types import Hull
from navfix.units import KNOT_MPS


def bits(*fields: tuple[int, int]) -> str:
    """Pack (width, value) pairs; a negative value becomes two's complement."""
    return "".join(f"{value % (1 << width):0{width}b}" for width, value in fields)


def text_bits(text: str, characters: int) -> str:
    return "".join(f"{(ord(c) - 64 if ord(c) >= 64 else ord(c)):06b}" for c in text.ljust(characters, "@"))


def armour(stream: str) -> tuple[str, int]:
    fill = -len(stream) % 6
    stream += "0" * fill
    codes = (int(stream[i : i + 6], 2) for i in range(0, len(stream), 6))
    return "".join(chr(code + 48 if code < 40 else code + 56) for code in codes), fill


def sentence(
    payload: str,
    fill: int,
    *,
    total: int = 1,
    number: int = 1,
    sequence: str = "",
    channel: str = "A",
    address: str = "AIVDM",
) -> str:
    body = f"{address},{total},{number},{sequence},{channel},{payload},{fill}"
    return f"!{body}*{checksum(body):02X}"


def read(stream: str, address: str = "AIVDM") -> list[Record]:
    return Reader().feed(sentence(*armour(stream), address=address))


def position(stream: str, address: str = "AIVDM") -> AisPosition:
    record = read(stream, address)[0]
    assert isinstance(record, AisPosition)
    return record


LAT, LON = int(57.75 * 600000), int(-11.5 * 600000)
MMSI = 265547250


def class_a(
    *, kind: int = 1, mmsi: int = MMSI, status: int = 5, turn: int = 0, speed: int = 123, accuracy: int = 1,
    lon: int = LON, lat: int = LAT, course: int = 2250, heading: int = 231, second: int = 17,
) -> str:  # fmt: skip
    return bits(
        (6, kind), (2, 0), (30, mmsi), (4, status), (8, turn), (10, speed), (1, accuracy), (28, lon), (27, lat),
        (12, course), (9, heading), (6, second), (2, 0), (3, 0), (1, 0), (19, 0),
    )  # fmt: skip


def class_b(
    *, speed: int = 61, lon: int = LON, lat: int = LAT, course: int = 900, heading: int = 511, second: int = 60
) -> str:
    return bits(
        (6, 18), (2, 0), (30, MMSI), (8, 0), (10, speed), (1, 0), (28, lon), (27, lat), (12, course), (9, heading),
        (6, second), (2, 0), (7, 0), (20, 0),
    )  # fmt: skip


def dimensions(a: int, b: int, c: int, d: int) -> str:
    return bits((9, a), (9, b), (6, c), (6, d))


def static_a(hull: str = dimensions(100, 20, 7, 9)) -> str:
    head = bits((6, 5), (2, 0), (30, MMSI), (2, 0), (30, 9000001)) + text_bits("SKXY", 7) + text_bits("NORDIC STAR", 20)
    return head + bits((8, 70)) + hull + bits((4, 1), (20, 0), (8, 71)) + text_bits("GOTEBORG", 20) + "00"


def aid(
    *, mmsi: int = 992651001, aid_type: int = 1, name: str = "TRUBADUREN", extension: str = "", second: int = 61,
    off: int = 0, virtual: int = 0, hull: str = dimensions(0, 0, 0, 0),
) -> str:  # fmt: skip
    head = bits((6, 21), (2, 0), (30, mmsi), (5, aid_type)) + text_bits(name, 20) + bits((1, 0), (28, LON), (27, LAT))
    tail = bits((4, 1), (6, second), (1, off), (8, 0), (1, 0), (1, virtual), (1, 0), (1, 0))
    return head + hull + tail + text_bits(extension, len(extension))


@pytest.mark.parametrize("kind", [1, 2, 3])
def test_class_a_position_reports(kind: int) -> None:
    report = position(class_a(kind=kind, turn=-20))
    assert (report.message_type, report.mmsi, report.kind, report.ais_class) == (kind, MMSI, "ship", "A")
    assert (report.lat_deg, report.lon_deg) == (57.75, -11.5)
    assert report.speed_mps == pytest.approx(12.3 * KNOT_MPS)
    assert (report.course_deg, report.heading_deg, report.utc_second) == (225.0, 231.0, 17)
    assert (report.navigation_status, report.accurate, report.own) == (5, True, False)
    assert report.turn_rate_deg_per_min == pytest.approx(-((20 / 4.733) ** 2), abs=0.5)


def test_what_is_not_available_is_none() -> None:
    report = position(
        class_a(
            turn=-128, speed=1023, accuracy=0, lon=181 * 600000, lat=91 * 600000, course=3600, heading=511, second=60
        )
    )
    assert (report.lat_deg, report.lon_deg) == (None, None)
    assert report.speed_mps is None
    assert report.course_deg is None
    assert report.heading_deg is None
    assert report.utc_second is None
    assert report.turn_rate_deg_per_min is None
    assert not report.accurate


@pytest.mark.parametrize("turn", [127, -127])
def test_a_turn_without_indicator_has_no_rate(turn: int) -> None:
    assert position(class_a(turn=turn)).turn_rate_deg_per_min is None


def test_the_fastest_speed_is_a_speed() -> None:
    assert position(class_a(speed=1022)).speed_mps == pytest.approx(102.2 * KNOT_MPS)


@pytest.mark.parametrize(("lat", "lon"), [(91, 11), (57, 181), (-95, 0), (0, -185)])
def test_a_position_that_cannot_be_is_none(lat: int, lon: int) -> None:
    report = position(class_a(lat=lat * 600000, lon=lon * 600000))
    assert (report.lat_deg, report.lon_deg) == (None, None)


def test_vdo_is_own_ship() -> None:
    assert position(class_a(), address="AIVDO").own


def test_a_search_and_rescue_aircraft_is_an_aircraft_in_any_message() -> None:
    assert position(class_a(mmsi=111265001)).kind == "aircraft"
    report = position(
        bits(
            (6, 9),
            (2, 0),
            (30, 111265001),
            (12, 300),
            (10, 120),
            (1, 0),
            (28, LON),
            (27, LAT),
            (12, 900),
            (6, 5),
            (34, 0),
        )
    )
    assert (report.message_type, report.kind, report.course_deg) == (9, "aircraft", 90.0)
    assert report.speed_mps == pytest.approx(120 * KNOT_MPS)


def test_a_base_station_is_no_ship() -> None:
    date = ((14, 2015), (4, 7), (5, 27), (5, 13), (6, 46), (6, 1))
    report = position(
        bits((6, 4), (2, 0), (30, 2655000), *date, (1, 1), (28, LON), (27, LAT), (4, 1), (10, 0), (1, 0), (19, 0))
    )
    assert (report.kind, report.lat_deg, report.lon_deg) == ("base_station", 57.75, -11.5)


def test_class_b_position_reports() -> None:
    report = position(class_b())
    assert (report.ais_class, report.kind, report.message_type) == ("B", "ship", 18)
    assert (report.heading_deg, report.utc_second, report.course_deg) == (None, None, 90.0)
    assert report.speed_mps == pytest.approx(6.1 * KNOT_MPS)


def test_the_extended_class_b_report_gives_position_and_static_data() -> None:
    head = class_b()[6:139]
    stream = (
        bits((6, 19)) + head + "0000" + text_bits("SMALL BOAT", 20) + bits((8, 36)) + dimensions(5, 7, 2, 1) + "0" * 11
    )
    report, static = read(stream)
    hull = Hull(5.0, 7.0, 2.0, 1.0)
    assert isinstance(report, AisPosition)
    assert (report.hull, report.name, report.ship_type, report.message_type) == (hull, "SMALL BOAT", 36, 19)
    assert static == AisStatic(None, MMSI, 19, hull, 36, "SMALL BOAT")


def test_static_data_of_class_a() -> None:
    first, second = parts(static_a())
    reader = Reader()
    assert reader.feed(first) == []
    assert reader.feed(second) == [AisStatic(None, MMSI, 5, Hull(100.0, 20.0, 7.0, 9.0), 70, "NORDIC STAR")]


@pytest.mark.parametrize(
    ("hull", "expected"),
    [
        (dimensions(0, 0, 0, 0), None),
        (dimensions(0, 120, 0, 16), Hull(60.0, 60.0, 8.0, 8.0)),
        (dimensions(0, 120, 5, 11), Hull(0.0, 120.0, 5.0, 11.0)),
    ],
)
def test_dimensions_zero_are_unknown_and_without_reference_point_amidships(hull: str, expected: Hull | None) -> None:
    reader = Reader()
    (static,) = [record for part in parts(static_a(hull)) for record in reader.feed(part)]
    assert isinstance(static, AisStatic)
    assert static.hull == expected


def test_static_data_of_class_b_come_in_two_halves() -> None:
    a = bits((6, 24), (2, 0), (30, MMSI), (2, 0)) + text_bits("SMALL BOAT", 20) + "0" * 8
    assert read(a) == [AisStatic(None, MMSI, 24, name="SMALL BOAT")]
    b = bits((6, 24), (2, 0), (30, MMSI), (2, 1), (8, 36), (42, 0), (42, 0)) + dimensions(5, 7, 2, 1) + "0" * 6
    assert read(b) == [AisStatic(None, MMSI, 24, Hull(5.0, 7.0, 2.0, 1.0), 36)]


def test_ship_type_zero_is_not_available() -> None:
    stream = bits((6, 24), (2, 0), (30, MMSI), (2, 1), (8, 0), (42, 0), (42, 0)) + dimensions(5, 7, 2, 1) + "0" * 6
    assert read(stream) == [AisStatic(None, MMSI, 24, Hull(5.0, 7.0, 2.0, 1.0), None)]


def test_an_auxiliary_craft_sends_its_mother_ship_in_place_of_dimensions() -> None:
    stream = bits((6, 24), (2, 0), (30, 982655001), (2, 1), (8, 36), (42, 0), (42, 0), (30, MMSI), (6, 0))
    assert read(stream) == [AisStatic(None, 982655001, 24, None, 36)]


def test_aids_to_navigation() -> None:
    report = position(aid(hull=dimensions(2, 3, 2, 3)))
    assert (report.kind, report.mmsi, report.aid_type, report.name) == ("aton", 992651001, 1, "TRUBADUREN")
    assert report.hull == Hull(2.0, 3.0, 2.0, 3.0)
    assert not report.virtual
    assert report.ais_class is None
    assert position(aid(virtual=1)).virtual


@pytest.mark.parametrize(
    ("second", "off", "expected"), [(59, 1, True), (0, 1, True), (30, 0, False), (60, 1, False), (63, 1, False)]
)
def test_off_position_is_valid_only_with_a_time(second: int, off: int, expected: bool) -> None:
    assert position(aid(second=second, off=off)).off_position is expected


@pytest.mark.parametrize(
    ("name", "extension", "expected"),
    [
        ("NORTH CARDINAL BUOY ", "OF VINGA", "NORTH CARDINAL BUOY OF VINGA"),
        ("ABCDEFGHIJKLMNOPQRST", "UVW", "ABCDEFGHIJKLMNOPQRSTUVW"),
        ("VINGA", "", "VINGA"),
        ("", "", None),
    ],
)
def test_long_names_go_on_in_the_extension(name: str, extension: str, expected: str | None) -> None:
    assert position(aid(name=name, extension=extension)).name == expected


def test_long_range_reports_are_coarse_and_marked() -> None:
    stream = bits(
        (6, 27), (2, 0), (30, MMSI), (1, 0), (1, 0), (4, 0), (18, -6900), (17, 34650), (6, 12), (9, 225), (1, 0), (1, 0)
    )
    report = position(stream)
    assert (report.kind, report.lat_deg, report.lon_deg) == ("long_range", 57.75, -11.5)
    assert report.speed_mps == pytest.approx(12 * KNOT_MPS)
    stream = bits(
        (6, 27),
        (2, 0),
        (30, MMSI),
        (1, 0),
        (1, 0),
        (4, 0),
        (18, 108600),
        (17, 54600),
        (6, 63),
        (9, 511),
        (1, 0),
        (1, 0),
    )
    report = position(stream)
    assert (report.lat_deg, report.speed_mps, report.course_deg) == (None, None, None)


@pytest.mark.parametrize("kind", [6, 7, 8, 10, 11, 12, 13, 14, 15, 16, 17, 20, 22, 23, 25, 26, 28, 63, 0])
def test_messages_of_no_use_are_not_decoded(kind: int) -> None:
    assert read(bits((6, kind))) == [OtherMessage(None, "VDM")]


@pytest.mark.parametrize("length", [6, 38, 60, 100, 142])
def test_a_message_cut_short_is_refused_not_half_read(length: int) -> None:
    reader = Reader()
    assert reader.feed(sentence(*armour(class_a()[:length]))) == []
    assert [problem.kind for problem in reader.problems] == ["ais_short"]


def test_the_second_half_of_class_b_static_data_without_dimensions_is_refused() -> None:
    reader = Reader()
    stream = bits((6, 24), (2, 0), (30, MMSI), (2, 1), (8, 36), (42, 0), (42, 0))
    assert reader.feed(sentence(*armour(stream))) == []
    assert [problem.kind for problem in reader.problems] == ["ais_short"]


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        ("!AIVDM,1,1,,A,,0*26", "ais_empty"),
        (sentence("1000000 0000 xyz", 0), "ais_payload"),
        (sentence("1000000000000000000000000000", 7), "ais_sentence"),
        (sentence("1000000000000000000000000000", 0, total=2, number=3), "ais_sentence"),
        (sentence("1000000000000000000000000000", 0, total=0, number=0), "ais_sentence"),
        ("!AIVDM,1,1*" + f"{checksum('AIVDM,1,1'):02X}", "ais_sentence"),
        ("!AIVDM,x,1,,A,1,0*" + f"{checksum('AIVDM,x,1,,A,1,0'):02X}", "ais_sentence"),
    ],
)
def test_bad_sentences_are_counted_by_kind(line: str, kind: str) -> None:
    reader = Reader()
    assert reader.feed(line) == []
    assert [problem.kind for problem in reader.problems] == [kind]


def test_lines_with_an_extra_field_are_read() -> None:
    payload, fill = armour(class_a())
    body = f"AIVDM,1,1,7,,{payload},{fill},{fill}"
    assert Reader().feed(f"!{body}*{checksum(body):02X}") == read(class_a())


# ------------------------------------------------------------------------------------------- multi-part messages


def parts(stream: str, *, sequence: str = "1", channel: str = "A", cut: int = 40) -> list[str]:
    payload, fill = armour(stream)
    return [
        sentence(payload[:cut], 0, total=2, number=1, sequence=sequence, channel=channel),
        sentence(payload[cut:], fill, total=2, number=2, sequence=sequence, channel=channel),
    ]


def names(reader: Reader, lines: list[str]) -> list[str | None]:
    return [record.name for line in lines for record in reader.feed(line) if isinstance(record, AisStatic)]


def other_ship(name: str) -> str:
    return static_a().replace(text_bits("NORDIC STAR", 20), text_bits(name, 20))


def test_parts_of_several_messages_may_be_interleaved() -> None:
    a = parts(other_ship("ALPHA"), sequence="1")
    b = parts(other_ship("BRAVO"), sequence="2")
    c = parts(other_ship("CHARLIE"), sequence="1", channel="B")
    reader = Reader()
    assert names(reader, [a[0], b[0], c[0], b[1], c[1], a[1]]) == ["BRAVO", "CHARLIE", "ALPHA"]
    assert reader.counts == {"AIVDM": 6}


def test_parts_may_come_in_the_wrong_order() -> None:
    a = parts(other_ship("ALPHA"))
    assert names(Reader(), a[::-1]) == ["ALPHA"]


def test_tag_groups_keep_equal_sequence_numbers_apart() -> None:
    def grouped(number: int, group: str, line: str) -> str:
        body = f"g:{number}-2-{group}"
        return f"\\{body}*{checksum(body):02X}\\{line}"

    a, b = parts(other_ship("ALPHA")), parts(other_ship("BRAVO"))
    lines = [grouped(1, "11", a[0]), grouped(1, "12", b[0]), grouped(2, "11", a[1]), grouped(2, "12", b[1])]
    assert names(Reader(), lines) == ["ALPHA", "BRAVO"]


def test_sources_keep_equal_sequence_numbers_apart() -> None:
    def sourced(source: str, line: str) -> str:
        body = f"s:{source},c:1418169601"
        return f"\\{body}*{checksum(body):02X}\\{line}"

    a, b = parts(other_ship("ALPHA")), parts(other_ship("BRAVO"))
    lines = [sourced("S1", a[0]), sourced("S2", b[0]), sourced("S1", a[1]), sourced("S2", b[1])]
    assert names(Reader(), lines) == ["ALPHA", "BRAVO"]


def test_a_source_named_on_one_part_only_does_no_harm() -> None:
    first, second = parts(other_ship("ALPHA"))
    assert names(Reader(), [first, second + ",b003000001"]) == ["ALPHA"]


def test_the_time_of_a_message_is_that_of_its_first_part() -> None:
    first, second = parts(static_a())
    reader = Reader()
    reader.feed(first, at=100.0)
    (static,) = reader.feed(second, at=103.0)
    assert static.time_s == 100.0


def test_a_lost_part_is_counted_and_never_joined_with_another_message() -> None:
    a, b = parts(other_ship("ALPHA")), parts(other_ship("BRAVO"))
    reader = Reader()
    assert names(reader, [a[0], b[0], b[1]]) == ["BRAVO"]
    reader.close()
    assert [(problem.kind, problem.count) for problem in reader.problems] == [("ais_incomplete", 1)]


def test_a_part_that_comes_half_a_minute_late_belongs_to_another_message() -> None:
    a, b = parts(other_ship("ALPHA")), parts(other_ship("BRAVO"))
    reader = Reader()
    reader.feed(a[0], at=0.0)
    assert reader.feed(b[1], at=31.0) == []
    reader.close()
    assert [(problem.kind, problem.count) for problem in reader.problems] == [("ais_incomplete", 2)]


def test_parts_that_never_end_do_not_pile_up() -> None:
    reader = Reader()
    for index in range(500):
        reader.feed(sentence("5" * 20, 0, total=2, number=1, sequence=str(index % 10), channel=str(index)))
    reader.close()
    assert [(problem.kind, problem.count) for problem in reader.problems] == [("ais_incomplete", 500)]
