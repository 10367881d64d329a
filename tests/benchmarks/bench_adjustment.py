"""RMSE over the Cramer-Rao bound for every kernel and share of wrong matches, and the time a fix takes.

Run: python tests/benchmarks/bench_adjustment.py [runs a cell]
     python tests/benchmarks/bench_adjustment.py timing
"""

from __future__ import annotations

import contextlib
import math
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix import catalog
from navfix.adjustment import adjust, graph
from navfix.adjustment.solve import solve
from navfix.errors import NoFix
from tests.adjustment_scenes import epoch_scene, plane_scene

KERNELS = ("none", "huber", "hampel", "danish", "tukey", "igg3")
WRONG = (0, 4, 9)


def ratio(kernel: str, wrong: int, runs: int, damping: str = "joint") -> tuple[float, int]:
    """Return RMSE / bound over the scenes with a fix, and in how many there was none."""
    rng, squares, bounds, none = np.random.default_rng(1), 0.0, 0.0, 0
    for _ in range(runs):
        scene = plane_scene(rng, wrong=wrong)
        try:
            found = solve(scene.network, catalog.kernel(kernel), damping, solver="dense")  # type: ignore[arg-type]
        except NoFix:
            none += 1
            continue
        squares += float(found.pose[:2] @ found.pose[:2])
        bounds += float(np.trace(scene.bound()[:2, :2]))
    return math.sqrt(squares / bounds), none


def table(runs: int) -> None:
    """Print RMSE / bound, 20 targets, wrong positions 200 to 3000 m off."""
    print(f"RMSE / Cramer-Rao bound, 20 targets, {runs} runs a cell (in brackets: runs without a fix)")
    print("kernel     damping  " + "".join(f"{5 * wrong:>12d} %" for wrong in WRONG))
    for damping in ("joint", "separate"):
        for kernel in KERNELS:
            cells = [ratio(kernel, wrong, runs, damping) for wrong in WRONG]
            print(f"{kernel:10s} {damping:8s} " + "".join(f"{value:9.2f} ({none})".rjust(14) for value, none in cells))


def loop_ms() -> float:
    """Return the processor time of a fixed loop, so that figures of different machines compare."""
    taken = []
    for _ in range(5):
        start = time.process_time()
        sum(i * i for i in range(10**6))
        taken.append(1e3 * (time.process_time() - start))
    return min(taken)


def timing(marks: int, runs: int, *, solver: str) -> tuple[float, float]:
    """Return median and 99 % quantile [ms] of the processor time of one call of adjust, everything included."""
    rng = np.random.default_rng(2)
    scenes = [epoch_scene(rng, marks=marks, wrong=marks // 5) for _ in range(runs)]
    taken = []
    for epoch, association in scenes[:1] + scenes:
        start = time.process_time()
        with contextlib.suppress(NoFix):
            adjust(epoch, association, solver=solver)  # type: ignore[arg-type]
        taken.append(1e3 * (time.process_time() - start))
    median, p99 = np.quantile(taken[1:], [0.5, 0.99])  # the first one imports
    return float(median), float(p99)


def timings() -> Iterator[str]:
    """Yield the times of all sizes, in ms and in turns of a fixed loop."""
    loop = loop_ms()
    yield f"| pairs | road | median ms | p99 ms | median loops | p99 loops (1 loop = {loop:.1f} ms here) |"
    yield "|---|---|---|---|---|---|"
    for marks, runs in ((5, 200), (20, 200), (100, 50), (500, 20)):
        for solver in ("gtsam", "dense") if graph.available() else ("dense",):
            median, p99 = timing(marks, runs, solver=solver)
            shown = f"{median:.1f} | {p99:.1f} | {median / loop:.3f} | {p99 / loop:.3f}"
            yield f"| {marks} | {solver} | {shown} |"


def main() -> None:
    """Print the table and the timings."""
    if sys.argv[1:] != ["timing"]:
        table(int(sys.argv[1]) if len(sys.argv) > 1 else 500)
    for line in timings():
        print(line, flush=True)


if __name__ == "__main__":
    main()
