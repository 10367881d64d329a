"""Which plot is which track: the cheapest one-to-one assignment of a whole turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from navfix.picture.tracking.gating import Distances

_NEVER = 1e6


def assign(found: Distances, allowed: NDArray[np.bool_], gate_chi2: float) -> list[tuple[int, int]]:
    """Return (track, plot) pairs, each track and each plot once at most, that cost least in sum, eq. (11.6).

    A pair costs its chi-square distance plus the log determinant against the track's most certain plot; a track without
    a plot costs the gate. ``allowed`` (n, m) excludes pairs.
    """
    from scipy.optimize import linear_sum_assignment

    tracks, plots = found.chi2.shape
    inside = allowed & (found.chi2 <= gate_chi2)
    if not inside.any():
        return []
    least = np.where(inside, found.log_det, np.inf).min(axis=1, keepdims=True)
    cost = np.full((tracks, plots + tracks), _NEVER)
    cost[:, :plots] = np.where(inside, found.chi2 + found.log_det - np.where(np.isfinite(least), least, 0.0), _NEVER)
    cost[np.arange(tracks), plots + np.arange(tracks)] = gate_chi2
    rows, columns = linear_sum_assignment(cost)
    return [(int(row), int(column)) for row, column in zip(rows, columns, strict=True) if column < plots]
