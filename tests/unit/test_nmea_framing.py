"""Lines as they come: headers, TAG blocks, stamps, comments, checksums."""

from __future__ import annotations

import pytest

from navfix.nmea.framing import Unreadable, as_text, checksum, frame

HDT = "$HEHDT,123.4,T"


def closed(body: str) -> str:
    return f"{body}*{checksum(body[1:]):02X}"


def tag(body: str) -> str:
    return f"\\{body}*{checksum(body):02X}\\"


def test_a_plain_sentence_is_cut_into_address_and_fields() -> None:
    found = frame("$GPGLL,5133.81,N,00042.25,W*75")  # the example that NMEA texts print everywhere
    assert found is not None
    assert (found.talker, found.formatter) == ("GP", "GLL")
    assert found.values == ["GPGLL", "5133.81", "N", "00042.25", "W"]
    assert found.checked
    assert not found.encapsulated
    assert found.time_s is None


def test_a_wrong_checksum_is_named_with_the_right_one() -> None:
    with pytest.raises(Unreadable, match=r"printed \*74.*gives \*75") as caught:
        frame("$GPGLL,5133.81,N,00042.25,W*74")
    assert caught.value.kind == "checksum"


@pytest.mark.parametrize("printed", ["75", "7", "FF", "0"])
def test_only_the_right_checksum_passes(printed: str) -> None:
    text = f"$GPGLL,5133.81,N,00042.25,W*{printed}"
    if printed == "75":
        assert frame(text) is not None
    else:
        with pytest.raises(Unreadable):
            frame(text)


def test_a_checksum_without_leading_zero_is_read() -> None:
    bodies = (f"HEROT,{tenths / 10:.1f},{status}" for tenths in range(3600) for status in "AV")
    small = next(body for body in bodies if checksum(body) < 16)
    found = frame(f"${small}*{checksum(small):X}")  # as some converters write it
    assert found is not None
    assert found.checked


def test_lower_case_checksums_are_read() -> None:
    body = "$HEHDT,123.5,T"
    assert frame(f"{body}*{checksum(body[1:]):02x}") is not None


def test_bom_crlf_and_blanks_do_no_harm() -> None:
    for line in (
        b"\xef\xbb\xbf" + closed(HDT).encode() + b"\r\n",
        "\ufeff" + closed(HDT) + "\r\n",
        "  " + closed(HDT) + " \r",
    ):
        found = frame(as_text(line))
        assert found is not None
        assert found.values[1] == "123.4"


def test_a_tag_block_gives_time_source_and_group() -> None:
    found = frame(tag("g:1-2-77,s:rSTATION008,c:1418169601") + closed(HDT))
    assert found is not None
    assert (found.time_s, found.source, found.group) == (1418169601.0, "rSTATION008", (1, 2, "77"))


def test_a_tag_time_in_milliseconds_is_told_by_its_size() -> None:
    found = frame(tag("c:1418169601250") + closed(HDT))
    assert found is not None
    assert found.time_s == pytest.approx(1418169601.25, abs=1e-6)


def test_several_tag_blocks_are_read_together() -> None:
    found = frame(tag("s:RA0001") + tag("c:1418169601") + closed(HDT))
    assert found is not None
    assert (found.time_s, found.source) == (1418169601.0, "RA0001")


def test_a_tag_block_with_wrong_checksum_is_not_believed_but_its_sentence_is() -> None:
    found = frame("\\s:RA0001,c:1418169601*00\\" + closed(HDT))
    assert found is not None
    assert found.time_s is None
    assert found.source is None
    assert "checksum" in (found.trouble or "")
    assert found.values[1] == "123.4"


@pytest.mark.parametrize("time", ["x", "-5", "99999999999999999999", "", "1e9", "nan"])
def test_a_tag_time_that_is_none_is_named(time: str) -> None:
    found = frame(tag(f"c:{time}") + closed(HDT))
    assert found is not None
    assert found.time_s is None
    assert "POSIX" in (found.trouble or "")


def test_a_tag_block_alone_is_no_sentence_and_no_problem() -> None:
    assert frame(tag("s:RA0001,c:1418169601")) is None


def test_an_open_tag_block_keeps_its_sentence() -> None:
    found = frame("\\s:RA0001,c:1418169601*00 " + closed(HDT))
    assert found is not None
    assert found.time_s is None
    assert found.trouble is not None


