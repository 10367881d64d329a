"""Step 2a: tracks brought to the knots of a window, and the basis over its own bins in which a track is judged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from navfix.association.scene import ComplexArray
from navfix.association.window.tracks import Track
from navfix.types import FloatArray

LEAST_SPAN_S = 4.0  # reports that span less have no slope
FEWEST_REPORTS = 3  # nor have fewer


def binned(tracks: Sequence[Track], knot_s: FloatArray, bin_s: float) -> tuple[np.ndarray, ComplexArray]:
    """Return where the tracks live (m, K) and their places at the knots (m, K), 0 where they do not live.

    The place is that of a line through the reports of the bin; its slope is taken from three bins about the knot.
    """
    if not tracks:
        return np.zeros((0, len(knot_s)), dtype=bool), np.zeros((0, len(knot_s)), dtype=np.complex128)
    length = np.array([len(track.time_s) for track in tracks])
    first = np.cumsum(length) - length
    rho = np.concatenate([track.rho for track in tracks])[:, None]
    after_s = np.concatenate([track.time_s for track in tracks])[:, None] - knot_s  # (reports, K)
    inside = np.abs(after_s) <= 0.5 * bin_s + 0.5 if len(knot_s) > 1 else np.ones_like(after_s, dtype=bool)
    slope = _slopes(after_s, rho, np.abs(after_s) <= 1.5 * bin_s, first)
    straight = np.where(inside, rho - np.repeat(slope, length, axis=0) * after_s, 0.0)
    count = np.add.reduceat(inside.astype(np.int64), first)
    place = np.add.reduceat(straight, first) / np.maximum(count, 1)
    return count > 0, place.astype(np.complex128)


def _slopes(time_s: FloatArray, rho: ComplexArray, used: np.ndarray, first: np.ndarray) -> ComplexArray:
    """Return the slopes (m, K) of lines through the reports that are used (r, K) [m/s]; 0 where they are too few."""
    count = np.add.reduceat(used.astype(np.int64), first)
    length = np.diff(first, append=len(used))
    mean_s = np.add.reduceat(np.where(used, time_s, 0.0), first) / np.maximum(count, 1)
    centred_s = np.where(used, time_s - np.repeat(mean_s, length, axis=0), 0.0)
    begin_s = np.minimum.reduceat(np.where(used, time_s, np.inf), first)
    end_s = np.maximum.reduceat(np.where(used, time_s, -np.inf), first)
    enough = (count >= FEWEST_REPORTS) & (end_s - begin_s >= LEAST_SPAN_S)
    square = np.add.reduceat(centred_s**2, first)
    return np.where(enough, np.add.reduceat(centred_s * rho, first) / np.where(enough, square, 1.0), 0.0)


def bases(alive: np.ndarray, knot_s: FloatArray) -> tuple[FloatArray, np.ndarray, FloatArray]:
    """Return an orthonormal basis over each track's bins (m, s, K): mean, line, the rest.

    Also which rows of it are used (m, s), and the sum of squares of the bins' times about their mean (m,) [s^2].
    """
    tracks, count = alive.shape
    basis, used, spread = np.zeros((tracks, count, count)), np.zeros((tracks, count), dtype=bool), np.zeros(tracks)
    for row in np.unique(alive, axis=0):
        alike, bins = np.flatnonzero((alive == row).all(axis=1)), np.flatnonzero(row)
        after_s = knot_s[bins] - knot_s[bins].mean()
        q, r = np.linalg.qr(np.vander(after_s, len(bins), increasing=True) / 10.0 ** np.arange(len(bins)))
        basis[np.ix_(alike, np.arange(len(bins)), bins)] = (q * np.sign(np.diag(r))).T  # mean and line point forward
        used[alike, : len(bins)] = True
        spread[alike] = (after_s**2).sum()
    return basis, used, spread
