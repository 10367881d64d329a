"""The plain mean without gross errors: how far from the bound it lies, by geometry and by how it gets its heading.

Run: python tests/benchmarks/bench_mean_geometry.py [runs a cell]
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix.adjustment import adjust, mean_fix
from navfix.association.cpd import register_from_all_sides
from navfix.geodesy import LocalPlane, centroid, inverse
from navfix.types import Association, Epoch, Mark, Position, RadarTarget
from navfix.units import NM_M
from tests.adjustment_scenes import BEARING_SIGMA_RAD, GDYNIA_BAY, MARK_SIGMA_M, RANGE_SIGMA_M, displaced

MARKS, SEED = 20, 2026
DEGREE_OF_LATITUDE_M, DEGREE_OF_LONGITUDE_M = 110_574.0, 111_320.0  # at the equator
Draw = Callable[[np.random.Generator], float]
GEOMETRIES: Mapping[str, tuple[Draw, float]] = {  # distance of a mark [m], range sigma as a share of it
    "1-15 km, even in the logarithm, 30 m": (lambda r: math.exp(r.uniform(math.log(1e3), math.log(15e3))), 0.0),
    "0.5-12 NM, even in distance, 30 m": (lambda r: r.uniform(0.5, 12.0) * NM_M, 0.0),
    "12 NM disc, even in area, 30 m": (lambda r: 12.0 * NM_M * math.sqrt(r.uniform(0.002, 1.0)), 0.0),
    "0.5-12 NM, even in distance, 30 m or 1 %": (lambda r: r.uniform(0.5, 12.0) * NM_M, 0.01),
}
METHODS = ("heading that fits all pairs", "heading from CPD", "as its source makes it")


def scene(rng: np.random.Generator, draw: Draw, range_share: float) -> tuple[Epoch, Association]:
    """Twenty marks all round own ship in Gdynia bay, any heading, no gross errors."""
    heading_deg, sigma_deg = rng.uniform(0.0, 360.0), math.degrees(BEARING_SIGMA_RAD)
    targets, marks = [], []
    for index in range(MARKS):
        distance_m, azimuth_deg = draw(rng), rng.uniform(0.0, 360.0)
        sigma_m = max(RANGE_SIGMA_M, range_share * distance_m)
        seen = (distance_m + sigma_m * rng.normal(), azimuth_deg - heading_deg + sigma_deg * rng.normal())
        targets.append(RadarTarget(f"t{index}", *seen, range_sigma_m=sigma_m, bearing_sigma_deg=sigma_deg))
        off_m = MARK_SIGMA_M * math.hypot(*rng.normal(size=2))
        place = displaced(GDYNIA_BAY, azimuth_deg, distance_m, rng.uniform(0.0, 360.0), off_m)
        marks.append(Mark(f"m{index}", place, MARK_SIGMA_M))
    epoch = Epoch(None, tuple(targets), tuple(marks))
    return epoch, Association.from_pairs(epoch, [(i, i) for i in range(MARKS)])


def cpd_heading_deg(epoch: Epoch, unit_m: tuple[float, float]) -> float:
    """Return the rotation of plain rigid CPD from eight sides, north and east measured in units of ``unit_m``.

    The source builds both clouds in degrees at the origin of the coordinates, where a degree of latitude is 0.67 %
    shorter than one of longitude.
    """
    lat, lon = [m.position.lat_deg for m in epoch.marks], [m.position.lon_deg for m in epoch.marks]
    north, east = LocalPlane(centroid(lat, lon)).all_to_plane(lat, lon).T
    bearing = np.radians([t.bearing_deg for t in epoch.targets])
    seen = np.array([t.range_m for t in epoch.targets]) * np.exp(1j * bearing)
    marks = north / unit_m[0] + 1j * east / unit_m[1]
    found, _ = register_from_all_sides(marks, seen.real / unit_m[0] + 1j * seen.imag / unit_m[1])
    return math.degrees(float(np.angle(found.rotation)))


def means(epoch: Epoch, association: Association) -> Iterator[Position]:
    """Yield the plain mean by each of ``METHODS``."""
    yield mean_fix(epoch, association).position
    yield mean_fix(epoch, association, heading_deg=cpd_heading_deg(epoch, (1.0, 1.0))).position
    in_degrees = cpd_heading_deg(epoch, (DEGREE_OF_LATITUDE_M, DEGREE_OF_LONGITUDE_M))
    yield mean_fix(epoch, association, heading_deg=in_degrees, literal=True).position


def measure(geometry: str, runs: int) -> tuple[float, list[float]]:
    """Return the RMSE [m] of the fix, and that of each mean over it."""
    draw, share = GEOMETRIES[geometry]
    rng, squares = np.random.default_rng(SEED), np.zeros(1 + len(METHODS))
    for _ in range(runs):
        epoch, association = scene(rng, draw, share)
        fix = adjust(epoch, association, solver="dense")
        assert isinstance(fix.position, Position)
        places = [fix.position, *means(epoch, association)]
        squares += [inverse(GDYNIA_BAY, place)[0] ** 2 for place in places]
    rmse = np.sqrt(squares / runs)
    return float(rmse[0]), (rmse[1:] / rmse[0]).tolist()


def section(runs: int) -> list[str]:
    """Return the table as lines of Markdown."""
    lines = ["| marks, range sigma | fix RMSE m | " + " | ".join(METHODS) + " |", "|---|---|" + "---|" * len(METHODS)]
    for geometry in GEOMETRIES:
        rmse_m, ratios = measure(geometry, runs)
        lines.append(f"| {geometry} | {rmse_m:.1f} | " + " | ".join(f"{ratio:.2f}" for ratio in ratios) + " |")
    return lines


def main() -> None:
    """Print the table."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print("\n".join(section(runs)))


if __name__ == "__main__":
    main()
