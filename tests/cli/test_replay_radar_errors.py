"""``navfix replay --radar-errors``: what minutes say of the radar's clock and ranges, in every line and on stderr."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from navfix.cli import main
from tests.radar_error_scenes import recording

BIAS_M = 60.0


@pytest.fixture(scope="module")
def roads(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("roads") / "roads.nmea"
    made = recording(1, clock_s=0.0, bias_m=BIAS_M, duration_s=45.0)
    log.write_text("\n".join(made.lines) + "\n", encoding="utf-8")
    return log


def replayed(log: Path, capsys: pytest.CaptureFixture[str], *options: str) -> tuple[list[dict[str, Any]], str]:
    assert main(["replay", str(log), "--radar", "solid_state", "--every", "3", *options]) == 0
    said = capsys.readouterr()
    return [json.loads(line) for line in said.out.splitlines()], said.err


def test_the_range_bias_is_found_taken_off_and_told(roads: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows, said = replayed(roads, capsys, "--independent")
    found = rows[-1]["radar_errors"]["range"]
    assert found["significant"]
    assert found["value_m"] == pytest.approx(BIAS_M, abs=3.0 * found["sigma_m"])
    assert found["applied_m"] != 0.0
    assert "navfix: radar range bias: +" in said
    assert "taken off" in said
    assert rows[0]["radar_errors"]["range"]["applied_m"] == 0.0
    assert any("radar errors that were taken off" in note for note in rows[-1]["notes"])
    assert not any("radar errors that were taken off" in note for note in rows[0]["notes"])


def test_report_leaves_the_fix_as_it_is_and_off_says_nothing(roads: Path, capsys: pytest.CaptureFixture[str]) -> None:
    reported, said = replayed(roads, capsys, "--independent", "--radar-errors", "report")
    off, silent = replayed(roads, capsys, "--independent", "--radar-errors", "off")
    assert [row["position"] for row in reported] == [row["position"] for row in off]
    assert reported[-1]["radar_errors"]["range"]["value_m"] is not None
    assert reported[-1]["radar_errors"]["range"]["applied_m"] == 0.0
    assert all(row["radar_errors"] is None for row in off)
    assert "radar range bias" in said
    assert "radar" not in silent


def test_windows_keep_the_clock_for_themselves(roads: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows, _ = replayed(roads, capsys, "--independent", "--window", "20")
    assert all(row["radar_errors"]["clock"]["applied_s"] == 0.0 for row in rows)
    assert rows[-1]["radar_errors"]["range"]["fixes"] > 0
