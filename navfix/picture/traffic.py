"""The AIS picture: latest reports and static data of every station, and the marks that they give at an instant."""

from __future__ import annotations

import math
from collections import Counter, deque
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from navfix.catalog import AisModel, ais_model
from navfix.geodesy import direct
from navfix.nmea.records import AisPosition, AisStatic
from navfix.picture.hull import hull_shift, size_of
from navfix.picture.motion import DEFAULT, Carried, History, Point, carry, history
from navfix.picture.motion.growth import still_sigma_m
from navfix.picture.motion.history import SAME_REPORT_S
from navfix.picture.selection import why_never_a_mark
from navfix.picture.time_base import AisClock
from navfix.types import Hull, Mark, Position

STILL_STATUS = (1, 5, 6)  # at anchor, moored, aground
STEERING_MPS = 1.5  # above this the course over ground stands in for a heading that is not sent
WORST_SIGMA_M = 250.0  # a mark less certain than this says nothing
NEWEST_AHEAD_S = 5.0
HISTORY_REPORTS = 16
HISTORY_S = 600.0
REPEATED_MPS = 1.0  # faster than this no ship reports the same place twice: the report was relayed


@dataclass(frozen=True, slots=True)
class Station:
    """The newest position report of one MMSI, when it held, and the static data received so far."""

    report: AisPosition
    position_time_s: float
    hull: Hull | None = None
    ship_type: int | None = None
    name: str | None = None


class Traffic:
    """The AIS picture over time: feed it records, ask it for the marks of an instant.

    Parameters
    ----------
    motion : the motion model that carries moving ships (`navfix.picture.motion.MODELS`)
    """

    def __init__(self, *, motion: str = DEFAULT) -> None:
        self._motion = motion
        self._clock = AisClock()
        self._points: dict[int, deque[Point]] = {}
        self._histories: dict[int, History] = {}
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
            self._take(record, self._clock.position_time(record.mmsi, record.time_s, record.utc_second))

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

    def history(self, mmsi: int) -> History | None:
        """Return what a station has reported lately, None when nothing is kept of it."""
        if mmsi not in self._histories and self._points.get(mmsi):
            self._histories[mmsi] = history(self._points[mmsi])
        return self._histories.get(mmsi)

    @property
    def clock_offset_s(self) -> float:
        """Clock of the log minus UTC [s] as the seconds of the AIS reports tell it; 0 where they agree."""
        return self._clock.offset_s

    def own_gnss(self) -> AisPosition | None:
        """Return the newest AIS report of own ship: GNSS under another name, only ever compared with a fix."""
        reports = [self._stations[m].report for m in self._own_mmsi if m in self._stations]
        return max(reports, key=lambda r: r.time_s or 0.0, default=None)

    def _take(self, record: AisPosition, position_time_s: float) -> None:
        """Keep a report: in the history by its time, whatever the order of arrival; as the newest where it is."""
        point = _point(record, position_time_s)
        if point is not None:
            points = self._points.setdefault(record.mmsi, deque(maxlen=HISTORY_REPORTS))
            if _heard_before(point, points):
                return
            _insert(points, point)
            self._histories.pop(record.mmsi, None)
        previous = self._stations.get(record.mmsi)
        if previous is None or position_time_s >= previous.position_time_s:
            self._stations[record.mmsi] = Station(record, position_time_s)

    def _step(self, mmsi: int, station: Station, at_s: float, model: AisModel) -> Carried:
        """Return the step from the newest report to an instant."""
        age_s = at_s - station.position_time_s
        past = None if is_still(station.report) else self.history(mmsi)
        if past is None:
            return Carried(0.0, 0.0, still_sigma_m(age_s, model))
        if self._clock.scatter_s:
            model = replace(model, clock_sigma_s=math.hypot(model.clock_sigma_s, self._clock.scatter_s))
        return carry(past, at_s, model, name=self._motion)

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
        step = self._step(mmsi, station, at_s, model)
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


def is_still(report: AisPosition) -> bool:
    """Tell whether a station lies still: at anchor, moored or aground and slower than a knot, or an aid."""
    if report.kind == "aton":
        return True
    slow = report.speed_mps is not None and report.speed_mps <= 0.5
    return slow or (report.navigation_status in STILL_STATUS and (report.speed_mps is None or report.speed_mps < 1.5))


def _point(report: AisPosition, position_time_s: float) -> Point | None:
    """Return the point of a ship's report, None where it has no position or is no ship's."""
    lat_deg, lon_deg = report.lat_deg, report.lon_deg
    if lat_deg is None or lon_deg is None or report.kind != "ship":
        return None
    turn = report.turn_rate_deg_per_min
    return Point(position_time_s, lat_deg, lon_deg, report.speed_mps, report.course_deg, turn)


def _insert(points: deque[Point], point: Point) -> None:
    """Put a report at its place in time; what has become too old goes."""
    later: list[Point] = []
    while points and points[-1].time_s > point.time_s:
        later.append(points.pop())
    points.append(point)
    points.extend(reversed(later))
    while points[-1].time_s - points[0].time_s > HISTORY_S:
        points.popleft()


def _heard_before(point: Point, points: deque[Point]) -> bool:
    """Tell whether a report was heard before: of the same time, or a moving ship's at the same place to the digit."""
    moves = (point.speed_mps or 0.0) > REPEATED_MPS
    return any(
        abs(known.time_s - point.time_s) < SAME_REPORT_S
        or (moves and (known.lat_deg, known.lon_deg) == (point.lat_deg, point.lon_deg))
        for known in points
    )


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
