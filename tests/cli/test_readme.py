"""What the README and the quick start tell a newcomer to do is done here, word for word."""

from __future__ import annotations

import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

import navfix
from navfix.cli import COMMANDS, main

REPOSITORY = Path(__file__).resolve().parents[2]
PAGES = ("README.md", "docs/quickstart.md")
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def _blocks(page: str, language: str) -> list[str]:
    text = (REPOSITORY / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def _commands(page: str) -> list[str]:
    return [
        line.removeprefix("$ ")
        for block in _blocks(page, "console")
        for line in block.splitlines()
        if line.startswith("$ navfix")
    ]


SNIPPETS = [(page, block) for page in PAGES for block in _blocks(page, "python")]
LINES = [(page, command) for page in PAGES for command in _commands(page)]


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with the files that the pages name: a log and its truth, made from the shipped ones."""
    logs = REPOSITORY / "data" / "logs"
    shutil.copy(min(logs.glob("*.nmea")), tmp_path / "approach.nmea")
    shutil.copy(min(logs.glob("*truth*.csv")), tmp_path / "approach_truth.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("page", "snippet"), SNIPPETS)
def test_the_python_of_the_pages_runs(page: str, snippet: str, desk: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-W", "error", "-c", snippet],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=desk,
        env={"PYTHONPATH": str(Path(navfix.__file__).parents[1]), "OMP_NUM_THREADS": "1", "PATH": ""},
    )
    assert ended.returncode == 0, ended.stderr
    assert re.search(r"\b54\.4\d+.*\b12\.0\d+", ended.stdout), "the approach lies at 54.4 N 12.1 E"


@pytest.mark.parametrize(("page", "command"), LINES)
def test_the_commands_of_the_pages_run(
    page: str, command: str, desk: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    argv = shlex.split(command)[1:]
    if "--at" in argv:  # the page shows the form; the time is one of this log
        argv[argv.index("--at") + 1] = _a_time_of(desk / "approach.nmea")
    assert main(argv) == 0, capsys.readouterr().err
    assert capsys.readouterr().out
    for option, value in pairwise(argv):
        if option == "--out":
            assert (desk / value).stat().st_size > 0


def _a_time_of(log: Path) -> str:
    """Return the time of the last scan of a log."""
    from navfix.nmea import read_log
    from navfix.pipeline import epochs

    (epoch,) = epochs(read_log(str(log)), last=True)
    assert epoch.time_utc is not None
    return epoch.time_utc.isoformat()


def test_the_case_of_the_quick_start_is_solved(desk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (case,) = _blocks("docs/quickstart.md", "toml")
    assert set(tomllib.loads(case)) == {"frame", "marks", "observations", "start"}
    (desk / "case.toml").write_text(case)
    assert main(["adjust", "case.toml"]) == 0
    assert "sigma0" in capsys.readouterr().out


def _numbers(text: str) -> list[float]:
    return [float(number) for number in NUMBER.findall(text)]


def test_the_output_in_the_readme_is_what_is_printed_now(tmp_path: Path) -> None:
    make_readme = runpy.run_path(str(REPOSITORY / "docs" / "make_readme.py"), run_name="make_readme")
    then = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    now = make_readme["filled"](then, tmp_path)
    assert "FIX  " in now
    assert "95 %: " in now
    why = "run `make pages`"
    assert NUMBER.sub("#", now) == NUMBER.sub("#", then), why
    # Another processor may round a last digit the other way.
    assert _numbers(now) == pytest.approx(_numbers(then), abs=0.11, rel=0.01), why


def test_every_command_is_in_the_readme_and_no_other() -> None:
    table = re.findall(r"^\| `navfix (\w+)", (REPOSITORY / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(table) == sorted(COMMANDS)


def test_pages_of_this_kind_hold_something_to_run() -> None:
    assert len(SNIPPETS) >= 2
    assert len(LINES) >= 3
