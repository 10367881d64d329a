"""``navfix chart`` and --chart: lists, files that can be read again, logs without AIS, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from navfix.catalog import data_folder
from navfix.cli import main
from navfix.simulation import files, scenario

TABLE = """label,lat,lon,kind,type,depth_m,name,mmsi
B1,54.10,7.20,floating,BOYLAT,18,Buoy 1,992001001
L1,54.10,7.20,fixed,LIGHTS,,,
T1,54.15,7.20,fixed,BCNSPP,,Tower,
X1,54.90,7.20,fixed,pile,,,
S1,54.11,7.20,fixed,LNDMRK,,Church,
bad,99,7.2,fixed,pile,,,
"""


@pytest.fixture
def chart(tmp_path: Path) -> Path:
    path = tmp_path / "marks.csv"
    path.write_text(TABLE)
    return path


@pytest.fixture(scope="module")
def channel(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A buoyed channel: the log, the same without AIS, its aids as a chart, and the truth."""
    folder = tmp_path_factory.mktemp("channel")
    recording = scenario.simulate(scenario.load("buoyed_channel"), 1, duration_s=40.0)
    log, truth, _ = files.write_files(recording, folder / "all.nmea")
    (folder / "chart.csv").write_text(files.chart_csv(recording))
    radar_only = "".join(line for line in log.read_text().splitlines(keepends=True) if "VDM" not in line)
    (folder / "radar.nmea").write_text(radar_only)
    return {"all": log, "radar": folder / "radar.nmea", "chart": folder / "chart.csv", "truth": truth}


def test_the_list_counts_by_kind_and_type(chart: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["chart", str(chart)]) == 0
    out, err = capsys.readouterr()
    assert "3 marks: 2 fixed, 1 floating" in out
    assert "1  lateral buoy" in out
    assert "Buoy 1" in out
    assert "Church" not in out
    assert max(map(len, out.splitlines())) <= 100
    assert err.startswith("navfix: marks.csv: 1 passed over: position out of range, first in 7: lat_deg must be")
    assert len(err.splitlines()) == 1


def test_near_limits_and_sorts_in_miles_or_metres(chart: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["chart", str(chart), "--near", "54.15,7.2,4", "--json"]) == 0
    names = [mark["name"] for mark in json.loads(capsys.readouterr().out)["marks"]]
    assert names == ["Tower", "Buoy 1"]
    assert main(["chart", str(chart), "--near", "54.15,7.2,4000m", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert [mark["name"] for mark in content["marks"]] == ["Tower"]
    assert content["marks"][0]["distance_m"] == pytest.approx(0.0, abs=1e-3)
    assert main(["chart", str(chart), "--near", "54.15,7.2,4NM", "--land"]) == 0
    out = capsys.readouterr().out
    assert "Church" in out
    assert max(map(len, out.splitlines())) <= 100


@pytest.mark.parametrize("near", ["54,7", "54,7,x", "54,7,-1", "95,7,1", "54,7,nan", "54,7,0m"])
def test_a_place_that_cannot_be_right_is_a_usage_error(
    chart: Path, near: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["chart", str(chart), "--near", near]) == 2
    assert "must be like 54.2,7.5,6 (NM) or 54.2,7.5,800m" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".csv", ".geojson"])
