"""``navfix replay``: every radar scan of a log -> JSON lines, each scan solved alone, the GNSS verdict lasting."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from navfix.cli import options, solving
from navfix.cli.errors import NO_FIX, OK, CommandError

if TYPE_CHECKING:
    from navfix.types import Epoch

SUFFIXES = (".json",)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser("replay", help="every radar scan of a log, as JSON lines", description=__doc__)
    options.add_log(parser)
    parser.add_argument("--every", metavar="N", type=_count, default=1, help="only every N-th scan (default: 1)")
    options.add_estimation(parser)
    options.add_evidence(parser)
    options.add_window(parser)
    options.add_independent(parser)
    options.add_truth(parser)
    options.add_output(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Solve scan by scan; a line as soon as it is known."""
    from navfix import pipeline
    from navfix.integrity import GnssMonitor
    from navfix.report.writers import render

    solving.refuse(args, ["chart", "window"])
    track = solving.truth_track(args)
    log = solving.read(args.log)
    lines, fixes, known, monitor = [], 0, 0, GnssMonitor()
    for count, epoch in enumerate(pipeline.epochs(log, radar=options.radar(args))):
        if count % args.every:
            continue
        answer = pipeline.watched(solving.solve(solving.without_hints(epoch, args), args, track), monitor)
        if answer.gnss is not None and answer.gnss.alert:
            print(f"navfix: {_clock(epoch)}{answer.gnss.alert}", file=sys.stderr)
        fixes += answer.fix is not None
        known += answer.truth is not None
        lines.append(render(answer, ".json").strip())
        print(lines[-1], flush=True)
    if not lines:
        raise CommandError(f"{args.log}: no fix: no complete radar scan", NO_FIX)
    options.write_outputs(args.out, {".json": lambda: "\n".join(lines) + "\n"})
    truths = "" if track is None else f", {known} of them with a truth"
    print(f"navfix: {fixes} fixes in {len(lines)} scans{truths}", file=sys.stderr)
    return OK if fixes else NO_FIX


def _clock(epoch: Epoch) -> str:
    return "" if epoch.time_utc is None else f"{epoch.time_utc:%H:%M:%SZ} "


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number >= 1, got {text!r}")
    return int(text)
