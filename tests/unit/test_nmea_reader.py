"""The reader: counts, problems, time, datagrams."""

from __future__ import annotations

import pytest

from navfix.nmea import Reader
from navfix.nmea.framing import checksum
from navfix.nmea.records import OtherMessage, OwnHeading, TargetReport


def closed(body: str) -> str:
    return f"${body}*{checksum(body):02X}"


def tag(body: str) -> str:
    return f"\\{body}*{checksum(body):02X}\\"


def ttm(number: int = 1, utc: str = "") -> str:
    return closed(f"RATTM,{number:02d},1.07,338.5,R,11.7,49.5,T,,,N,,T,,{utc},A")


def test_a_line_gives_its_record_and_is_counted() -> None:
    reader = Reader()
    (report,) = reader.feed(ttm(), at=100.0)
    assert isinstance(report, TargetReport)
    assert report.time_s == 100.0
    assert reader.counts == {"TTM": 1}
    assert reader.lines == 1
    assert reader.problems == ()


def test_sentences_of_no_use_are_counted_too() -> None:
    reader = Reader()
    assert reader.feed(closed("GPGSV,1,1,00")) == [OtherMessage(None, "GSV")]
    assert reader.feed(closed("PSMDCN,2")) == [OtherMessage(None, "PSMDCN")]
    assert reader.counts == {"GSV": 1, "PSMDCN": 1}


def test_a_wrong_checksum_is_counted_as_a_problem_and_dropped() -> None:
    reader = Reader()
    for _ in range(3):
        assert reader.feed(ttm()[:-2] + "00") == []
    assert reader.counts == {}
    (problem,) = reader.problems
    assert (problem.kind, problem.count, problem.first_line) == ("checksum", 3, 1)
    assert problem.first_text.startswith("$RATTM,01")
    assert "3 x checksum" in str(problem)


def test_problems_come_most_frequent_first() -> None:
    reader = Reader()
    for line in ("hello", ttm()[:-2] + "00", ttm()[:-2] + "00"):
        reader.feed(line)
    assert [(problem.kind, problem.first_line) for problem in reader.problems] == [("checksum", 2), ("no_sentence", 1)]


def test_a_sender_that_had_checksums_and_now_has_none_was_cut_short() -> None:
    reader = Reader()
    reader.feed(ttm())
    assert reader.feed("$RATTM,02,1.07,33.0,R,11.7,49.5,T,,,N,,T,") == []
    assert [problem.kind for problem in reader.problems] == ["no_checksum"]


def test_a_sender_that_never_had_checksums_is_believed() -> None:
    (report,) = Reader().feed("$RATTM,02,1.07,33.0,R,11.7,49.5,T,,,N,,T,")
    assert isinstance(report, TargetReport)


def test_half_a_sentence_alone_is_a_problem() -> None:
    reader = Reader()
    assert reader.feed("$RATTM,01,1.07,33") == []
    assert [problem.kind for problem in reader.problems] == ["too_short"]


def test_a_datagram_of_several_lines_is_read_line_by_line() -> None:
    datagram = "UdPbC\x00" + tag("s:RA0001,n:1") + ttm(1) + "\r\n" + tag("s:RA0001,n:2") + ttm(2) + "\r\n"
    for data in (datagram, datagram.encode()):
        reader = Reader()
        records = reader.feed(data, at=5.0)
        assert [
            (record.number, record.source, record.time_s) for record in records if isinstance(record, TargetReport)
        ] == [
            (1, "RA0001", 5.0),
            (2, "RA0001", 5.0),
        ]
        assert reader.lines == 2


def test_the_tag_time_goes_before_the_stamp_and_the_stamp_before_the_hour_of_arrival() -> None:
    reader = Reader()
    stamped = "1452603731;" + ttm(utc="134601")
    assert reader.feed(tag("c:1418169601") + stamped, at=7.0)[0].time_s == 1418169601.0
    assert reader.feed(stamped, at=7.0)[0].time_s == 1452603731.0
    assert reader.feed(ttm(utc="134601"), at=7.0)[0].time_s == 7.0
    assert reader.time_basis == "reception"


def test_a_line_without_time_gets_that_of_the_line_shortly_before() -> None:
    reader = Reader()
    reader.feed(tag("c:1418169601") + ttm())
    assert reader.feed(ttm(utc="134601"))[0].time_s == 1418169601.0


