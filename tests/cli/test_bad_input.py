"""Whatever a log holds: one clear line on stderr and the right exit code, never a traceback."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

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
