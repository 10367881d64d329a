"""The frame of the command line: exit codes, one line on stderr, help without heavy imports, closed pipes."""

from __future__ import annotations

import argparse
import logging
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import navfix
from navfix import cli
from navfix.cli import errors, main
from navfix.errors import Ambiguous, CatalogError, InputError, NoAgreement, TooFewPairs, Unobservable

SOURCES = Path(navfix.__file__).parents[1]

ENDINGS = [
    (TooFewPairs("2 pairs", observations=4, unknowns=3), 3, "no fix (too_few_pairs): 2 pairs"),
    (Unobservable("all marks in one point", direction="heading"), 3, "no fix (unobservable)"),
    (NoAgreement("nothing better than chance", evidence=0.1), 3, "no fix (no_agreement)"),
    (Ambiguous("two places", alternatives=()), 3, "no fix (ambiguous): two places"),
    (CatalogError("no radar model named 'x'", key="x"), 2, "no radar model named 'x'"),
    (InputError("expected a number, got 'x'", source="case.toml", line=3), 4, "case.toml:3: expected a number"),
    (InputError("case.toml is empty", source="case.toml"), 4, "case.toml is empty"),
    (FileNotFoundError(2, "No such file", "gone.nmea"), 4, "gone.nmea: no such file"),
    (IsADirectoryError(21, "Is a directory", "folder"), 4, "folder: is a directory"),
    (PermissionError(13, "Permission denied", "secret"), 4, "secret: Permission denied"),
    (UnicodeDecodeError("utf-8", b"\xff", 0, 1, "invalid"), 4, "not text"),
    (errors.CommandError("no AIS in the log", errors.NO_FIX), 3, "no AIS in the log"),
    (errors.CommandError("two of --x"), 2, "two of --x"),
    (RuntimeError("a fault\nof two lines"), 1, "internal error, RuntimeError: a fault of two lines"),
]


def _command(monkeypatch: pytest.MonkeyPatch, run: Callable[[argparse.Namespace], int]) -> None:
    """Let `navfix models` run ``run``."""
    monkeypatch.setattr("navfix.cli.models.run", run)


@pytest.mark.parametrize(
    ("error", "code", "text"), ENDINGS, ids=[type(e[0]).__name__ + str(i) for i, e in enumerate(ENDINGS)]
)
def test_every_way_to_fail_has_its_code_and_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], error: Exception, code: int, text: str
) -> None:
    def run(_: argparse.Namespace) -> int:
        raise error

    _command(monkeypatch, run)
    assert main(["models"]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("navfix: ")
    assert captured.err.count("\n") == 1
    assert text in captured.err


def test_the_code_of_a_command_is_passed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    _command(monkeypatch, lambda _: errors.NO_FIX)
    assert main(["models"]) == 3


def test_ctrl_c_ends_quietly(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def run(_: argparse.Namespace) -> int:
        raise KeyboardInterrupt

    _command(monkeypatch, run)
    assert main(["models"]) == 130
    assert capsys.readouterr().err == ""


def test_only_much_verbosity_shows_a_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(_: argparse.Namespace) -> int:
        raise RuntimeError("deep")

    _command(monkeypatch, run)
    main(["models", "-v"])
    assert "Traceback" not in capsys.readouterr().err
    main(["models", "-vv"])
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("flags", "levels"), [([], "warning"), (["-v"], "warning info"), (["-vv"], "warning info debug")]
)
def test_the_log_goes_to_stderr(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], flags: list[str], levels: str
) -> None:
    def run(_: argparse.Namespace) -> int:
        for level in ("warning", "info", "debug"):
            getattr(logging.getLogger("navfix.somewhere"), level)(level)
        return 0

    _command(monkeypatch, run)
    main(["models", *flags])
    main([*flags, "models"])
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.split("\n") == [f"navfix: {level}" for level in levels.split()] * 2 + [""]


@pytest.mark.parametrize(
    "argv", [[], ["conjure"], ["models", "--no-such-option"], ["models", "--js"], ["models", "--out", "picture.bmp"]]
)
def test_a_command_line_that_cannot_be_right_is_usage(argv: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(argv) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "usage: navfix" in captured.err


def test_help_and_version_go_to_stdout(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    assert main(["--version"]) == 0
    captured = capsys.readouterr()
    assert f"navfix {navfix.__version__}" in captured.out
    assert captured.err == ""


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_explains_itself(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    text = capsys.readouterr().out
    assert f"usage: navfix {command}" in text
    assert len(text.splitlines()) > 4


def test_python_m_navfix_is_the_command() -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "navfix", "--version"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=SOURCES,
    )
    assert (ended.returncode, ended.stdout.strip(), ended.stderr) == (0, f"navfix {navfix.__version__}", "")


def test_a_reader_that_closes_the_pipe_is_no_error() -> None:
    read_end, write_end = os.pipe()
    os.close(read_end)  # gone before anything is written
    try:
        ended = subprocess.run(
            [sys.executable, "-m", "navfix", "models"],
            stdout=write_end,
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
            cwd=SOURCES,
        )
    finally:
        os.close(write_end)
    assert (ended.returncode, ended.stderr) == (0, b"")


def test_a_terminal_without_utf8_is_no_error() -> None:
    script = """
import navfix.cli, navfix.cli.models
navfix.cli.models.run = lambda args: print("54\u00b0 \u00b1 1") or 0
raise SystemExit(navfix.cli.main(["models"]))
"""
    ended = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        timeout=60,
        check=False,
        cwd=SOURCES,
        env={"PYTHONIOENCODING": "ascii", "PATH": ""},
    )
    assert (ended.returncode, ended.stdout.strip(), ended.stderr) == (0, b"54? ? 1", b"")
