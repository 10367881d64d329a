"""What the commands that solve logs share: the epochs that the options choose, the solution, the files."""

from __future__ import annotations

import argparse
from collections import deque
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from navfix.cli import inputs, options, outputs
from navfix.cli.errors import NO_FIX, CommandError

if TYPE_CHECKING:
    from navfix.catalog import AssociationModel, CpdModel
    from navfix.nmea import Log
    from navfix.picture.outlines import Outlines
    from navfix.report.answer import Answer
    from navfix.report.truth import TruthTrack
    from navfix.types import Association, Epoch, Mark


def outlined(epoch: Epoch, found: Outlines | None) -> Epoch:
    """Put the centres of hulls in place of the echoes that have an outline."""
    if found is None:
        return epoch
    from navfix.picture.outlines import with_outlines

    return with_outlines(epoch, found)


def one_epoch(log: Log, args: argparse.Namespace, charted: Sequence[Mark] = ()) -> Epoch:
    """Return the epoch that --at chooses, or that of the last complete scan.

    Raises
    ------
    CommandError : the log holds no complete radar scan there
    """
    from navfix import pipeline

    epochs = pipeline.epochs(log, radar=options.radar(args), charted=charted, at=args.at, last=args.at is None)
    epoch = next(epochs, None)
    if epoch is None:
        when = "" if args.at is None else f" at {args.at:%Y-%m-%dT%H:%M:%SZ}"
        raise CommandError(f"{args.log}: no fix: no complete radar scan{when}", NO_FIX)
    return outlined(as_asked(epoch, args), inputs.outlines(args))


def as_asked(epoch: Epoch, args: argparse.Namespace) -> Epoch:
    """Take out what the options exclude: the data that --choice source leaves, then the hints."""
    from navfix.picture.choice import as_the_source_chooses

    if getattr(args, "choice", "all") == "source":
        epoch = as_the_source_chooses(epoch)
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


def solve_scans(epochs: Sequence[Epoch], args: argparse.Namespace, track: TruthTrack | None) -> Answer:
    """Solve a window of epochs together with the options of the command, and set the truth beside it."""
    from navfix import pipeline

    found = pipeline.answer_of_window(epochs, radar=options.radar(args), kernel=args.kernel, method=method(args))
    return finish(found, args, track)


def finish(answer: Answer, args: argparse.Namespace, track: TruthTrack | None) -> Answer:
    """Judge the GNSS at the ship's reference point, where that is told, and set the truth beside the answer."""
    return with_truth(_at_reference_point(answer, args), track)


def with_truth(answer: Answer, track: TruthTrack | None) -> Answer:
    """Return the answer with the truth of its instant beside it, where there is any."""
    if track is None:
        return answer
    from navfix.report import truth

    return truth.with_truth(answer, track)


def trim(epochs: deque[Epoch], window_s: float) -> None:
    """Drop the epochs that are older than a window ending at the newest one."""
    newest = epochs[-1].time_utc
    while newest is not None and epochs[0].time_utc is not None:
        if (newest - epochs[0].time_utc).total_seconds() <= window_s:
            break
        epochs.popleft()


def window_epochs(log: Log, args: argparse.Namespace, charted: Sequence[Mark] = ()) -> tuple[Epoch, ...]:
    """Return the epochs of the --window that ends at --at, or at the last complete scan.

    Raises
    ------
    CommandError : the log holds no complete radar scan there
    """
    from navfix import pipeline

    newest, outlines = one_epoch(log, args, charted), inputs.outlines(args)
    kept: deque[Epoch] = deque()
    for epoch in pipeline.epochs(log, radar=options.radar(args), charted=charted):
        if newest.time_utc is None or epoch.time_utc is None or epoch.time_utc > newest.time_utc:
            break
        kept.append(outlined(as_asked(epoch, args), outlines))
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

    outputs.write_outputs(paths, {suffix: partial(render, answer, suffix) for suffix in outputs.OUT_SUFFIXES})
