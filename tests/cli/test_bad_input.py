"""Whatever a log holds: one clear line on stderr and the right exit code, never a traceback."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from navfix.catalog import data_folder
from navfix.cli import main

TTM = "$RATTM,07,5.76,237.5,R,5.8,176.3,T,0.1,2.0,N,,T,,120000.00,A*"
AIS = "!AIVDM,1,1,,A,15M67FC000G?ufbE`FepT@3n00Sa,0*"


def _sentence(body: str) -> str:
    """Return the sentence with its checksum."""
    checksum = 0
    for character in body[1:-1]:
        checksum ^= ord(character)
    return f"{body}{checksum:02X}"


def _stamped(*sentences: str) -> bytes:
    return "".join(f"2026-01-01T12:00:{second:02d}Z {s}\r\n" for second, s in enumerate(sentences)).encode()


BAD = {
    "empty": (b"", 4),
    "blank lines": (b"\r\n\r\n   \n", 4),
    "binary": (random.Random(1).randbytes(20_000), 4),
    "half a sentence": (TTM[:30].encode(), 4),
    "prose": (b"Dear diary,\ntoday we left port at noon.\n", 4),
    "without AIS": (_stamped(*[_sentence(TTM)] * 20), 3),
    "without radar": (_stamped(*[_sentence(AIS)] * 20), 3),
    "neither": (_stamped(_sentence("$HEHDT,123.4,T*")), 3),
    "one target": (_stamped(_sentence(TTM), _sentence(AIS), _sentence(TTM)), 3),
}


def _ends(argv: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> str:
    """Run the command; it must end with the code and say why on one line of stderr. Return the line."""
    assert main(argv) == code
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1, captured.err
    assert captured.err.startswith("navfix: ")
    assert "internal error" not in captured.err
    return captured.err.strip()


@pytest.mark.parametrize("command", ["fix", "replay", "compare"])
@pytest.mark.parametrize("name", BAD)
def test_a_log_without_an_answer_says_why(
    name: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content, code = BAD[name]
    log = tmp_path / "log.nmea"
    log.write_bytes(content)
    line = _ends([command, str(log)], code, capsys)
    assert len(line) > 20


@pytest.mark.parametrize("command", ["fix", "replay", "compare", "adjust"])
def test_a_missing_file_is_named(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gone = str(tmp_path / "gone.toml")
    assert f"{gone}: no such file" in _ends([command, gone], 4, capsys)


@pytest.mark.parametrize("command", ["fix", "replay", "compare", "adjust"])
def test_a_directory_is_named(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert str(tmp_path) in _ends([command, str(tmp_path)], 4, capsys)


def test_a_missing_truth_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.nmea"
    log.write_bytes(BAD["one target"][0])
    gone = str(tmp_path / "gone.csv")
    assert f"{gone}: no such file" in _ends(["fix", str(log), "--truth", gone], 4, capsys)


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02", b"frame = ", b'{"frame": "plane"}', b"[1, 2]"])
def test_a_case_that_is_no_case_says_why(content: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.toml"
    case.write_bytes(content)
    assert "case.toml" in _ends(["adjust", str(case)], 4, capsys)


def test_a_no_fix_is_json_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.nmea"
    log.write_bytes(BAD["one target"][0])
    assert main(["fix", "--json", str(log)]) == 3
    told = json.loads(capsys.readouterr().out)
    assert (told["status"], told["position"]) == ("no_fix", None)
    assert told["reason"]


def test_a_log_without_any_time_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.nmea"
    silent = "$RATTM,07,5.76,237.5,R,5.8,176.3,T,0.1,2.0,N,,T,,,A*"
    log.write_text(f"{_sentence(silent)}\n{_sentence(AIS)}\n" * 20)
    for command in ("fix", "replay", "compare"):
        assert "tells no time" in _ends([command, str(log)], 3, capsys)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "missing lat, lon, unix"),
        (b"unix,lat\n1,2\n", "missing lon"),
        (b"unix,lat,lon\n", "no rows"),
        (b"unix,lat,lon\n1,2\n", "truth.csv:2: lon must be a finite number, got nothing"),
        (b"unix,lat,lon\nx,1,2\n", "truth.csv:2: unix must be a finite number, got x"),
        (b"unix,lat,lon,heading_deg\n1,2,3,nan\n", "truth.csv:2: heading_deg must be a finite number, got nan"),
        (b"unix,lat,lon\n1,95,3\n", "truth.csv:2: lat_deg must be within -90 .. 90"),
        (random.Random(2).randbytes(3000), "truth.csv: not"),
        (b"unix,lat,lon\n1,2," + b"3" * 200_000 + b"\n", "truth.csv: not a CSV file"),
    ],
)
def test_a_truth_that_is_none_names_file_and_line(
    content: bytes, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, truth = tmp_path / "log.nmea", tmp_path / "truth.csv"
    log.write_bytes(BAD["one target"][0])
    truth.write_bytes(content)
    assert said in _ends(["fix", str(log), "--truth", str(truth)], 4, capsys)


def test_a_missing_kernel_file_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case, gone = tmp_path / "case.toml", tmp_path / "gone.toml"
    case.write_text("frame = 'plane'")
    assert f"{gone}: no such file" in _ends(["adjust", str(case), "--kernel", str(gone)], 2, capsys)


def test_a_truth_of_another_time_is_told_beside_the_fix(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    truth = tmp_path / "truth.csv"
    truth.write_text("unix,lat,lon\n1,54,12\n2,54,12\n")
    log = str(data_folder("data") / "logs" / "approach.nmea")
    for command in ("fix", "compare"):
        assert "nothing about the time of this scan" in _ends([command, log, "--truth", str(truth)], 0, capsys)


@pytest.mark.parametrize(("command", "suffix"), [("replay", ".svg"), ("compare", ".geojson")])
def test_a_format_that_the_command_cannot_write_is_refused_at_once(
    command: str, suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, "log.nmea", "--out", str(tmp_path / f"out{suffix}")]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "the suffix chooses the format" in captured.err


def test_a_log_without_a_date_says_which_day_it_is_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.nmea"
    log.write_text("".join(f"{_sentence(s)}\n" for s in (TTM, AIS, TTM.replace("120000", "120003"))))
    assert main(["fix", str(log)]) == 3
    captured = capsys.readouterr()
    assert "no date: its first day is called 1970-01-01" in captured.err
    assert "1970-01-01 12:00:0" in captured.out
