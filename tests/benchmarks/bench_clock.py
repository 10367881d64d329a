"""The radar clock of the real recordings: association from truth, then blind; is there an offset, and does it help?

Association from truth: each target turned out with the true pose and the bearing bias of the recording, the nearest AIS
mark within the gate. Ships that lie still say nothing of clocks, so they are counted apart.

Run: python tests/benchmarks/bench_clock.py
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix import pipeline
from navfix.adjustment import adjust
from navfix.catalog import radar_errors_model
from navfix.errors import NoFix
from navfix.geodesy import LocalPlane, inverse
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.sequence.clock import with_offset
from navfix.sequence.radar_errors import RadarErrorsOverTime
from navfix.types import Association, Epoch, Fix, Position

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "marce"
BIAS_DEG = {"marce_01_004": -3.2, "marce_01_010": -3.5}  # of the recording, true pose against AIS
GATE_M, GATE_DEG = 250.0, 4.0
ALL = replace(radar_errors_model(), memory_s=1e6, clock_walk=0.0, range_walk=0.0)  # the whole recording
OFFSETS_S = (-7.0, -3.0, -1.0, 0.0, 1.0, 3.0, 5.0, 7.0, 9.0, 12.0)


def truth(name: str) -> np.ndarray:
    """Return (n, 4): POSIX s, latitude, longitude, heading [deg]."""
    with (SHARED / f"{name}_truth.csv").open() as lines:
        return np.array([[float(r[k]) for k in ("unix", "lat", "lon", "heading_deg")] for r in csv.DictReader(lines)])


def pose_at(rows: np.ndarray, time_s: float) -> tuple[Position, float]:
    """Return own position and heading [deg] at a time."""
    lat, lon = (float(np.interp(time_s, rows[:, 0], rows[:, k])) for k in (1, 2))
    heading = np.degrees(np.unwrap(np.radians(rows[:, 3])))
    return Position(lat, lon), float(np.interp(time_s, rows[:, 0], heading))


def pairs_from_truth(epoch: Epoch, own: Position, zero_mark_deg: float) -> list[tuple[int, int]]:
    """Return (target, mark) pairs: nearest mark in range and bearing, each mark once, the nearest target first."""
    plane = LocalPlane(own)
    found = []
    for i, target in enumerate(epoch.targets):
        for j, mark in enumerate(epoch.marks):
            north, east = plane.to_plane(mark.position)
            range_off = target.range_m - math.hypot(north, east)
            bearing_off = target.bearing_deg + zero_mark_deg - math.degrees(math.atan2(east, north))
            bearing_off = (bearing_off + 180.0) % 360.0 - 180.0
            if abs(range_off) < GATE_M and abs(bearing_off) < GATE_DEG:
                found.append((math.hypot(range_off / GATE_M, bearing_off / GATE_DEG), i, j))
    pairs, used = [], set()
    for _, i, j in sorted(found):
        if i not in {a for a, _ in pairs} and j not in used:
            pairs.append((i, j))
            used.add(j)
    return pairs


def fixed(epoch: Epoch, pairs: Sequence[tuple[int, int]]) -> Fix | None:
    """Return the fix of given pairs, None where there is none."""
    try:
        return adjust(epoch, Association.from_pairs(epoch, pairs)) if len(pairs) >= 3 else None
    except NoFix:
        return None


def shifted(chosen: Sequence[Epoch], rows: np.ndarray, offset_s: float, bias_deg: float) -> Iterator[tuple[Epoch, Fix]]:
    """Yield the fixes with the association from truth when the radar's clock is corrected by an offset."""
    for epoch in chosen:
        moved = with_offset(epoch, offset_s)
        own, heading = pose_at(rows, moved.time_utc.timestamp())
        fix = fixed(moved, pairs_from_truth(moved, own, heading - bias_deg))
        if fix is not None:
            yield moved, fix


def errors_m(found: Sequence[tuple[Epoch, Fix]], rows: np.ndarray) -> np.ndarray:
    """Return how far the fixes are from where own ship was at their (corrected) times."""
    return np.array([inverse(fix.position, pose_at(rows, e.time_utc.timestamp())[0])[0] for e, fix in found])


def study(name: str, every: int) -> None:
    """Print what one recording says."""
    rows, records = truth(name), read_log(SHARED / f"{name}.nmea", report=False).records
    chosen = list(epochs(records, every=every))
    print(f"{name}: {len(chosen)} scans")
    for offset_s in OFFSETS_S:
        found = list(shifted(chosen, rows, offset_s, BIAS_DEG[name]))
        errors = errors_m(found, rows)
        own_time = np.array(
            [inverse(f.position, pose_at(rows, e.time_utc.timestamp() + offset_s)[0])[0] for e, f in found]
        )
        sigma0 = np.median([f.sigma0 for _, f in found])
        print(
            f"  offset {offset_s:+5.1f} s: {len(found)} fixes, error median {np.median(errors):5.1f} / 95 % "
            f"{np.percentile(errors, 95):5.1f} m (own ship at the stamped time: {np.median(own_time):5.1f}), "
            f"sigma0 {sigma0:.2f}"
        )
    told = RadarErrorsOverTime(model=ALL, correct=False)
    for _, fix in shifted(chosen, rows, 0.0, BIAS_DEG[name]):
        told.feed(fix)
    print("  association from truth:", told.estimate())
    blind = RadarErrorsOverTime(model=ALL, correct=False)
    for epoch in chosen:
        answer = pipeline.answer(epoch)
        if answer.fix is not None:
            blind.feed(answer.fix)
    print("  blind:", blind.estimate(), flush=True)


def main() -> None:
    """Print the study of each recording."""
    if not SHARED.is_dir():
        print("shared data absent")
        return
    for name in BIAS_DEG:
        study(name, every=2 if name.endswith("004") else 6)


if __name__ == "__main__":
    main()
