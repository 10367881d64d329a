"""What the commands that solve logs share: read the log and the truth, refuse what is not there yet, solve, write."""

from __future__ import annotations

import argparse
import logging
import sys
from collections import deque
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from navfix.cli import options
from navfix.cli.errors import NO_FIX, CommandError

if TYPE_CHECKING:
    from navfix.catalog import AssociationModel, CpdModel
    from navfix.nmea import Log
    from navfix.report.answer import Answer
    from navfix.report.truth import TruthTrack
    from navfix.types import Association, Epoch

_logger = logging.getLogger(__name__)


def read(path: str) -> Log:
    """Read LOG ("-": standard input); it must hold radar targets and AIS.

    Raises
    ------
    InputError : nothing readable
    CommandError : readable, but without radar or without AIS (no fix can follow)
    """
    from navfix.errors import InputError
    from navfix.nmea import read_log
    from navfix.nmea.log import report_problems
    from navfix.nmea.records import AisPosition, TargetReport

    log = (
        read_log(sys.stdin.buffer, name="standard input", report=False)
        if path == options.STDIN
        else read_log(path, report=False)
    )
    path = log.name if path == options.STDIN else path
    if not log.records:
        first = f"; {log.problems[0]}" if log.problems else ""
        raise InputError(f"{path}: nothing readable, expected NMEA sentences{first}", source=path)
    ais = any(not report.own for report in log.of(AisPosition))
    lacking = [word for word, there in (("radar targets (TTM)", log.of(TargetReport)), ("AIS (VDM)", ais)) if not there]
    if lacking:
        raise CommandError(f"{path}: no fix: the log holds no {' and no '.join(lacking)}", NO_FIX)
    if log.time_basis == "none":
        raise CommandError(
            f"{path}: no fix: the log tells no time; expected TAG blocks, time stamps, or RMC, ZDA or TTM with UTC",
            NO_FIX,
        )
    report_problems(log)
    if not log.time_known:
        _logger.warning("%s: tells the time of day and no date: its first day is called 1970-01-01", log.name)
    return log


def truth_track(args: argparse.Namespace) -> TruthTrack | None:
    """Read --truth where it is given."""
    if args.truth is None:
        return None
    from navfix.report.truth import TruthTrack

    with args.truth.open(encoding="utf-8-sig", newline="") as lines:
        return TruthTrack.parse(lines, source=str(args.truth))


def one_epoch(log: Log, args: argparse.Namespace) -> Epoch:
    """Return the epoch that --at chooses, or that of the last complete scan.

    Raises
    ------
    CommandError : the log holds no complete radar scan there
    """
    from navfix import pipeline

    epoch = next(pipeline.epochs(log, radar=options.radar(args), at=args.at, last=args.at is None), None)
    if epoch is None:
        when = "" if args.at is None else f" at {args.at:%Y-%m-%dT%H:%M:%SZ}"
        raise CommandError(f"{args.log}: no fix: no complete radar scan{when}", NO_FIX)
    return without_hints(epoch, args)


def without_hints(epoch: Epoch, args: argparse.Namespace) -> Epoch:
    """Take the hints out that --no-prior and --heading-from none forbid."""
    from dataclasses import replace

    if args.no_prior or args.heading_from == "none":
        epoch = replace(epoch, heading_hint=None)
    return replace(epoch, position_hint=None) if args.no_prior else epoch


def solve(epoch: Epoch, args: argparse.Namespace, track: TruthTrack | None) -> Answer:
    """Solve an epoch with the options of the command, and set the truth beside it."""
    from navfix import pipeline

    answer = pipeline.answer(
        epoch,
        radar=options.radar(args),
        kernel=args.kernel,
        method=method(args),
        prove=getattr(args, "prove", False),
        association=pairs_by_hand(epoch, args),
    )
    return finish(answer, args, track)


