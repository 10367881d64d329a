"""Radar falls silent in simulated ports: dead reckoning of the navigator in the gap, and its fixes after it.

    python tests/benchmarks/bench_gaps.py --seeds 20        with and without gyro and log

Prints tables in Markdown: the fixes before the gap; error of dead reckoning after 1, 5, 10 min and how often its 95 %
ellipse held own ship; then the wait for the first fix after a gap of 2 min and the errors in the minute from there on.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, field, replace

import numpy as np
import sequence_scenes as scenes

from navfix.association.window.tracks import epoch_time
from navfix.geodesy import inverse
from navfix.report.truth import TruthTrack
from navfix.sequence import Navigator
from navfix.types import Epoch, Fix, FloatArray, Position

SEEN_S = 150.0
AGES_S = (60.0, 300.0, 600.0)
SHORT_S, AFTER_S = 120.0, 60.0
STEP_S = 5.0
INSIDE_SQ = 5.991


@dataclass
class Gap:
    """What the gaps of one kind gave: error [m] and whether the ellipse held it, by age; and after a short gap."""

    error_m: dict[float, list[float]] = field(default_factory=lambda: {age: [] for age in AGES_S})
    held: dict[float, list[bool]] = field(default_factory=lambda: {age: [] for age in AGES_S})
    early: int = 0
    before_m: list[float] = field(default_factory=list)
    before_axis_m: list[float] = field(default_factory=list)
    before_held: list[bool] = field(default_factory=list)
    wait_s: list[float] = field(default_factory=list)
    after_m: list[float] = field(default_factory=list)
    after_held: list[bool] = field(default_factory=list)


def off_m(track: TruthTrack, epoch: Epoch, place: Position) -> FloatArray:
    """Return the error (north, east) [m] of a place."""
    there = track.at(epoch_time(epoch))
    assert there is not None
    distance_m, azimuth_deg = inverse(there.position, place)
    return distance_m * np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))])


def inside(error: FloatArray, fix: Fix) -> bool:
    """Tell whether the 95 % ellipse of a fix holds own ship."""
    radius_sq = INSIDE_SQ if np.isinf(fix.dof) else fix.dof * (0.05 ** (-2.0 / fix.dof) - 1.0)
    return bool(error @ np.linalg.solve(fix.covariance[:2, :2], error) <= radius_sq)


def long_gap(run: scenes.Run, gap: Gap) -> None:
    """Cut all echoes off after a while and see where dead reckoning leads."""
    navigator, last_s, due, fixed = Navigator(), -np.inf, list(AGES_S), False
    assert run.truth is not None
    for epoch in run.epochs():
        seconds = epoch_time(epoch) - run.first_s
        navigator.feed(epoch if seconds <= SEEN_S else replace(epoch, targets=()))
        if seconds - last_s < STEP_S - 0.1:
            continue
        last_s, outcome = seconds, navigator.step()
        reckoned = outcome.dead_reckoning
        gap.early += reckoned is not None and not fixed
        fixed = fixed or outcome.fix is not None
        if outcome.fix is not None and seconds <= SEEN_S:
            error = off_m(run.truth, epoch, outcome.fix.position)
            gap.before_m.append(float(np.hypot(*error)))
            gap.before_axis_m.append(outcome.fix.ellipse(0.95).semi_major_m)
            gap.before_held.append(inside(error, outcome.fix))
        if due and reckoned is not None and reckoned.age_s >= due[0]:
            error = off_m(run.truth, epoch, reckoned.position)
            gap.error_m[due[0]].append(float(np.hypot(*error)))
            gap.held[due[0]].append(bool(error @ np.linalg.solve(reckoned.covariance, error) <= INSIDE_SQ))
            due.pop(0)


def short_gap(run: scenes.Run, gap: Gap) -> None:
    """Cut the echoes off for a time and see how the place is found again."""
    navigator, last_s, first_s = Navigator(), -np.inf, None
    assert run.truth is not None
    for epoch in run.epochs():
        seconds = epoch_time(epoch) - run.first_s - SEEN_S
        navigator.feed(replace(epoch, targets=()) if 0.0 < seconds <= SHORT_S else epoch)
        if seconds - last_s < STEP_S - 0.1:
            continue
        last_s, fix = seconds, navigator.step().fix
        if fix is None or seconds <= SHORT_S:
            continue
        first_s = seconds if first_s is None else first_s
        if seconds - first_s <= AFTER_S:
            error = off_m(run.truth, epoch, fix.position)
            gap.after_m.append(float(np.hypot(*error)))
            gap.after_held.append(inside(error, fix))
    gap.wait_s.append(np.inf if first_s is None else first_s - SHORT_S)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--short", type=int, default=6, help="of these seeds also a gap of 2 min, and what follows")
    parser.add_argument("--share", type=float, default=0.5, help="of echoes that have AIS")
    parser.add_argument("--targets", type=int, default=20)
    args = parser.parse_args()
    found = {}
    for sensors in (True, False):
        gap = found[sensors] = Gap()
        for seed in range(700, 700 + args.seeds):
            port = {"ais_share": args.share, "targets": args.targets, "sensors": sensors}
            print(f"seed {seed}", file=sys.stderr, flush=True)
            long_gap(scenes.port(seed, duration_s=SEEN_S + max(AGES_S) + 30.0, **port), gap)
            if seed < 700 + args.short:
                short_gap(scenes.port(seed, duration_s=SEEN_S + SHORT_S + 120.0, **port), gap)
    print("| gyro and log | fixes before the gap | median m | 95 % m | ellipse, longer axis m | holds % |")
    print("|---|---|---|---|---|---|")
    for sensors, gap in found.items():
        e, axis_m = np.array(gap.before_m), np.median(gap.before_axis_m)
        print(
            f"| {'with' if sensors else 'without'} | {len(e)} | {np.median(e):.1f} | {np.percentile(e, 95):.1f} "
            f"| {axis_m:.0f} | {100 * np.mean(gap.before_held):.0f} |"
        )
    print("\n| gyro and log, after | runs | median m | worst m | 95 % ellipse holds % |\n|---|---|---|---|---|")
    for sensors, gap in found.items():
        word = "with" if sensors else "without"
        for age_s in AGES_S:
            error, held = np.array(gap.error_m[age_s]), gap.held[age_s]
            if len(error):
                print(
                    f"| {word}, {age_s / 60:.0f} min | {len(error)} | {np.median(error):.0f} | {error.max():.0f} "
                    f"| {100 * np.mean(held):.0f} |"
                )
        print(f"\n{word}: dead reckoning before a first fix: {gap.early} steps\n")
    print("| gyro and log | gaps | first fix after s, median / worst | fixes | median m | worst m | ellipse holds % |")
    print("|---|---|---|---|---|---|---|")
    for sensors, gap in found.items():
        e, wait = np.array(gap.after_m or [np.nan]), np.array(gap.wait_s)
        print(
            f"| {'with' if sensors else 'without'} | {len(wait)} | {np.median(wait):.0f} / {wait.max():.0f} | {len(e)} "
            f"| {np.median(e):.0f} | {e.max():.0f} | {100 * np.mean(gap.after_held):.0f} |"
        )


if __name__ == "__main__":
    main()
