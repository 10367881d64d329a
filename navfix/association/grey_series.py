"""Series for the grey association: how far one grey model holds, and its values between the points.

References
----------
[1] Dong, AARFS system level design (2008), eq. 1.3 to 1.17.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from navfix.types import FloatArray


def section_length(series: Sequence[FloatArray], least: int) -> int:
    """Return how many of the first points one grey model holds for: the largest n within [1] eq. (1.17).

    All class ratios x(k - 1) / x(k) of every series must lie within exp(-2 / (n + 1)) .. exp(2 / (n + 1)). Never below
    ``least`` where there are so many points: shorter series have no model.
    """
    count = min(len(values) for values in series)
    for n in range(count, least, -1):
        width = 2.0 / (n + 1)
        if all(_ratios_within(values[:n], width) for values in series):
            return n
    return min(least, count)


def _ratios_within(values: FloatArray, width: float) -> bool:
    if (values <= 0.0).any():
        return False
    return bool((np.abs(np.log(values[:-1] / values[1:])) < width).all())


def grey_parameters(values: FloatArray) -> tuple[float, float]:
    """Return a and b of x0(k) + a z1(k) = b by least squares, closed form, [1] eq. (1.11) and (1.12)."""
    total = np.cumsum(values)
    z, x = 0.5 * (total[1:] + total[:-1]), values[1:]
    C, D, E, F, n = z.sum(), x.sum(), (z * x).sum(), (z * z).sum(), len(x)
    determinant = n * F - C * C
    if n < 2 or determinant <= 1e-12 * n * F:
        return 0.0, float(x.mean()) if n else float(values[0])
    return float((C * D - n * E) / determinant), float((D * F - C * E) / determinant)


def grey_values(values: FloatArray, steps: ArrayLike) -> FloatArray:
    """Return the series at ``steps`` (0: its first point, whole or not) by its grey model, [1] eq. (1.15) and (1.16).

    A constant series has a = 0 and b / a without bound: then the limit is taken, x1(k) = x(1) + b k. Before step 1 the
    difference of (1.16) would reach before the series: a straight line joins the first point and the model.
    """
    a, b = grey_parameters(values)
    k = np.asarray(steps, dtype=np.float64)
    later = np.maximum(k, 1.0)
    one_step = 1.0 if abs(a) < 1e-12 else -math.expm1(-a) / a
    found = (b - a * values[0]) * np.exp(-a * (later - 1.0)) * one_step
    result: FloatArray = np.where(k < 1.0, values[0] + (found - values[0]) * k, found)
    return result
