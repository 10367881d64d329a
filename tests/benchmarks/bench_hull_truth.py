"""What is left of the error behind hulls: recordings with generated radar, association from truth, noise told apart.

Two tables. Ships of known size and heading: how far their echoes lie off the mark along the line of sight, as the mean
of a ship (what stays: the hull) and about that mean (the radar's noise). Fixes from the true pairs: error by the point
that the mark stands for, beside the error to expect of the radar's noise alone.

Run: python tests/benchmarks/bench_hull_truth.py [EVERY]
"""

from __future__ import annotations

import csv
import math
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix.adjustment import adjust
from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.picture.hull import facing
from navfix.report.truth import TruthTrack
from navfix.types import Association, Epoch, Mark, Position
from tests.benchmarks.bench_hulls import at_antenna

SEMI_REAL = Path(__file__).resolve().parents[3] / "shared" / "data" / "semi_real"
RECORDINGS = (("dense_sf", 10), ("coastal_hakefjord", 5), ("moored_harlingen_atons", 1))
POINTS = ("antenna", "centre", "visible side")
Pairs = list[tuple[int, int]]


@dataclass(frozen=True)
class Scan:
    """One scan with its true pairs, by the point that each mark stands for."""

    pairs: Pairs
    own: Position
    by_point: dict[str, Epoch]


def sized(mark: Mark) -> bool:
    """Tell whether a mark is an aid, or a ship of known size and heading."""
    return mark.kind != "ship" or (mark.hull is not None and mark.heading_deg is not None)


def scans(name: str, every: int) -> Iterator[Scan]:
    """Yield the scans of a recording with the pairs that its association file tells."""
    with (SEMI_REAL / f"{name}_truth.csv").open() as lines:
        track = TruthTrack.parse(lines)
    told: dict[int, dict[float, str]] = defaultdict(dict)
    with (SEMI_REAL / f"{name}_assoc.csv").open() as lines:
        for row in csv.DictReader(lines):
            told[int(row["target_no"])][float(row["unix"])] = row["mmsi"]
    for epoch in epochs(read_log(SEMI_REAL / f"{name}.nmea", report=False).records, every=every):
        time_s = epoch.time_utc.timestamp()
        own, pairs = track.at(time_s), list(true_pairs(epoch, told, time_s))
        if own is not None and len(pairs) >= 3:
            seen = facing(epoch, own.position, np.array(pairs))
            yield Scan(pairs, own.position, dict(zip(POINTS, (at_antenna(epoch), epoch, seen), strict=True)))


def true_pairs(epoch: Epoch, told: dict[int, dict[float, str]], time_s: float) -> Iterator[tuple[int, int]]:
    """Yield (target, mark) of the targets whose number is told within a turn of now."""
    marks = {mark.label: index for index, mark in enumerate(epoch.marks)}
    for index, target in enumerate(epoch.targets):
        at = told.get(int("".join(c for c in target.label if c.isdigit()) or -1), {})
        nearest = min(at, key=lambda t: abs(t - time_s), default=None)
        if nearest is not None and abs(nearest - time_s) < 4.0 and at[nearest] in marks:
            yield index, marks[at[nearest]]


def echoes_off(seen: list[Scan]) -> tuple[str, ...]:
    """Return, for ships of known size: their number, rms of their means by point, rms about the means [m]."""
    off_m: dict[str, list[list[float]]] = defaultdict(list)
    for scan in seen:
        for target, index in scan.pairs:
            mark = scan.by_point["centre"].marks[index]
            if mark.kind == "ship" and sized(mark):
                measured = scan.by_point["centre"].targets[target].range_m
                places = [scan.by_point[point].marks[index].position for point in POINTS]
                off_m[mark.label].append([measured - inverse(scan.own, place)[0] for place in places])
    ships = [np.array(rows) for rows in off_m.values() if len(rows) >= 3]
    if len(ships) < 3:
        return (str(len(ships)), "-", "-", "-", "-")
    weight = np.array([len(rows) for rows in ships]) / sum(len(rows) for rows in ships)
    means = np.sqrt(weight @ np.array([rows.mean(axis=0) ** 2 for rows in ships]))
    about = math.sqrt(float(weight @ np.array([rows[:, 2].var() for rows in ships])))
    return (str(len(ships)), *(f"{m:.0f}" for m in means), f"{about:.0f}")


def fix_errors(seen: list[Scan], *, only_sized: bool) -> tuple[str, ...] | None:
    """Return the number of fixes, the median error [m] to expect of noise alone, and that by point."""
    noise_m, error_m = [], {point: [] for point in POINTS}
    random = np.random.default_rng(1)
    for scan in seen:
        whole = scan.by_point["centre"]
        pairs = [p for p in scan.pairs if not only_sized or sized(whole.marks[p[1]])]
        if len(pairs) < 3:
            continue
        exact = tuple(replace(mark, sigma_m=0.1, hull_sigma_m=0.0) for mark in whole.marks)
        try:
            fixes = [adjust(scan.by_point[point], Association.from_pairs(whole, pairs)) for point in POINTS]
            radar = adjust(replace(whole, marks=exact), Association.from_pairs(whole, pairs), kernel="none")
        except NoFix:
            continue
        drawn = random.multivariate_normal(np.zeros(2), radar.cofactor_matrix[:2, :2], 200)
        noise_m += np.hypot(*drawn.T).tolist()
        for point, fix in zip(POINTS, fixes, strict=True):
            error_m[point].append(inverse(fix.position, scan.own)[0])
    count = len(error_m["centre"])
    if count < 10:
        return None
    medians = [float(np.median(error_m[point])) for point in POINTS]
    change = 100.0 * (medians[2] / medians[0] - 1.0)
    return (str(count), f"{np.median(noise_m):.1f}", *(f"{m:.1f}" for m in medians), f"{change:+.0f}")


def main() -> None:
    """Print both tables in Markdown."""
    if not SEMI_REAL.is_dir():
        print("shared data absent")
        return
    more = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    seen = {name: list(scans(name, every * more)) for name, every in RECORDINGS}
    print("| recording | ships | antenna m | centre m | visible side m | about the mean m |\n" + "|---" * 6 + "|")
    for name, made in seen.items():
        print(f"| {name} | {' | '.join(echoes_off(made))} |")
    print("\n| recording | marks | fixes | noise alone m | antenna m | centre m | visible side m | change % |")
    print("|---" * 8 + "|")
    for name, made in seen.items():
        for which, only_sized in (("all", False), ("size known", True)):
            row = fix_errors(made, only_sized=only_sized)
            if row is not None:
                print(f"| {name} | {which} | {' | '.join(row)} |")


if __name__ == "__main__":
    main()
