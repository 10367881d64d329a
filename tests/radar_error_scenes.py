"""Open roads about a ship whose radar has a clock or ranges that are off: simulated logs, and how far the fixes lie."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix import pipeline
from navfix.geodesy import inverse
from navfix.nmea import read_log
from navfix.sequence.radar_errors import RadarErrorsOverTime
from navfix.simulation import scenario
from navfix.simulation.scenario import Recording
from navfix.types import Position, RadarErrors

SCENE = """
title = "Open roads: moving ships all round, most of them tracked, a few aids"
source = "Made up by navfix"
start_utc = 2026-03-01T10:00:00Z
duration_s = {duration_s}
lat_deg = 54.2
lon_deg = 7.6
[own]
speed_mps = 6.0
course_deg = 75.0
[[traffic]]
layout = "uniform"
count = 24
radius_m = 9000.0
inner_radius_m = 800.0
speed_min_mps = 3.0
speed_max_mps = 9.0
[[traffic]]
layout = "uniform"
kind = "aton"
count = 4
radius_m = 8000.0
[radar]
model = "solid_state"
acquired = 0.8
false_per_turn = 0.25
maximum_range_m = 9000.0
clock_offset_s = {clock_s}
range_bias_m = {bias_m}
"""


@dataclass(frozen=True)
class Passage:
    """Errors [m] of the single scans of one log, the oldest first, and what minutes said of the radar at its end."""

    errors_m: tuple[float, ...]
    held: tuple[bool, ...]
    radar: RadarErrors


def recording(seed: int, *, clock_s: float, bias_m: float, duration_s: float) -> Recording:
    text = SCENE.format(clock_s=clock_s, bias_m=bias_m, duration_s=duration_s)
    return scenario.simulate(scenario.from_text(text), seed)


def passage(
    seed: int, *, clock_s: float = 0.0, bias_m: float = 0.0, correct: bool, duration_s: float = 120.0, every: int = 4
) -> Passage:
    """Solve every N-th scan of a log by itself, with the radar's errors estimated from one to the next."""
    made = recording(seed, clock_s=clock_s, bias_m=bias_m, duration_s=duration_s)
    log = read_log(list(made.lines), name="roads", report=False)
    errors = RadarErrorsOverTime(correct=correct, radar="solid_state")
    off_m, held = [], []
    for epoch in list(pipeline.epochs(log, radar="solid_state"))[::every]:
        fix = pipeline.answer(errors.corrected(epoch), radar="solid_state").fix
        errors.feed(fix)
        if fix is None:
            continue
        assert epoch.time_utc is not None
        assert isinstance(fix.position, Position)
        at_s = epoch.time_utc.timestamp() - clock_s  # what the echoes of this scan really belong to
        row = min(made.truth, key=lambda row: abs(row.unix_s - at_s))
        distance_m, azimuth_deg = inverse(Position(row.lat_deg, row.lon_deg), fix.position)
        off = distance_m * np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))])
        off_m.append(distance_m)
        held.append(bool(off @ np.linalg.solve(fix.covariance[:2, :2], off) <= 5.991))
    return Passage(tuple(off_m), tuple(held), errors.estimate())
