"""``navfix replay``: every radar scan of a log -> JSON lines; a place is held from scan to scan."""

from __future__ import annotations

import argparse
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from navfix.cli import options, solving
from navfix.cli.errors import NO_FIX, OK, CommandError

if TYPE_CHECKING:
    from navfix.errors import NoFix
    from navfix.report.answer import Answer
    from navfix.report.truth import TruthTrack
    from navfix.sequence import Navigator
    from navfix.types import Epoch, ShipVeracity

SUFFIXES = (".json",)
VERACITY_SUFFIXES = (".txt", ".json")


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
    parser.add_argument(
        "--veracity",
        metavar="FILE",
        type=partial(options.output_file, suffixes=VERACITY_SUFFIXES),
        help="which ships' AIS radar does not confirm, over the whole log: a table (.txt) or rows (.json)",
    )
    options.add_output(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Solve scan by scan; a line as soon as it is known."""
    from navfix import pipeline
    from navfix.integrity import AisVeracity, GnssMonitor
    from navfix.report.writers import render

    solving.refuse(args, ["chart"])
    written = [path for path in (*args.out, args.veracity) if path is not None]
    options.protect_inputs(argparse.Namespace(**{**vars(args), "out": written}))
    track = solving.truth_track(args)
    log = solving.read(args.log)
    lines, fixes, known, monitor, veracity = [], 0, 0, GnssMonitor(), AisVeracity()
    for answer in answers(pipeline.epochs(log, radar=options.radar(args)), args, track):
        answer = pipeline.watched(answer, monitor)
        if answer.gnss is not None and answer.gnss.alert:
            print(f"navfix: {_clock(answer.epoch)}{answer.gnss.alert}", file=sys.stderr)
        if answer.fix is not None:
            fixes += 1
            if answer.fix.observations:  # a place carried forward has none
                veracity.feed(answer.fix)
        known += answer.truth is not None
        lines.append(render(answer, ".json").strip())
        print(lines[-1], flush=True)
    if not lines:
        raise CommandError(f"{args.log}: no fix: no complete radar scan", NO_FIX)
    options.write_outputs(args.out, {".json": lambda: "\n".join(lines) + "\n"})
    truths = "" if track is None else f", {known} of them with a truth"
    print(f"navfix: {fixes} fixes in {len(lines)} scans{truths}", file=sys.stderr)
    if args.veracity is not None:
        _write_veracity(args.veracity, veracity.ships())
    return OK if fixes else NO_FIX


def answers(epochs: Iterable[Epoch], args: argparse.Namespace, track: TruthTrack | None) -> Iterator[Answer]:
    """Yield the answer of every N-th scan: by the navigator, or with --independent each scan or window alone."""
    navigator = None if args.independent else _navigator(args)
    kept: deque[Epoch] = deque()
    for count, epoch in enumerate(epochs):
        epoch = solving.without_hints(epoch, args)
        wanted = count % args.every == 0
        if navigator is not None:
            navigator.feed(epoch)
            if wanted:
                yield solving.finish(_step(navigator, epoch), args, track)
        elif wanted and args.window is None:
            yield solving.solve(epoch, args, track)
        elif args.window is not None:
            kept.append(epoch)
            solving.trim(kept, args.window)
            if wanted:
                yield solving.solve_window(tuple(kept), args, track)


def _navigator(args: argparse.Namespace) -> Navigator:
    from dataclasses import replace

    from navfix.catalog import navigator_model
    from navfix.sequence import Navigator

    model = navigator_model()
    if args.window is not None:
        model = replace(model, window_s=args.window, kept_s=max(model.kept_s, args.window + 5.0))
    return Navigator(model=model)


def _step(navigator: Navigator, epoch: Epoch) -> Answer:
    """Return the navigator's outcome at the newest epoch as an answer."""
    from dataclasses import replace

    from navfix import pipeline
    from navfix.errors import Ambiguous, NoAgreement
    from navfix.report.answer import Answer

    began_s = time.perf_counter()
    outcome = navigator.step()
    timing_ms = {"epoch": epoch.build_ms or 0.0, "navigate": round(1e3 * (time.perf_counter() - began_s), 3)}
    if outcome.fix is not None:
        answer = pipeline.beside(outcome.fix, outcome.association, epoch, timing_ms=timing_ms)
        return replace(answer, track=outcome.track)
    if outcome.track.status == "conflict":
        error: NoFix = Ambiguous(outcome.reason, alternatives=navigator.alternatives())
    else:
        evidence = outcome.track.score if outcome.track.score is not None else 0.0
        error = NoAgreement(outcome.reason, evidence=evidence, alternatives=navigator.alternatives())
    return Answer(epoch=epoch, error=error, timing_ms=timing_ms, track=outcome.track)


def _write_veracity(path: Path, ships: tuple[ShipVeracity, ...]) -> None:
    from navfix.report.veracity import summary, veracity_json, veracity_text

    writers = {".json": lambda: veracity_json(ships), ".txt": lambda: veracity_text(ships, all_ships=True)}
    options.write_outputs([path], writers)
    print(f"navfix: AIS veracity: {summary(ships)}", file=sys.stderr)


def _clock(epoch: Epoch | None) -> str:
    return "" if epoch is None or epoch.time_utc is None else f"{epoch.time_utc:%H:%M:%SZ} "


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number >= 1, got {text!r}")
    return int(text)
