"""``navfix demo``: solves a shipped log, prints the report and writes pictures into ./navfix-demo/."""

from __future__ import annotations

import argparse
from pathlib import Path

from navfix.cli import inputs, solving
from navfix.cli.errors import NO_FIX, OK, CommandError

LOG = "approach.nmea"
FOLDER = Path("navfix-demo")
FILES = ("fix.svg", "fix.geojson", "fix.json", "fix.html", "fix.txt")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser(
        "demo", help="solve a shipped log and write pictures into ./navfix-demo/", description=__doc__
    )
    parser.set_defaults(
        run=run,
        at=None,
        kernel="hampel",
        radar="imo",
        range_sigma=None,
        bearing_sigma=None,
        compass_sigma=None,
        radar_antenna=None,
        gnss_antenna=None,
        alignment=None,
        no_prior=True,
        heading_from="none",
    )


def run(args: argparse.Namespace) -> int:
    """Do what ``navfix fix`` does, with the log that comes along and the truth beside it."""
    from navfix.catalog import data_folder
    from navfix.report.writers import render

    folder = data_folder("data") / "logs"
    args.log, args.truth = str(folder / LOG), folder / LOG.replace(".nmea", "_truth.csv")
    answer = solving.solve(solving.one_epoch(inputs.read(args.log), args), args, inputs.truth_track(args))
    print(render(answer, ".txt").rstrip("\n"))
    paths = [FOLDER / name for name in FILES]
    try:
        FOLDER.mkdir(exist_ok=True)
    except OSError as error:
        raise CommandError(f"./{FOLDER}: cannot be made: {error.strerror}") from error
    solving.write_files(answer, paths)
    print(f"\nWritten: {', '.join(str(path) for path in paths)}")
    return OK if answer.fix is not None else NO_FIX
