"""Radar reports -> scans: one report per target, the latest within one antenna turn, whose length the data tell."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from navfix.nmea.records import TargetReport

FIRST_TURN_S = 3.0  # until two reports of one target have shown the turn
SHORTEST_TURN_S, LONGEST_TURN_S = 0.3, 12.0
DAY_S = 86400.0


@dataclass(frozen=True, slots=True)
class Scan:
    """The targets of one antenna turn; ``time_s`` [POSIX s] is that of its newest report."""

    time_s: float
    turn_s: float
    reports: tuple[TargetReport, ...]


class ScanBuilder:
    """Groups target reports into scans as they come.

    A new scan begins when a target is reported again, or when a turn has passed since the scan began. The same report
    twice, as a log holds it that two listeners wrote, is one.
    """

    def __init__(self) -> None:
        self._current: dict[tuple[str, int], tuple[float, TargetReport]] = {}
        self._previous: dict[tuple[str, int], TargetReport] = {}
        self._last_seen: dict[tuple[str, int], float] = {}
        self._gaps: deque[float] = deque(maxlen=200)

    @property
    def turn_s(self) -> float:
        """The antenna turn: the median time between two reports of one target."""
        return float(np.median(self._gaps)) if len(self._gaps) >= 5 else FIRST_TURN_S

    def feed(self, report: TargetReport) -> Scan | None:
        """Take a report; return the scan that it closes, if it does. A report without any time is passed over."""
        time_s = report_time(report)
        if time_s is None:
            return None
        key = (report.talker, report.number)
        if self._repeats(key, time_s, report):
            return None
        closed = self._close() if self._begins_new(key, time_s) else None
        self._note_gap(key, time_s)
        self._current[key] = (time_s, report)
        return closed

    def cut_off(self) -> Scan | None:
        """Return the scan under way, complete or not: radar has fallen silent."""
        return self._close() if self._current else None

    def flush(self) -> Scan | None:
        """Return the scan under way when it is complete: it holds what the scan before it held."""
        complete = set(self._previous) - self._lost_before() <= set(self._current)
        return self._close() if self._current and complete else None

    def _repeats(self, key: tuple[str, int], time_s: float, report: TargetReport) -> bool:
        """Tell whether a report was taken already: the same content sooner than an antenna comes round again."""
        if key not in self._current:
            return False
        before_s, before = self._current[key]
        alike = replace(report, time_s=before.time_s, source=before.source) == before
        return alike and abs(time_s - before_s) < SHORTEST_TURN_S

    def _begins_new(self, key: tuple[str, int], time_s: float) -> bool:
        if not self._current:
            return False
        began_s = min(t for t, _ in self._current.values())
        return key in self._current or abs(time_s - began_s) > 0.9 * max(self.turn_s, 1.0)

    def _note_gap(self, key: tuple[str, int], time_s: float) -> None:
        gap_s = time_s - self._last_seen.get(key, -DAY_S)
        if SHORTEST_TURN_S <= gap_s <= LONGEST_TURN_S:
            self._gaps.append(gap_s)
        self._last_seen[key] = time_s

    def _close(self) -> Scan | None:
        reports = {key: report for key, (_, report) in self._current.items()}
        scan = None
        usable = tuple(r for key, r in reports.items() if not self._is_lost(key, r))
        if usable:
            scan = Scan(max(t for t, _ in self._current.values()), self.turn_s, usable)
        self._previous, self._current = reports, {}
        return scan

    def _is_lost(self, key: tuple[str, int], report: TargetReport) -> bool:
        """Tell whether a report is of a lost target: status L and standing still.

        One radar reports L for every target that lies on an AIS target, so L alone says nothing.
        """
        before = self._previous.get(key)
        moved = before is None or (before.range_m, before.bearing_deg) != (report.range_m, report.bearing_deg)
        return report.status == "L" and not moved

    def _lost_before(self) -> set[tuple[str, int]]:
        return {key for key, report in self._previous.items() if report.status == "L"}


def report_time(report: TargetReport) -> float | None:
    """Return when a target was measured [POSIX s]: the sentence's own UTC where it agrees with the reception."""
    if report.time_s is None or report.utc_of_day_s is None:
        return report.time_s
    late_s = (report.time_s - report.utc_of_day_s + DAY_S / 2.0) % DAY_S - DAY_S / 2.0
    return report.time_s - late_s if -2.0 <= late_s <= 30.0 else report.time_s
