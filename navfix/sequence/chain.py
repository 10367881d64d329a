"""Fixes that one ship can have made: the longest chain without a step that no ship can take."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from navfix.catalog import OwnMotionModel
from navfix.geodesy import cloud_to_plane
from navfix.types import Fix, FloatArray, Position


def consistent(fixes: Sequence[Fix | None], time_s: FloatArray, motion: OwnMotionModel) -> list[int]:
    """Return the indices of the fixes of the longest chain in which each can be reached from the one before.

    Two fixes are joined when they lie no farther apart than the fastest ship goes in the time between them, with some
    sigmas of both and a slack. A chain counts its pairs, so that a few full scans outweigh many with two pairs.
    """
    index = [i for i, fix in enumerate(fixes) if fix is not None and isinstance(fix.position, Position)]
    if not index:
        return []
    chosen = [fix for i in index if (fix := fixes[i]) is not None]
    places = [fix.position for fix in chosen if isinstance(fix.position, Position)]
    plane = cloud_to_plane(
        places[len(places) // 2], np.array([p.lat_deg for p in places]), np.array([p.lon_deg for p in places])
    )
    sigma = np.array([np.sqrt(np.linalg.eigvalsh(fix.covariance[:2, :2])[-1]) for fix in chosen])
    count = np.array([max(len(fix.association.pairs), 1) if fix.association else 1 for fix in chosen], float)
    best, before = count.copy(), np.full(len(index), -1)
    for i in range(1, len(index)):
        apart_m = np.hypot(*(plane[:i] - plane[i]).T)
        elapsed_s = time_s[index[i]] - time_s[np.array(index[:i])]
        reach_m = motion.fastest_mps * elapsed_s + motion.chain_sigma * np.hypot(sigma[:i], sigma[i]) + motion.chain_m
        reachable = apart_m <= reach_m
        if np.any(reachable):
            value = np.where(reachable, best[:i], -np.inf)
            before[i] = int(np.argmax(value))
            best[i] += best[before[i]]
    chain, at = [], int(np.argmax(best))
    while at >= 0:
        chain.append(index[at])
        at = int(before[at])
    return chain[::-1]
