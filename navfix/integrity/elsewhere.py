"""An echo that goes with a ship's AIS track at a constant distance: the ship itself, elsewhere than it says."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from navfix.geodesy import LocalPlane
from navfix.types import FloatArray, Position


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """The echo ``label`` at ``offset_m`` (2,) north, east from the AIS position, with its covariance.

    ``chance`` is the probability that some echo of another ship does the same, for want of anything rarer.
    """

    label: str
    offset_m: FloatArray
    covariance_m2: FloatArray
    moved_m: float
    chance: float

    @property
    def in_words(self) -> str:
        """What speaks for it."""
        return f"may be echo {self.label}, which keeps its distance while the AIS moves {self.moved_m:.0f} m"


@dataclass(slots=True)
class Elsewhere:
    """The offsets of one free echo from one AIS track, as they are seen."""

    farthest_m: ClassVar[float] = 5000.0
    radar_share: ClassVar[float] = 0.01  # sigma of an echo's place, per distance: 0.6 deg, 1 % of range
    least_sigma_m: ClassVar[float] = 20.0

    label: str
    places: list[Position] = field(default_factory=list)
    offsets_m: list[FloatArray] = field(default_factory=list)
    sigmas_m: list[float] = field(default_factory=list)
    times_s: list[float | None] = field(default_factory=list)

    def add(self, place: Position, offset_m: FloatArray, distance_m: float, time_s: float | None) -> None:
        """Take one epoch in."""
        self.places.append(place)
        self.offsets_m.append(offset_m)
        self.sigmas_m.append(max(self.least_sigma_m, self.radar_share * distance_m))
        self.times_s.append(time_s)

    def moved_m(self) -> float:
        """Return how far the AIS position went."""
        return float(np.hypot(*LocalPlane(self.places[0]).to_plane(self.places[-1])))

    def span_s(self) -> float:
        """Return how long it was followed, 0 where the epochs have no times."""
        first, last = self.times_s[0], self.times_s[-1]
        return 0.0 if first is None or last is None else last - first


def find_elsewhere(
    tracks: Iterable[Elsewhere], fewest: int, velocity_mps: FloatArray, others_mps: FloatArray
) -> Found | None:
    """Return the echo that keeps its offset best, or None.

    Demanded: ``fewest`` epochs; an AIS track that moved ten sigma and 300 m (any still echo keeps its offset from a
    ship at anchor); offsets that scatter and drift no more than radar noise does. How much that proves depends on how
    common the ship's velocity is among ``others_mps`` (n, 2): in a lane many ships keep their distance from each other.
    """
    tried = [track for track in tracks if len(track.offsets_m) >= fewest]
    best, best_spread = None, math.inf
    for track in tried:
        offsets, sigma_m = np.array(track.offsets_m), float(np.sqrt(np.mean(np.square(track.sigmas_m))))
        moved_m, span_s = track.moved_m(), track.span_s()
        if moved_m < max(300.0, 10.0 * sigma_m) or span_s <= 0.0:
            continue
        mean = offsets.mean(axis=0)
        spread = float(np.sqrt(np.mean(np.sum((offsets - mean) ** 2, axis=1)) / 2.0)) / sigma_m
        third = max(len(offsets) // 3, 1)
        drifted_m = float(np.hypot(*(offsets[-third:].mean(axis=0) - offsets[:third].mean(axis=0))))
        if spread < min(best_spread, 1.5) and drifted_m < max(3.0 * sigma_m, 0.1 * moved_m):
            alike = np.hypot(*(others_mps - velocity_mps).T) < max(3.0 * sigma_m, 0.1 * moved_m) / span_s
            share = (float(np.sum(alike)) + 0.5) / (len(alike) + 1.0)
            chance = 1.0 - (1.0 - share) ** len(tried)
            best, best_spread = Found(track.label, mean, sigma_m**2 * np.eye(2), moved_m, chance), spread
    return best
