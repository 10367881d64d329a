"""Step 1: every pair of marks, sorted by distance. It depends on the marks alone and is kept between calls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.association.scene import ComplexArray
from navfix.types import FloatArray


@dataclass(frozen=True, eq=False)
class PairIndex:
    """Pairs of marks by distance: ``distance_m`` (k,) ascending; ``first`` and ``second`` (k,) are mark indices."""

    distance_m: NDArray[np.float32]
    first: NDArray[np.int32]
    second: NDArray[np.int32]

    @classmethod
    def of(cls, z: ComplexArray, longest_m: float) -> PairIndex:
        """Index all pairs of marks ``z`` (n,) [m] at most ``longest_m`` apart; two in one point have no direction."""
        first, second = _close_pairs(z, longest_m)
        distance_m = np.abs(z[first] - z[second]).astype(np.float32)
        order = np.argsort(distance_m, kind="stable")
        return cls(distance_m[order], first[order], second[order])

    def window(self, distance_m: FloatArray, half_width_m: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return begin and end of the pairs whose distance is within ``half_width_m`` of ``distance_m``, each (k,)."""
        low = np.searchsorted(self.distance_m, (distance_m - half_width_m).astype(np.float32), side="left")
        high = np.searchsorted(self.distance_m, (distance_m + half_width_m).astype(np.float32), side="right")
        return low, high


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
