"""``navfix replay`` while radar is silent: lines of dead reckoning, apart from any fix, whose ellipse grows."""

from __future__ import annotations

import json
import re
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from navfix.cli import main

FIRST_S, SILENT_S, BACK_S, LAST_S = 1772355605, 1772355645, 1772355715, 1772355755


@pytest.fixture(scope="module")
def rows(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """Replay the shipped log without its echoes from the 40th to the 110th second."""
    logs = repository / "data" / "logs"
    kept, now_s = [], FIRST_S
    for line in (logs / "approach.nmea").read_text().splitlines(keepends=True):
        stamp = re.search(r"c:(\d{10})", line)
        now_s = int(stamp[1]) if stamp else now_s
        if now_s <= LAST_S and not ("TTM" in line and SILENT_S <= now_s < BACK_S):
            kept.append(line)
    log = tmp_path_factory.mktemp("silence") / "silent.nmea"
    log.write_text("".join(kept))
    out = StringIO()
    with redirect_stdout(out):
        assert main(["replay", str(log), "--truth", str(logs / "approach_truth.csv")]) == 0
    return [json.loads(line) for line in out.getvalue().splitlines()]


def test_dead_reckoning_goes_on_while_radar_is_silent_and_is_no_fix(rows: list[dict[str, Any]]) -> None:
    silent = [row for row in rows if row["track"]["status"] == "dead_reckoning" and row["dead_reckoning"]["age_s"] > 15]
    assert len(silent) >= 4
    for row in silent:
        assert row["status"] == "no_fix"
        assert row["reason"] == "too_few_pairs"
        assert row["position"] is None
        assert row["track"]["probability_wrong"] is None, "nothing is given out"
        assert row["dead_reckoning"]["probability_wrong"] >= 0.01
        assert row["dead_reckoning"]["doubt"] is None
        assert "dead reckoning" in row["message"]
    ages = [row["dead_reckoning"]["age_s"] for row in silent]
    axes = [row["dead_reckoning"]["ellipse"]["semi_major_m"] for row in silent]
    assert ages == sorted(ages)
    assert axes == sorted(axes)
    assert axes[-1] > 1.5 * axes[0]


def test_there_is_none_before_the_first_fix(rows: list[dict[str, Any]]) -> None:
    first = next(k for k, row in enumerate(rows) if row["status"] == "fix")
    assert all(row["dead_reckoning"] is None for row in rows[: first + 1])


def test_after_the_silence_no_fix_is_drawn_to_where_dead_reckoning_wrongly_leads(rows: list[dict[str, Any]]) -> None:
    """A prior from before the silence gave fixes 280 to 470 m off, ellipse 220 m, from a few pairs that fit."""
    back = max(k for k, row in enumerate(rows) if not row["unmatched_targets"] and "no echo" in row["message"])
    fixes = [row for row in rows[back + 1 :] if row["status"] == "fix"]
    assert len(fixes) >= 4
    assert max(row["truth"]["distance_m"] for row in fixes) < 60.0
