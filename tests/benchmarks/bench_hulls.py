"""Hulls: nearest echo, ellipse and known hull compared, and what the visible side brings on recordings.

``python tests/benchmarks/bench_hulls.py [rest|underway|recordings] [--write docs]`` prints the tables of docs/hulls.md;
with ``--write`` it also draws the picture. Everything is seeded; recordings are used where they are beside the project.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from line_chart import Panel, line_chart

from navfix import associate
from navfix.adjustment import adjust
from navfix.adjustment.visible_side import adjust_visible_side
from navfix.errors import NoFix
from navfix.geodesy import direct, inverse
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.picture.ellipse import antenna_step, fit_ellipse, fit_known_ellipse
from navfix.picture.fusion import fuse, fuse_angles
from navfix.picture.hull import Size, echo, hull_shift, size_of
from navfix.picture.kalman import predict, start, update
from navfix.picture.outlines import Outline, hull_centre
from navfix.report.truth import TruthTrack
from navfix.types import Association, Epoch, Fix, FloatArray, Position
from navfix.units import KNOT_MPS

LENGTH_M, BEAM_M, CENTRE_M = 249.0, 44.0, np.array([4000.0, 4000.0])
RECORDINGS = Path(__file__).resolve().parents[3] / "shared" / "data"


@dataclass(frozen=True)
class Noise:
    """1 sigma of one boundary point."""

    name: str
    range_m: float
    bearing_deg: float

    def add(self, points: FloatArray, rng: np.random.Generator) -> FloatArray:
        polar = to_polar(points)
        return polar + rng.normal(0.0, 1.0, polar.shape) * [self.range_m, self.bearing_deg]


NOISES = (
    Noise("as printed: 20 m, 1.41°", 20.0, math.sqrt(2.0)),
    Noise("5 m, 0.05°", 5.0, 0.05),
    Noise("2 m, 0.02°", 2.0, 0.02),
    Noise("none", 0.0, 0.0),
)


def boundary(centre: FloatArray, heading_deg: float, angles: FloatArray) -> FloatArray:
    heading = math.radians(heading_deg)
    own = np.column_stack([LENGTH_M / 2.0 * np.cos(angles), BEAM_M / 2.0 * np.sin(angles)])
    turn = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
    return centre + own @ turn.T


def to_polar(points: FloatArray) -> FloatArray:
    return np.column_stack([np.hypot(*points.T), np.degrees(np.arctan2(points[:, 1], points[:, 0]))])


def to_plane(polar: FloatArray) -> FloatArray:
    bearing = np.radians(polar[:, 1])
    return polar[:, :1] * np.column_stack([np.cos(bearing), np.sin(bearing)])


# ---------------------------------------------------------------------------------------------------- one ship at rest


def plain_conic(points: FloatArray) -> FloatArray | None:
    """Return the centre by the conic of source [11], eq. (4): least squares without a condition; None: no ellipse."""
    x, y = ((points - points.mean(axis=0)) / 100.0).T
    A, B, C, D, E = np.linalg.lstsq(np.column_stack([x * x, x * y, y * y, x, y]), -np.ones_like(x), rcond=None)[0]
    if B * B - 4.0 * A * C >= 0.0:
        return None
    centre = np.linalg.solve([[2.0 * A, B], [B, 2.0 * C]], [-D, -E])
    return points.mean(axis=0) + 100.0 * centre


def centres(polar: FloatArray, heading_deg: float) -> dict[str, FloatArray | None]:
    points = to_plane(polar)
    fitted = fit_ellipse(points)
    chosen = hull_centre(Outline(0.0, "1", polar))
    assert chosen is not None
    known = fit_known_ellipse(points, LENGTH_M, BEAM_M, heading_deg)
    return {
        "source's conic": plain_conic(points),
        "ellipse": None if fitted is None else np.array([fitted.north_m, fitted.east_m]),
        "ellipse or extent": to_plane(np.array([[chosen.range_m, chosen.bearing_deg]]))[0],
        "known hull": np.array([known.north_m, known.east_m]),
    }


def at_rest(draws: int = 400, counts: tuple[int, ...] = (5, 20)) -> Iterator[tuple[str, ...]]:
    yield ("heading", "noise of a point", "points", "method", "no ellipse %", "centre: median m", "95 % m")
    for heading_deg in (225.0, 305.0):
        for noise in NOISES:
            for count in counts:
                rng, found = np.random.default_rng(11), {}
                for _ in range(draws):
                    polar = noise.add(boundary(CENTRE_M, heading_deg, rng.uniform(0.0, 2.0 * math.pi, count)), rng)
                    for method, centre in centres(polar, heading_deg).items():
                        found.setdefault(method, []).append(centre)
                for method, all_centres in found.items():
                    there = [float(np.hypot(*(c - CENTRE_M))) for c in all_centres if c is not None]
                    none = 100.0 * (1.0 - len(there) / draws)
                    middle, most = np.percentile(there, [50, 95]) if there else (math.nan, math.nan)
                    figures = f"{none:.0f}", f"{middle:.1f}", f"{most:.0f}"
                    yield (f"{heading_deg:.0f}", noise.name, str(count), method, *figures)


# ------------------------------------------------------------------------------------------- the scenario of the source


def underway(draws: int = 8, duration_s: float = 300.0) -> Iterator[tuple[str, ...]]:
    """10 kn on 225 deg from (4000, 4000), own ship at rest, radar every 2 s, five points; error of the antenna."""
    yield ("noise of a point", "AIS variance", "radar point", "radar alone m", "fused m")
    for noise in NOISES[:3]:
        for ais_name, ais_m2, ais_deg2 in (("80 m², 1.2°² as printed", 80.0, 1.2), ("80 m², 80 m² across", 80.0, None)):
            for point in ("nearest", "ellipse or extent", "known hull"):
                errors = [_one_run(noise, ais_m2, ais_deg2, point, seed, duration_s) for seed in range(draws)]
                alone, fused = np.mean(errors, axis=0)
                yield (noise.name, ais_name, point, f"{alone:.1f}", f"{fused:.1f}")


def _one_run(
    noise: Noise, ais_m2: float, ais_deg2: float | None, point: str, seed: int, duration_s: float
) -> tuple[float, float]:
    rng, radar, ais, alone, fused = np.random.default_rng(seed), _Polar(), _Polar(), [], []
    heading_deg, course = 225.0, np.array([math.cos(math.radians(225.0)), math.sin(math.radians(225.0))])
    for time_s in np.arange(0.0, duration_s, 2.0):
        centre = CENTRE_M + 10.0 * KNOT_MPS * time_s * course
        antenna = centre + antenna_step(LENGTH_M, heading_deg)
        ((true_m, true_deg),) = to_polar(antenna[None])
        polar = noise.add(boundary(centre, heading_deg, rng.uniform(0.0, 2.0 * math.pi, 5)), rng)
        seen = to_polar(_radar_point(point, polar, heading_deg)[None])[0]
        across_deg2 = ais_deg2 or ais_m2 * math.degrees(1.0 / true_m) ** 2
        told = np.array([true_m, true_deg]) + rng.normal(0.0, 1.0, 2) * np.sqrt([ais_m2, across_deg2])
        by_radar = radar.feed(time_s, seen, (400.0, 2.0))
        by_ais = ais.feed(time_s, told, (ais_m2, across_deg2))
        range_m, _ = fuse(np.array([by_ais[0], by_radar[0]]), np.array([ais_m2, 400.0]))
        bearing_deg, _ = fuse_angles(np.array([by_ais[1], by_radar[1]]), np.array([across_deg2, 2.0]))
        if time_s >= 20.0:
            alone.append(float(np.hypot(*(to_plane(by_radar[None])[0] - antenna))))
            fused.append(float(np.hypot(*(to_plane(np.array([[range_m, bearing_deg]]))[0] - antenna))))
    return float(np.mean(alone)), float(np.mean(fused))


class _Polar:
    """Range and bearing of one sensor, each by a Kalman filter."""

    def __init__(self) -> None:
        self._tracks = None

    def feed(self, time_s: float, seen: FloatArray, variances: tuple[float, float]) -> FloatArray:
        if self._tracks is None:
            self._tracks = [start(time_s, v, s, rate_variance=25.0) for v, s in zip(seen, variances, strict=True)]
        else:
            self._tracks = [
                update(predict(track, time_s, acceleration), float(v), s)
                for track, acceleration, v, s in zip(self._tracks, (0.05, 0.001), seen, variances, strict=True)
            ]
        return np.array([track.value for track in self._tracks])


def _radar_point(point: str, polar: FloatArray, heading_deg: float) -> FloatArray:
    """Return what radar takes for the antenna's place: with the hull's centre known, a quarter of the length aft."""
    nearest = polar[int(np.argmin(polar[:, 0]))]
    aft = antenna_step(LENGTH_M, heading_deg)
    if point == "nearest":
        return to_plane(nearest[None])[0]
    if point == "known hull":
        known = fit_known_ellipse(to_plane(polar), LENGTH_M, BEAM_M, heading_deg)
        return np.array([known.north_m, known.east_m]) + aft
    chosen = hull_centre(Outline(0.0, "1", polar))
    assert chosen is not None
    return to_plane(np.array([[chosen.range_m, chosen.bearing_deg]]))[0] + aft


# ---------------------------------------------------------------------------------------------------------- recordings


def at_antenna(epoch: Epoch) -> Epoch:
    """Undo the step from antenna to centre: what a fix without any hull correction takes."""
    marks = []
    for mark in epoch.marks:
        size = size_of(mark.hull, aid=mark.kind != "ship", ais_class=mark.ais_class, ship_type=mark.ship_type)
        step = hull_shift(size, mark.heading_deg)
        back_m, back_deg = math.hypot(step.north_m, step.east_m), math.degrees(math.atan2(-step.east_m, -step.north_m))
        marks.append(replace(mark, position=direct(mark.position, back_deg, back_m)))
    return replace(epoch, marks=tuple(marks))


METHODS: dict[str, Callable[[Epoch, Association], Fix]] = {
    "antenna": lambda epoch, pairs: adjust(at_antenna(epoch), pairs),
    "centre": lambda epoch, pairs: adjust(epoch, pairs),
    "visible side": lambda epoch, pairs: adjust_visible_side(epoch, pairs),
}


def sized_only(epoch: Epoch) -> Epoch:
    """Keep aids, and ships whose dimensions and heading are known."""
    sized = [m for m in epoch.marks if m.kind != "ship" or (m.hull is not None and m.heading_deg is not None)]
    return replace(epoch, marks=tuple(sized))


def on_recordings(sparser: int = 3) -> Iterator[tuple[str, ...]]:
    yield ("recording", "marks", "point", "fixes", "median m", "95 % m", "ellipse holds %")
    for name, every in (
        ("semi_real/dense_sf", 10), ("semi_real/coastal_hakefjord", 5), ("semi_real/moored_harlingen_atons", 1),
        ("marce/marce_01_010", 2), ("marce/marce_01_004", 1),
    ):  # fmt: skip
        if not (RECORDINGS / f"{name}.nmea").is_file():
            continue
        with (RECORDINGS / f"{name}_truth.csv").open() as lines:
            track = TruthTrack.parse(lines)
        seen = list(epochs(read_log(RECORDINGS / f"{name}.nmea").records, every=every * sparser))
        for which, keep in (("all", lambda e: e), ("size known", sized_only)):
            rows = [row for epoch in seen if (row := _errors(keep(epoch), track)) is not None]
            for method in METHODS if len(rows) >= 10 else ():
                errors_m, inside = np.array([row[method][0] for row in rows]), np.mean([row[method][1] for row in rows])
                middle, most = np.percentile(errors_m, [50, 95])
                yield (name, which, method, str(len(rows)), f"{middle:.1f}", f"{most:.1f}", f"{100 * inside:.0f}")


def _errors(epoch: Epoch, track: TruthTrack) -> dict[str, tuple[float, bool]] | None:
    """Return error [m] and whether the 95 % ellipse holds the truth, by method, all from the same pairs."""
    truth = track.at(epoch.time_utc.timestamp()) if epoch.time_utc else None
    if truth is None:
        return None
    try:
        pairs = associate(epoch)
        return {method: _error(solve(epoch, pairs), truth.position) for method, solve in METHODS.items()}
    except NoFix:
        return None


def _error(found: Fix, truth: Position) -> tuple[float, bool]:
    assert isinstance(found.position, Position)
    error_m, azimuth_deg = inverse(found.position, truth)
    ellipse = found.ellipse(0.95)
    off = math.radians(azimuth_deg - ellipse.azimuth_deg)
    return error_m, math.hypot(
        error_m * math.cos(off) / ellipse.semi_major_m, error_m * math.sin(off) / ellipse.semi_minor_m
    ) <= 1.0


# ------------------------------------------------------------------------------------------------------------- output


def picture() -> str:
    """Return depth of the echo against aspect, and error of the centre against the number of points."""
    size, aspects = Size(LENGTH_M, BEAM_M), range(0, 91, 2)
    visible = [(float(a), echo(size, math.radians(a)).depth_m) for a in aspects]
    nearest = [
        (float(a), LENGTH_M / 2 * math.cos(math.radians(a)) + BEAM_M / 2 * math.sin(math.radians(a))) for a in aspects
    ]
    lines: dict[str, list[tuple[float, float]]] = {}
    for count in (5, 7, 10, 15, 20, 30, 50, 70, 90):
        rng, found = np.random.default_rng(11), {}
        for _ in range(200):
            polar = NOISES[1].add(boundary(CENTRE_M, 225.0, rng.uniform(0.0, 2.0 * math.pi, count)), rng)
            for method, centre in centres(polar, 225.0).items():
                if centre is not None and method != "ellipse":
                    found.setdefault(method, []).append(float(np.hypot(*(centre - CENTRE_M))))
        for method, errors in found.items():
            lines.setdefault(method, []).append((float(count), float(np.median(errors))))
    depth = Panel("echo before the centre, by aspect [deg]", {"visible side": visible, "nearest edge": nearest})
    error = Panel("error of the centre, by points (5 m, 0.05 deg)", lines)
    return line_chart([depth, error], x_title="aspect [deg], points", y_title="m", emphasised="visible side")


PARTS: dict[str, Callable[[], Iterator[tuple[str, ...]]]] = {
    "rest": at_rest,
    "underway": underway,
    "recordings": on_recordings,
}


def markdown(rows: Iterator[tuple[str, ...]]) -> str:
    head, *body = rows
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ("---",) * len(head), *body))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", nargs="?", choices=PARTS, help="one table (default: all of them)")
    parser.add_argument("--write", metavar="DOCS", type=Path, help="folder whose images/hulls.svg is written")
    args = parser.parse_args()
    for title in PARTS if args.part is None else (args.part,):
        print(f"\n### {title}\n\n{markdown(PARTS[title]())}", flush=True)
    if args.write is not None:
        (args.write / "images" / "hulls.svg").write_text(picture(), encoding="utf-8")


if __name__ == "__main__":
    main()
