"""The adjustment in figures: another adjuster, ellipse, bound, global minimum, protection level, time; all seeded.

Run: python tests/benchmarks/bench_figures.py [TABLE ...] [--runs N] [--write]
     prints the tables (all without a name, few runs each); --write puts them into docs/adjustment_figures.md
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.benchmarks import bench_adjustment
from tests.montecarlo import test_adjustment_figures as figures
from tests.montecarlo import test_global_minimum as minimum
from tests.montecarlo import test_protection_level as level
from tests.montecarlo import test_single_point_oracle as other

PAGE = Path(__file__).resolve().parents[2] / "docs" / "adjustment_figures.md"
SECTORS_DEG = (360.0, 20.0)
Rows = Iterator[str]


def coverage(runs: int) -> Rows:
    """Yield the share of runs inside the stated ellipses: 24 cells."""
    yield "| pairs | wrong | sector | noise over sigma | inside 95 % | inside 99 % | RMSE / bound | no fix |"
    yield "|---|---|---|---|---|---|---|---|"
    for marks, counts in ((8, (0, 1, 2)), (20, (0, 3, 6))):
        for wrong in counts:
            for sector_deg in SECTORS_DEG:
                for factor in (1.0, 1.5):
                    found = figures.measure(
                        runs, 32, marks=marks, wrong=wrong, sector_deg=sector_deg, sigma_factor=factor
                    )
                    shares = f"{100 * found.inside_95:.1f} % | {100 * found.inside_99:.1f} %"
                    rest = f"{found.ratio:.2f} | {100 * found.no_fix:.2f} %"
                    yield f"| {marks} | {wrong} | {sector_deg:.0f}° | {factor:.1f} | {shares} | {rest} |"


def bound(runs: int) -> Rows:
    """Yield RMSE over the Cramer-Rao bound: independent and agreeing errors."""
    yield "| pairs | wrong | errors | sector | RMSE / bound | wanted | no fix |"
    yield "|---|---|---|---|---|---|---|"
    cells = (
        (20, 0, False, 360.0, 1.03),
        (20, 4, False, 360.0, 1.06),
        (20, 9, False, 360.0, 1.10),
        (20, 8, True, 360.0, 1.30),
        (8, 2, False, 360.0, 1.10),
        (8, 3, False, 360.0, 1.15),
        (20, 9, False, 20.0, None),
        (20, 8, True, 20.0, None),
        (8, 3, False, 20.0, None),
        (8, 3, True, 360.0, None),
    )
    for marks, wrong, agreeing, sector_deg, wanted in cells:
        found = figures.measure(runs, 34, marks=marks, wrong=wrong, agreeing=agreeing, sector_deg=sector_deg)
        kind = "agreeing" if agreeing else "independent"
        limit = "" if wanted is None else f"{wanted:.2f}"
        shown = f"{found.ratio:.2f} | {limit} | {100 * found.no_fix:.2f} %"
        yield f"| {marks} | {wrong} | {kind} | {sector_deg:.0f}° | {shown} |"


def lowest(runs: int) -> Rows:
    """Yield in how many scenes the search ends above the lowest of seventy starts."""
    yield "| kernel | scenes | missed | by at most (loss) |"
    yield "|---|---|---|---|"
    for kernel in minimum.KERNELS:
        gaps = [minimum.shortfall(seed, kernel) for seed in range(runs)]
        missed = [gap for gap in gaps if gap > 1e-5]
        yield f"| {kernel} | {runs} | {len(missed)} | {max(missed, default=0.0):.3g} |"


@dataclass(frozen=True)
class LevelCell:
    """A kind of scene for the protection level."""

    marks: int
    wrong: int
    agreeing: bool = False
    sector_deg: float = 360.0
    noise: float = 1.0


INDEPENDENT = (
    LevelCell(8, 0),
    LevelCell(8, 3),
    LevelCell(8, 3, sector_deg=20.0),
    LevelCell(20, 4),
    LevelCell(20, 8),
)
HARDER = (
    LevelCell(8, 2, agreeing=True),
    LevelCell(8, 3, agreeing=True),
    LevelCell(8, 3, agreeing=True, sector_deg=20.0),
    LevelCell(20, 8, agreeing=True),
    LevelCell(8, 2, noise=1.5),
)


def protection(runs: int) -> Rows:
    """Yield how many errors passed the protection level without an alarm, wrong marks independent of each other."""
    yield from _levels(runs, INDEPENDENT)


def protection_harder(runs: int) -> Rows:
    """Yield the same where the wrong marks agree with each other or the sigmas are too small."""
    yield from _levels(runs, HARDER)


def _levels(runs: int, cells: Sequence[LevelCell]) -> Rows:
    yield "| marks | wrong | errors | sector | noise over sigma | fixes | beyond | no level | no fix | median |"
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for cell in cells:
        found = level.measure(
            runs,
            65 if cell.agreeing else 63,
            marks=cell.marks,
            wrong=cell.wrong,
            agreeing=cell.agreeing,
            sector_deg=cell.sector_deg,
            noise=cell.noise,
        )
        kind = "agreeing" if cell.agreeing else "independent"
        scene = f"{cell.marks} | {cell.wrong} | {kind} | {cell.sector_deg:.0f}° | {cell.noise:.1f}"
        fixes = round(runs * (1.0 - found.no_fix))
        shares = f"{100 * found.without_level:.2f} % | {100 * found.no_fix:.2f} % | {found.median_m:.0f} m"
        yield f"| {scene} | {fixes} | {found.beyond} | {shares} |"


def oracle(runs: int) -> Rows:
    """Yield the largest differences from an independent adjuster in random single-point cases."""
    yield "| road | cases compared | position m | covariance, relative | redundancy number | w | heading ° |"
    yield "|---|---|---|---|---|---|---|"
    for solver in ("gtsam", "dense"):
        found = other.compared(runs, solver)
        names = ("position_m", "covariance", "redundancy", "w", "heading_deg")
        worst = " | ".join(f"{max(getattr(d, name) for d in found):.1e}" for name in names)
        yield f"| {solver} | {len(found)} | {worst} |"
    yield "| wanted | | 1e-03 | 1e-05 | 1e-04 | 1e-03 | 1e-05 |"


def timing(_: int) -> Rows:
    """Yield the processor time of a fix."""
    yield from bench_adjustment.timings()


TABLES: dict[str, tuple[Callable[[int], Rows], int]] = {  # with the runs of a quick look
    "oracle": (oracle, 20),
    "coverage": (coverage, 50),
    "bound": (bound, 50),
    "minimum": (lowest, 12),
    "protection": (protection, 50),
    "protection-harder": (protection_harder, 50),
    "timing": (timing, 200),
}


def written(text: str, table: str, rows: list[str], runs: int) -> str:
    """Return the page with the rows of one table in their place.

    Raises
    ------
    ValueError : the page has no place for the table
    """
    command = f"`python tests/benchmarks/bench_figures.py {table} --runs {runs} --write`"
    block = "\n".join([f"<!-- {table} -->", "", *rows, "", f"{runs} runs a row; {command}", "", "<!-- end -->"])
    result, count = re.subn(rf"<!-- {table} -->.*?<!-- end -->", lambda _: block, text, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"{PAGE.name}: expected one place for the table {table}, found {count}")
    return result


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="*", choices=[*TABLES, []], metavar="TABLE")
    parser.add_argument("--runs", type=int)
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    for name in args.tables or TABLES:
        table, quick = TABLES[name]
        runs, rows = args.runs or quick, []
        print(f"{name}, {runs} runs a row", flush=True)
        for row in table(runs):
            print(row, flush=True)
            rows.append(row)
        if args.write:
            PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), name, rows, runs), encoding="utf-8")


if __name__ == "__main__":
    main()
