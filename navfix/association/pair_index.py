"""Step 1: every pair of marks, sorted by distance. It depends on the marks alone and is kept between calls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from navfix.association.scene import ComplexArray
from navfix.types import FloatArray, IntArray

BIN_M = 20.0


@dataclass(frozen=True, eq=False)
class PairIndex:
    """Pairs of marks by distance: ``distance_m`` (k,) ascending; ``first`` and ``second`` (k,) are mark indices.

    An index that was kept while marks moved has ``slack_m`` > 0: no distance has changed by more. Its ``first`` and
    ``second`` then count places in ``row``, which holds the mark's index today, -1 where it has gone.
    """

    distance_m: NDArray[np.float32]
    first: NDArray[np.int32]
    second: NDArray[np.int32]
    slack_m: float = 0.0
    row: IntArray | None = None

    @classmethod
    def of(cls, z: ComplexArray, longest_m: float) -> PairIndex:
        """Index all pairs of marks ``z`` (n,) [m] at most ``longest_m`` apart; two in one point have no direction."""
        first, second = _close_pairs(z, longest_m)
        distance_m = np.abs(z[first] - z[second]).astype(np.float32)
        order = _ascending(distance_m)
        return cls(distance_m[order], first[order], second[order])

    @cached_property
    def _shorter(self) -> NDArray[np.int64]:
        """How many pairs are closer than each whole number of `BIN_M`."""
        longest = float(self.distance_m[-1]) if len(self.distance_m) else 0.0
        edges = np.arange(int(longest / BIN_M) + 2, dtype=np.float32) * np.float32(BIN_M)
        return np.searchsorted(self.distance_m, edges)

    def about_how_many(self, distance_m: FloatArray, half_width_m: FloatArray) -> NDArray[np.int64]:
        """Return how many pairs (k,) are within ``half_width_m`` of ``distance_m``, rounded up to whole bins."""
        last = len(self._shorter) - 1
        low = np.clip((distance_m - half_width_m) / BIN_M, 0, last).astype(np.int64)
        high = np.clip((distance_m + half_width_m) / BIN_M + 1.0, 0, last).astype(np.int64)
        return self._shorter[high] - self._shorter[low]

    def marks_of(self, entry: IntArray) -> tuple[NDArray[np.signedinteger], NDArray[np.signedinteger]]:
        """Return both marks (k,) of pairs ``entry`` (k,) by their index today, -1 where one has gone."""
        first, second = self.first[entry], self.second[entry]
        return (first, second) if self.row is None else (self.row[first], self.row[second])

    def window(self, distance_m: FloatArray, half_width_m: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return begin and end of the pairs whose distance is within ``half_width_m`` of ``distance_m``, each (k,)."""
        half_width_m = half_width_m + self.slack_m
        low = np.searchsorted(self.distance_m, (distance_m - half_width_m).astype(np.float32), side="left")
        high = np.searchsorted(self.distance_m, (distance_m + half_width_m).astype(np.float32), side="right")
        return low, high


def _ascending(distance_m: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the order of distances, equal ones as they come.

    The bits of floats that are not negative are in the order of the floats: with the index behind them one sort of
    whole numbers is quicker than a stable one of floats.
    """
    keyed = (distance_m.view(np.int32).astype(np.int64) << 32) | np.arange(len(distance_m))
    keyed.sort()
    return np.asarray(keyed & 0xFFFFFFFF)


def _close_pairs(z: ComplexArray, longest_m: float) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return both index columns of the pairs closer than ``longest_m``; sorting by north bounds the memory."""
    order = np.argsort(z.real, kind="stable")
    north = z.real[order]
    last = np.searchsorted(north, north + longest_m, side="right")
    firsts, seconds = [], []
    for begin in range(0, len(z), 256):
        rows = np.arange(begin, min(begin + 256, len(z)))
        columns = np.arange(begin, int(last[rows[-1]]))
        apart_m = np.abs(z[order[rows]][:, None] - z[order[columns]][None, :])
        close = (apart_m > 0.0) & (apart_m <= longest_m)
        row, column = np.nonzero(close & (columns[None, :] > rows[:, None]))
        firsts.append(order[rows[row]].astype(np.int32))
        seconds.append(order[columns[column]].astype(np.int32))
    if not firsts:
        return np.empty(0, np.int32), np.empty(0, np.int32)
    return np.concatenate(firsts), np.concatenate(seconds)
