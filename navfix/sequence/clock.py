"""The radar's clock against AIS: what an offset does to an observation, and an epoch without it.

A radar whose clock is ahead by tau stamps an echo tau late: its ship was v tau behind the mark that was carried to the
stamp. Ships in one direction at one speed only move the fix; the position takes that.
"""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import timedelta

from navfix.catalog import RadarErrorsModel, radar_errors_model
from navfix.geodesy import direct
from navfix.types import AdjustedObservation, Epoch, GnssReport, Mark

STILL_MPS = 0.5


def with_offset(epoch: Epoch, offset_s: float, model: RadarErrorsModel | str = "default") -> Epoch:
    """Return an epoch whose marks stand where they were when its echoes were really seen: ``offset_s`` earlier.

    Its time is the earlier one. The GNSS position stays and is less sure by what own ship makes in the offset.
    """
    if offset_s == 0.0:
        return epoch
    time_utc = None if epoch.time_utc is None else epoch.time_utc - timedelta(seconds=offset_s)
    unknown_mps = radar_errors_model(model).own_speed_mps
    own_mps = unknown_mps if epoch.speed_hint is None else abs(epoch.speed_hint.speed_mps)
    gnss = None if epoch.gnss is None else _less_sure(epoch.gnss, own_mps * offset_s)
    return replace(epoch, marks=tuple(_earlier(m, offset_s) for m in epoch.marks), time_utc=time_utc, gnss=gnss)


def column(o: AdjustedObservation, mark: Mark, range_m: float, azimuth_rad: float) -> float:
    """Return d observation / d offset: the mark moves back along its course."""
    if mark.speed_mps is None or mark.course_deg is None or mark.speed_mps <= STILL_MPS:
        return 0.0
    angle = math.radians(mark.course_deg) - azimuth_rad
    if o.kind == "range":
        return -mark.speed_mps * math.cos(angle)
    return -mark.speed_mps * math.sin(angle) / range_m


def _earlier(mark: Mark, offset_s: float) -> Mark:
    if mark.speed_mps is None or mark.course_deg is None or mark.speed_mps <= STILL_MPS:
        return mark
    return replace(mark, position=direct(mark.position, mark.course_deg + 180.0, mark.speed_mps * offset_s))


def _less_sure(report: GnssReport, way_m: float) -> GnssReport:
    return replace(report, sigma_m=math.hypot(report.sigma_m, way_m))
