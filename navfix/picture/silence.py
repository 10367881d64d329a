"""Radar that falls silent: empty scans in its place, so that own ship goes on by her other sensors."""

from __future__ import annotations

import math
from collections.abc import Iterator

from navfix.nmea.records import Record, TargetReport
from navfix.picture.scans import LONGEST_TURN_S, Scan

_LATE_S = 30.0  # a report may tell a measurement that is so old: none of them goes back behind an empty scan


class Silence:
    """Tells when radar has been silent for longer than any antenna turns.

    Parameters
    ----------
    every_s : time between empty scans [s]
    """

    def __init__(self, every_s: float) -> None:
        self._every_s = every_s
        self._report_s = -math.inf
        self._empty_s = -math.inf

    def falls(self, record: Record) -> bool:
        """Tell whether an empty scan is due at a record: radar was heard before it and is silent now."""
        time_s = record.time_s
        if time_s is None:
            return False
        if isinstance(record, TargetReport):
            self._report_s = time_s
            return False
        silent = time_s - self._report_s > LONGEST_TURN_S and self._report_s > -math.inf
        return silent and time_s - self._empty_s >= self._every_s

    def scans(self, cut_off: Scan | None, record: Record) -> Iterator[Scan]:
        """Yield what radar had begun before it fell silent, or an empty scan at the time of a record."""
        if cut_off is not None:
            if self.takes(cut_off):
                yield cut_off
            return
        assert record.time_s is not None
        self._empty_s = record.time_s
        yield Scan(record.time_s, self._every_s, ())

    def takes(self, scan: Scan) -> bool:
        """Tell whether a scan with echoes may follow: not one that is just older than the newest empty one."""
        if 0.0 <= self._empty_s - scan.time_s <= _LATE_S:
            return False
        self._empty_s = min(self._empty_s, scan.time_s)  # a clock that was set back begins anew
        return True
