"""The files that --out names: their formats, written by suffix, and never one of the inputs."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from navfix.cli.errors import CommandError
from navfix.cli.values import STDIN

OUT_SUFFIXES = (".txt", ".json", ".svg", ".geojson", ".html", ".nmea", ".gpx", ".csv")
_INPUTS = ("log", "case", "truth", "chart", "outlines", "kernel", "plots")


def output_file(text: str, suffixes: Sequence[str] = OUT_SUFFIXES) -> Path:
    """Return a path to write to: a suffix that the command can write, in a folder that exists."""
    path = Path(text)
    if path.suffix.lower() not in suffixes:
        raise argparse.ArgumentTypeError(
            f"{text}: the suffix chooses the format; here it is one of {' '.join(suffixes)}"
        )
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: is a directory")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: there is no folder {path.parent}")
    return path


def named_inputs(args: argparse.Namespace) -> Iterator[Path]:
    """Yield every file that the arguments name as input."""
    for name in _INPUTS:
        value = getattr(args, name, None)
        for item in value if isinstance(value, list) else [value]:
            if item not in (None, STDIN):
                yield Path(item)


def protect_inputs(args: argparse.Namespace) -> None:
    """Refuse an output that is one of the inputs (also through links or as standard input), or that is named twice.

    Raises
    ------
    CommandError : the same file is read and written, or written twice
    """
    read = list(named_inputs(args))
    written: list[Path] = []
    for out in getattr(args, "out", None) or ():
        if any(_same(out, path) for path in read) or (_reads_stdin(args) and _is_stdin(out)):
            raise CommandError(f"--out {out} is an input file; an input is never overwritten")
        if any(_same(out, path) for path in written):
            raise CommandError(f"--out {out} is named twice")
        written.append(out)


def _reads_stdin(args: argparse.Namespace) -> bool:
    case = getattr(args, "case", None) or ()
    return getattr(args, "log", None) == STDIN or STDIN in case


def _is_stdin(path: Path) -> bool:
    """Tell whether standard input comes from this file (``navfix fix - < LOG``)."""
    try:
        return path.exists() and os.path.samestat(path.stat(), os.fstat(sys.stdin.fileno()))
    except (OSError, ValueError, AttributeError):  # no such thing as a file behind standard input
        return False


def _same(one: Path, other: Path) -> bool:
    if one.exists() and other.exists():
        return one.samefile(other)
    return one.resolve() == other.resolve()


def write_outputs(paths: Sequence[Path], writers: Mapping[str, Callable[[], str]]) -> None:
    """Write each path with the writer of its suffix; a writer returns the whole text and runs only when asked for.

    Raises
    ------
    CommandError : no writer for a suffix (before anything is written), or a file cannot be written
    """
    for path in paths:
        if path.suffix.lower() not in writers:
            raise CommandError(f"--out {path}: this command cannot write {path.suffix}; it writes {' '.join(writers)}")
    for path in paths:
        text = writers[path.suffix.lower()]()
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise CommandError(f"--out {path}: cannot be written: {error.strerror}") from error
