"""Thresholds of squared differences in two dimensions, and what size of an offset they find."""

from __future__ import annotations

import math

_LARGEST = 9999.0  # scipy's search ends at 1e4


def squared_radius(probability: float, dof: float | None) -> float:
    """Return the squared Mahalanobis radius that a right difference passes with ``probability``.

    Chi-square with 2 degrees of freedom: -2 ln p; twice the F quantile with (2, dof): dof (p^(-2/dof) - 1).
    """
    return -2.0 * math.log(probability) if dof is None else dof * math.expm1(-2.0 / dof * math.log(probability))


def noncentrality(threshold: float, dof: float | None, missed: float) -> float:
    """Return the squared offset (in sigmas) that stays below ``threshold`` only with probability ``missed``."""
    from scipy.special import chndtrinc, ncfdtrinc

    if dof is None:
        return float(chndtrinc(threshold, 2.0, missed))
    found = float(ncfdtrinc(2.0, dof, missed, threshold / 2.0))
    return found if found < _LARGEST else math.inf
