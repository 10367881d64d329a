"""Ellipses through points of a hull's outline: least squares with an ellipse as the only outcome, or a known size."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.types import FloatArray

FEWEST_POINTS = 5
LARGEST_STRETCH = 3.0  # an ellipse longer than this times the extent of its points is not held by them
_DISCRIMINANT = np.array([[0.0, 0.0, 2.0], [0.0, -1.0, 0.0], [2.0, 0.0, 0.0]])  # a' K a = 4 A C - B^2


@dataclass(frozen=True, slots=True)
class FittedEllipse:
    """An ellipse in a plane (north, east) [m]; ``azimuth_deg`` of its length, 0 .. 180: either end may be the bow."""

    north_m: float
    east_m: float
    length_m: float
    beam_m: float
    azimuth_deg: float


def fit_ellipse(points_m: FloatArray) -> FittedEllipse | None:
    """Fit an ellipse to points (n, 2) by least squares of its equation; None where they do not hold one.

    The conic A n^2 + B n e + C e^2 + D n + E e + F = 0 with 4 A C - B^2 = 1, eq. (8.4): a condition that only ellipses
    fulfil. The three linear coefficients follow from the quadratic ones (8.5), which leaves an eigenvalue problem of
    three unknowns (8.6). Fewer than five points, points on one line, or an ellipse much longer than the points' extent
    give None.
    """
    if len(points_m) < FEWEST_POINTS or not np.all(np.isfinite(points_m)):
        return None
    middle = points_m.mean(axis=0)
    extent_m = float(np.hypot(*np.ptp(points_m, axis=0)))
    if extent_m <= 0.0:
        return None
    found = _axes(_conics(*((points_m - middle) / extent_m).T))
    if found is None or found.length_m > LARGEST_STRETCH:
        return None
    return FittedEllipse(
        north_m=float(middle[0]) + extent_m * found.north_m,
        east_m=float(middle[1]) + extent_m * found.east_m,
        length_m=extent_m * found.length_m,
        beam_m=extent_m * found.beam_m,
        azimuth_deg=found.azimuth_deg,
    )


def fitted_centres(points_m: FloatArray) -> FloatArray:
    """Return the centres (k, 2) of the ellipses through k sets of points (k, n, 2), NaN where there is none."""
    middle = points_m.mean(axis=(0, 1))
    extent_m = float(np.hypot(*np.ptp(points_m, axis=(0, 1)))) or 1.0
    scaled = (points_m - middle) / extent_m
    A, B, C, D, E, _ = np.moveaxis(_conics(scaled[..., 0], scaled[..., 1]), -1, 0)
    determinant = 4.0 * A * C - B * B
    centre = np.stack([B * E - 2.0 * C * D, B * D - 2.0 * A * E], axis=-1) / determinant[..., None]  # eq. (8.7)
    return np.asarray(middle + extent_m * centre)


def distances_m(points_m: FloatArray, ellipse: FittedEllipse) -> FloatArray:
    """Return the distance [m] of points (n, 2) from an ellipse, to first order: value over slope, eq. (8.8)."""
    scaled = (points_m - [ellipse.north_m, ellipse.east_m]) @ _to_axes(ellipse).T
    radius = np.maximum(np.linalg.norm(scaled, axis=1), 1e-9)
    slope = np.linalg.norm((scaled / radius[:, None]) @ _to_axes(ellipse), axis=1)
    return np.asarray(np.abs(radius - 1.0) / slope)


def fit_known_ellipse(
    points_m: FloatArray, length_m: float, beam_m: float, azimuth_deg: float, *, rounds: int = 20
) -> FittedEllipse:
    """Fit the place of an ellipse of known size and direction to points (n, 2), n >= 1: eq. (8.8) by Gauss-Newton."""
    to_axes = _to_axes(FittedEllipse(0.0, 0.0, length_m, beam_m, azimuth_deg))
    centre = best = points_m.mean(axis=0)
    least = math.inf
    for _ in range(rounds):
        scaled = (points_m - centre) @ to_axes.T
        radius = np.maximum(np.linalg.norm(scaled, axis=1), 1e-9)
        gradient = -(scaled / radius[:, None]) @ to_axes
        slope = np.linalg.norm(gradient, axis=1)  # (radius - 1) / slope is the distance to the ellipse, to first order
        distance_m = (1.0 - radius) / slope
        misfit_m2 = float(distance_m @ distance_m)
        if misfit_m2 < least:
            best, least = centre, misfit_m2
        step = np.linalg.lstsq(gradient / slope[:, None], distance_m, rcond=None)[0]
        size_m = float(np.hypot(*step))
        centre = centre + step * min(1.0, beam_m / max(size_m, 1e-9))  # farther than a beam the slope is another one
        if size_m < 1e-4:
            break
    return FittedEllipse(float(best[0]), float(best[1]), length_m, beam_m, azimuth_deg % 180.0)


def antenna_step(length_m: float, heading_deg: float) -> FloatArray:
    """Return the step (north, east) [m] from a hull's centre to an antenna at the bridge, a quarter of the length aft.

    For ships that do not send where their antenna is; where they do, `navfix.picture.hull.hull_shift` has it.
    """
    heading_rad = math.radians(heading_deg)
    return -length_m / 4.0 * np.array([math.cos(heading_rad), math.sin(heading_rad)])


def _to_axes(ellipse: FittedEllipse) -> FloatArray:
    """Return the matrix that makes a unit circle of an ellipse about the origin."""
    azimuth_rad = math.radians(ellipse.azimuth_deg)
    cos, sin = math.cos(azimuth_rad), math.sin(azimuth_rad)
    return np.array([[cos, sin], [-sin, cos]]) / (np.array([[ellipse.length_m], [ellipse.beam_m]]) / 2.0)


def _conics(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return A .. F (..., 6) of the best ellipse through points (..., n), NaN where there is none."""
    quadratic, linear = np.stack([x * x, x * y, y * y], axis=-1), np.stack([x, y, np.ones_like(x)], axis=-1)
    try:
        to_linear = linear.swapaxes(-1, -2)
        reduction = -np.linalg.solve(to_linear @ linear, to_linear @ quadratic)  # eq. (8.5)
        scatter = quadratic.swapaxes(-1, -2) @ (quadratic + linear @ reduction)
        _, vectors = np.linalg.eig(np.linalg.solve(_DISCRIMINANT, scatter))  # eq. (8.6)
    except np.linalg.LinAlgError:
        return np.full((*x.shape[:-1], 6), np.nan)
    vectors = vectors.real
    ellipses = np.einsum("...ik,ij,...jk->...k", vectors, _DISCRIMINANT, vectors) > 1e-12
    which = np.argmax(ellipses, axis=-1)[..., None, None]
    a = np.take_along_axis(vectors, which, axis=-1)
    conic = np.concatenate([a, reduction @ a], axis=-2)[..., 0]
    return np.where(ellipses.any(axis=-1)[..., None], conic, np.nan)


def _axes(conic: FloatArray) -> FittedEllipse | None:
    """Return centre, axes and direction of a conic, None where it is no real ellipse: eq. (8.7)."""
    if not np.all(np.isfinite(conic)):
        return None
    A, B, C, D, E, F = conic.tolist()
    matrix = np.array([[A, B / 2.0], [B / 2.0, C]])
    centre = np.linalg.solve(matrix, [-D / 2.0, -E / 2.0])
    value = F + (D * centre[0] + E * centre[1]) / 2.0
    roots, directions = np.linalg.eigh(matrix)
    squares = -value / roots
    if not np.all(np.isfinite(squares)) or np.any(squares <= 0.0):
        return None
    long = int(np.argmax(squares))
    azimuth_deg = math.degrees(math.atan2(directions[1, long], directions[0, long])) % 180.0
    semi = np.sqrt(squares)
    return FittedEllipse(
        float(centre[0]), float(centre[1]), 2.0 * float(semi[long]), 2.0 * float(semi[1 - long]), azimuth_deg
    )
