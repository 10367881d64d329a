"""Tracks laid over the paths of the marks: how well each track fits each mark near it, and how well it fits clutter.

A track is judged in its own basis (mean, line, scatter). On a mark: normal with the variances of track and mark
together. As clutter: any place (the local density), a mixture of still and moving over ground for the line, and the
same scatter about it. Whatever own motion explains badly makes both small, so own motion is a part of the evidence
too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.association.scene import BoolArray, ComplexArray
from navfix.association.window.field import LINE, LOG_2PI, MEAN, SCATTER, WindowField
from navfix.association.window.knots import Knots
from navfix.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Fit:
    """k motions, m tracks, q neighbours, s basis vectors, 2 axes (radial, tangential at the track's middle).

    ``mark`` (k, m, q); ``misfit`` (k, m, q, s, 2) mark minus track; ``variance_m2`` (k, m, q, 3, 2) of mean, line and
    scatter, ``log_det`` (k, m, q, 3) ln of their products over both axes; ``rate`` (k, m, q, s, 2) velocity of the
    mark: what a second of clock does; ``path`` (k, m, s, 2) minus the track's own way over ground; ``axis`` (k, m)
    complex; ``barred`` (k, m) which tracks are no mark, None: any may be.
    """

    mark: IntArray
    misfit: FloatArray
    variance_m2: FloatArray
    log_det: FloatArray
    rate: FloatArray
    path: FloatArray
    axis: ComplexArray
    barred: BoolArray | None = None

    @property
    def distance_sq(self) -> FloatArray:
        """Squared Mahalanobis distance (k, m, q) of the means."""
        return over_axes(self.misfit[..., MEAN, :] ** 2 / self.variance_m2[..., MEAN, :])


def lay_over(field: WindowField, knots: Knots) -> Fit:
    """Place the tracks by k own motions and measure their misfit to the marks nearest at their middle."""
    mark, (path, axis) = near_middle(field, knots), paths_over_ground(field, knots)
    back = np.conj(axis)[:, :, None, None]
    z, v = (_in_basis(field.scene.basis, way, mark) for way in (field.scene.paths.z, field.scene.paths.v))
    misfit = by_axis((z + v * knots.clock_s[:, None, None, None]) * back) + path[:, :, None]
    on = (np.arange(mark.shape[1])[None, :, None], mark)
    return Fit(mark, misfit, field.variance_m2[on], field.log_det[on], by_axis(v * back), path, axis, knots.barred)


def paths_over_ground(field: WindowField, knots: Knots) -> tuple[FloatArray, ComplexArray]:
    """Return minus the way over ground (k, m, s, 2) of all tracks at k own motions, and their axes (k, m)."""
    turn = np.exp(1j * knots.heading_rad)
    axis = axes(field, turn)
    by_place, by_turn = field.by_coordinate
    world = (knots.p @ by_place + turn @ by_turn).reshape(*axis.shape, -1)  # (k, m, s)
    return by_axis(-world * np.conj(axis)[:, :, None]), axis


def axes(field: WindowField, turn: ComplexArray) -> ComplexArray:
    """Return the directions (k, m) in which the tracks are seen in the middle of their lives."""
    sight = turn[:, field.scene.middle_bin] * field.middle_rho
    direction: ComplexArray = sight / np.maximum(np.abs(sight), 1e-9)
    return direction


def near_middle(field: WindowField, knots: Knots) -> IntArray:
    """Return the marks (k, m, q) nearest to every track in the middle of its life."""
    middle = field.scene.middle_bin
    at = knots.p[:, middle] + np.exp(1j * knots.heading_rad[:, middle]) * field.middle_rho
    mark = np.empty((*at.shape, field.neighbours), dtype=np.int64)
    for knot in np.unique(middle):
        rows = np.flatnonzero(middle == knot)
        _, near = field.trees[knot].query(by_axis(at[:, rows]), k=field.neighbours)
        mark[:, rows] = near.reshape(len(at), len(rows), field.neighbours)
    return mark


def by_axis(values: ComplexArray) -> FloatArray:
    """Return complex values (...) as coordinates (..., 2)."""
    return np.ascontiguousarray(values).view(np.float64).reshape(*values.shape, 2)


def over_axes(values: FloatArray) -> FloatArray:
    """Return the sum (...) over both axes of values (..., 2): over so short an axis numpy's own takes its time."""
    total: FloatArray = values[..., 0] + values[..., 1]
    return total


def _in_basis(basis: FloatArray, path: ComplexArray, mark: IntArray) -> ComplexArray:
    """Return the paths (n, K) of the marks (k, m, q) near each track in the track's own basis: (k, m, q, s)."""
    count, tracks, neighbours = mark.shape
    of_track = path[mark.swapaxes(0, 1)].reshape(tracks, count * neighbours, path.shape[1])
    return (of_track @ basis.swapaxes(1, 2)).reshape(tracks, count, neighbours, basis.shape[1]).swapaxes(0, 1)


@dataclass(frozen=True, eq=False)
class Clutter:
    """Tracks as clutter at k motions.

    ``log_density`` (k, m) of line and scatter; ``kind`` (3, k, m) shares that stand, move and jump; ``scatter_weight``
    (k, m) of the robust scatter.
    """

    log_density: FloatArray
    kind: FloatArray
    scatter_weight: FloatArray


def as_clutter(field: WindowField, path: FloatArray) -> Clutter:
    """Return how well every track's own way over ground (k, m, s, 2) fits an echo that is no mark."""
    scene = field.scene
    log_scatter, weight = _scatter(field, path, scene.white_m2, over_axes(np.log(scene.white_m2)), field.scatters)
    if scene.knots == 1:
        return Clutter(log_scatter, np.zeros((3, *log_scatter.shape)), weight)
    by_kind = np.log(field.line_share)[:, None, None] + log_normal(path[None, ..., LINE, :], field.line_m2[:, None])
    log_line = np.where(field.has_line[None], np.logaddexp.reduce(by_kind, axis=0), 0.0)
    kind = np.where(field.has_line[None, None], np.exp(by_kind - log_line[None]), 0.0)
    return Clutter(log_line + log_scatter, kind, weight)


def log_fit(field: WindowField, fit: Fit, widening: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return ln density (k, m, q) of every track on its marks, its mean per m^2, and the weight of its scatter."""
    scene = field.scene
    kinds = min(scene.knots, SCATTER)
    square = over_axes(fit.misfit[..., :kinds, :] ** 2 / fit.variance_m2[..., :kinds, :]) / widening**2
    normal = -0.5 * (square + fit.log_det[..., :kinds]) - LOG_2PI - 2.0 * np.log(widening)
    mean = normal[..., MEAN] + np.log(scene.bins)[None, :, None]
    if scene.knots == 1:
        return mean, np.zeros_like(mean)
    line, variance = normal[..., LINE], fit.variance_m2[..., SCATTER, :]
    log_scatter, weight = _scatter(field, fit.misfit, variance, fit.log_det[..., SCATTER], field.scatters[:, None])
    return mean + np.where(field.has_line[None, :, None], line, 0.0) + log_scatter, weight


def _scatter(
    field: WindowField, coordinates: FloatArray, variance: FloatArray, log_det: FloatArray, count: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return ln density of the scatter (a t distribution: tracks swap and turn) and its weight in the adjustment.

    ``coordinates`` (..., s, 2) in a track's basis, ``variance`` (..., 2), ``log_det`` (...) ln of its product over both
    axes, ``count`` (...) how many of them are scatter.
    """
    nu = field.model.scatter_dof
    scattered = coordinates[..., SCATTER:, :]
    square = over_axes(np.einsum("...sa,...sa->...a", scattered, scattered) / variance)
    log_density = -0.5 * (nu + count) * np.log1p(square / nu) - 0.25 * count * log_det
    return log_density, (nu + count) / (nu + square)


def log_normal(offset: FloatArray, variance: FloatArray) -> FloatArray:
    """Return ln of the normal density (...) of offsets (..., 2) with variances (..., 2)."""
    log_density: FloatArray = -0.5 * over_axes(offset**2 / variance + np.log(variance)) - LOG_2PI
    return log_density
