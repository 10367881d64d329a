"""``--window``, ``--independent`` and the track of ``navfix replay``."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from navfix.cli import main


@pytest.fixture(scope="module")
def approach(repository: Path) -> str:
    return str(repository / "data" / "logs" / "approach.nmea")


@pytest.fixture(scope="module")
def truth(repository: Path) -> str:
    return str(repository / "data" / "logs" / "approach_truth.csv")


def test_a_window_of_scans_is_one_answer(approach: str, truth: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fix", approach, "--window", "60", "--truth", truth, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["status"] == "fix"
    assert content["truth"]["distance_m"] <= 60.0
    assert content["kernel"] == "hampel"  # the scans of the window adjusted as one graph
    assert len(content["pairs"]) >= 6
    assert main(["fix", approach, "--window", "60", "--at", "2026-03-01T09:01:30Z"]) == 0
    said = re.search(r"window of (\d+) scans over (\d+) s", capsys.readouterr().out)
    assert said is not None
    assert int(said[1]) >= 20
    assert 55 <= int(said[2]) <= 60


@pytest.mark.parametrize("options", [["--pairs", "01=AB"], ["--prove"], ["--accept", "0.01"]])
def test_what_speaks_of_one_scan_is_refused_with_a_window(
    approach: str, options: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fix", approach, "--window", "60", *options]) == 2
    assert "for one scan" in capsys.readouterr().err


def test_replay_holds_a_place_and_says_what_it_knows_of_it(
    approach: str, truth: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["replay", approach, "--every", "9", "--truth", truth]) == 0
    printed = capsys.readouterr()
    lines = [json.loads(line) for line in printed.out.splitlines()]
    states = [line["track"]["status"] for line in lines]
    assert states[0] == "cold"
    assert lines[0]["reason"] == "no_agreement"
    assert states[-1] == "tracking"
    assert lines[-1]["status"] == "fix"
    assert lines[-1]["track"]["probability_wrong"] >= 0.01
    assert lines[-1]["track"]["since_s"] > 30.0
    truths = [line["truth"] for line in lines if line["status"] == "fix"]
    assert all(row["distance_m"] <= 120.0 for row in truths)
    share = 100 * sum(row["in_ellipse"] for row in truths) / len(truths)
    worst_m = max(row["distance_m"] for row in truths)
    assert f"{worst_m:.0f} m at worst; {share:.0f} % inside the 95 % ellipse" in printed.err


def test_the_navigator_damps_as_asked(approach: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", approach, "--every", "20", "--kernel", "danish"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {line["kernel"] for line in lines if line["status"] == "fix"} == {"danish"}


def test_independent_windows_and_scans_carry_no_track(approach: str, capsys: pytest.CaptureFixture[str]) -> None:
    for options in (["--window", "40"], []):
        assert main(["replay", approach, "--independent", "--every", "30", *options]) == 0
        lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
        assert all(line["track"] is None for line in lines)
        assert lines[-1]["status"] == "fix"


@pytest.mark.parametrize("command", [["fix", "--json", "--window", "60"], ["replay"]])
def test_where_all_bearings_are_true_a_window_has_a_place_a_compass_error_and_no_heading(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "channel.nmea"
    assert main(["simulate", "buoyed_channel", "--duration", "60", "--out", str(log)]) == 0
    capsys.readouterr()
    assert main([*command, str(log), "--truth", str(tmp_path / "channel_truth.csv")]) == 0
    content = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert content["status"] == "fix"
    assert content["heading_deg"] is None
    assert len(content["covariance"]) == 2
    assert content["truth"]["distance_m"] <= 60.0
