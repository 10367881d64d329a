"""Stable labels for targets: a number used again is two targets, two numbers of one echo are one, swaps are undone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from navfix.catalog import RadarModel, StitchingModel, radar_model, stitching_model
from navfix.picture.scans import Scan
from navfix.picture.stitching.joins import find_joins
from navfix.picture.stitching.sightings import Sightings, Tracked, backward, follow, of_epochs
from navfix.picture.stitching.swaps import Swap, find_swaps
from navfix.types import Epoch, IntArray

__all__ = ["Stitched", "stitch", "stitch_scans"]


@dataclass(frozen=True, slots=True)
class Stitched:
    """Epochs with stable labels, and what was done: numbers cut, segments joined, pairs of numbers that had swapped."""

    epochs: tuple[Epoch, ...]
    cuts: int
    joins: int
    swaps: int


def stitch(
    epochs: Sequence[Epoch], *, radar: RadarModel | str = "imo", model: StitchingModel | str = "numbers"
) -> Stitched:
    """Return epochs in the order of time with one label per echo.

    A label keeps its name from its first target on ("07"); what appears later under the same number and is another
    echo is "07b", "07c", ...; an echo that comes back or changes over keeps the label that it had before.

    Parameters
    ----------
    radar : sigmas of targets that bring none
    model : constants, models/stitching
    """
    seen = _seen(epochs, radar)
    labels, counts = _labels(seen, stitching_model(model))
    names = iter(labels)
    renamed = tuple(
        replace(epoch, targets=tuple(replace(target, label=next(names)) for target in epoch.targets))
        for epoch in epochs
    )
    return Stitched(renamed, *counts)


def stitch_scans(
    scans: Sequence[Scan], *, radar: RadarModel | str = "imo", model: StitchingModel | str = "numbers"
) -> tuple[tuple[str, ...], ...]:
    """Return the stable label of each report of each scan, as `stitch` gives them to targets."""
    from navfix.picture.picture import radar_target

    measures = radar_model(radar)
    bare = [Epoch(None, tuple(radar_target(report, measures) for report in scan.reports), ()) for scan in scans]
    stitched = stitch(bare, radar=radar, model=model)
    return tuple(tuple(target.label for target in epoch.targets) for epoch in stitched.epochs)


def _seen(epochs: Sequence[Epoch], radar: RadarModel | str) -> Sightings:
    measures = radar_model(radar)
    return of_epochs(epochs, range_sigma_m=measures.range_sigma_m, bearing_sigma_deg=measures.bearing_sigma_deg)


def _labels(seen: Sightings, model: StitchingModel) -> tuple[list[str], tuple[int, int, int]]:
    """Return the label of each sighting and how many cuts, joins and swaps led to them."""
    if not len(seen):
        return [], (0, 0, 0)
    tracked = follow(seen, model)
    back = backward(seen, tracked, tracked.segment, model)
    swaps = find_swaps(seen, tracked, back, model)
    segment, crossed = _cut_swaps(seen, tracked, swaps)
    joins = find_joins(seen, tracked, back, segment, model, taken=crossed)
    chains = _chains(int(segment.max()) + 1, [*crossed, *joins])
    cuts = int(tracked.segment.max()) + 1 - len(seen.labels)
    return _names(seen, segment, chains), (cuts, len(joins), len(swaps))


def _cut_swaps(seen: Sightings, tracked: Tracked, swaps: list[Swap]) -> tuple[IntArray, list[tuple[int, int]]]:
    """Return the segments cut where numbers changed over, and the pairs (earlier, later) that follow from it."""
    segment = tracked.segment.copy()
    crossed = []
    for before_a, before_b, after_a, after_b in sorted(swaps, key=lambda swap: swap[2]):
        fresh = int(segment.max()) + 1
        for offset, after in enumerate((after_a, after_b)):
            later = (segment == segment[after]) & (np.arange(len(segment)) >= after)
            segment[later] = fresh + offset
        crossed += [(int(segment[before_a]), fresh + 1), (int(segment[before_b]), fresh)]
    return segment, crossed


def _chains(segments: int, pairs: list[tuple[int, int]]) -> IntArray:
    """Return for each segment the earliest one of its chain."""
    before = dict((later, earlier) for earlier, later in pairs)
    chain = np.arange(segments, dtype=np.intp)
    for segment in range(segments):
        head = segment
        while head in before:
            head = before[head]
        chain[segment] = head
    return chain


def _names(seen: Sightings, segment: IntArray, chain: IntArray) -> list[str]:
    """Return the label of each sighting: that of its chain's first number, with a letter where it is used again."""
    name_of: dict[int, str] = {}
    used: dict[str, int] = {}
    names = []
    for row in range(len(seen)):
        head = int(chain[segment[row]])
        if head not in name_of:
            label = seen.labels[int(seen.number[row])]
            name_of[head] = label + _letters(used.get(label, 0))
            used[label] = used.get(label, 0) + 1
        names.append(name_of[head])
    return names


def _letters(count: int) -> str:
    """Return "" for 0, "b" for 1, ... "z", then "ba", "bb", ..."""
    text = ""
    while count:
        count, digit = divmod(count, 26)
        text = chr(ord("a") + digit) + text
    return text
