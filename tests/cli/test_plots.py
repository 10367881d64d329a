"""``--plots``: raw echoes beside a log that brings the AIS, in place of its targets."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from navfix.cli import main
from navfix.simulation import radar
from navfix.simulation.scenario import load, simulate

DURATION_S = 60.0


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a log without targets, the plots of its radar, and the truth."""
    folder = tmp_path_factory.mktemp("plots")
    scenario = replace(load("approach"), duration_s=DURATION_S)
    made = simulate(scenario, 3)
    (folder / "log.nmea").write_text("\n".join(line for line in made.lines if "TTM" not in line) + "\n")
    (folder / "both.nmea").write_text("\n".join(made.lines) + "\n")
    rows = [f"{t.unix_s},{t.lat_deg},{t.lon_deg},{t.heading_deg}" for t in made.truth]
    (folder / "truth.csv").write_text("\n".join(["unix,lat,lon,heading_deg", *rows]) + "\n")
    world, model = scenario.world(3), scenario.radar_model()
    settings = replace(scenario.radar, maximum_range_m=scenario.radar.maximum_range_m or model.maximum_range_m)
    turns, _ = radar.turns(world, settings, model, DURATION_S, 3)
    plots = [f"{world.start_s + p.time_s},{p.range_m},{p.relative_deg}" for turn in turns for p in turn]
    (folder / "plots.csv").write_text("\n".join(["unix,range_m,bearing_deg", *plots, "not,a,plot"]) + "\n")
    return folder


def test_fix_from_plots(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, plots, truth = (str(recording / name) for name in ("log.nmea", "plots.csv", "truth.csv"))
    assert main(["fix", log, "--plots", plots, "--truth", truth, "--json"]) == 0
    said = capsys.readouterr()
    answer = json.loads(said.out)
    assert answer["status"] == "fix"
    assert answer["truth"]["distance_m"] < 80.0
    assert {row["kind"] for row in answer["observations"]} == {"range", "relative_bearing"}
    assert "rows that cannot be read: 1 x" in said.err


def test_replay_from_plots_leaves_the_targets_of_the_log_out(
    recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plots, truth = str(recording / "plots.csv"), str(recording / "truth.csv")
    answers = []
    for name in ("log.nmea", "both.nmea"):
        assert main(["replay", str(recording / name), "--plots", plots, "--truth", truth, "--every", "3"]) == 0
        answers.append([json.loads(line) for line in capsys.readouterr().out.splitlines()])
    fixed = [a for a in answers[0] if a["status"] == "fix"]
    assert len(fixed) >= 4
    assert max(a["truth"]["distance_m"] for a in fixed) < 100.0
    assert [a["position"] for a in answers[0]] == [a["position"] for a in answers[1]]


def test_true_bearings_are_told_by_the_option(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    truth = {round(float(row.split(",")[0])): row for row in (recording / "truth.csv").read_text().splitlines()[1:]}
    rows = [row.split(",") for row in (recording / "plots.csv").read_text().splitlines()[1:-1]]
    zero_deg = [float(truth[round(float(row[0]))].split(",")[3]) for row in rows]
    north_up = recording / "north_up.csv"
    turned = [f"{row[0]},{row[1]},{(float(row[2]) + h) % 360.0}" for row, h in zip(rows, zero_deg, strict=True)]
    north_up.write_text("\n".join(["unix,range_m,bearing_deg", *turned]) + "\n")
    log = str(recording / "log.nmea")
    assert main(["fix", log, "--plots", str(north_up), "--plots-reference", "true", "--json"]) == 0
    kinds = {row["kind"] for row in json.loads(capsys.readouterr().out)["observations"]}
    assert kinds == {"range", "true_bearing"}


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--plots", "none.csv"], 4, "no such file"),
        (["--plots", "truth.csv"], 4, "must name time, range and bearing"),
        (["--plots", "old.csv"], 3, "its plots are of 1970-01-01"),
        (["--plots", "few.csv"], 3, "none of its 2 plots could be followed"),
        (["--plots", "good.csv", "--tracking", "nonsense"], 2, "no tracking model named 'nonsense'"),
        (["--plots-reference", "true"], 2, "--plots, which is not given"),
        (["--tracking", "plots"], 2, "--plots, which is not given"),
    ],
)
def test_what_cannot_be_used_ends_with_one_line(
    recording: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    code: int,
    words: str,
) -> None:
    monkeypatch.chdir(recording)
    plots = (recording / "plots.csv").read_text().splitlines()
    (recording / "few.csv").write_text("\n".join(plots[:3]) + "\n")
    (recording / "good.csv").write_text("\n".join(plots[:-1]) + "\n")
    (recording / "old.csv").write_text("unix,range_m,bearing_deg\n5,100,3\n")
    assert main(["fix", "log.nmea", *options]) == code
    error = capsys.readouterr().err
    assert words in error
    assert len(error.strip().splitlines()) == 1


def test_the_plots_are_an_input_that_is_never_overwritten(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plots = recording / "plots.csv"
    before = plots.read_text()
    assert main(["fix", str(recording / "log.nmea"), "--plots", str(plots), "--out", str(plots)]) == 2
    assert "is an input file" in capsys.readouterr().err
    assert plots.read_text() == before