def test_what_is_written_can_be_read_as_a_chart_again(
    chart: Path, tmp_path: Path, suffix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out, again = tmp_path / f"out{suffix}", tmp_path / f"again{suffix}"
    assert main(["chart", str(chart), "--out", str(out)]) == 0
    capsys.readouterr()
    assert main(["chart", str(out), "--out", str(again)]) == 0
    assert "3 marks: 2 fixed, 1 floating" in capsys.readouterr().out
    assert "LIGHTS" in out.read_text()
    assert again.read_text() == out.read_text()


def test_a_chart_is_never_overwritten_and_a_missing_one_ends_with_4(
    chart: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["chart", str(chart), "--out", str(chart)]) == 2
    assert chart.read_text() == TABLE
    assert main(["chart", str(tmp_path / "none.csv")]) == 4
    assert "no such file" in capsys.readouterr().err


def test_chart_marks_alone_give_a_fix(channel: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    log, chart, truth = (str(channel[name]) for name in ("radar", "chart", "truth"))
    assert main(["fix", log, "--chart", chart, "--truth", truth, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["truth"]["distance_m"] < 60.0
    assert answer["chart"] == {
        "charted": 26, "in_reach": 26, "added": 26, "confirmed": [], "off_station": [], "not_charted": [],
        "shift_m": None, "shift_azimuth_deg": None,
    }  # fmt: skip
    assert answer["choice"]["decision"] == "all"
    assert answer["choice"]["source_choice"] == "aids"
    assert not answer["choice"]["ships"]
    assert all(pair["mark"].startswith("BUOY") for pair in answer["pairs"])


def test_without_a_chart_a_log_without_ais_is_still_refused(
    channel: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fix", str(channel["radar"])]) == 3
    assert "holds no AIS" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["compare", "replay"])
def test_the_other_commands_take_charts_too(
    channel: dict[str, Path], command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    more = ["--every", "8"] if command == "replay" else ["--json"]
    assert main([command, str(channel["radar"]), "--chart", str(channel["chart"]), *more]) == 0
    assert '"navfix.' in capsys.readouterr().out


def test_aids_of_ais_are_confirmed_by_the_chart_and_own_speed_is_not_needed(
    channel: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fix", str(channel["all"]), "--chart", str(channel["chart"]), "--choice", "source"]) == 0
    out = capsys.readouterr().out
    assert "confirm an AIS aid" in out
    assert "as the source's table says" in out
    assert "Choice " in out


def test_charted_marks_check_ais_for_a_shift_and_a_chart_of_another_datum_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (data_folder("data") / "scenarios" / "buoyed_channel.toml").read_text(encoding="utf-8") + "gnss = true\n"
    recording = scenario.simulate(scenario.from_text(text.replace("count = 10", "count = 16")), 1, duration_s=40.0)
    log, chart, moved = tmp_path / "g.nmea", tmp_path / "g.csv", tmp_path / "moved.csv"
    log.write_text(files.log_text(recording))
    chart.write_text(files.chart_csv(recording))
    rows = [row.split(",", 1) for row in chart.read_text().splitlines()]
    moved.write_text("\n".join([",".join(rows[0]), *(f"{float(lat) + 0.003:.6f},{rest}" for lat, rest in rows[1:])]))
    assert main(["fix", str(log), "--chart", str(chart), "--json"]) == 0
    right = json.loads(capsys.readouterr().out)
    assert right["gnss"]["verdict"] == "ok"
    assert any(
        reason.startswith("checked: the") and "charted marks alone" in reason for reason in right["gnss"]["reasons"]
    )
    main(["fix", str(log), "--chart", str(moved), "--json"])
    wrong = json.loads(capsys.readouterr().out)
    assert wrong["chart"]["shift_m"] == pytest.approx(334.0, abs=30.0)
    assert wrong["chart"]["shift_azimuth_deg"] == pytest.approx(180.0, abs=10.0)
    assert any("datum" in note for note in wrong["notes"])


def test_a_chart_with_objects_ashore_alone_needs_the_option(
    channel: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    land = tmp_path / "land.csv"
    land.write_text("lat,lon,type\n54,8.3,LNDMRK\n")
    assert main(["fix", str(channel["radar"]), "--chart", str(land)]) == 4
    assert "--chart-land" in capsys.readouterr().err
    assert main(["fix", str(channel["radar"]), "--chart", str(land), "--chart-land"]) == 3
    assert "too_few_pairs" in capsys.readouterr().err


def test_the_simulator_writes_its_aids_as_a_chart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, chart = tmp_path / "x.nmea", tmp_path / "x_chart.csv"
    argv = ["simulate", "buoyed_channel", "--duration", "5", "--out", str(log)]
    assert main([*argv, "--chart-out", str(chart)]) == 0
    assert chart.read_text().startswith("lat,lon,kind,type,sigma_m,name,mmsi\n")
    assert len(chart.read_text().splitlines()) == 27
    assert main([*argv, "--chart-out", str(tmp_path / "x_truth.csv")]) == 2
    assert main(["simulate", "--chart-out", str(chart)]) == 2
    assert "--chart-out need" in capsys.readouterr().err
