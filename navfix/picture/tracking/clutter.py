"""How thick clutter lies at a place: from the plots that came to nothing in the last turns."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import numpy as np

from navfix.catalog import TrackingModel
from navfix.types import FloatArray


class ClutterMap:
    """Density [1/m2 and turn] of plots that no track could use, about own ship."""

    def __init__(self, model: TrackingModel) -> None:
        self._radius_m = model.clutter_radius_m
        self._floor_per_m2 = model.clutter_floor_per_km2 * 1e-6
        self._turns: deque[list[FloatArray]] = deque([[]], maxlen=model.clutter_turns)
        self._known = np.empty((0, 2))

    def begin_turn(self) -> None:
        """Open the record of another turn; the oldest one is forgotten."""
        self._known = np.array([place for turn in self._turns for place in turn]).reshape(-1, 2)
        self._turns.append([])

    def add(self, positions: Iterable[FloatArray]) -> None:
        """Record plots (2,) [m] that proved to be clutter."""
        self._turns[-1].extend(positions)

    def per_m2(self, position: FloatArray) -> float:
        """Return the density at a place (2,) [m], never below the floor."""
        gap_m = np.hypot(*(self._known - position).T)
        near = int(np.count_nonzero(gap_m <= self._radius_m))
        return max(self._floor_per_m2, near / (math.pi * self._radius_m**2 * len(self._turns)))
