"""Own motion within a turn of the antenna: targets seen at different times are brought to the instant of the scan."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from navfix.nmea.records import OwnHeading, OwnTurnRate, TargetReport
from navfix.picture.scans import Scan, report_time
from navfix.types import FloatArray, HeadingHint, SpeedHint
from navfix.units import wrap_360

SAME_INSTANT_S = 0.02
HEADING_SPAN_S, HEADING_AGE_S = 6.0, 3.0
TRACK_SPAN_S = 30.0
LEAST_RANGES, LEAST_TARGETS = 4, 3
TURN_SPAN_S = 12.0
SURE = 3.0  # a common change of bearing counts from so many of its sigmas on
FASTEST_TURN_DEG_S = 6.0
LARGEST_JUMP_M = 800.0

Key = tuple[str, int]
Seen = tuple[float, float, float]  # time s, range m, bearing deg


@dataclass(frozen=True, slots=True)
class OwnMotion:
    """Rate of turn [deg/s], speed along the bow [m/s] and heading [deg] while a scan was made, None where not known."""

    turn_rate_deg_s: float | None = None
    speed_mps: float | None = None
    heading_deg: float | None = None


class TurnMotion:
    """Remembers headings and target tracks; brings the targets of a scan to its instant."""

    def __init__(self) -> None:
        self._headings: deque[tuple[float, float]] = deque(maxlen=200)
        self._reference: str | None = None
        self._turn_rate: tuple[float, float] | None = None
        self._tracks: dict[Key, deque[Seen]] = {}

    def heading(self, record: OwnHeading) -> None:
        """Take a heading of the gyro or the magnetic compass; only its change counts."""
        if record.time_s is None or not record.valid:
            return
        if record.reference != self._reference:
            self._headings.clear()
            self._reference = record.reference
        self._headings.append((record.time_s, record.heading_deg))

    def turn_rate(self, record: OwnTurnRate) -> None:
        """Take a rate of turn."""
        if record.time_s is not None:
            self._turn_rate = record.time_s, record.turn_rate_deg_per_min / 60.0

    def note(self, scan: Scan) -> None:
        """Remember a scan; a number that jumps or was silent is another target."""
        alive: dict[Key, deque[Seen]] = {}
        for report in scan.reports:
            key, seen = (report.talker, report.number), _seen(report)
            track = self._tracks.get(key)
            if track is None or not _continues(track[-1], seen):
                track = deque(maxlen=40)
            track.append(seen)
            while track[-1][0] - track[0][0] > TRACK_SPAN_S:
                track.popleft()
            alive[key] = track
        for key, track in self._tracks.items():
            if key not in alive and scan.time_s - track[-1][0] <= TRACK_SPAN_S:
                alive[key] = track
        self._tracks = alive

    def aligned(self, scan: Scan, speed: SpeedHint | None, heading: HeadingHint | None) -> tuple[TargetReport, ...]:
        """Return the reports of a scan as they would be had all been seen at its instant.

        The bow turns by gyro or rate-of-turn indicator, else by the change of bearing that all targets share. Own ship
        runs by the log, with the target's own speed where the radar tells it; else each range goes on as it went.
        """
        if all(abs(scan.time_s - _time(report)) < SAME_INSTANT_S for report in scan.reports):
            return scan.reports
        own = OwnMotion(
            self._rate_at(scan.time_s),
            None if speed is None else speed.speed_mps,
            None if heading is None else heading.heading_deg,
        )
        return tuple(self._aligned(report, scan.time_s, own) for report in scan.reports)

    def _rate_at(self, at_s: float) -> float | None:
        """Return the rate of turn [deg/s] about an instant."""
        near = [(t, h) for t, h in self._headings if abs(at_s - t) <= HEADING_SPAN_S]
        if len(near) >= 2 and near[-1][0] - near[0][0] >= 0.5 and abs(at_s - near[-1][0]) <= HEADING_AGE_S:
            times, headings = np.array(near).T
            return _slope(times, np.degrees(np.unwrap(np.radians(headings))))
        if self._turn_rate is not None and abs(at_s - self._turn_rate[0]) <= HEADING_AGE_S:
            return self._turn_rate[1]
        return self._common_rate(at_s)

    def _common_rate(self, at_s: float) -> float | None:
        """Return what the bearings of all targets say, None where they do not agree on a turn."""
        rates = []
        for track in self._tracks.values():
            recent = [seen for seen in track if at_s - seen[0] <= TURN_SPAN_S]
            if len(recent) >= 3 and at_s - recent[-1][0] <= 0.5 * TURN_SPAN_S:
                times, _, bearings = np.array(recent).T
                rates.append(-_slope(times, np.degrees(np.unwrap(np.radians(bearings)))))
        if len(rates) < LEAST_TARGETS:
            return None
        rate = median(rates)
        sigma = 1.4826 * median(abs(r - rate) for r in rates) * math.sqrt(0.5 * math.pi / len(rates))
        return rate if SURE * sigma < abs(rate) < FASTEST_TURN_DEG_S else None

    def _aligned(self, report: TargetReport, at_s: float, own: OwnMotion) -> TargetReport:
        late_s = at_s - _time(report)
        if abs(late_s) < SAME_INSTANT_S:
            return report
        range_mps, bearing_deg_s = self._rates(report, own)
        if report.bearing_reference == "relative" and own.turn_rate_deg_s is not None:
            bearing_deg_s -= own.turn_rate_deg_s
        return replace(
            report,
            range_m=max(report.range_m + range_mps * late_s, 1.0),
            bearing_deg=wrap_360(report.bearing_deg + bearing_deg_s * late_s),
            time_s=at_s,
            utc_of_day_s=None,
        )

    def _rates(self, report: TargetReport, own: OwnMotion) -> tuple[float, float]:
        """Return how range [m/s] and bearing [deg/s] change by the motion of both, the turning of the bow left out."""
        if own.speed_mps is None or (report.bearing_reference == "true" and own.heading_deg is None):
            return self._range_rate(report), 0.0
        off_bow = math.radians(report.bearing_deg - (own.heading_deg or 0.0) * (report.bearing_reference == "true"))
        along, across = -own.speed_mps * math.cos(off_bow), own.speed_mps * math.sin(off_bow)
        if report.speed_mps is not None and report.course_deg is not None and report.course_reference == "true":
            true_deg = report.bearing_deg + (own.heading_deg or 0.0) * (report.bearing_reference == "relative")
            if report.bearing_reference == "true" or own.heading_deg is not None:
                angle = math.radians(report.course_deg - true_deg)
                along += report.speed_mps * math.cos(angle)
                across += report.speed_mps * math.sin(angle)
        return along, math.degrees(across / report.range_m)

    def _range_rate(self, report: TargetReport) -> float:
        track = self._tracks.get((report.talker, report.number))
        if track is None or len(track) < LEAST_RANGES:
            return 0.0
        times, ranges, _ = np.array(track).T
        return _slope(times, ranges)


def _time(report: TargetReport) -> float:
    time_s = report_time(report)
    return math.nan if time_s is None else time_s


def _seen(report: TargetReport) -> Seen:
    return _time(report), report.range_m, report.bearing_deg


def _continues(before: Seen, seen: Seen) -> bool:
    """Tell whether a report goes on with a track: no long silence, no jump."""
    return 0.0 < seen[0] - before[0] <= TRACK_SPAN_S and abs(seen[1] - before[1]) < LARGEST_JUMP_M


def _slope(times: FloatArray, values: FloatArray) -> float:
    t = times - times.mean()
    spread = float(t @ t)
    return float(t @ (values - values.mean())) / spread if spread > 0.0 else 0.0
