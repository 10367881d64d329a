"""Several marks wrong at once: the sets of marks that a level must hold against where the residuals are suspicious."""

from __future__ import annotations

from itertools import combinations
from math import comb

import numpy as np

from navfix.adjustment.reliability import global_test
from navfix.integrity.separation import Blocks, BoolArray, Separation, separate

_MOST = 3  # marks that may be wrong together: of eight, 40 %
_SETS = 2000  # not more than so many hypotheses


def suspicious(sigma0: float, dof: float) -> bool:
    """Tell whether the residuals are larger than chance explains (global test, 5 %).

    Then the sigmas are too small, or the fix rests on marks that agree on a wrong place: in a narrow sector three
    marks shifted alike across the line of sight turn the heading until nearly all marks fit.
    """
    test = global_test(sigma0**2 * dof, dof)
    return test is not None and not test.passed


def without_several(blocks: Blocks) -> Separation:
    """Leave out every set of two or three marks; sets without which nothing determines the fix are passed over."""
    found = separate(blocks, _sets(len(blocks.labels)))
    fine = found.determined
    return Separation(found.cofactor, found.without[fine], found.shift[fine], found.determined[fine])


def _sets(count: int) -> BoolArray:
    """Return one row for each set of two to three of ``count`` marks, as many sizes as the number allows."""
    sizes = [size for size in range(2, _MOST + 1) if sum(comb(count, k) for k in range(2, size + 1)) <= _SETS]
    chosen = [members for size in sizes for members in combinations(range(count), size)]
    result = np.zeros((len(chosen), count), bool)
    for row, members in enumerate(chosen):
        result[row, list(members)] = True
    return result
