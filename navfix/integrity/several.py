"""Several marks wrong at once: the sets of marks that a level must hold against where the residuals are suspicious."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from navfix.adjustment.reliability import global_test
from navfix.integrity.separation import Blocks, BoolArray, Separation, separate
from navfix.types import IntArray

_AMONG = {2: 63, 3: 22}  # size of a set: from so many marks, those that the fix rests on most; some 2000 sets of each


def suspicious(sigma0: float, dof: float) -> bool:
    """Tell whether the residuals are larger than chance explains (global test, 5 %).

    Then the sigmas are too small, or the fix rests on marks that agree on a wrong place: in a narrow sector three
    marks shifted alike across the line of sight turn the heading until nearly all marks fit.
    """
    test = global_test(sigma0**2 * dof, dof)
    return test is not None and not test.passed


def without_several(blocks: Blocks) -> Separation:
    """Leave out every set of two or three marks; sets without which nothing determines the fix are passed over.

    Of many marks those are combined without which the position is least sure: 63 to pairs, 22 to threes.
    """
    alone = separate(blocks)
    unsure = np.where(alone.determined, np.trace(alone.without[:, :2, :2], axis1=1, axis2=2), np.inf)
    found = separate(blocks, _sets(np.argsort(-unsure, kind="stable")))
    fine = found.determined
    return Separation(found.cofactor, found.without[fine], found.shift[fine], found.determined[fine])


def _sets(order: IntArray) -> BoolArray:
    """Return one row (h, g) for each set of two or three of g marks, given their numbers in ``order`` of weight."""
    rows = []
    for size, among in _AMONG.items():
        members = np.array(list(combinations(order[:among].tolist(), size)), np.int64).reshape(-1, size)
        row = np.zeros((len(members), len(order)), bool)
        np.put_along_axis(row, members, True, axis=1)
        rows.append(row)
    return np.concatenate(rows)
