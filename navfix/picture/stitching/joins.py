"""Segments that are one echo: an end and a beginning that one motion joins, better than chance and than any other."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from navfix.catalog import StitchingModel
from navfix.picture.stitching.sightings import Sightings, Tracked
from navfix.picture.tracking.filter import carried
from navfix.types import FloatArray, IntArray

_NEVER = 1e6


def find_joins(
    seen: Sightings,
    tracked: Tracked,
    back: tuple[FloatArray, FloatArray],
    segment: IntArray,
    model: StitchingModel,
    *,
    taken: Iterable[tuple[int, int]] = (),
) -> list[tuple[int, int]]:
    """Return pairs of segments (earlier, later) that are one echo; ``taken`` pairs are so already.

    The log odds of eq. (11.8) must pass ``join_log_odds``, and no other end or beginning may come within ``join_lead``.
    """
    odds = _log_odds(seen, tracked, back, segment, (_ends(segment), _starts(segment)), model)
    busy, pairs = list(taken), list[tuple[int, int]]()
    while True:  # a rival that is joined elsewhere is none any more
        odds[[earlier for earlier, _ in busy], :] = -_NEVER
        odds[:, [later for _, later in busy]] = -_NEVER
        busy = _clear_joins(odds, model)
        if not busy:
            return pairs
        pairs += busy


def _clear_joins(odds: FloatArray, model: StitchingModel) -> list[tuple[int, int]]:
    """Return the pairs of the best one-to-one assignment that are likely enough and clearly ahead."""
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(-np.maximum(odds, 0.0))
    pairs = []
    for row, column in zip(rows, columns, strict=True):
        value = odds[row, column]
        rivals = np.concatenate([np.delete(odds[row], column), np.delete(odds[:, column], row)])
        if value >= model.join_log_odds and value - rivals.max(initial=-_NEVER) >= model.join_lead:
            pairs.append((int(row), int(column)))
    return pairs


def _ends(segment: IntArray) -> IntArray:
    last = np.zeros(int(segment.max(initial=-1)) + 1, dtype=np.intp)
    last[segment] = np.arange(len(segment))
    return last


def _starts(segment: IntArray) -> IntArray:
    first = np.zeros(int(segment.max(initial=-1)) + 1, dtype=np.intp)
    first[segment[::-1]] = np.arange(len(segment))[::-1]
    return first


def _log_odds(
    seen: Sightings,
    tracked: Tracked,
    back: tuple[FloatArray, FloatArray],
    segment: IntArray,
    borders: tuple[IntArray, IntArray],
    model: StitchingModel,
) -> FloatArray:
    """Return the log odds (s, s) that a later segment goes on with an earlier one, -1e6 where it cannot."""
    ends, starts = borders
    gap_s = seen.time_s[starts][None, :] - seen.time_s[ends][:, None]
    sightings = np.bincount(segment, minlength=len(ends))
    enough = sightings >= model.least_sightings
    possible = (gap_s > 0.0) & (gap_s <= model.longest_join_s) & enough[:, None] & enough[None, :]
    odds = np.full(gap_s.shape, -_NEVER)
    row, column = np.nonzero(possible)
    if not len(row):
        return odds
    mean, covariance = carried(
        tracked.mean[ends[row]], tracked.covariance[ends[row]], gap_s[row, column], model.relative_acceleration_mps2
    )
    miss, total = back[0][starts[column]] - mean, covariance + back[1][starts[column]]
    chi2 = np.einsum("ni,ni->n", miss, np.linalg.solve(total, miss[..., None])[..., 0])
    log_density = -0.5 * (chi2 + np.linalg.slogdet(total)[1]) - 2.0 * math.log(2.0 * math.pi)
    by_chance = _log_density_by_chance(seen, back[0][starts[column]], starts, gap_s[row, column], model)
    odds[row, column] = np.where(chi2 <= model.join_chi2, log_density - by_chance, -_NEVER)
    return odds


def _log_density_by_chance(
    seen: Sightings, begun: FloatArray, starts: IntArray, gap_s: FloatArray, model: StitchingModel
) -> FloatArray:
    """Return the log density [1/(m2 (m/s)2)] of new echoes that begin within the gap, there and with that velocity."""
    lasted_s = max(float(np.ptp(seen.time_s)), 1.0)
    area_m2 = math.pi * max(float(np.percentile(seen.range_m, 95.0)), 1000.0) ** 2
    expected = np.maximum(len(starts) * np.minimum(gap_s / lasted_s, 1.0), 1.0)
    speed2 = np.sum(begun[:, 2:] ** 2, axis=1)
    variance = model.clutter_speed_mps**2
    velocity = -0.5 * speed2 / variance - math.log(2.0 * math.pi * variance)
    result: FloatArray = np.log(expected / area_m2) + velocity
    return result
