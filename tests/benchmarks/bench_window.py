"""Windows of scans against single ones: error, coverage and CPU time, with what stays modelled and not.

    python tests/benchmarks/bench_window.py [--runs N]

Passages with 20 targets, a tenth of them wrong, a scan every 3 s, gyro and log in a current of 0.6 m/s; radar 30 m and
1 deg, new in every scan where nothing else is said; AIS antennas 10 m off, for good. The last rows show what happens
when the current, or that errors stay, is left out: the covariance is a lie.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from navfix import catalog
from navfix.adjustment import adjust, graph
from navfix.adjustment.window import adjust_window
from navfix.types import Association, Fix, SpeedHint
from tests.window_scenes import Errors, Passage, passage

ERRORS = Errors(range_m=30.0, bearing_deg=1.0, mark_m=10.0)
REACH_M = (2e3, 15e3)
NO_CURRENT = replace(
    catalog.adjustment_model(), current_sigma_mps=1e-6, largest_component=1.0, smallest_component=0.999
)
ALL_NEW = replace(catalog.adjustment_model(), steady_share=0.0, largest_component=1.0, smallest_component=0.999)


@dataclass(frozen=True)
class Row:
    """One row of the table."""

    name: str
    rms_m: float
    inside: float
    cpu_ms: float

    def __str__(self) -> str:
        return f"| {self.name} | {self.rms_m:.1f} | {100 * self.inside:.0f} % | {self.cpu_ms:.0f} |"


def measured(name: str, solve: Callable[[Passage], Fix], passages: list[Passage]) -> Row:
    """Return rms error, share inside the 95 % ellipse, and CPU time of a way to solve."""
    errors, inside, spent = [], 0, 0.0
    for one in passages:
        began = time.process_time()
        fix = solve(one)
        spent += time.process_time() - began
        error = one.error(fix.position)
        radius_sq = fix.dof * (0.05 ** (-2.0 / fix.dof) - 1.0)
        inside += float(error @ np.linalg.solve(fix.covariance[:2, :2], error)) < radius_sq
        errors.append(float(error @ error))
    n = len(passages)
    return Row(name, float(np.sqrt(np.mean(errors))), inside / n, 1e3 * spent / n)


def single(one: Passage) -> Fix:
    """Solve the newest scan alone."""
    epoch = one.epochs[-1]
    return adjust(epoch, Association.from_pairs(epoch, list(one.pairs.items())))


def windowed(scans: int, **options: object) -> Callable[[Passage], Fix]:
    """Return what solves the last ``scans`` of a passage together."""
    return lambda one: adjust_window(one.epochs[-scans:], one.pairs, **options)  # type: ignore[arg-type]


def marks_as_new(one: Passage) -> Fix:
    """Solve with the offsets of the marks told as noise of each scan: fixed marks, the noise in the radar."""
    epochs = [
        replace(
            e,
            marks=tuple(replace(m, sigma_m=0.01) for m in e.marks),
            targets=tuple(
                replace(t, range_sigma_m=float(np.hypot(t.range_sigma_m or 30.0, ERRORS.mark_m))) for t in e.targets
            ),
        )
        for e in one.epochs
    ]
    return adjust_window(epochs, one.pairs, solver="dense", model=ALL_NEW)


def without_current(one: Passage) -> Fix:
    """Solve with the current held at zero and the log believed."""
    epochs = [replace(e, speed_hint=SpeedHint(e.speed_hint.speed_mps, 0.05)) for e in one.epochs if e.speed_hint]
    return adjust_window(epochs, one.pairs, solver="dense", model=NO_CURRENT, kernel="none")


def _passages(runs: int, *, wrong: int = 2, errors: Errors = ERRORS) -> list[Passage]:
    rngs = (np.random.default_rng(seed) for seed in range(runs))
    return [passage(rng, epochs=60, targets=20, wrong=wrong, errors=errors, reach_m=REACH_M, mates=0.3) for rng in rngs]


def rows(runs: int) -> Iterator[Row]:
    """Yield the table."""
    passages = _passages(runs)
    yield measured("single scan", single, passages)
    for scans in (20, 40, 60):
        road = windowed(scans, solver="dense")
        yield measured(f"window of {3 * scans} s, offsets and current, normal equations", road, passages)
    short = windowed(20, solver="dense")
    yield measured("window of 60 s, no wrong marks", short, _passages(runs, wrong=0))
    stays = _passages(runs, errors=replace(ERRORS, steady=0.5))
    yield measured("window of 60 s, half of the radar's error stays", short, stays)
    few = passages[: max(4, runs // 4)]
    if graph.available():
        for scans in (20, 60):
            yield measured(f"window of {3 * scans} s, the same by GTSAM", windowed(scans, solver="gtsam"), few)
    right = [replace(p, pairs={t: m for t, m in p.pairs.items() if t not in ("t0", "t1")}) for p in passages]
    yield measured("window of 180 s, offsets and what stays taken for new noise", marks_as_new, right)
    yield measured("window of 180 s, current not modelled", without_current, right)
    bare = [
        replace(p, epochs=tuple(replace(e, speed_hint=None, heading_hint=None) for e in p.epochs)) for p in passages
    ]
    yield measured("window of 180 s without gyro and log", windowed(60, solver="dense"), bare)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=60)
    args = parser.parse_args()
    print("| estimator | rms m | 95 % ellipse holds | CPU ms |\n|---|---|---|---|")
    for row in rows(args.runs):
        print(row, flush=True)


if __name__ == "__main__":
    main()