def test_one_stamped_line_does_not_stop_the_time_of_a_log_for_good() -> None:
    reader = Reader()
    reader.feed("1438005000;" + ttm())
    for second in range(600):  # from 13:50:00 = 1438005000
        (record,) = reader.feed(closed(f"GPZDA,13{50 + second // 60:02d}{second % 60:02d}.00,27,07,2015,00,00"))
    assert record.time_s == 1438005000.0 + 599.0


def test_sentence_time_of_rmc_dates_what_follows() -> None:
    reader = Reader()
    assert reader.feed(ttm())[0].time_s is None
    reader.feed(closed("GPRMC,235959.50,A,5744.5125,N,01138.2500,E,0.0,67.0,270715,2.9,E,A"))
    (report,) = reader.feed(ttm())
    assert report.time_s == 1438041599.5
    (late,) = reader.feed(ttm(utc="000001.00"))
    assert late.time_s == 1438041599.5  # GNSS leads
    reader.feed(closed("GPRMC,000001.00,A,5744.5125,N,01138.2500,E,0.0,67.0,280715,2.9,E,A"))
    assert reader.feed(ttm())[0].time_s == 1438041601.0
    assert reader.time_basis == "sentence"


def test_a_log_with_times_of_day_only_runs_on_over_midnight_on_a_declared_day() -> None:
    reader = Reader()
    times = [reader.feed(ttm(utc=utc))[0].time_s for utc in ("235958", "235959.5", "000000", "000001.5")]
    assert times == [86398.0, 86399.5, 86400.0, 86401.5]
    assert reader.time_basis == "time_of_day"


def test_a_magnetic_heading_without_variation_gets_that_of_the_last_hdg() -> None:
    reader = Reader()
    assert reader.feed(closed("HCHDM,100.0,M"))[0] == OwnHeading(None, 100.0, "magnetic", "HDM")
    reader.feed(closed("HCHDG,100.0,,,2.9,W"))
    assert reader.feed(closed("HCHDM,100.0,M"))[0] == OwnHeading(None, 100.0, "magnetic", "HDM", -2.9)
    reader.feed(closed("GPRMC,134601,A,5744.5125,N,01138.2500,E,0.0,67.0,270715,9.9,E,A"))
    heading = reader.feed(closed("HCHDM,100.0,M"))[0]
    assert isinstance(heading, OwnHeading)
    assert heading.variation_deg == -2.9


def test_optional_nonsense_is_noted_and_the_rest_of_the_sentence_is_used() -> None:
    reader = Reader()
    (report,) = reader.feed(closed("RATTM,01,1.0,90.0,R,-1.-5,10.0,T,,,N,,T,"))
    assert isinstance(report, TargetReport)
    assert [problem.kind for problem in reader.problems] == ["field"]


@pytest.mark.parametrize("line", ["", b"", "\r\n", b"\n\n\n", "# comment"])
def test_nothing_is_nothing(line: str | bytes) -> None:
    reader = Reader()
    assert reader.feed(line) == []
    assert reader.problems == ()


def test_a_line_of_a_megabyte_is_read_in_no_time() -> None:
    reader = Reader()
    for filler in (",", "$", "!AIVDM,", "1:", "\\", "-"):
        reader.feed(filler * 200_000)
        reader.feed(ttm() + filler * 200_000)
        reader.feed(filler * 200_000 + ttm())
    assert reader.lines == 18


def test_other_sentences_with_an_exclamation_mark_are_counted_under_their_address() -> None:
    body = "AIABK,265547250,A,8,5,0"
    reader = Reader()
    assert reader.feed(f"!{body}*{checksum(body):02X}") == [OtherMessage(None, "ABK")]
    assert reader.counts == {"AIABK": 1}


def test_a_stamp_without_date_is_the_last_resort() -> None:
    reader = Reader()
    assert reader.feed("23:59:59.5 " + closed("HEHDT,10.0,T"))[0].time_s == 86399.5
    assert reader.feed("00:00:00.5 " + closed("HEHDT,10.0,T"))[0].time_s == 86400.5
    assert reader.time_basis == "time_of_day"


def test_a_sentence_without_checksum_and_with_bytes_that_are_no_text_is_refused() -> None:
    reader = Reader()
    assert reader.feed(b"$HEHDT,1\x00\x01,T") == []
    assert [problem.kind for problem in reader.problems] == ["binary"]
