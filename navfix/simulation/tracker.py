"""From plots to tracked targets: acquisition, target numbers that are recycled, status Q, T and L, TTM records."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.catalog import RadarModel
from navfix.nmea.records import TargetReport
from navfix.simulation.radar import Plot
from navfix.simulation.settings import RadarSettings
from navfix.simulation.world import World
from navfix.types import FloatArray
from navfix.units import NM_M, wrap_360


@dataclass(frozen=True, slots=True)
class TrackedPlot:
    """A plot with its target number, status (Q acquiring, T tracking, L lost) and the track's age in turns."""

    plot: Plot
    number: int
    status: str
    turns: int


@dataclass(slots=True)
class _Track:
    number: int
    last: Plot
    turns: int = 0
    misses: int = 0


class Tracker:
    """Keeps tracks from turn to turn. An echo seen ``acquire_hits`` turns in a row becomes a target.

    Numbers run from 1 to ``highest_number`` and start again; a lost target's number is free at once.
    """

    def __init__(self, settings: RadarSettings, turn_s: float) -> None:
        self._settings = settings
        self._turn_s = turn_s
        self._tracks: dict[int, _Track] = {}
        self._hits: dict[int, int] = {}
        self._last_number = 0

    def turn(self, plots: list[Plot]) -> list[TrackedPlot]:
        """Take the plots of one turn and return what is reported: seen targets, and once each lost one."""
        reports = [report for plot in plots if (report := self._take(plot)) is not None]
        seen = {plot.key for plot in plots}
        self._hits = {key: hits for key, hits in self._hits.items() if key in seen}
        return reports + self._lose(seen)

    def _take(self, plot: Plot) -> TrackedPlot | None:
        track = self._tracks.get(plot.key)
        if track is None:
            self._hits[plot.key] = self._hits.get(plot.key, 0) + 1
            number = self._free_number()
            if self._hits[plot.key] < self._settings.acquire_hits or number is None:
                return None
            self._last_number = number
            track = self._tracks[plot.key] = _Track(number, plot)
            del self._hits[plot.key]
        track.last, track.misses, track.turns = plot, 0, track.turns + 1
        return TrackedPlot(plot, track.number, "T" if track.turns > self._settings.settle_turns else "Q", track.turns)

    def _lose(self, seen: set[int]) -> list[TrackedPlot]:
        lost = []
        for key in [key for key in self._tracks if key not in seen]:
            track = self._tracks[key]
            track.misses += 1
            if track.misses >= self._settings.lost_turns:
                coasted = replace(track.last, time_s=track.last.time_s + track.misses * self._turn_s)
                lost.append(TrackedPlot(coasted, track.number, "L", track.turns))
                del self._tracks[key]
        return lost

    def _free_number(self) -> int | None:
        if len(self._tracks) >= self._settings.maximum_targets:
            return None
        highest, used = self._settings.highest_number, {track.number for track in self._tracks.values()}
        candidates = ((self._last_number + step) % highest + 1 for step in range(highest))
        return next((number for number in candidates if number not in used), None)


def target_report(
    world: World,
    settings: RadarSettings,
    tracked: TrackedPlot,
    *,
    gyro_bias_deg: float,
    rng: np.random.Generator,
) -> TargetReport:
    """Return the TTM record of a tracked plot, stamped by the radar's clock."""
    plot, own = tracked.plot, world.own.at(tracked.plot.time_s)
    heading_deg = float(world.true_deg(own, own.heading_rad))
    true_bearing = settings.bearing_reference == "true"
    stamp_s = world.start_s + plot.time_s + settings.clock_offset_s
    report = TargetReport(
        time_s=stamp_s,
        number=tracked.number,
        range_m=plot.range_m,
        bearing_deg=wrap_360(plot.relative_deg + heading_deg + gyro_bias_deg) if true_bearing else plot.relative_deg,
        bearing_reference="true" if true_bearing else "relative",
        status=tracked.status,
        utc_of_day_s=stamp_s % 86400.0,
        range_resolution_m=10.0**-settings.range_decimals * NM_M,
        bearing_resolution_deg=10.0**-settings.bearing_decimals,
    )
    velocity = np.array([plot.north_mps, plot.east_mps]) + _velocity_noise(settings, tracked.turns, rng)
    if settings.target_speed == "blank":
        return report
    relative = settings.target_speed == "relative"
    if relative:
        velocity = velocity - np.array([own.north_mps, own.east_mps])
    course_deg = float(world.true_deg(own, np.arctan2(velocity[1], velocity[0])))
    return replace(
        report,
        speed_mps=math.hypot(*velocity),
        course_deg=wrap_360(course_deg - heading_deg) if relative else course_deg,
        course_reference="relative" if relative else "true",
    )


def _velocity_noise(settings: RadarSettings, age_turns: int, rng: np.random.Generator) -> FloatArray:
    """Return the error of a tracked velocity [m/s]: large for a young track, ``speed_sigma_mps`` for a steady one."""
    return rng.normal(0.0, settings.speed_sigma_mps * (1.0 + 8.0 / age_turns), 2)


def follow(
    world: World,
    settings: RadarSettings,
    model: RadarModel,
    plots: list[list[Plot]],
    *,
    gyro_bias_deg: float,
    rng: np.random.Generator,
) -> list[tuple[TargetReport, int]]:
    """Return the TTM records of the recording by time, each with the MMSI of what it is (0: no AIS, or nothing)."""
    tracker = Tracker(settings, model.turn_s)
    reports = []
    for turn in plots:
        for tracked in tracker.turn(turn):
            mmsi = world.bodies[tracked.plot.key].mmsi if tracked.plot.key >= 0 else 0
            report = target_report(world, settings, tracked, gyro_bias_deg=gyro_bias_deg, rng=rng)
            reports.append((report, mmsi))
    return sorted(reports, key=lambda entry: entry[0].time_s or 0.0)
