"""Track association about a known pose: grey relational against nearest neighbours, fuzzy, JPDA, and CPD's own pairs.

Own pose is the truth (position, radar's zero mark): what is compared is the association alone. Only the last
row starts from nothing. "right": radar tracks of a ship with AIS that are given it; "wrong": any other answer.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from navfix.association import associate
from navfix.association.grey import PolarTrack, match_tracks
from navfix.association.grey_tracks import SeenFrom, polar_tracks
from navfix.errors import NoFix
from navfix.nmea import read_log
from navfix.picture import epochs as epochs_of
from navfix.picture.stitching import stitch
from navfix.report.truth import TruthTrack
from navfix.simulation.scenario import from_text, simulate
from navfix.types import Epoch, Position

SCENE = """
    title = "{name}"
    source = "bench"
    start_utc = 2026-03-01T09:00:00Z
    duration_s = 120.0
    lat_deg = 55.0
    lon_deg = 5.0
    [own]
    speed_mps = 5.0
    course_deg = 20.0
    [ais]
    wrong_count = 0
    [radar]
    edge_share = 0.6
    target_speed = "blank"
    maximum_range_m = 11000.0
    detection = 0.9
    """
LANE = """
    [[traffic]]
    layout = "lane"
    count = {count}
    axis_deg = {axis}
    length_m = {length}
    width_m = {width}
    with_ais = 0.7
    speed_min_mps = {slow}
    speed_max_mps = 9.0
    """
CROWD = """
    [[traffic]]
    layout = "uniform"
    count = 80
    radius_m = 5000.0
    inner_radius_m = 500.0
    with_ais = 0.6
    """
Answer = Mapping[str, str | None]


def lane(**values: object) -> str:
    return LANE.format(**values)


SCENES = {
    "crossing": lane(count=14, axis=20, length=9000, width=500, slow=4)
    + lane(count=14, axis=110, length=9000, width=500, slow=4),
    "overtaking": lane(count=24, axis=45, length=7000, width=300, slow=2),
    "dense": CROWD,
}  # fmt: skip


# ------------------------------------------------------------------------------------------------- methods


def places(track: PolarTrack, times_s: np.ndarray) -> np.ndarray:
    """Return a track's places at times as complex numbers, NaN outside of it."""
    there = track.range_m * np.exp(1j * np.radians(track.bearing_deg))
    found = np.interp(times_s, track.time_s, there.real) + 1j * np.interp(times_s, track.time_s, there.imag)
    return np.where((times_s < track.time_s[0] - 3) | (times_s > track.time_s[-1] + 3), np.nan, found)


def misfits(track: PolarTrack, marks: Sequence[PolarTrack]) -> np.ndarray:
    """Return (marks, points) chi-square of range and bearing at the track's instants, NaN where there is none."""
    sigma_r, sigma_t = 40.0, np.hypot(40.0, track.range_m * np.radians(1.02))
    turn = np.exp(-1j * np.radians(track.bearing_deg))
    apart = np.array([places(mark, track.time_s) * turn - track.range_m for mark in marks])
    return (apart.real / sigma_r) ** 2 + (apart.imag / sigma_t) ** 2


def grey(tracks: Sequence[PolarTrack], marks: Sequence[PolarTrack]) -> Answer:
    return {match.radar: match.ais for match in match_tracks(tracks, marks)}


def global_nearest(tracks: Sequence[PolarTrack], marks: Sequence[PolarTrack]) -> Answer:
    from scipy.optimize import linear_sum_assignment

    gate = 11.8
    cost = np.array([np.nan_to_num(np.nanmean(_padded(misfits(t, marks)), axis=1), nan=1e6) for t in tracks])
    wide = np.concatenate([np.minimum(cost, 1e6), np.full((len(tracks), len(tracks)), gate)], axis=1)
    rows, columns = linear_sum_assignment(wide)
    return {tracks[r].label: marks[c].label if c < len(marks) else None for r, c in zip(rows, columns, strict=True)}


