"""Target numbers whose truth is known: simulated recycling and swaps, and how pure and whole the labels are."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from navfix.nmea.records import TargetReport
from navfix.picture.picture import radar_target
from navfix.picture.scans import ScanBuilder
from navfix.simulation import radar, tracker
from navfix.simulation.scenario import from_text
from navfix.simulation.world import random_stream
from navfix.types import Epoch

SCENE = """
    title = "numbers"
    source = "test"
    start_utc = 2026-03-01T09:00:00Z
    duration_s = {duration_s}
    lat_deg = 55.0
    lon_deg = 5.0
    [own]
    speed_mps = 5.0
    course_deg = 20.0
    yaw_deg = 2.0
    turn_at_s = 100.0
    turn_deg = 60.0
    turn_rate_deg_per_min = 90.0
    [[traffic]]
    layout = "lane"
    count = 25
    axis_deg = 70.0
    length_m = 16000.0
    width_m = 900.0
    speed_max_mps = 9.0
    turning = 0.3
    [radar]
    detection = {detection}
    lost_turns = 2
    acquire_hits = 2
    highest_number = 30
    edge_share = 0.5
    maximum_range_m = 9000.0
    bearing_resolution_deg = 1.5
    """

Labelled = tuple[TargetReport, int]


def recycled_numbers(*, duration_s: float = 300.0, detection: float = 0.8, seed: int = 1) -> list[Labelled]:
    """Return reports with their MMSI: two turns without an echo lose a target, whose number is soon used again."""
    scenario = from_text(SCENE.format(duration_s=duration_s, detection=detection))
    world, model = scenario.world(seed), scenario.radar_model()
    turns, _ = radar.turns(world, scenario.radar, model, scenario.duration_s, seed)
    reports = tracker.follow(world, scenario.radar, model, turns, gyro_bias_deg=0.0, rng=random_stream(seed, "tracker"))
    return [(report, mmsi) for report, mmsi in reports if report.status != "L"]


def with_swaps(reports: Sequence[Labelled], *, within_m: float, seed: int, most: int = 6) -> tuple[list[Labelled], int]:
    """Exchange the numbers of pairs of targets where they pass nearest, if that is within a distance; return how many.

    Each pair goes on under exchanged numbers to the end of its tracks; a number takes part in one swap at most.
    """
    rng = np.random.default_rng(seed)
    tracks: dict[tuple[int, int], list[int]] = defaultdict(list)
    for index, (report, mmsi) in enumerate(reports):
        tracks[(report.number, mmsi)].append(index)
    keys = [key for key, rows in tracks.items() if len(rows) >= 40]
    pairs = [(one, other) for i, one in enumerate(keys) for other in keys[i + 1 :] if one[0] != other[0]]
    renumbered = [report.number for report, _ in reports]
    used: set[tuple[int, int]] = set()
    swaps = 0
    for pick in rng.permutation(len(pairs)):
        one, other = pairs[int(pick)]
        at = _closest(reports, tracks[one], tracks[other], within_m)
        if at is None or one in used or other in used or swaps == most or _used_later(reports, (one, other), at):
            continue
        used |= {one, other}
        swaps += 1
        for key, number in ((one, other[0]), (other, one[0])):
            for index in tracks[key]:
                if (reports[index][0].time_s or 0.0) > at:
                    renumbered[index] = number
    renewed = [
        (replace(report, number=number), mmsi) for (report, mmsi), number in zip(reports, renumbered, strict=True)
    ]
    return renewed, swaps


def _used_later(reports: Sequence[Labelled], pair: tuple[tuple[int, int], tuple[int, int]], at: float) -> bool:
    """Tell whether another ship gets one of the two numbers later: then one number would stand for two targets."""
    numbers = {key[0] for key in pair}
    return any(
        report.number in numbers and (report.number, mmsi) not in pair and (report.time_s or 0.0) > at
        for report, mmsi in reports
    )


def _closest(reports: Sequence[Labelled], one: list[int], other: list[int], within_m: float) -> float | None:
    """Return when two tracks are nearest [POSIX s], None where that is not within the distance or too near an end."""
    times = np.array([reports[i][0].time_s for i in one])
    places = {name: np.array([_place(reports[i][0]) for i in rows]) for name, rows in (("one", one), ("other", other))}
    theirs = np.array([reports[i][0].time_s for i in other])
    nearest = np.abs(theirs[None, :] - times[:, None]).argmin(axis=1)
    together = np.abs(theirs[nearest] - times) < 3.0
    gap_m = np.where(together, np.abs(places["one"] - places["other"][nearest]), np.inf)
    at = int(gap_m.argmin())
    if gap_m[at] > within_m or not 10 <= at < len(one) - 10 or not 10 <= nearest[at] < len(other) - 10:
        return None
    return float(max(times[at], theirs[nearest[at]]))


def _place(report: TargetReport) -> complex:
    return report.range_m * np.exp(1j * np.radians(report.bearing_deg))


def epochs_of(reports: Iterable[Labelled], model: object) -> tuple[list[Epoch], list[list[int]]]:
    """Return the scans of reports as epochs without marks, and the MMSI of each target."""
    mmsi_of = {id(report): mmsi for report, mmsi in reports}
    builder = ScanBuilder()
    scans = [scan for report, _ in reports if (scan := builder.feed(report)) is not None]
    found = [[mmsi_of[id(report)] for report in scan.reports] for scan in scans]
    return [Epoch(None, tuple(radar_target(r, model) for r in scan.reports), ()) for scan in scans], found  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class LabelFigures:
    """How pure labels are (share of sightings that are their label's main ship) and how many labels a ship has."""

    purity: float
    labels_per_ship: float
    labels: int


def label_figures(labels: Iterable[Iterable[str]], mmsi: Iterable[Iterable[int]]) -> LabelFigures:
    """Return the figures of labels against the truth; sightings of no known ship (MMSI 0) do not count."""
    of_label: dict[str, Counter[int]] = defaultdict(Counter)
    of_ship: dict[int, set[str]] = defaultdict(set)
    for row, truth in zip(labels, mmsi, strict=True):
        for label, ship in zip(row, truth, strict=True):
            if ship:
                of_label[label][ship] += 1
                of_ship[ship].add(label)
    total = sum(sum(counts.values()) for counts in of_label.values())
    main = sum(counts.most_common(1)[0][1] for counts in of_label.values())
    return LabelFigures(main / total, float(np.mean([len(names) for names in of_ship.values()])), len(of_label))


@dataclass(frozen=True, slots=True)
class LinkFigures:
    """Precision and recall of the cuts (a number goes on with another ship) and joins (a ship with another number)."""

    cut_precision: float
    cut_recall: float
    join_precision: float
    join_recall: float


def link_figures(
    numbers: Sequence[Sequence[str]], labels: Sequence[Sequence[str]], mmsi: Sequence[Sequence[int]]
) -> LinkFigures:
    """Return how right the cuts and joins of labels are, over neighbouring sightings of known ships."""
    rows = [item for trio in zip(numbers, labels, mmsi, strict=True) for item in zip(*trio, strict=True) if item[2]]
    by_number, by_label, by_ship = (_neighbours(rows, which) for which in (0, 1, 2))
    cut_made = [one[2] != other[2] for one, other in by_number if one[1] != other[1]]
    cut_due = [one[1] != other[1] for one, other in by_number if one[2] != other[2]]
    join_made = [one[2] == other[2] for one, other in by_label if one[0] != other[0]]
    join_due = [one[1] == other[1] for one, other in by_ship if one[0] != other[0]]
    return LinkFigures(*(float(np.mean(x)) if x else float("nan") for x in (cut_made, cut_due, join_made, join_due)))


def _neighbours(
    rows: list[tuple[str, str, int]], which: int
) -> list[tuple[tuple[str, str, int], tuple[str, str, int]]]:
    """Return each sighting with the next one of the same number (0), label (1) or ship (2)."""
    last: dict[object, tuple[str, str, int]] = {}
    pairs = []
    for row in rows:
        if row[which] in last:
            pairs.append((last[row[which]], row))
        last[row[which]] = row
    return pairs
