"""The files that the commands read: log, plots, charts, outlines, truth; what no fix can follow from is refused."""

from __future__ import annotations

import argparse
import logging
import sys
from typing import TYPE_CHECKING

from navfix.cli import options, values
from navfix.cli.errors import NO_FIX, UNREADABLE, CommandError

if TYPE_CHECKING:
    from navfix.nmea import Log
    from navfix.nmea.plots import PlotFile
    from navfix.picture.outlines import Outlines
    from navfix.report.truth import TruthTrack
    from navfix.types import Mark

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
        if path == values.STDIN
        else read_log(path, report=False)
    )
    path = log.name if path == values.STDIN else path
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
