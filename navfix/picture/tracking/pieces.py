"""Echoes of one hull in several pieces: joined to one plot, and two tracks of one hull to one track."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from navfix.picture.tracking.filter import Measured
from navfix.types import FloatArray, IntArray


def beside(one: FloatArray, others: FloatArray, *, piece_m: float, bearing_sigma_deg: float) -> FloatArray:
    """Tell which of the places ``others`` (n, 2) [m] may be pieces of the hull at ``one`` (2,).

    Along the line of sight within ``piece_m``; across it also within one sigma of the bearing, where that is more.
    """
    range_m = float(np.hypot(*one))
    sight = one / max(range_m, 1e-9)
    gap = others - one
    along_m, across_m = np.abs(gap @ sight), np.abs(gap @ np.array([-sight[1], sight[0]]))
    near: FloatArray = (along_m <= piece_m) & (across_m <= max(piece_m, range_m * np.radians(bearing_sigma_deg)))
    return near


def joined(seen: Sequence[Measured], members: Iterable[int]) -> Measured:
    """Return the pieces of one hull as one plot: their mean, with the covariance of the first."""
    chosen = list(members)
    return Measured(np.mean([seen[index].position for index in chosen], axis=0), seen[chosen[0]].covariance)


def clusters(
    seen: Sequence[Measured],
    time_s: FloatArray,
    free: IntArray,
    *,
    piece_m: float,
    bearing_sigma_deg: float,
    near_s: float,
) -> list[list[int]]:
    """Return the plots ``free`` in groups, each the pieces of one hull: seen within ``near_s`` and side by side."""
    groups: list[list[int]] = []
    left = [int(index) for index in free]
    while left:
        first = left.pop(0)
        places = np.array([seen[index].position for index in left]).reshape(-1, 2)
        close = beside(seen[first].position, places, piece_m=piece_m, bearing_sigma_deg=bearing_sigma_deg)
        together = [i for i, near in zip(left, close, strict=True) if near and abs(time_s[i] - time_s[first]) <= near_s]
        groups.append([first, *together])
        left = [index for index in left if index not in together]
    return groups
