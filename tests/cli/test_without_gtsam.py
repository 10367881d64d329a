"""A platform for which GTSAM has no wheel: everything runs, says so, and gives the same answer."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement

from navfix.adjustment import graph
from navfix.adjustment.adjust_case import adjust_case
from navfix.adjustment.case import parse_case
from navfix.errors import InputError
from navfix.geodesy import inverse
from navfix.types import Position

REPOSITORY = Path(__file__).resolve().parents[2]
LOG = str(REPOSITORY / "data" / "logs" / "approach.nmea")
GDYNIA = REPOSITORY / "data" / "golden" / "gdynia.toml"
PLATFORMS = {
    ("linux", "x86_64"): True,
    ("linux", "aarch64"): True,
    ("darwin", "arm64"): True,
    ("darwin", "x86_64"): False,
    ("win32", "AMD64"): False,
    ("win32", "ARM64"): False,
    ("linux", "riscv64"): False,
}


def navfix(*arguments: str, gtsam: bool) -> dict[str, Any]:
    """Run the command in a process of its own, where ``import gtsam`` fails if asked to; return its JSON."""
    hide = "" if gtsam else "sys.modules['gtsam'] = None; "
    program = f"import sys; {hide}from navfix.cli import main; sys.exit(main({list(arguments)!r}))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=120)
    content: dict[str, Any] = json.loads(done.stdout)
    return content


def test_a_log_is_solved_alike_with_and_without() -> None:
    if not graph.available():
        pytest.skip("GTSAM is not installed")
    with_it, without = (navfix("fix", LOG, "--json", gtsam=there) for there in (True, False))
    assert "solved by GTSAM" in with_it["notes"]
    assert "solved by dense normal equations" in without["notes"]
    places = [Position(**found["position"]) for found in (with_it, without)]
    assert inverse(*places)[0] < 1e-3
    assert without["heading_deg"] == pytest.approx(with_it["heading_deg"], abs=1e-5)
    for mine, theirs in zip(without["covariance"], with_it["covariance"], strict=True):
        assert mine == pytest.approx(theirs, rel=1e-5, abs=1e-9)


def test_a_case_is_adjusted_and_the_report_says_by_which_road() -> None:
    assert "solved by dense normal equations" in navfix("adjust", str(GDYNIA), "--json", gtsam=False)["notes"]


def test_who_asks_for_gtsam_where_it_is_not_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graph, "available", lambda: False)
    with pytest.raises(InputError, match="not installed"):
        adjust_case(parse_case(GDYNIA.read_text(encoding="utf-8")), solver="gtsam")


@pytest.mark.parametrize(("platform", "machine"), PLATFORMS)
def test_pip_asks_for_gtsam_only_where_there_is_a_wheel(platform: str, machine: str) -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (marker,) = [r.marker for line in project["dependencies"] if (r := Requirement(line)).name == "gtsam"]
    assert marker is not None
    wanted = marker.evaluate({"sys_platform": platform, "platform_machine": machine})
    assert wanted is PLATFORMS[platform, machine]
