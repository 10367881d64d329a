"""Offset of the radar's clock against AIS, from moving ships over minutes."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import timedelta

from navfix.geodesy import direct
from navfix.sequence.common_error import CommonError, CommonErrors
from navfix.types import AdjustedObservation, Epoch, Fix, Mark

SPAN_S = 600.0
LEAST_SHIPS = 4
LEAST_SEPARABLE = 0.05
STILL_MPS = 0.5
LARGEST_S = 30.0


class ClockOffset:
    """Estimates radar clock minus AIS clock [s] from the fixes that are fed.

    A radar whose clock is ahead by tau stamps an echo tau late: its ship was v tau behind the mark that was carried to
    the stamp. Ships in one direction at one speed only move the fix; the position takes that.
    """

    def __init__(self, *, span_s: float = SPAN_S) -> None:
        self._errors = CommonErrors(_column, span_s=span_s, least_marks=LEAST_SHIPS, least_separable=LEAST_SEPARABLE)

    def feed(self, fix: Fix, *, applied_s: float = 0.0) -> None:
        """Take a fix, whose marks `with_offset` has set back by ``applied_s``."""
        self._errors.feed(fix, applied=applied_s)

    def estimate(self) -> CommonError | None:
        """Return the offset [s], None before any fix."""
        return self._errors.estimate()

    @property
    def offset_s(self) -> float:
        """The offset to apply [s]: 0 unless it is significant and possible."""
        found = self.estimate()
        return found.value if found is not None and found.significant and abs(found.value) <= LARGEST_S else 0.0


def with_offset(epoch: Epoch, offset_s: float) -> Epoch:
    """Return an epoch whose marks stand where they were when its echoes were really seen: ``offset_s`` earlier."""
    if offset_s == 0.0:
        return epoch
    time_utc = None if epoch.time_utc is None else epoch.time_utc - timedelta(seconds=offset_s)
    return replace(epoch, marks=tuple(_earlier(mark, offset_s) for mark in epoch.marks), time_utc=time_utc)


def _earlier(mark: Mark, offset_s: float) -> Mark:
    if mark.speed_mps is None or mark.course_deg is None or mark.speed_mps <= STILL_MPS:
        return mark
    way_m = mark.speed_mps * offset_s
    return replace(mark, position=direct(mark.position, mark.course_deg + 180.0, way_m))


def _column(o: AdjustedObservation, mark: Mark, range_m: float, azimuth_rad: float) -> float:
    """Return d observation / d offset: the mark moves back along its course."""
    if mark.speed_mps is None or mark.course_deg is None or mark.speed_mps <= STILL_MPS:
        return 0.0
    angle = math.radians(mark.course_deg) - azimuth_rad
    if o.kind == "range":
        return -mark.speed_mps * math.cos(angle)
    return -mark.speed_mps * math.sin(angle) / range_m
