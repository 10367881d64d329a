"""Scaled unscented transform: mean and covariance of a function of a Gaussian vector, from 2 n + 1 points.

References
----------
[1] Julier, Uhlmann (1996); scaled form with alpha, beta, kappa as in the paper on AIS tracks, 2.2.3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from navfix.types import FloatArray


@dataclass(frozen=True, slots=True)
class Scaling:
    """``alpha`` spreads the points, ``beta`` = 2 is best for a Gaussian, ``kappa`` scales once more."""

    alpha: float = 1.0
    beta: float = 2.0
    kappa: float = 0.0

    def weights(self, n: int) -> tuple[FloatArray, FloatArray]:
        """Return the weights (2 n + 1) of mean and covariance; with alpha 0.01 the centre has -9999 for every n."""
        spread = self.spread(n)
        mean = np.full(2 * n + 1, 0.5 / spread)
        mean[0] = 1.0 - n / spread
        covariance = mean.copy()
        covariance[0] += 1.0 - self.alpha**2 + self.beta
        return mean, covariance

    def spread(self, n: int) -> float:
        """Return n + lambda = alpha^2 (n + kappa)."""
        return self.alpha**2 * (n + self.kappa)


@dataclass(frozen=True, slots=True, eq=False)
class Transformed:
    """Mean (m,), covariance (m, m) and cross covariance (n, m) with the argument."""

    mean: FloatArray
    covariance: FloatArray
    cross: FloatArray


def points(mean: FloatArray, covariance: FloatArray, spread: float) -> FloatArray:
    """Return the 2 n + 1 points, shape (2 n + 1, n): the mean first, then one on each side along each column.

    The root is taken by eigenvectors, as the source does: it exists for a singular covariance too.
    """
    value, vector = np.linalg.eigh(covariance)
    root = vector * np.sqrt(spread * np.maximum(value, 0.0))
    return np.vstack([mean, mean + root.T, mean - root.T])


def transform(
    mean: FloatArray, covariance: FloatArray, function: Callable[[FloatArray], FloatArray], scaling: Scaling
) -> Transformed:
    """Return the moments of ``function``, which takes points (k, n) to (k, m).

    With d_i = y_i - y_0 the printed sums become mean = y_0 + m, covariance = sum w d d' + (beta - alpha^2) m m' with
    m = sum w d, the centre left out: nothing large cancels, so that a tiny alpha does no harm (theory, eq. 13.9).
    """
    scales = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    argument = points(np.zeros_like(mean), covariance / np.outer(scales, scales), scaling.spread(len(mean))) * scales
    result = function(mean + argument)
    weight = 0.5 / scaling.spread(len(mean))
    d = result[1:] - result[0]
    m = weight * d.sum(axis=0)
    spread = weight * d.T @ d + (scaling.beta - scaling.alpha**2) * np.outer(m, m)
    return Transformed(result[0] + m, spread, weight * argument[1:].T @ d)


def transform_as_printed(
    mean: FloatArray, covariance: FloatArray, function: Callable[[FloatArray], FloatArray], scaling: Scaling
) -> Transformed:
    """Return the same moments by the sums with the centre's weight, as the source prints them."""
    weight_m, weight_c = scaling.weights(len(mean))
    argument = points(mean, covariance, scaling.spread(len(mean)))
    result = function(argument)
    centre = weight_m @ result
    off, result_off = argument - mean, result - centre
    return Transformed(
        centre, (weight_c[:, None] * result_off).T @ result_off, (weight_c[:, None] * off).T @ result_off
    )
