"""``navfix replay``: the lasting GNSS verdict in every line, its alerts on stderr, AIS veracity as table or JSON."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from navfix.cli import main
from navfix.geodesy import LocalPlane
from navfix.nmea import write
from navfix.report.truth import TruthTrack


@pytest.fixture(scope="module")
def approach(repository: Path) -> Path:
    return repository / "data" / "logs" / "approach.nmea"


def with_gnss(approach: Path, jump_m: float) -> str:
    """Return the log with own GGA every 2 s, half way through off northwards by ``jump_m``."""
    with approach.with_name("approach_truth.csv").open(encoding="utf-8", newline="") as lines:
        track = TruthTrack.parse(lines, source="truth")
    stamped = [(_time(line), line) for line in approach.read_text(encoding="utf-8").splitlines()]
    first, last = stamped[0][0], stamped[-1][0]
    time_s = first
    while time_s < last:
        truth = track.at(time_s)
        if truth is not None:
            off_m = jump_m if time_s > (first + last) / 2.0 else 0.0
            place = LocalPlane(truth.position).to_position(off_m, 0.0)
            stamped.append((time_s, write.tag_block(time_s, "GP0001") + write.gga(time_s, place, quality=1)))
        time_s += 2.0
    return "\n".join(line for _, line in sorted(stamped)) + "\n"


def _time(line: str) -> float:
    found = re.search(r"c:(\d+)", line)
    assert found is not None
    number = float(found[1])
    return number / 1000.0 if number > 1e11 else number


def test_a_jump_of_gnss_gives_one_alert_and_a_lasting_verdict(
    approach: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "jump.nmea"
    log.write_text(with_gnss(approach, 400.0), encoding="utf-8")
    assert main(["replay", str(log), "--every", "2"]) == 0
    said = capsys.readouterr()
    gnss = [line["gnss"] for line in map(json.loads, said.out.splitlines()) if line["gnss"] is not None]
    verdicts = [block["verdict"] for block in gnss]
    assert len(verdicts) >= 25
    assert "unsafe" not in verdicts[:10]
    assert "ok" in verdicts[:10]
    assert set(verdicts[-8:]) == {"unsafe"}
    alerts = [block["alert"] for block in gnss if block["alert"] and "-> unsafe" in block["alert"]]
    assert len(alerts) == 1
    assert said.err.count("-> unsafe") == 1


def test_the_veracity_of_a_log_is_written_as_json_and_as_text(
    approach: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for suffix, scans in ((".json", ["--every", "6"]), (".txt", ["--every", "20", "--independent"])):
        path = tmp_path / f"ships{suffix}"
        assert main(["replay", str(approach), *scans, "--veracity", str(path)]) == 0
        assert "navfix: AIS veracity: " in capsys.readouterr().err
        text = path.read_text(encoding="utf-8")
        if suffix == ".json":
            content = json.loads(text)
            assert content["schema"] == "navfix.veracity/1"
            assert sum(row["status"] == "agrees" for row in content["ships"]) >= 10
            assert not any(row["status"] == "disagrees" for row in content["ships"])
        else:
            assert text.startswith("AIS veracity: ")


def test_the_log_itself_is_never_overwritten_by_the_veracity(approach: Path, tmp_path: Path) -> None:
    log = tmp_path / "log.txt"
    log.write_bytes(approach.read_bytes())
    assert main(["replay", str(log), "--veracity", str(log)]) == 2
    assert log.read_bytes() == approach.read_bytes()


def test_a_second_recording_that_is_earlier_begins_anew_and_ends_nothing(
    approach: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = approach.read_text(encoding="utf-8").splitlines()
    eighth = len(lines) // 8
    log = tmp_path / "two.nmea"
    log.write_text("\n".join([*lines[-eighth:], *lines[:eighth]]) + "\n", encoding="utf-8")
    main(["replay", str(log), "--every", "8"])
    times = [json.loads(line)["time_utc"] for line in capsys.readouterr().out.splitlines()]
    assert times != sorted(times)


def test_a_compass_that_is_90_deg_off_is_told_once_and_stands_once_in_each_line(
    approach: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with approach.with_name("approach_truth.csv").open(encoding="utf-8", newline="") as lines:
        track = TruthTrack.parse(lines, source="truth")
    stamped = [(_time(line), line) for line in approach.read_text(encoding="utf-8").splitlines()]
    stamped = [(time_s, line) for time_s, line in stamped if time_s < stamped[0][0] + 60.0]
    for time_s in sorted({time_s for time_s, _ in stamped}):
        truth = track.at(time_s)
        if truth is not None and truth.heading_deg is not None:
            gyro_deg = (truth.heading_deg + 90.0) % 360.0
            stamped.append((time_s, write.tag_block(time_s, "GY0001") + write.hdt(gyro_deg)))
    log = tmp_path / "compass.nmea"
    log.write_text("\n".join(line for _, line in sorted(stamped)) + "\n", encoding="utf-8")
    assert main(["replay", str(log), "--every", "2"]) == 0
    said = capsys.readouterr()
    assert said.err.count("Check the compass") == 1
    notes = [line["notes"] for line in map(json.loads, said.out.splitlines()) if line["status"] == "fix"]
    assert len(notes) >= 3
    refuted = [sum("heading hint is refuted" in note for note in said) for said in notes]
    assert max(refuted) == 1
    assert sum(refuted) >= 3
