"""The command simulate: what it writes and prints, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest

from navfix.cli import main
from navfix.nmea import read_log
from navfix.simulation import scenario


def test_without_a_file_the_log_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "open_sea", "--duration", "30"]) == 0
    out = capsys.readouterr().out
    log = read_log(out.splitlines())
    assert log.problems == ()
    assert tuple(out.splitlines()) == scenario.simulate(scenario.load("open_sea"), 1, duration_s=30.0).lines


def test_log_truth_and_association_are_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "run.nmea"
    assert main(["simulate", "approach", "--seed", "3", "--duration", "30", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    for name in ("run.nmea", "run_truth.csv", "run_assoc.csv"):
        assert (tmp_path / name).stat().st_size > 100
        assert f"wrote {tmp_path / name}" in printed
    assert "seed 3, 30 s" in printed


def test_truth_and_association_go_where_they_are_told(tmp_path: Path) -> None:
    truth, assoc = tmp_path / "t.csv", tmp_path / "a.csv"
    arguments = ["--out", str(tmp_path / "x.nmea"), "--truth-out", str(truth), "--assoc-out", str(assoc)]
    assert main(["simulate", "open_sea", "--duration", "30", *arguments]) == 0
    assert truth.read_text().startswith("unix,lat,lon,heading_deg,sog_kn,cog_deg")
    assert assoc.read_text().startswith("unix,target_no,mmsi")


def test_the_list_names_every_scenario_with_its_title(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == scenario.names()
    assert all(scenario.load(line.split()[0]).title in line for line in lines)


def test_a_scenario_file_is_simulated_and_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shipped = scenario._folder() / "open_sea.toml"
    mine = tmp_path / "mine.toml"
    mine.write_bytes(shipped.read_bytes())
    assert main(["simulate", str(mine), "--duration", "20", "--out", str(tmp_path / "x.nmea")]) == 0
    link = tmp_path / "link.csv"
    link.symlink_to(mine)
    assert main(["simulate", str(mine), "--out", str(tmp_path / "x.nmea"), "--truth-out", str(link)]) == 2
    assert "never overwritten" in capsys.readouterr().err
    assert mine.read_bytes() == shipped.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["harbour"], "no scenario named 'harbour'"),
        (["--seed", "-1"], "whole number"),
        (["--seed", "x"], "whole number"),
        (["--duration", "0"], "must be > 0"),
        (["--duration", "1e9"], "at most 86400 s"),
        (["--out", "x.csv"], "suffix"),
        (["--truth-out", "t.csv"], "need --out"),
        (["--out", "x.nmea", "--out", "y.nmea"], "one log"),
        (["--out", "x.nmea", "--truth-out", "x_assoc.csv"], "two of log"),
        (["--out", "nowhere/x.nmea"], "no folder"),
    ],
)
def test_what_cannot_be_done_is_one_clear_line_and_a_code(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", *arguments]) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert "Traceback" not in printed.err
    assert printed.out == ""
    assert list(tmp_path.iterdir()) == []


def test_a_missing_scenario_file_is_said_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "none.toml"
    assert main(["simulate", str(missing)]) == 4
    assert capsys.readouterr().err == f"navfix: {missing}: no such file\n"


def test_a_scenario_file_that_is_not_toml_is_said_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = tmp_path / "broken.toml"
    broken.write_bytes(bytes(range(128, 256)))
    assert main(["simulate", str(broken)]) == 2
    assert "broken.toml: not a readable TOML file" in capsys.readouterr().err
