"""The AIS picture: newest report and static data of every station, and the marks that they give at an instant."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from navfix.catalog import AisModel, ais_model
from navfix.geodesy import direct
from navfix.nmea.records import AisPosition, AisStatic
from navfix.picture.hull import hull_shift, size_of
from navfix.picture.motion import carry
from navfix.picture.selection import why_never_a_mark
from navfix.types import Hull, Mark, Position

STILL_STATUS = (1, 5, 6)  # at anchor, moored, aground
STEERING_MPS = 1.5  # above this the course over ground stands in for a heading that is not sent
WORST_SIGMA_M = 250.0  # a mark less certain than this says nothing
NEWEST_AHEAD_S = 5.0


@dataclass(frozen=True, slots=True)
class Station:
    """The newest position report of one MMSI, when it held, and the static data received so far."""

    report: AisPosition
    position_time_s: float
    hull: Hull | None = None
    ship_type: int | None = None
    name: str | None = None


class Traffic:
    """The AIS picture over time: feed it records, ask it for the marks of an instant."""

    def __init__(self) -> None:
        self._stations: dict[int, Station] = {}
        self._static: dict[int, AisStatic] = {}
        self._own_mmsi: set[int] = set()

    def feed(self, record: AisPosition | AisStatic) -> None:
        """Take a position or static report; one without any time cannot be placed and is passed over."""
        if record.own:
            self._own_mmsi.add(record.mmsi)
        if isinstance(record, AisStatic):
            self._merge_static(record)
        elif record.time_s is not None:
            previous = self._stations.get(record.mmsi)
            position_time_s = position_time(record.time_s, record.utc_second)
            if previous is None or position_time_s >= previous.position_time_s:
                self._stations[record.mmsi] = Station(record, position_time_s)

    def marks(self, at_s: float) -> tuple[tuple[Mark, ...], dict[str, int]]:
        """Return the marks at an instant [POSIX s] and how many stations were left out for which reason."""
        marks: list[Mark] = []
        left_out: Counter[str] = Counter()
        own = frozenset(self._own_mmsi)
        for mmsi, station in self._stations.items():
            reason = why_never_a_mark(station.report, own)
            mark = None if reason else self._mark(mmsi, station, at_s)
            if mark is None:
                left_out[reason or "stale report"] += 1
            else:
                marks.append(mark)
        return tuple(marks), dict(left_out)

    def aids(self, at_s: float) -> tuple[tuple[AisPosition, str | None], ...]:
        """Return the aids with a fresh position, each with the reason why it is no mark (None where it is one)."""
        oldest_s, own = ais_model("aton").oldest_still_s, frozenset(self._own_mmsi)
        fresh = (
            station.report
            for station in self._stations.values()
            if station.report.kind == "aton" and -NEWEST_AHEAD_S <= at_s - station.position_time_s <= oldest_s
        )
        return tuple((report, why_never_a_mark(report, own)) for report in fresh if report.lat_deg is not None)

    def own_gnss(self) -> AisPosition | None:
        """Return the newest AIS report of own ship: GNSS under another name, only ever compared with a fix."""
        reports = [self._stations[m].report for m in self._own_mmsi if m in self._stations]
        return max(reports, key=lambda r: r.time_s or 0.0, default=None)

    def _merge_static(self, record: AisStatic) -> None:
        """Keep what is known: parts A and B of type 24 bring different fields."""
        known = self._static.get(record.mmsi)
        if known is not None:
            record = replace(
                record,
                hull=record.hull or known.hull,
                ship_type=record.ship_type if record.ship_type is not None else known.ship_type,
                name=record.name or known.name,
            )
        self._static[record.mmsi] = record

    def _mark(self, mmsi: int, station: Station, at_s: float) -> Mark | None:
        """Return the mark of a station at an instant, None when its report is stale or from the future."""
        report, static = station.report, self._static.get(mmsi)
        model = _class_model(report)
        age_s = at_s - station.position_time_s
        still = is_still(report)
        if age_s < -NEWEST_AHEAD_S or age_s > (model.oldest_still_s if still else model.oldest_moving_s):
            return None
        hull = report.hull or (static.hull if static else None)
        heading_deg = _heading(report)
        if report.lat_deg is None or report.lon_deg is None:
            return None
        reported = Position(report.lat_deg, report.lon_deg)
        step = carry(0.0 if still else report.speed_mps, report.course_deg, age_s, model)
        aton, ship_type = report.kind == "aton", _ship_type(report, static)
        size = size_of(hull, aid=aton, ais_class=report.ais_class, ship_type=ship_type)
        shift = hull_shift(size, heading_deg)
        base_m = model.accurate_sigma_m if report.accurate else model.default_sigma_m
        sigma_m = math.sqrt(base_m**2 + step.sigma_m**2 + shift.sigma_m**2)
        if sigma_m > WORST_SIGMA_M:
            return None
        return Mark(
            label=str(mmsi),
            position=_step(reported, step.north_m + shift.north_m, step.east_m + shift.east_m),
            sigma_m=sigma_m,
            kind="aton" if aton else "ship",
            mmsi=mmsi,
            time_utc=datetime.fromtimestamp(station.position_time_s, UTC),
            speed_mps=report.speed_mps,
            course_deg=report.course_deg,
            heading_deg=heading_deg,
            hull=hull,
            name=report.name or (static.name if static else None),
            ais_class=report.ais_class,
            ship_type=ship_type,
            age_s=age_s,
            hull_sigma_m=shift.sigma_m,
        )


def position_time(received_s: float, utc_second: int | None) -> float:
    """Return when a position held [POSIX s]: its own second of the minute, where the reception makes that plausible."""
    if utc_second is None:
        return received_s
    age_s = (received_s - utc_second) % 60.0
    if age_s > 45.0:
        age_s -= 60.0  # the receiver's clock is a little slow
    return received_s - age_s if -5.0 <= age_s <= 15.0 else received_s


def is_still(report: AisPosition) -> bool:
    """Tell whether a station lies still: at anchor, moored or aground and slower than a knot, or an aid."""
    if report.kind == "aton":
        return True
    slow = report.speed_mps is not None and report.speed_mps <= 0.5
    return slow or (report.navigation_status in STILL_STATUS and (report.speed_mps is None or report.speed_mps < 1.5))


def _class_model(report: AisPosition) -> AisModel:
    if report.kind == "aton":
        return ais_model("aton")
    return ais_model("class_b" if report.ais_class == "B" else "class_a")


def _ship_type(report: AisPosition, static: AisStatic | None) -> int | None:
    if report.ship_type is not None:
        return report.ship_type
    return static.ship_type if static else None


def _heading(report: AisPosition) -> float | None:
    if report.heading_deg is not None:
        return report.heading_deg
    steering = report.speed_mps is not None and report.speed_mps > STEERING_MPS
    return report.course_deg if steering else None


def _step(start: Position, north_m: float, east_m: float) -> Position:
    distance_m = math.hypot(north_m, east_m)
    return direct(start, math.degrees(math.atan2(east_m, north_m)), distance_m) if distance_m > 0.01 else start