def test_the_datagram_header_of_iec_61162_450_is_taken_off() -> None:
    found = frame("UdPbC\x00" + tag("s:IN0001,n:1") + closed(HDT))
    assert found is not None
    assert (found.source, found.formatter) == ("IN0001", "HDT")


@pytest.mark.parametrize(
    ("prefix", "time_s"),
    [
        ("2016-01-12T13:02:11.250Z ", 1452603731.25),
        ("2016-01-12 13:02:11.250,", 1452603731.25),
        ("2016-01-12T14:02:11.250+01:00;", 1452603731.25),
        ("1452603731;", 1452603731.0),
        ("1452603731.25 ", 1452603731.25),
        ("1452603731250;A;", 1452603731.25),
        ("1452603731250000\t", 1452603731.25),
        ('"2016-01-12T13:02:11.250Z","AIS","', 1452603731.25),
    ],
)
def test_stamps_before_the_sentence_are_read(prefix: str, time_s: float) -> None:
    found = frame(prefix + closed(HDT))
    assert found is not None
    assert found.time_s == pytest.approx(time_s, abs=1e-5)


def test_a_clock_stamp_without_date_is_kept_apart() -> None:
    found = frame("13:02:11.5 " + closed(HDT))
    assert found is not None
    assert found.time_s is None
    assert found.clock_s == 13 * 3600 + 2 * 60 + 11.5


@pytest.mark.parametrize("prefix", ["2016-13-45T13:02:11Z ", "42 ", "noise ", "12-34-56 "])
def test_a_stamp_that_is_no_time_is_no_time(prefix: str) -> None:
    found = frame(prefix + closed(HDT))
    assert found is not None
    assert found.time_s is None


@pytest.mark.parametrize(
    ("suffix", "source", "time_s"),
    [
        (",b003000001,1452603731", "b003000001", 1452603731.0),
        (",rSHORE_01,1452603731", "rSHORE_01", 1452603731.0),
        (",d-100,S2000,t130211.00,T11.5,r003000001,1452603731,1452603699", "r003000001", 1452603731.0),
        (",s30000,d-080,T59.5", None, None),
        ("\\x0d\\x0a", None, None),
        ("   ", None, None),
    ],
)
def test_what_shore_stations_write_behind_the_sentence(suffix: str, source: str | None, time_s: float | None) -> None:
    found = frame(closed(HDT) + suffix)
    assert found is not None
    assert (found.source, found.time_s) == (source, time_s)


def test_the_tag_block_goes_before_the_stamp() -> None:
    found = frame(tag("c:1418169601") + "1452603731;" + closed(HDT) + ",r003000001,1325394060")
    assert found is not None
    assert found.time_s == 1418169601.0


@pytest.mark.parametrize("line", ["", "   ", "\r\n", "# $HEHDT,123.4,T*00", "#GPRMC,120000,A,5744.5125,N*00"])
def test_blank_lines_and_comments_are_passed_over(line: str) -> None:
    assert frame(line) is None


@pytest.mark.parametrize("line", ["hello", "AIVDM,1,1,,A,1000000000000,2*26", "Time,MMSI,Latitude", "$,,,", "$AB,1*00"])
def test_text_without_a_sentence_is_named(line: str) -> None:
    with pytest.raises(Unreadable) as caught:
        frame(line)
    assert caught.value.kind == "no_sentence"


def test_bytes_that_are_no_text_are_named_binary() -> None:
    with pytest.raises(Unreadable) as caught:
        frame(as_text(bytes(range(32))))
    assert caught.value.kind == "binary"


def test_a_proprietary_address_stays_whole() -> None:
    found = frame("$PGRME,15.0,M,45.0,M,25.0,M*1C")
    assert found is not None
    assert (found.formatter, found.talker) == ("PGRME", "")


def test_names_in_utf_8_keep_their_checksum() -> None:
    body = "RATTM,01,1.0,90.0,R,,,,,,N,Skärgård,T,"
    value = 0
    for byte in body.encode("utf-8"):
        value ^= byte
    line = f"${body}*{value:02X}"
    assert frame(as_text(line)) == frame(as_text(line.encode("utf-8")))
