"""Raw plots -> target reports: a plain tracker for radars that show echoes and keep no tracks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from navfix.catalog import RadarModel, TrackingModel, radar_model
from navfix.nmea.plots import RadarPlot
from navfix.nmea.records import Record, TargetReport
from navfix.picture.scans import report_time
from navfix.picture.tracking.tracker import PlotTracker
from navfix.picture.tracking.turns import turn_length_s, turns
from navfix.types import BearingReference

__all__ = ["PlotTracker", "track_plots", "turn_length_s", "turns", "with_tracked_plots"]


def track_plots(
    plots: Sequence[RadarPlot],
    *,
    reference: BearingReference = "relative",
    radar: RadarModel | str = "imo",
    model: TrackingModel | str = "plots",
) -> tuple[TargetReport, ...]:
    """Return the reports of the confirmed targets of a recording, in the order of time.

    Range and bearing are filtered; numbers count from 1 and are never used twice. The length of the antenna turn is
    taken from the plots, from the radar model where they do not tell it.
    """
    ordered = sorted(plots, key=lambda plot: plot.time_s)
    turn_s = turn_length_s(ordered, radar_model(radar).turn_s)
    tracker = PlotTracker(turn_s, reference=reference, radar=radar, model=model)
    return tuple(report for turn in turns(ordered, turn_s) for report in tracker.feed(turn))


def with_tracked_plots(records: Iterable[Record], reports: Iterable[TargetReport]) -> Iterator[Record]:
    """Yield the records of a log with ``reports`` in the place of its own targets, each when it was seen.

    The targets of the log are left out: two radars in one picture would count every echo twice.
    """
    waiting = iter(sorted(reports, key=lambda report: report_time(report) or 0.0))
    upcoming = next(waiting, None)
    for record in records:
        if isinstance(record, TargetReport):
            continue
        while upcoming is not None and record.time_s is not None and (report_time(upcoming) or 0.0) <= record.time_s:
            yield upcoming
            upcoming = next(waiting, None)
        yield record
    if upcoming is not None:
        yield upcoming
        yield from waiting
