"""Tracks of ships for the benchmark of motion models: real AIS logs where they are, simulated manoeuvres always."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from navfix.geodesy import direct
from navfix.nmea import read_log
from navfix.nmea.records import AisPosition
from navfix.picture.motion import Point
from navfix.picture.time_base import AisClock
from navfix.picture.traffic import is_still
from navfix.types import Position
from navfix.units import KNOT_MPS

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
LOGS = (
    "ais_logs/PacCupStart.txt",
    "ais_logs/gofree-merrimac.log",
    "ais_logs/hakan.txt",
    "ais_logs/stupan.se-10112-tcp.log",
    "marce/marce_01_001.nmea",
    "marce/marce_01_004.nmea",
    "marce/marce_01_010.nmea",
)
TABLE = "ais_logs/SolentAIS_20160112_130211.csv"
CLASS_B_GAP_S = 27.0  # class B reports every 30 s under way: tells the class where a table does not


@dataclass(frozen=True)
class Track:
    """The reports of one station in one log, by the time at which they held; ``moves`` as the picture decides.

    ``station`` tells the tracks of one log apart; ``scatter_s`` is the sigma of these times where they had to be those
    of the reception.
    """

    log: str
    ais_class: str
    points: tuple[Point, ...]
    moves: tuple[bool, ...]
    scatter_s: float = 0.0
    station: int = 0


def real_tracks() -> list[Track]:
    """Return every ship's track of the shared recordings; none where they are absent."""
    if not SHARED.is_dir():
        return []
    tracks = [track for name in LOGS for track in _of_log(SHARED / name)]
    return [*tracks, *_of_table(SHARED / TABLE)]


def _of_log(path: Path) -> Iterator[Track]:
    clock, stations = AisClock(), {}
    reports = [r for r in read_log(path, report=False).of(AisPosition) if r.time_s is not None]
    for report in reports:  # the clock of the log is learnt first
        clock.position_time(report.mmsi, report.time_s, report.utc_second)
    for report in reports:
        if report.kind == "ship" and report.lat_deg is not None and report.lon_deg is not None:
            time_s = clock.position_time(report.mmsi, report.time_s, report.utc_second)
            motion = report.speed_mps, report.course_deg, report.turn_rate_deg_per_min
            point = Point(time_s, report.lat_deg, report.lon_deg, *motion)
            stations.setdefault(report.mmsi, []).append((point, not is_still(report), report.ais_class or "A"))
    for station, rows in stations.items():
        track = _track(path.name, rows[0][2], [(point, moves) for point, moves, _ in rows])
        yield replace(track, scatter_s=clock.scatter_s, station=station)


def _of_table(path: Path) -> Iterator[Track]:
    stations: dict[str, list[tuple[Point, bool]]] = {}
    with path.open() as lines:
        for row in csv.DictReader(lines):
            time_s = datetime.fromisoformat(row["Time"]).replace(tzinfo=UTC).timestamp()
            knots, course = float(row["SOG_knots"]), float(row["COG_degrees"])
            speed = None if knots >= 102.2 else knots * KNOT_MPS
            place = float(row["Latitude_degrees"]), float(row["Longitude_degrees"])
            point = Point(time_s, *place, speed, None if course >= 360.0 else course)
            stations.setdefault(row["MMSI"], []).append((point, speed is not None and knots > 1.0))
    for station, rows in stations.items():
        gaps = [gap for gap in np.diff(sorted(p.time_s for p, _ in rows)) if gap > 1.0]
        is_b = len(gaps) > 3 and np.percentile(gaps, 15) >= CLASS_B_GAP_S
        yield replace(_track("Solent", "B" if is_b else "A", rows), station=int(station))


def _track(log: str, ais_class: str, rows: Sequence[tuple[Point, bool]]) -> Track:
    kept: list[tuple[Point, bool]] = []
    for point, moves in sorted(rows, key=lambda row: row[0].time_s):
        if not kept or point.time_s - kept[-1][0].time_s >= 0.5:
            kept.append((point, moves))
    return Track(log, ais_class, tuple(p for p, _ in kept), tuple(m for _, m in kept))


def simulated_tracks(count: int, seed: int) -> list[Track]:
    """Return ships that run straight, turn, and change speed in turns, reporting as class A does, GNSS 3 m."""
    rng = np.random.default_rng(seed)
    return [replace(_simulated(rng), station=number) for number in range(count)]


def _simulated(rng: np.random.Generator) -> Track:
    place, speed, course = Position(54.0, 8.0), float(rng.uniform(2.0, 10.0)), float(rng.uniform(0.0, 360.0))
    points, seconds, next_s, rate, gain, until = [], 0, 0.0, 0.0, 0.0, 0
    while seconds < 1800:
        if seconds >= until:
            kind = rng.choice(3, p=[0.6, 0.25, 0.15])
            until = seconds + int(rng.uniform(60.0, 400.0) if kind == 0 else rng.uniform(20.0, 120.0))
            rate = float(rng.uniform(10.0, 60.0) * rng.choice([-1.0, 1.0])) / 60.0 if kind == 1 else 0.0
            gain = float(rng.normal(0.0, 0.04)) if kind == 2 else 0.0
        if seconds >= next_s:
            north, east, along, across = rng.normal(0.0, 1.0, 4)
            shown = direct(place, math.degrees(math.atan2(east, north)), 3.0 * math.hypot(north, east))
            course_noise = math.degrees(0.05 / max(speed, 0.2)) * across
            told = speed + 0.05 * along, (course + course_noise) % 360.0
            points.append(Point(seconds, shown.lat_deg, shown.lon_deg, *told, rate * 60.0))
            next_s = seconds + (10.0 if abs(rate) < 0.1 else 10.0 / 3.0) * float(rng.uniform(0.9, 1.1))
        place = direct(place, course + 0.5 * rate, max(speed + 0.5 * gain, 0.0))
        speed, course, seconds = min(max(speed + gain, 0.5), 14.0), course + rate, seconds + 1
    return Track("simulated", "A", tuple(points), tuple(True for _ in points))
