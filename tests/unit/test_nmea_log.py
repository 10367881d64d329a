"""Whole logs: files that cannot be read, order and selection of records, the account of what was read."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path

import pytest

import navfix.nmea
from navfix.errors import InputError
from navfix.nmea import Log, read_log
from navfix.nmea.framing import checksum
from navfix.nmea.records import AisPosition, OtherMessage, OwnHeading, TargetReport
from navfix.nmea.write_ais import position_report


def closed(body: str) -> str:
    return f"${body}*{checksum(body):02X}"


TTM = closed("RATTM,01,1.07,338.5,R,11.7,49.5,T,,,N,,T,,134601,A")
RMC = closed("GPRMC,134602,A,5744.5125,N,01138.2500,E,0.0,67.0,270715,2.9,E,A")
VDM = position_report(AisPosition(None, 265547250, 1, "ship", 57.75, 11.64))[0]


def test_a_log_of_lines_a_file_and_an_open_file_are_the_same(tmp_path: Path) -> None:
    path = tmp_path / "log.nmea"
    path.write_bytes("\r\n".join([VDM, RMC, TTM, ""]).encode())
    from_path, from_name, from_lines = read_log(path), read_log(str(path)), read_log([VDM, RMC, TTM])
    with path.open("rb") as stream:
        from_stream = read_log(stream, name="log.nmea")
    assert from_path.records == from_name.records == from_lines.records == from_stream.records
    assert from_path.name == from_stream.name == "log.nmea"
    assert dict(from_path.counts) == {"AIVDM": 1, "RMC": 1, "TTM": 1}
    assert (from_path.lines, from_path.sentences) == (3, 3)


def test_records_are_picked_by_their_type_in_order() -> None:
    log = read_log([TTM, VDM, TTM, RMC])
    assert [type(record).__name__ for record in log.records] == [
        "TargetReport", "AisPosition", "TargetReport", "UtcTime", "OwnPosition",
    ]  # fmt: skip
    assert len(log.of(TargetReport)) == 2
    assert log.of(AisPosition) == (log.records[1],)
    assert log.of(OwnHeading) == ()


def test_a_log_cannot_be_changed() -> None:
    log = read_log([TTM])
    with pytest.raises(AttributeError):
        log.name = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        log.counts["TTM"] = 5  # type: ignore[index]


def test_lines_before_the_first_time_get_it_from_what_follows() -> None:
    log = read_log([VDM, TTM, RMC])
    assert [record.time_s for record in log.records] == [1438004761.0, 1438004761.0, 1438004762.0, 1438004762.0]
    assert (log.time_basis, log.time_known) == ("sentence", True)


def test_an_undated_hour_before_the_first_date_keeps_its_own_time() -> None:
    lines = [closed(f"RATTM,01,1.07,338.5,R,,,,,,N,,T,,12{minute:02d}00,A") for minute in range(60)]
    log = read_log([*lines, RMC])
    assert log.records[0].time_s == 1438004762.0 - 2.0 - 46 * 60 - 3600.0
    assert log.records[59].time_s == 1438004762.0 - 2.0 - 46 * 60 - 60.0


def test_a_log_without_date_says_that_its_day_is_not_known() -> None:
    log = read_log([TTM, VDM])
    assert (log.time_basis, log.time_known) == ("time_of_day", False)
    assert [record.time_s for record in log.records] == [49561.0, 49561.0]
    log = read_log([VDM])
    assert (log.time_basis, log.time_known) == ("none", False)
    assert log.records[0].time_s is None


def test_each_kind_of_problem_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, logger="navfix"):
        read_log([TTM, "hello", "hello", "$RATTM,01*00", "$RATTM,01*00", "$RATTM,01*00"], name="small.log")
    assert [message.split(",")[0] for message in caplog.messages] == [
        "small.log: 3 x checksum",
        "small.log: 2 x no_sentence",
    ]
    assert "first in line 4" in caplog.messages[0]


def test_a_missing_file_a_directory_and_an_empty_file_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"missing\.nmea: no such file") as caught:
        read_log(tmp_path / "missing.nmea")
    assert caught.value.source == str(tmp_path / "missing.nmea")
    with pytest.raises(InputError, match="is a directory"):
        read_log(tmp_path)
    for content in (b"", b"\r\n\r\n", b"# only a comment\n"):
        (tmp_path / "empty.nmea").write_bytes(content)
        with pytest.raises(InputError, match=r"empty\.nmea: is empty"):
            read_log(tmp_path / "empty.nmea")
    with pytest.raises(InputError, match="is empty"):
        read_log([])
    with pytest.raises(InputError, match="cannot be read"):
        read_log("a\x00b")


def test_every_message_is_one_line(tmp_path: Path) -> None:
    for source in (tmp_path, tmp_path / "missing.nmea"):
        with pytest.raises(InputError) as caught:
            read_log(source)
        assert "\n" not in str(caught.value)


def test_a_binary_file_holds_no_nmea(tmp_path: Path) -> None:
    path = tmp_path / "picture.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + bytes(range(256)) * 20)
    with pytest.raises(InputError, match=r"picture\.png: a binary file, nothing in it is NMEA"):
        read_log(path)


def test_a_text_without_nmea_gives_a_log_without_sentences() -> None:
    log = read_log(["Time,MMSI,Latitude", "2016-01-12 13:02:11.218,235070762,50.77"])
    assert (log.sentences, log.records) == (0, ())
    assert [problem.kind for problem in log.problems] == ["no_sentence"]


def test_sentences_inside_a_capture_are_found(tmp_path: Path) -> None:
    path = tmp_path / "capture.bin"
    path.write_bytes(b"\xd4\xc3\xb2\xa1\x02\x00\n" + b"\x00\x01E\x00" + TTM.encode() + b"\r\n" + bytes(20))
    assert len(read_log(path).of(TargetReport)) == 1


def test_a_log_may_end_in_half_a_sentence() -> None:
    log = read_log([TTM, TTM, TTM[:20]])
    assert len(log.of(TargetReport)) == 2
    assert [problem.kind for problem in log.problems] == ["no_checksum"]


def test_the_package_exports_what_it_promises() -> None:
    assert navfix.nmea.__all__ == ["Log", "Reader", "read_log"]
    assert isinstance(read_log([TTM, closed("GPGSV,1,1,00")]), Log)
    assert read_log([closed("GPGSV,1,1,00")]).records == (OtherMessage(None, "GSV"),)
    with pytest.raises(AttributeError):
        navfix.nmea.nothing  # noqa: B018


def test_the_records_alone_import_no_decoder() -> None:
    unwanted = ("pyais", "pynmea2", "navfix.nmea.reader")
    code = f"import sys, navfix.nmea.records; sys.exit(any(module in sys.modules for module in {unwanted}))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
