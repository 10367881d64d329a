"""``navfix replay --smooth``: every scan's fix from the minutes about it; dead reckoning in every line."""

from __future__ import annotations

import json
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from navfix.cli import main

Rows = list[dict[str, Any]]


@pytest.fixture(scope="module")
def replayed(repository: Path) -> dict[str, Rows]:
    logs = repository / "data" / "logs"
    argv = [
        "replay",
        str(logs / "approach.nmea"),
        "--truth",
        str(logs / "approach_truth.csv"),
        "--every",
        "6",
    ]
    found = {}
    for name, more in (("alone", []), ("smooth", ["--smooth"])):
        out = StringIO()
        with redirect_stdout(out):
            assert main([*argv, *more]) == 0
        found[name] = [json.loads(line) for line in out.getvalue().splitlines()]
    return found


def test_the_smoothed_log_is_complete_and_better(replayed: dict[str, Rows]) -> None:
    alone, smooth = replayed["alone"], replayed["smooth"]
    assert [row["time_utc"] for row in smooth] == [row["time_utc"] for row in alone]
    errors = [[row["truth"]["distance_m"] for row in rows if row["status"] == "fix"] for rows in (alone, smooth)]
    assert len(errors[1]) >= len(errors[0]) > 3
    assert sum(errors[1]) / len(errors[1]) < 0.8 * sum(errors[0]) / len(errors[0])
    assert any(note.startswith("window of ") for note in smooth[-1]["notes"])


def test_three_positions_stand_apart_in_every_line(replayed: dict[str, Rows]) -> None:
    rows = replayed["alone"]
    assert rows[0]["dead_reckoning"] is None
    after = [row for row in rows[1:] if row["dead_reckoning"] and row["status"] == "fix"]
    assert after
    for row in after:
        assert row["dead_reckoning"]["source"] in ("log_and_gyro", "log", "last_velocity")
        assert row["dead_reckoning"]["ellipse"]["semi_major_m"] > 0.0
        places = [row[key]["position"] for key in ("dead_reckoning", "observed")] + [row["position"]]
        assert len({(place["lat_deg"], place["lon_deg"]) for place in places}) == 3
