"""``navfix replay``: every radar scan of a log -> JSON lines; a place is held from scan to scan, or all is smoothed."""

from __future__ import annotations

import argparse
import sys
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from navfix.cli import inputs, options, outputs, solving
from navfix.cli.errors import NO_FIX, OK, CommandError

if TYPE_CHECKING:
    from navfix.nmea import Log
    from navfix.report.answer import Answer
    from navfix.report.truth import TruthTrack
    from navfix.sequence import Navigator
    from navfix.sequence.radar_errors import RadarErrorsOverTime
    from navfix.types import Epoch, Fix, Mark, RadarErrors, ShipVeracity

SUFFIXES = (".json",)
VERACITY_SUFFIXES = (".txt", ".json")
SILENT_S = 5.0  # own ship goes on while radar is silent: a line so often


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser("replay", help="every radar scan of a log, as JSON lines", description=__doc__)
    options.add_log(parser)
    parser.add_argument("--every", metavar="N", type=_count, default=1, help="only every N-th scan (default: 1)")
    options.add_estimation(parser)
    options.add_evidence(parser)
    options.add_window(parser, default="60 s, with --independent one scan alone")
    options.add_independent(parser)
    options.add_outlines(parser)
    options.add_plots(parser)
    parser.add_argument(
        "--smooth",
        action="store_true",
        help="the whole log forward and backward: each scan's fix from minutes about it",
    )
    parser.add_argument(
        "--radar-errors",
        choices=("apply", "report", "off"),
        default="apply",
        help="the radar's clock and range bias, estimated over minutes: taken off where they are told from zero "
        "(default), only reported, or not looked for",
    )
    options.add_truth(parser)
    parser.add_argument(
        "--veracity",
        metavar="FILE",
        type=partial(outputs.output_file, suffixes=VERACITY_SUFFIXES),
        help="which ships' AIS radar does not confirm, over the whole log: a table (.txt) or rows (.json)",
    )
    options.add_output(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Solve scan by scan; a line as soon as it is known (with --smooth at the end)."""
    from navfix.integrity import AisVeracity
    from navfix.report import words
    from navfix.report.error_summary import ErrorSummary
    from navfix.report.writers import render

    written = [path for path in (*args.out, args.veracity) if path is not None]
    outputs.protect_inputs(argparse.Namespace(**{**vars(args), "out": written}))
    track, charted = inputs.truth_track(args), inputs.charted_marks(args)
    log = inputs.read_all(args, charted=bool(charted))
    lines: list[str] = []  # kept for --out only: a log of days has many
    scans, fixes, off, veracity = 0, 0, ErrorSummary(), AisVeracity()
    errors: RadarErrors | None = None
    compass_told = False
    for answer in _answers(log, args, track, charted):
        if answer.gnss is not None and answer.gnss.alert:
            print(f"navfix: {_clock(answer.epoch)}{answer.gnss.alert}", file=sys.stderr)
        compass_told = compass_told or _tell_compass(answer)
        if answer.fix is not None:
            fixes += 1
            if answer.fix.observations:  # a place carried forward has none
                veracity.feed(answer.fix)
        off.feed(answer.truth)
        errors = answer.radar_errors or errors
        scans += answer.epoch is None or bool(answer.epoch.targets)
        line = render(answer, ".json").strip()
        print(line, flush=True)
        if args.out:
            lines.append(line)
    if not scans:
        raise CommandError(f"{args.log}: no fix: no complete radar scan", NO_FIX)
    outputs.write_outputs(args.out, {".json": lambda: "\n".join(lines) + "\n"})
    truths = "" if track is None else f", {off.words()}"
    print(f"navfix: {words.plural(fixes, 'fix')} in {words.plural(scans, 'scan')}{truths}", file=sys.stderr)
    if errors is not None and fixes:
        _tell_radar_errors(errors, windows=_in_windows(args))
    if args.veracity is not None:
        _write_veracity(args.veracity, veracity.ships())
    return OK if fixes else NO_FIX


def _answers(log: Log, args: argparse.Namespace, track: TruthTrack | None, charted: Sequence[Mark]) -> Iterator[Answer]:
    """Yield the answers of every N-th scan; with --smooth from all scans, when all of them are known."""
    from navfix import pipeline
    from navfix.integrity import GnssMonitor
    from navfix.sequence.answers import reckoned, smoothed
    from navfix.sequence.dead_reckoning import DeadReckoner

    monitor, reckoner = GnssMonitor(), DeadReckoner()
    silent_s = None if args.independent else SILENT_S
    epochs = pipeline.epochs(log, radar=options.radar(args), charted=charted, silent_s=silent_s)
    solved = _solved(epochs, args, track, every=1 if args.smooth else args.every)
    forward = (reckoned(answer, reckoner) for answer in solved)
    if not args.smooth:
        yield from (pipeline.watched(answer, monitor) for answer in forward)
        return
    for answer in smoothed(tuple(forward), radar=options.radar(args), kernel=args.kernel)[:: args.every]:
        yield solving.with_truth(answer, track)


def _solved(
    epochs: Iterable[Epoch], args: argparse.Namespace, track: TruthTrack | None, *, every: int
) -> Iterator[Answer]:
    """Yield the answer of every N-th scan: by the navigator, or with --independent each scan or window alone."""
    from navfix.sequence.answers import navigated

    navigator = None if args.independent else _navigator(args)
    outlines, errors = inputs.outlines(args), _radar_errors(args)
    kept: deque[Epoch] = deque()
    last: Epoch | None = None
    for count, epoch in enumerate(epochs):
        if _begins_anew(last, epoch):  # another recording in the same log: what was known does not hold
            navigator, errors = None if navigator is None else _navigator(args), _radar_errors(args)
            kept.clear()
        last = epoch
        seen = solving.outlined(solving.as_asked(epoch, args), outlines)
        seen = seen if errors is None else errors.corrected(seen)
        if navigator is not None:
            navigator.feed(seen)
        kept.append(seen)
        solving.trim(kept, args.window or 0.0)
        if count % every:
            continue
        if navigator is not None:
            answer = solving.finish(navigated(navigator, seen), args, track)
        elif args.window is not None:
            answer = solving.solve_scans(tuple(kept), args, track)
        else:
            answer = solving.solve(seen, args, track)
        yield answer if errors is None else _with_radar_errors(answer, errors, args, track)


def _begins_anew(last: Epoch | None, epoch: Epoch) -> bool:
    if last is None or last.time_utc is None or epoch.time_utc is None:
        return False
    return epoch.time_utc < last.time_utc


def _radar_errors(args: argparse.Namespace) -> RadarErrorsOverTime | None:
    """Return the estimator of --radar-errors; the clock is left to the windows wherever there are any."""
    if args.radar_errors == "off":
        return None
    from navfix.sequence.radar_errors import RadarErrorsOverTime

    return RadarErrorsOverTime(
        windows=_in_windows(args), correct=args.radar_errors == "apply", radar=options.radar(args), kernel=args.kernel
    )


def _in_windows(args: argparse.Namespace) -> bool:
    return not args.independent or args.window is not None or args.smooth


def _tell_compass(answer: Answer) -> bool:
    """Say that the echoes refute the compass, where they do; every line holds it, the log of the run tells it once."""
    from navfix.integrity.cautions import CHECK_COMPASS

    found = next((caution for caution in answer.cautions if caution.startswith(CHECK_COMPASS)), None)
    if found is not None:
        print(f"navfix: {_clock(answer.epoch)}{found}", file=sys.stderr)
    return found is not None


def _tell_radar_errors(errors: RadarErrors, *, windows: bool) -> None:
    from navfix.report.radar_errors import radar_errors_words

    for line in radar_errors_words(errors, windows=windows):
        print(f"navfix: {line}", file=sys.stderr)


def _with_radar_errors(
    answer: Answer, errors: RadarErrorsOverTime, args: argparse.Namespace, track: TruthTrack | None
) -> Answer:
    """Feed the fix of an answer; return the answer with the doubt about what was taken off and what is known now."""
    from dataclasses import replace

    errors.feed(answer.fix)
    doubted = None if answer.fix is None else errors.doubted(answer.fix)
    if doubted is not answer.fix:
        answer = solving.finish(_judged_anew(answer, doubted), args, track)
    return replace(answer, radar_errors=errors.estimate())


def _judged_anew(answer: Answer, fix: Fix | None) -> Answer:
    from dataclasses import replace

    from navfix.integrity import gnss_verdict

    gnss = None if answer.epoch is None else answer.epoch.gnss
    return replace(answer, fix=fix, gnss=None if fix is None or gnss is None else gnss_verdict(fix, gnss))


def _navigator(args: argparse.Namespace) -> Navigator:
    from dataclasses import replace

    from navfix.catalog import navigator_model
    from navfix.sequence import Navigator

    model = navigator_model()
    if args.window is not None:
        model = replace(model, window_s=args.window, kept_s=max(model.kept_s, args.window + 5.0))
    return Navigator(model=model, radar=options.radar(args), kernel=args.kernel)


def _write_veracity(path: Path, ships: tuple[ShipVeracity, ...]) -> None:
    from navfix.report.veracity import summary, veracity_json, veracity_text

    writers = {".json": lambda: veracity_json(ships), ".txt": lambda: veracity_text(ships, all_ships=True)}
    outputs.write_outputs([path], writers)
    print(f"navfix: AIS veracity: {summary(ships)}", file=sys.stderr)


def _clock(epoch: Epoch | None) -> str:
    return "" if epoch is None or epoch.time_utc is None else f"{epoch.time_utc:%H:%M:%SZ} "


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number >= 1, got {text!r}")
    return int(text)
