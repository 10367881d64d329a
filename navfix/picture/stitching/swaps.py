"""Two numbers that change over while their echoes pass: found by the motions before and after."""

from __future__ import annotations

import numpy as np

from navfix.catalog import StitchingModel
from navfix.picture.stitching.sightings import Sightings, Tracked
from navfix.picture.tracking.filter import carried
from navfix.types import FloatArray, IntArray

_NEAR_SIGMA = 6.0
_MARGIN = 3  # sightings on each side of the change that are looked at once more
Swap = tuple[int, int, int, int]  # last sightings before, of the one and the other, and first sightings after


def find_swaps(
    seen: Sightings, tracked: Tracked, back: tuple[FloatArray, FloatArray], model: StitchingModel
) -> list[Swap]:
    """Return the swaps of segments that pass each other, eq. (11.9).

    Of each pair that comes near, the scan is looked for at which "they have changed over" is most ahead of "they have
    not", both judged by position and velocity of a filter that runs up to it and of one that runs back to it.
    """
    found = []
    for one, other in sorted(_passing(seen, tracked)):
        first, second = np.flatnonzero(tracked.segment == one), np.flatnonzero(tracked.segment == other)
        _, a, b = np.intersect1d(seen.scan[first], seen.scan[second], assume_unique=True, return_indices=True)
        swap = _best(seen, tracked, back, (first[a], second[b]), model)
        if swap is not None:
            found.append(swap)
    return found


def _passing(seen: Sightings, tracked: Tracked) -> set[tuple[int, int]]:
    """Return the pairs of segments that come near each other in any scan."""
    noise_m2 = np.trace(tracked.spread, axis1=1, axis2=2) / 2.0
    near: set[tuple[int, int]] = set()
    for rows in seen.scans():
        apart_m2 = np.sum((tracked.position[rows][:, None] - tracked.position[rows][None, :]) ** 2, axis=2)
        close = apart_m2 <= _NEAR_SIGMA**2 * (noise_m2[rows][:, None] + noise_m2[rows][None, :])
        for i, j in np.argwhere(np.triu(close, 1)):
            one, other = sorted((int(tracked.segment[rows[i]]), int(tracked.segment[rows[j]])))
            near.add((one, other))
    return near


def _best(
    seen: Sightings,
    tracked: Tracked,
    back: tuple[FloatArray, FloatArray],
    pair: tuple[IntArray, IntArray],
    model: StitchingModel,
) -> Swap | None:
    """Return the best swap of two segments over their common scans, None where none is ahead."""
    a, b = pair
    gap_m = np.hypot(*(tracked.position[a] - tracked.position[b]).T)
    reach_m = _NEAR_SIGMA * np.sqrt(np.trace(tracked.spread[a] + tracked.spread[b], axis1=1, axis2=2) / 2.0)
    guard = model.swap_guard
    cuts = np.arange(model.least_sightings - 1, len(a) - model.least_sightings - guard)
    cuts = cuts[(gap_m <= reach_m)[cuts]] if len(cuts) else cuts
    if not len(cuts):
        return None
    after = cuts + 1 + guard  # sightings right at the change belong to neither motion
    stay = _mismatch(seen, tracked, back, a[cuts], a[after], model) + _mismatch(
        seen, tracked, back, b[cuts], b[after], model
    )
    change = _mismatch(seen, tracked, back, a[cuts], b[after], model) + _mismatch(
        seen, tracked, back, b[cuts], a[after], model
    )
    best = int(np.argmax(stay - change))
    if stay[best] - change[best] < model.swap_lead or change[best] > model.swap_chi2:
        return None
    low = max(int(cuts[best]) - _MARGIN, 0)
    high = min(int(after[best]) + _MARGIN, len(a) - 1)
    change_at = _change_scan(seen, tracked, back, (a[low : high + 1], b[low : high + 1]), model) + low
    return int(a[change_at - 1]), int(b[change_at - 1]), int(a[change_at]), int(b[change_at])


def _change_scan(
    seen: Sightings,
    tracked: Tracked,
    back: tuple[FloatArray, FloatArray],
    pair: tuple[IntArray, IntArray],
    model: StitchingModel,
) -> int:
    """Return from which scan on the sightings of a pair fit the other motion better.

    One motion leads from the first sighting of the one number to the last of the other, the second the other way.
    """
    a, b = pair
    inside = slice(1, -1)
    before, afterwards = np.zeros(len(a) - 2), np.zeros(len(a) - 2)
    for rows, others in ((a, b), (b, a)):
        for state, mine, theirs in (
            ((tracked.mean[rows[0]], tracked.covariance[rows[0]], seen.time_s[rows[0]]), rows, others),
            ((back[0][others[-1]], back[1][others[-1]], seen.time_s[others[-1]]), rows, others),
        ):
            before += _off(seen, tracked, state, mine[inside], model)
            afterwards += _off(seen, tracked, state, theirs[inside], model)
    total = np.concatenate([[0.0], np.cumsum(before)]) + np.concatenate([np.cumsum(afterwards[::-1])[::-1], [0.0]])
    return int(np.argmin(total)) + 1


def _off(
    seen: Sightings,
    tracked: Tracked,
    state: tuple[FloatArray, FloatArray, float],
    rows: IntArray,
    model: StitchingModel,
) -> FloatArray:
    """Return the chi-square (2 degrees of freedom) of sightings against one state carried to their times."""
    shape = (len(rows), 4)
    mean, covariance = carried(
        np.broadcast_to(state[0], shape),
        np.broadcast_to(state[1], (*shape, 4)),
        seen.time_s[rows] - state[2],
        model.relative_acceleration_mps2,
    )
    miss = tracked.position[rows] - mean[:, :2]
    total = covariance[:, :2, :2] + tracked.spread[rows]
    chi2: FloatArray = np.einsum("ni,ni->n", miss, np.linalg.solve(total, miss[..., None])[..., 0])
    return chi2


def _mismatch(
    seen: Sightings,
    tracked: Tracked,
    back: tuple[FloatArray, FloatArray],
    before: IntArray,
    after: IntArray,
    model: StitchingModel,
) -> FloatArray:
    """Return the chi-square (4 degrees of freedom) between the state up to ``before`` and the one back to ``after``."""
    dt_s = seen.time_s[after] - seen.time_s[before]
    mean, covariance = carried(tracked.mean[before], tracked.covariance[before], dt_s, model.relative_acceleration_mps2)
    miss = back[0][after] - mean
    total = covariance + back[1][after]
    chi2: FloatArray = np.einsum("ni,ni->n", miss, np.linalg.solve(total, miss[..., None])[..., 0])
    return chi2
