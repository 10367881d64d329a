"""Rigid Coherent Point Drift as published, without scale: Myronenko & Song (2010), "Point Set Registration", section 4.

In the plane a point is a complex number and a rotation a unit number, so the M-step needs no singular values and cannot
reflect: the best rotation is a / |a| with a = sum P_mn conj(y_m - mu_y) (x_n - mu_x).

Alone it finds the nearest local optimum: seeds (`navfix.association.seeds`) or many starts must bring it near. The
Knopp thesis (2.2.4, 4.2.3) starts it eight times, 45 degrees apart, and keeps the least error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.association.scene import ComplexArray
from navfix.types import FloatArray

STARTS = 8


@dataclass(frozen=True, eq=False)
class Registration:
    """A rigid registration x ~ rotation * y + translation.

    ``correspondence`` (m, n): P(y_m generated x_n); ``sigma_m``: the common standard deviation at the end [m].
    """

    rotation: complex
    translation: complex
    sigma_m: float
    correspondence: FloatArray
    iterations: int


def register(
    x: ComplexArray,
    y: ComplexArray,
    *,
    outlier_share: float = 0.1,
    start_rotation: complex = 1.0 + 0.0j,
    tolerance: float = 1e-5,
    most_iterations: int = 200,
) -> Registration:
    """Register the centroids ``y`` (m,) onto the data ``x`` (n,), both complex [m].

    Parameters
    ----------
    outlier_share : w, the share of data that no centroid generated, 0 <= w < 1
    start_rotation : unit complex number that y is turned by at the start
    tolerance : stop when no centroid moves by more in one step, in units of the spread of x

    Both clouds are measured in the spread of x: the published outlier term is 1/N for any area, and so has a meaning
    only for data of unit variance.
    """
    unit_m, middle = float(np.sqrt(np.mean(np.abs(x - x.mean()) ** 2))), complex(x.mean())
    data, centroids = (x - middle) / unit_m, (y - y.mean()) / unit_m
    moved = centroids * start_rotation / abs(start_rotation)
    rotation = start_rotation / abs(start_rotation)
    translation = 0.0 + 0.0j
    sigma_sq = float(np.mean(np.abs(data[None, :] - moved[:, None]) ** 2)) / 2.0  # Fig. 2, initialisation
    correspondence = np.zeros((len(y), len(x)))
    iterations, step = 0, np.inf
    while iterations < most_iterations and step > tolerance:
        correspondence = expectation(data, moved, sigma_sq, outlier_share)
        rotation, translation, sigma_sq = maximisation(data, centroids, correspondence)
        step = float(np.abs(rotation * centroids + translation - moved).max())
        moved = rotation * centroids + translation
        iterations += 1
    shift = complex(middle + unit_m * translation - rotation * y.mean())
    return Registration(rotation, shift, float(np.sqrt(sigma_sq)) * unit_m, correspondence, iterations)


def expectation(x: ComplexArray, moved: ComplexArray, sigma_sq: float, outlier_share: float) -> FloatArray:
    """E-step: P (m, n), eq. (6) of Myronenko & Song with D = 2."""
    gauss = np.exp(-0.5 * np.abs(x[None, :] - moved[:, None]) ** 2 / sigma_sq)
    outlier = 2.0 * np.pi * sigma_sq * outlier_share / (1.0 - outlier_share) * len(moved) / len(x)
    total: FloatArray = gauss / np.maximum(gauss.sum(axis=0, keepdims=True) + outlier, 1e-300)
    return total


def maximisation(x: ComplexArray, y: ComplexArray, correspondence: FloatArray) -> tuple[complex, complex, float]:
    """M-step: rotation, translation and sigma^2 of Fig. 2 (rigid) of Myronenko & Song, with the scale held at 1."""
    by_x, by_y = correspondence.sum(axis=0), correspondence.sum(axis=1)
    total = max(float(by_x.sum()), 1e-300)
    mu_x, mu_y = complex(by_x @ x) / total, complex(by_y @ y) / total
    x_hat, y_hat = x - mu_x, y - mu_y
    a = complex(np.conj(y_hat) @ correspondence @ x_hat)
    rotation = a / abs(a) if abs(a) > 0.0 else 1.0 + 0.0j
    spread = float(by_x @ np.abs(x_hat) ** 2 + by_y @ np.abs(y_hat) ** 2)
    sigma_sq = max((spread - 2.0 * abs(a)) / (2.0 * total), 1e-12)
    return rotation, mu_x - rotation * mu_y, sigma_sq


def register_from_all_sides(
    x: ComplexArray, y: ComplexArray, *, outlier_share: float = 0.1, starts: int = STARTS
) -> tuple[Registration, NDArray[np.float64]]:
    """Register from ``starts`` rotations of y and keep the least sigma; return it and the sigma of every start (s,)."""
    turns = np.exp(2j * np.pi * np.arange(starts) / starts)
    tried = [register(x, y, outlier_share=outlier_share, start_rotation=turn) for turn in turns]
    sigma_m = np.array([found.sigma_m for found in tried])
    return tried[int(np.argmin(sigma_m))], sigma_m
