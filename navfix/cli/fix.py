"""``navfix fix``: one radar scan of a log, or a window of scans -> position, heading, ellipse, residual report."""

from __future__ import annotations

import argparse
import sys

from navfix.cli import inputs, options, solving
from navfix.cli.errors import NO_FIX, OK, CommandError, one_line


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser(
        "fix", help="adjusted position and heading of one radar scan of a log, or of a window", description=__doc__
    )
    options.add_one_scan(parser)
    options.add_window(parser)
    options.add_outlines(parser)
    options.add_plots(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Solve the scan, print the report, write the files."""
    from navfix.report.writers import render

    track, charted = inputs.truth_track(args), inputs.charted_marks(args)
    log = inputs.read_all(args, charted=bool(charted))
    if args.window is None:
        answer = solving.solve(solving.one_epoch(log, args, charted), args, track)
    else:
        _refuse_with_window(args)
        answer = solving.solve_scans(solving.window_epochs(log, args, charted), args, track)
    print(render(answer, ".json" if args.json else ".txt").rstrip("\n"))
    solving.write(answer, args)
    if answer.error is not None:
        print(f"navfix: no fix ({answer.error.reason}): {one_line(answer.error)}", file=sys.stderr)
        return NO_FIX
    if track is not None and answer.truth is None:
        print(f"navfix: {args.truth}: nothing about the time of this scan: no error can be told", file=sys.stderr)
    return OK


def _refuse_with_window(args: argparse.Namespace) -> None:
    """Refuse what says something about one scan only."""
    for name in ("pairs", "prove", "accept"):
        if getattr(args, name):
            raise CommandError(f"--{name} is for one scan: leave it out, or --window")
