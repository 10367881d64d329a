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
from navfix.cli.errors import NO_FIX, UNREADABLE, CommandError

if TYPE_CHECKING:
    from navfix.catalog import AssociationModel, CpdModel
    from navfix.nmea import Log
    from navfix.nmea.plots import PlotFile
    from navfix.picture.outlines import Outlines
    from navfix.report.answer import Answer
    from navfix.report.truth import TruthTrack
    from navfix.types import Association, Epoch, Mark

_AIS_AGE_S = 720.0  # a ship at anchor is believed to lie there for so long
_logger = logging.getLogger(__name__)


def read(path: str, *, charted: bool = False, targets_wanted: bool = True) -> Log:
    """Read LOG ("-": standard input): radar targets where they are ``targets_wanted``, AIS unless ``charted``.

    Raises
    ------
    InputError : nothing readable
    CommandError : readable, but without radar, or without AIS and chart (no fix can follow)
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
    ais = charted or any(not report.own for report in log.of(AisPosition))
    radar = not targets_wanted or bool(log.of(TargetReport))
    lacking = [word for word, there in (("radar targets (TTM)", radar), ("AIS (VDM)", ais)) if not there]
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


def charted_marks(args: argparse.Namespace) -> tuple[Mark, ...]:
    """Return the marks of every --chart; none without.

    Raises
    ------
    InputError : a chart that cannot be read; CommandError : charts without a single mark
    """
    if not args.chart:
        return ()
    from navfix.chart import marks, read_charts

    chart = read_charts(args.chart)
    found = marks(chart.objects, land=args.chart_land)
    if not found:
        raise CommandError(f"{chart.name}: no mark in it (objects ashore count with --chart-land)", UNREADABLE)
    return found


def read_all(args: argparse.Namespace, *, charted: bool = False) -> Log:
    """Read LOG, and --plots where it is given: the targets tracked from it stand in place of those of the log.

    Raises
    ------
    InputError : nothing readable in one of them
    CommandError : without radar or AIS, or plots of another time than the AIS
    """
    if args.plots is None:
        for name in ("plots_reference", "tracking"):
            if getattr(args, name) is not None:
                raise CommandError(f"--{name.replace('_', '-')} says something about --plots, which is not given")
        return read(args.log, charted=charted)
    from dataclasses import replace

    from navfix.nmea.plots import read_plots
    from navfix.picture.tracking import track_plots, with_tracked_plots

    log = read(args.log, charted=charted, targets_wanted=False)
    found = read_plots(args.plots)
    _require_common_time(log, found, args)
    reports = track_plots(
        found.plots,
        reference=args.plots_reference or found.reference,
        radar=options.radar(args),
        model=args.tracking or "plots",
    )
    if not reports:
        raise CommandError(
            f"{args.plots}: no fix: none of its {len(found.plots)} plots could be followed from turn to turn", NO_FIX
        )
    return replace(log, records=tuple(with_tracked_plots(log.records, reports)))


def _require_common_time(log: Log, found: PlotFile, args: argparse.Namespace) -> None:
    from datetime import UTC, datetime

    from navfix.nmea.records import AisPosition

    ais_s = [report.time_s for report in log.of(AisPosition) if report.time_s is not None]
    first_s, last_s = found.plots[0].time_s, found.plots[-1].time_s
    if not ais_s or (min(ais_s) <= last_s and max(ais_s) >= first_s - _AIS_AGE_S):
        return
    spans = [
        " .. ".join(f"{datetime.fromtimestamp(time_s, UTC):%Y-%m-%dT%H:%M:%SZ}" for time_s in span)
        for span in ((first_s, last_s), (min(ais_s), max(ais_s)))
    ]
    raise CommandError(
        f"{args.plots}: no fix: its plots are of {spans[0]}, the AIS of {args.log} is of {spans[1]}", NO_FIX
    )


def truth_track(args: argparse.Namespace) -> TruthTrack | None:
    """Read --truth where it is given."""
    if args.truth is None:
        return None
    from navfix.report.truth import TruthTrack

    with args.truth.open(encoding="utf-8-sig", newline="") as lines:
        return TruthTrack.parse(lines, source=str(args.truth))


def outlines(args: argparse.Namespace) -> Outlines | None:
    """Read --outlines where it is given."""
    if getattr(args, "outlines", None) is None:
        return None
    from navfix.picture.outlines import read_outlines

    with args.outlines.open(encoding="utf-8-sig", errors="replace") as lines:
        return read_outlines(lines, source=str(args.outlines))


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
    return outlined(as_asked(epoch, args), outlines(args))


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


def solve_window(epochs: Sequence[Epoch], args: argparse.Namespace, track: TruthTrack | None) -> Answer:
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

    newest = one_epoch(log, args, charted)
    kept: deque[Epoch] = deque()
    for epoch in pipeline.epochs(log, radar=options.radar(args), charted=charted):
        if newest.time_utc is None or epoch.time_utc is None or epoch.time_utc > newest.time_utc:
            break
        kept.append(outlined(as_asked(epoch, args), outlines(args)))
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
