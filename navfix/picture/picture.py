"""The picture over time: feed it records, and every complete radar scan gives an epoch."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import replace
from datetime import UTC, datetime

from navfix.catalog import RadarModel, radar_model
from navfix.geodesy import direct
from navfix.nmea.records import (
    AisPosition,
    AisStatic,
    OwnHeading,
    OwnPosition,
    OwnSpeed,
    OwnTurnRate,
    Record,
    TargetReport,
)
from navfix.picture.charted import ChartedMarks
from navfix.picture.choice import choose
from navfix.picture.motion import DEFAULT
from navfix.picture.scans import Scan, ScanBuilder
from navfix.picture.silence import Silence
from navfix.picture.traffic import Traffic
from navfix.picture.turn import TurnMotion
from navfix.types import ChartCheck, Epoch, GnssReport, HeadingHint, Mark, Position, RadarTarget, SpeedHint

GYRO_SIGMA_DEG = 1.5
LOG_SIGMA_MPS, LOG_SIGMA_SHARE = (
    0.1,
    0.02,
)  # IMO MSC.96(72) allows 0.2 kn or 2 % of the speed; taken as 1 sigma, for leeway
HINT_AGE_S = 10.0
GNSS_AGE_S = 15.0
GNSS_SIGMA_M = 10.0
AT_TOLERANCE_S = 0.5  # times on the command line are written with fewer digits than in the log


class Picture:
    """What radar, AIS and own sensors have said so far.

    Parameters
    ----------
    radar : sigma of range [m] and bearing [deg]; the rounding of the sentences is added
    charted : marks from a chart; those in reach join every epoch, and AIS aids are checked with them
    motion : the model that carries moving ships from their reports to the instant (`navfix.picture.motion.MODELS`)
    """

    def __init__(self, *, radar: RadarModel | str = "imo", charted: Iterable[Mark] = (), motion: str = DEFAULT) -> None:
        self._radar = radar_model(radar)
        self._charted = ChartedMarks(charted)
        self._traffic = Traffic(motion=motion)
        self._scans = ScanBuilder()
        self._turn = TurnMotion()
        self._heading: OwnHeading | None = None
        self._speed: OwnSpeed | None = None
        self._gnss: OwnPosition | None = None

    def feed(self, record: Record) -> Scan | None:
        """Take one record; return the radar scan that it completes, if it does."""
        match record:
            case TargetReport():
                return self._noted(self._scans.feed(record))
            case AisPosition() | AisStatic():
                self._traffic.feed(record)
            case OwnHeading() if record.valid and record.time_s is not None:
                self._heading = _better_heading(self._heading, record)
                if self._heading is record:
                    self._turn.heading(record)
            case OwnTurnRate():
                self._turn.turn_rate(record)
            case OwnSpeed() if record.time_s is not None and not record.from_gnss:
                self._speed = _better_speed(self._speed, record)
            case OwnPosition() if record.valid and record.time_s is not None:
                self._gnss = record
            case _:
                pass
        return None

    def cut_off(self) -> Scan | None:
        """Return the scan under way where radar has fallen silent, as far as it came."""
        return self._noted(self._scans.cut_off())

    def flush(self) -> Scan | None:
        """Return the last scan where it is complete: for the end of a log."""
        return self._noted(self._scans.flush())

    def epoch(self, scan: Scan) -> Epoch:
        """Reduce everything to the instant of a scan."""
        began_s = time.perf_counter()
        marks, left_out, chart = self._marks(scan)
        heading, speed = self._heading_hint(scan.time_s), self._speed_hint(scan.time_s)
        epoch = Epoch(
            time_utc=datetime.fromtimestamp(scan.time_s, UTC),
            targets=tuple(radar_target(report, self._radar) for report in self._turn.aligned(scan, speed, heading)),
            marks=marks,
            heading_hint=heading,
            speed_hint=speed,
            gnss=self._gnss_report(scan.time_s),
            left_out=tuple(sorted(left_out.items())),
            chart=chart,
        )
        return replace(epoch, choice=choose(epoch), build_ms=round(1e3 * (time.perf_counter() - began_s), 3))

    def _marks(self, scan: Scan) -> tuple[tuple[Mark, ...], dict[str, int], ChartCheck | None]:
        """Return the marks at the instant of a scan, who was left out, and how AIS and chart agree."""
        marks, left_out = self._traffic.marks(scan.time_s)
        if not self._charted.marks:
            return marks, left_out, None
        reach_m = max((report.range_m for report in scan.reports), default=0.0)
        joined = self._charted.join(marks, self._traffic.aids(scan.time_s), left_out, reach_m)
        return joined.marks, joined.left_out, joined.check

    def _noted(self, scan: Scan | None) -> Scan | None:
        if scan is not None:
            self._turn.note(scan)
        return scan

    def _heading_hint(self, at_s: float) -> HeadingHint | None:
        heading = self._heading
        if heading is None or heading.time_s is None or abs(at_s - heading.time_s) > HINT_AGE_S:
            return None
        if heading.reference == "true":
            return HeadingHint(heading.heading_deg, GYRO_SIGMA_DEG)
        if heading.variation_deg is None:
            return None
        true_deg = heading.heading_deg + (heading.deviation_deg or 0.0) + heading.variation_deg
        return HeadingHint(true_deg % 360.0, 3.0 * GYRO_SIGMA_DEG)

    def _speed_hint(self, at_s: float) -> SpeedHint | None:
        speed = self._speed
        if speed is None or speed.time_s is None or abs(at_s - speed.time_s) > HINT_AGE_S:
            return None
        along_mps = speed.forward_mps if speed.forward_mps is not None else speed.speed_mps
        if along_mps is None:
            return None
        sigma_mps = max(LOG_SIGMA_MPS, LOG_SIGMA_SHARE * abs(along_mps))
        return SpeedHint(along_mps, sigma_mps, speed.reference)

    def _gnss_report(self, at_s: float) -> GnssReport | None:
        """Return own GNSS at an instant, from sentences or else from own AIS: only ever compared with the fix."""
        report: OwnPosition | AisPosition | None = self._gnss or self._traffic.own_gnss()
        if report is None or report.time_s is None or report.lat_deg is None or report.lon_deg is None:
            return None
        age_s = at_s - report.time_s
        if abs(age_s) > GNSS_AGE_S:
            return None
        position = Position(report.lat_deg, report.lon_deg)
        if report.speed_mps is not None and report.course_deg is not None:
            position = direct(position, report.course_deg, report.speed_mps * age_s)
        time_utc = datetime.fromtimestamp(report.time_s, UTC)
        return GnssReport(position, GNSS_SIGMA_M + abs(age_s), time_utc)


def epochs(
    records: Iterable[Record],
    *,
    radar: RadarModel | str = "imo",
    charted: Iterable[Mark] = (),
    at: datetime | None = None,
    last: bool = False,
    every: int = 1,
    motion: str = DEFAULT,
    silent_s: float | None = None,
) -> Iterator[Epoch]:
    """Yield an epoch for each complete radar scan of a log.

    Parameters
    ----------
    records : in the order of reception, such as ``navfix.nmea.read_log(file).records``
    radar : model of the radar, by name or record
    charted : marks from a chart
    at : only the newest scan that is complete at this time
    last : only the newest scan of all
    every : only every n-th scan
    motion : the model that carries moving ships
    silent_s : an epoch without targets so often while radar is silent (default: none)
    """
    picture = Picture(radar=radar, charted=charted, motion=motion)
    if last:
        records = tuple(records)
        newest_of_all = sum(1 for _ in scans(Picture(), records)) - 1  # epochs are made only where they are wanted
        yield from (picture.epoch(s) for count, s in enumerate(scans(picture, records)) if count == newest_of_all)
        return
    newest: Epoch | None = None
    for count, scan in enumerate(scans(picture, records, silent_s=silent_s)):
        if at is None:
            if count % every == 0:
                yield picture.epoch(scan)
        elif scan.time_s > at.timestamp() + AT_TOLERANCE_S:
            break
        elif at.timestamp() - scan.time_s <= scan.turn_s + AT_TOLERANCE_S:
            newest = picture.epoch(scan)
    if newest is not None:
        yield newest


def radar_target(report: TargetReport, radar: RadarModel) -> RadarTarget:
    """Return the target of a report; its sigmas are the radar's with the variance of the rounding added."""
    range_sigma_m = float(radar.sigma_of_range_m(report.range_m))
    ground = report.course_reference == "true"
    return RadarTarget(
        label=f"{report.number:02d}",
        range_m=report.range_m,
        bearing_deg=report.bearing_deg,
        bearing_reference=report.bearing_reference,
        time_utc=None if report.time_s is None else datetime.fromtimestamp(report.time_s, UTC),
        speed_mps=report.speed_mps if ground else None,
        course_deg=report.course_deg if ground else None,
        range_sigma_m=math.hypot(range_sigma_m, report.range_resolution_m / math.sqrt(12.0)),
        bearing_sigma_deg=math.hypot(radar.bearing_sigma_deg, report.bearing_resolution_deg / math.sqrt(12.0)),
        status=report.status,
    )