def fuzzy(tracks: Sequence[PolarTrack], marks: Sequence[PolarTrack]) -> Answer:
    """Take the largest mean membership over position and speed, at least one half."""
    answer: dict[str, str | None] = {}
    for track in tracks:
        speed = np.array([np.interp(track.time_s, m.time_s, m.speed_mps) for m in marks]) - track.speed_mps
        near = np.exp(-misfits(track, marks) / 8.0)
        member = np.nanmean(
            _padded(0.7 * near + 0.3 * np.exp(-((speed / 3.0) ** 2)) * np.where(near > 0, 1, 0)), axis=1
        )
        best = int(np.nanargmax(np.nan_to_num(member)))
        answer[track.label] = marks[best].label if member[best] >= 0.5 else None
    return answer


def jpda(tracks: Sequence[PolarTrack], marks: Sequence[PolarTrack]) -> Answer:
    """Joint association probabilities (belief propagation) of whole tracks, from the mean misfit; the likeliest one.

    Williams and Lau, Approximate evaluation of marginal association probabilities with belief propagation, 2014.
    """
    chi2 = np.array([np.nan_to_num(np.nanmean(_padded(misfits(t, marks)), axis=1), nan=1e6) for t in tracks])
    weight = np.where(chi2 < 25.0, np.exp(-0.5 * np.minimum(chi2, 50.0)) * np.exp(0.5 * 11.8), 0.0)
    to_track = np.ones_like(weight)
    for _ in range(50):
        sums = 1.0 + (weight * to_track).sum(axis=1, keepdims=True) - weight * to_track
        to_mark = weight / sums
        to_track = 1.0 / (1.0 + to_mark.sum(axis=0, keepdims=True) - to_mark)
    probability = weight * to_track
    none = 1.0 / (1.0 + probability.sum(axis=1))
    probability *= none[:, None]
    best = probability.argmax(axis=1)
    return {
        t.label: marks[int(b)].label if probability[i, b] > none[i] else None
        for i, (t, b) in enumerate(zip(tracks, best, strict=True))
    }


def _padded(values: np.ndarray) -> np.ndarray:
    """Return the values, rows without any number made infinite: their mean is then a number."""
    empty = np.isnan(values).all(axis=1)
    return np.where(empty[:, None], 1e6, values)


METHODS: dict[str, Callable[[Sequence[PolarTrack], Sequence[PolarTrack]], Answer]] = {
    "grey": grey, "nearest": global_nearest, "fuzzy": fuzzy, "JPDA": jpda,
}  # fmt: skip


def from_nothing(epochs: Sequence[Epoch], every: int = 4) -> Answer:
    """Return the pairs of most of the single scans that are answered without any pose."""
    votes: dict[str, Counter[str | None]] = defaultdict(Counter)
    for epoch in epochs[::every]:
        try:
            found = associate(epoch)
        except NoFix:
            continue
        paired = {epoch.targets[int(t)].label: epoch.marks[int(m)].label for t, m in found.pairs}
        for target in epoch.targets:
            votes[target.label][paired.get(target.label)] += 1
    return {label: counts.most_common(1)[0][0] for label, counts in votes.items()}


# ------------------------------------------------------------------------------------------------- scenes


def judged(answer: Answer, truth: Mapping[str, str | None]) -> tuple[float, float]:
    """Return shares: of the tracks with a partner that found it, and of all tracks that got a wrong one."""
    partners = [label for label, mark in truth.items() if mark is not None]
    right = sum(answer.get(label) == truth[label] for label in partners)
    wrong = sum(answer.get(label) not in (None, mark) for label, mark in truth.items())
    return right / max(len(partners), 1), wrong / max(len(truth), 1)


