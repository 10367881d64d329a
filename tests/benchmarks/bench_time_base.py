"""How well AIS reports are timed: way between two reports over speed, against the time between them, by both clocks.

Ships above 3 m/s on a steady course, reports 2 to 40 s apart; median and 90 % of the absolute difference in seconds.

Run: python tests/benchmarks/bench_time_base.py
"""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix.geodesy import cloud_to_plane
from navfix.nmea import read_log
from navfix.nmea.records import AisPosition
from navfix.picture.time_base import delay
from navfix.types import Position
from navfix.units import wrap_180
from tests.benchmarks.motion_data import LOGS, SHARED

STEADY_DEG, LEAST_MPS = 3.0, 3.0


def differences(reports: list[AisPosition]) -> list[tuple[float, float]]:
    """Return for neighbouring reports of one ship: way / speed - time between receptions, and between seconds [s]."""
    found = []
    for a, b in pairwise(reports):
        if None in (a.course_deg, b.course_deg, a.utc_second, b.utc_second) or not 2.0 <= b.time_s - a.time_s <= 40.0:
            continue
        speed = 0.5 * ((a.speed_mps or 0.0) + (b.speed_mps or 0.0))
        if (
            min(a.speed_mps or 0.0, b.speed_mps or 0.0) < LEAST_MPS
            or abs(wrap_180(a.course_deg - b.course_deg)) > STEADY_DEG
        ):
            continue
        north, east = cloud_to_plane(Position(a.lat_deg, a.lon_deg), [b.lat_deg], [b.lon_deg])[0]
        course = math.radians(a.course_deg)
        way_s = (north * math.cos(course) + east * math.sin(course)) / speed
        received_s = b.time_s - a.time_s
        told_s = received_s - delay(b.time_s, b.utc_second) + delay(a.time_s, a.utc_second)
        found.append((way_s - received_s, way_s - told_s))
    return found


def main() -> None:
    """Print one line a recording."""
    if not SHARED.is_dir():
        print("shared data absent")
        return
    for name in LOGS:
        ships = defaultdict(list)
        for report in read_log(SHARED / name, report=False).of(AisPosition):
            if report.kind == "ship" and report.time_s is not None and report.lat_deg is not None:
                ships[report.mmsi].append(report)
        off = np.abs([pair for reports in ships.values() for pair in differences(reports)])
        received, told = (np.percentile(off[:, k], [50, 90]) for k in (0, 1))
        print(
            f"{Path(name).name:28} {len(off):5} pairs: by reception {received[0]:.2f} / {received[1]:.2f} s, "
            f"by the second {told[0]:.2f} / {told[1]:.2f} s"
        )


if __name__ == "__main__":
    main()