def scans(picture: Picture, records: Iterable[Record], *, silent_s: float | None = None) -> Iterator[Scan]:
    """Feed records to a picture and yield each radar scan as it is complete, empty ones while radar is silent."""
    silence = None if silent_s is None else Silence(silent_s)
    for record in records:
        if silence is not None and silence.falls(record):
            yield from silence.scans(picture.cut_off(), record)
        scan = picture.feed(record)
        if scan is not None and (silence is None or silence.takes(scan)):
            yield scan
    final = picture.flush()
    if final is not None and (silence is None or silence.takes(final)):
        yield final


def _better_speed(known: OwnSpeed | None, new: OwnSpeed) -> OwnSpeed:
    """Prefer a speed over ground (bottom track) over one through the water while it is fresh."""
    if known is None or new.reference == "ground" or known.reference == "water":
        return new
    stale = new.time_s is not None and known.time_s is not None and new.time_s - known.time_s > HINT_AGE_S
    return new if stale else known


def _better_heading(known: OwnHeading | None, new: OwnHeading) -> OwnHeading:
    """Prefer a true heading over a magnetic one while it is fresh."""
    if known is None or new.reference == "true" or known.reference == "magnetic":
        return new
    stale = new.time_s is not None and known.time_s is not None and new.time_s - known.time_s > HINT_AGE_S
    return new if stale else known
