"""The rotation weakness of plain CPD, as in the Knopp thesis, table 4.3: found minimum against the turn of the cloud.

Perfect data: 20 points, normally distributed, one cloud a turned copy of the other. Prints the table, the basin's half
width over many clouds and the success by number of starts; with --write DOCS the page and picture there.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from navfix.association import cpd

TURNS_DEG = np.arange(0, 360, 5)


def cloud(seed: int, points: int = 20) -> np.ndarray:
    random = np.random.default_rng(seed)
    return 5000.0 * (random.normal(size=points) + 1j * random.normal(size=points))


def found_deg(y: np.ndarray, turn_deg: float) -> float:
    """Return where the rotation ends when the cloud was turned by ``turn_deg``: 0 is right."""
    x = y * np.exp(1j * np.radians(turn_deg))
    rotation = cpd.register(x, y, outlier_share=0.1).rotation
    return float(np.degrees(np.angle(np.exp(1j * np.radians(turn_deg)) / rotation)) % 360.0)


def minima_table(found: np.ndarray) -> Iterator[str]:
    """Return runs of turns that end in the same minimum, as the thesis prints them."""
    yield "| turn of the cloud, deg | found minimum, deg |"
    yield "|---|---|"
    begin = 0
    for k in range(1, len(TURNS_DEG) + 1):
        apart = k == len(TURNS_DEG) or abs((found[k] - found[begin] + 180.0) % 360.0 - 180.0) > 3.0
        if apart:
            yield f"| {TURNS_DEG[begin]} - {TURNS_DEG[k - 1]} | {found[begin] % 360.0:.0f} |"
            begin = k


def half_widths(clouds: int) -> np.ndarray:
    """Return by how many degrees the turn may grow before the right minimum is lost, both ways, for each cloud."""
    widths = []
    for seed in range(clouds):
        y = cloud(seed)
        for sign in (1.0, -1.0):
            wrong = [t for t in range(5, 181, 5) if 1.0 < found_deg(y, sign * t) < 359.0]
            widths.append((wrong[0] - 5) if wrong else 180)
    return np.array(widths)


def success(clouds: int, starts: int) -> float:
    """Return the share of clouds, turned at random, that the best of so many starts solves."""
    random, right = np.random.default_rng(3), 0
    for seed in range(clouds):
        y, turn = cloud(1000 + seed), np.exp(2j * np.pi * random.uniform())
        best, _ = cpd.register_from_all_sides(y * turn, y, starts=starts)
        right += abs(np.angle(best.rotation / turn)) < 0.02
    return right / clouds


def lines(clouds: int) -> Iterator[str]:
    found = np.array([found_deg(cloud(7), float(t)) for t in TURNS_DEG])
    yield from minima_table(found)
    widths = half_widths(clouds)
    yield ""
    yield (
        f"Half width of the right basin over {clouds} clouds: median {np.median(widths):.0f} deg, "
        f"least {widths.min():.0f} deg."
    )
    yield ""
    yield "| starts | solved |"
    yield "|---|---|"
    for starts in (1, 2, 4, 6, 8, 12):
        yield f"| {starts} | {success(clouds, starts):.0%} |"


def picture(path: Path) -> None:
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    matplotlib.rcParams["svg.hashsalt"] = "navfix"
    figure, axes = pyplot.subplots(figsize=(7.0, 3.6))
    for seed in (7, 8, 9):
        found = [found_deg(cloud(seed), float(t)) for t in TURNS_DEG]
        axes.plot(TURNS_DEG, found, ".", label=f"cloud {seed}")
    axes.set(xlabel="turn of the cloud [deg]", ylabel="minimum found [deg]", xlim=(0, 360), ylim=(-5, 365))
    axes.set_title("Plain CPD from one start: 0 deg is right")
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clouds", type=int, default=40)
    parser.add_argument("--write", type=Path, metavar="DOCS")
    arguments = parser.parse_args()
    text = "\n".join(lines(arguments.clouds))
    print(text)
    if arguments.write:
        picture(arguments.write / "images" / "rotation_weakness.svg")
        (arguments.write / "rotation_weakness.md").write_text(
            "# The rotation weakness of plain CPD\n\n"
            "Written by `python tests/benchmarks/bench_rotation.py --write docs`. The Knopp thesis (4.2.3, table 4.3)\n"
            "shows five minima for one cloud of 20 points and a basin of about 65 deg; this is the same experiment\n"
            "with clouds of our own. For complete clouds eight starts suffice. For an AIS picture larger than the\n"
            "radar's they do not: see `bench_association.py methods`.\n\n"
            f"{text}\n\n![minimum found against turn](images/rotation_weakness.svg)\n"
        )