def solve_window(epochs: Sequence[Epoch], args: argparse.Namespace, track: TruthTrack | None) -> Answer:
    """Solve a window of epochs together with the options of the command, and set the truth beside it."""
    from navfix import pipeline

    return finish(pipeline.answer_of_window(epochs, method=method(args)), args, track)


def finish(answer: Answer, args: argparse.Namespace, track: TruthTrack | None) -> Answer:
    """Judge the GNSS at the ship's reference point, where that is told, and set the truth beside the answer."""
    answer = _at_reference_point(answer, args)
    if track is None:
        return answer
    from navfix.report.truth import with_truth

    return with_truth(answer, track)


def trim(epochs: deque[Epoch], window_s: float) -> None:
    """Drop the epochs that are older than a window ending at the newest one."""
    newest = epochs[-1].time_utc
    while newest is not None and epochs[0].time_utc is not None:
        if (newest - epochs[0].time_utc).total_seconds() <= window_s:
            break
        epochs.popleft()


def window_epochs(log: Log, args: argparse.Namespace) -> tuple[Epoch, ...]:
    """Return the epochs of the --window that ends at --at, or at the last complete scan.

    Raises
    ------
    CommandError : the log holds no complete radar scan there
    """
    from navfix import pipeline

    newest = one_epoch(log, args)
    kept: deque[Epoch] = deque()
    for epoch in pipeline.epochs(log, radar=options.radar(args)):
        if newest.time_utc is None or epoch.time_utc is None or epoch.time_utc > newest.time_utc:
            break
        kept.append(without_hints(epoch, args))
        trim(kept, args.window)
    return tuple(kept) or (newest,)


def method(args: argparse.Namespace) -> AssociationModel | CpdModel:
    """Return the association method that --method names, with --accept in place of its own probability."""
    from dataclasses import replace

    from navfix.catalog import AssociationModel, association_method

    chosen = association_method(getattr(args, "method", "seeded"))
    accept = getattr(args, "accept", None)
    return replace(chosen, accept_probability=accept) if accept and isinstance(chosen, AssociationModel) else chosen


def pairs_by_hand(epoch: Epoch, args: argparse.Namespace) -> Association | None:
    """Return the association that --pairs gives: a mark by its label (MMSI) or by its name."""
    from navfix.errors import InputError
    from navfix.types import Association

    if not getattr(args, "pairs", None):
        return None
    labels = {mark.label for mark in epoch.marks}
    by_name = {mark.name.strip().upper(): mark.label for mark in epoch.marks if mark.name}
    wanted = [(target, mark if mark in labels else by_name.get(mark.upper(), mark)) for target, mark in args.pairs]
    try:
        return Association.from_pairs(epoch, wanted)
    except InputError as error:
        raise CommandError(f"--pairs: {error}") from error


def _at_reference_point(answer: Answer, args: argparse.Namespace) -> Answer:
    """Judge the GNSS once more at the ship's reference point where --gnss-antenna says how far off its antenna is."""
    if args.gnss_antenna is None or answer.fix is None or answer.epoch is None or answer.epoch.gnss is None:
        return answer
    from dataclasses import replace

    from navfix.adjustment.lever_arm import gnss_at_reference_point
    from navfix.integrity import gnss_verdict

    moved = gnss_at_reference_point(answer.epoch.gnss, args.gnss_antenna, answer.fix)
    return replace(answer, gnss=gnss_verdict(answer.fix, moved))


def write(answer: Answer, args: argparse.Namespace) -> None:
    """Write the answer to every --out."""
    write_files(answer, args.out)


def write_files(answer: Answer, paths: Sequence[Path]) -> None:
    """Write the answer to every path, in the format of its suffix."""
    from navfix.report.writers import render

    options.write_outputs(paths, {suffix: partial(render, answer, suffix) for suffix in options.OUT_SUFFIXES})


def refuse(args: argparse.Namespace, names: Iterable[str]) -> None:
    """Refuse options that this version does not know how to serve, rather than pass over them in silence."""
    for name in names:
        if getattr(args, name, None):
            raise CommandError(f"--{name.replace('_', '-')} is not available in this version")