def compare(
    name: str, epochs: list[Epoch], poses: list[SeenFrom], mmsi: list[dict[str, int]], *, least: int = 12
) -> None:
    """Print a row for each method."""
    originals = [[target.label for target in epoch.targets] for epoch in epochs]
    stable = list(stitch(epochs).epochs)
    known: dict[str, Counter[int]] = defaultdict(Counter)
    for epoch, before, truth in zip(stable, originals, mmsi, strict=True):
        for target, number in zip(epoch.targets, before, strict=True):
            known[target.label][truth.get(number, 0)] += 1
    tracks, marks = polar_tracks(stable, poses)
    tracks = tuple(track for track in tracks if len(track) >= least)
    labels = {mark.label for mark in marks}
    truth_of: dict[str, str | None] = {}
    for track in tracks:
        ship = str(known[track.label].most_common(1)[0][0])
        truth_of[track.label] = ship if ship in labels else None
    paired = sum(mark is not None for mark in truth_of.values())
    print(f"{name}: {len(tracks)} radar tracks, {paired} with AIS, {len(marks)} AIS tracks")
    for method, run in METHODS.items():
        began_s = time.process_time()
        answer = run(tracks, marks)
        _row(method, answer, truth_of, time.process_time() - began_s)
    began_s = time.process_time()
    _row("CPD pairs, no pose", from_nothing(stable), truth_of, time.process_time() - began_s)


def _row(method: str, answer: Answer, truth: Mapping[str, str | None], spent_s: float) -> None:
    right, wrong = judged(answer, truth)
    print(f"  {method:<20} right {100 * right:5.1f} %   wrong {100 * wrong:5.1f} %   CPU {1e3 * spent_s:8.1f} ms")


def simulated(name: str, text: str, seed: int) -> None:
    scenario = from_text(SCENE.format(name=name) + text)
    made = simulate(scenario, seed)
    epochs = list(epochs_of(read_log(made.lines, report=False).records))
    track = {round(row.unix_s): SeenFrom(Position(row.lat_deg, row.lon_deg), row.radar_zero_deg) for row in made.truth}
    rows: dict[int, dict[str, int]] = defaultdict(dict)
    for row in made.association:
        rows[round(row.unix_s)][f"{row.target_number:02d}"] = row.mmsi
    _compare_epochs(f"{name}, seed {seed}", epochs, lambda s: track.get(round(s)), rows)


def recorded(folder: Path, name: str, minutes: float) -> None:
    import csv

    epochs = list(epochs_of(read_log(folder / f"{name}.nmea", report=False).records))
    first_s = epochs[0].time_utc.timestamp() if epochs[0].time_utc else 0.0
    epochs = [e for e in epochs if e.time_utc and e.time_utc.timestamp() < first_s + 60.0 * minutes]
    with (folder / f"{name}_truth.csv").open() as lines:
        way = TruthTrack.parse(lines)
    rows: dict[int, dict[str, int]] = defaultdict(dict)
    with (folder / f"{name}_assoc.csv").open() as lines:
        for row in csv.DictReader(lines):
            rows[int(float(row["unix"]))][f"{int(row['target_no']):02d}"] = int(row["mmsi"])

    def pose(time_s: float) -> SeenFrom | None:
        truth = way.at(time_s)
        heading = None if truth is None else truth.heading_deg
        return None if truth is None or heading is None else SeenFrom(truth.position, heading + 3.0)

    _compare_epochs(name, epochs, pose, rows)


def _compare_epochs(
    name: str, epochs: list[Epoch], pose: Callable[[float], SeenFrom | None], rows: Mapping[int, dict[str, int]]
) -> None:
    kept, poses, mmsi = [], [], []
    for epoch in epochs:
        time_s = epoch.time_utc.timestamp() if epoch.time_utc else 0.0
        here = pose(time_s)
        if here is not None:
            near = {k: v for s in range(int(time_s) - 3, int(time_s) + 2) for k, v in rows.get(s, {}).items()}
            kept.append(epoch)
            poses.append(here)
            mmsi.append(near)
    compare(name, kept, poses, mmsi)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=Path(__file__).resolve().parents[3] / "shared" / "data")
    parser.add_argument("--seeds", type=int, default=3)
    args = parser.parse_args()
    for name, text in SCENES.items():
        for seed in range(1, args.seeds + 1):
            simulated(name, text, seed)
    folder = args.data / "semi_real"
    if not folder.is_dir():
        print("shared data absent")
        return
    for name in ("dense_sf", "coastal_hakefjord", "moored_harlingen_atons"):
        recorded(folder, name, 2.0)


if __name__ == "__main__":
    main()
