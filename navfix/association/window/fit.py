"""Tracks laid over the paths of the marks: how well each track fits each mark near it, and how well it fits clutter.

A track is judged in its own basis (mean, line, scatter). On a mark: normal with the variances of track and mark
together. As clutter: any place (the local density), a mixture of still and moving over ground for the line, and the
same scatter about it. Whatever own motion explains badly makes both small, so own motion is a part of the evidence
too.
"""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from navfix.association.em import Field
from navfix.association.scene import ComplexArray
from navfix.association.window.knots import Knots
from navfix.association.window.scene import WindowScene
from navfix.catalog import AssociationModel, WindowModel
from navfix.types import FloatArray, IntArray

LOG_2PI = float(np.log(2.0 * np.pi))


class WindowField:
    """What every own motion in one window is tried against."""

    def __init__(self, scene: WindowScene, model: WindowModel, shared: AssociationModel) -> None:
        self.scene, self.model, self.shared = scene, model, shared
        self.flat = Field(scene.flat, shared)
        self.neighbours = min(model.neighbours, len(scene.paths.marks))
        scatter = scene.used.copy()
        scatter[:, :2] = False
        self.scatter = scatter
        self.has_line = scene.used[:, 1] if scene.knots > 1 else np.zeros(len(scene.bins), dtype=bool)

    @cached_property
    def without_marks(self) -> WindowField:
        """The same tracks with no mark near any of them: the null hypothesis."""
        bare = copy(self)
        bare.neighbours = 0
        return bare

    @cached_property
    def trees(self) -> list[cKDTree]:
        """A tree of the marks at each knot."""
        z = self.scene.paths.z
        return [cKDTree(np.column_stack([z[:, k].real, z[:, k].imag])) for k in range(self.scene.knots)]

    @cached_property
    def aged_m2(self) -> FloatArray:
        """Mean variance (n,) of what grows with the age of a mark's reports [m^2]."""
        mean: FloatArray = (self.scene.paths.aged_m**2).mean(axis=1)
        return mean

    @cached_property
    def line_m2(self) -> FloatArray:
        """Variances (3, m, 2) of the line of clutter: still, moving and jumping [m^2]."""
        speed = np.array([self.model.still_mps, self.model.moving_mps, self.model.jumping_mps])
        moved: FloatArray = self.scene.spread_s2[None, :, None] * speed[:, None, None] ** 2
        return self.scene.white_m2[None] + moved

    @cached_property
    def line_share(self) -> FloatArray:
        """Shares (3,) of clutter that stands, moves and jumps."""
        still, jumping = self.model.still_share, self.model.jumping_share
        return np.array([still, 1.0 - still - jumping, jumping])


@dataclass(frozen=True, eq=False)
class Fit:
    """k motions, m tracks, q neighbours, s basis vectors, 2 axes (radial, tangential at the track's middle).

    ``mark`` (k, m, q); ``misfit`` (k, m, q, s, 2) mark minus track; ``variance_m2`` (k, m, q, s, 2);
    ``rate`` (k, m, q, s, 2) velocity of the mark: what a second of clock does; ``path`` (k, m, s, 2) minus the track's
    own way over ground; ``axis`` (k, m) complex, ``lever`` (k, m, K) complex: how a track turns with own heading.
    """

    mark: IntArray
    misfit: FloatArray
    variance_m2: FloatArray
    rate: FloatArray
    path: FloatArray
    axis: ComplexArray
    lever: ComplexArray


def lay_over(field: WindowField, knots: Knots, *, position_only: bool = False) -> Fit:
    """Place the tracks by k own motions and measure their misfit to the marks nearest at their middle.

    With ``position_only`` nothing but the mean of each track: s = 1.
    """
    scene = field.scene
    turned = np.exp(1j * knots.heading_rad)[:, None, :] * scene.rho[None]  # (k, m, K)
    world = np.where(scene.alive[None], knots.p[:, None, :] + turned, 0.0)
    mark = _nearest(field, world)
    middle = np.take_along_axis(
        turned, np.broadcast_to(scene.middle_bin[None, :, None], (*turned.shape[:2], 1)), axis=2
    )
    axis = middle[:, :, 0] / np.maximum(np.abs(middle[:, :, 0]), 1e-9)
    back = np.conj(axis)[:, :, None]
    clock = knots.clock_s[:, None, None, None]
    v = scene.paths.v[mark]
    misfit = (scene.paths.z[mark] + v * clock - world[:, :, None, :]) * back[..., None]
    misfit = np.where(scene.alive[None, :, None, :], misfit, 0.0)
    lever = np.where(scene.alive[None], 1j * turned * back, 0.0)
    if position_only:
        none = np.zeros((*mark.shape, 0, 2))
        return Fit(
            mark, in_basis(scene.basis[:, :1], misfit), _variance(field, mark, 1), none, none[:, :, 0], axis, lever
        )
    rate = np.where(scene.alive[None, :, None, :], v * back[..., None], 0.0)
    return Fit(
        mark,
        in_basis(scene.basis, misfit),
        _variance(field, mark, scene.knots),
        in_basis(scene.basis, rate),
        in_basis(scene.basis, -world * back),
        axis,
        lever,
    )


def in_basis(basis: FloatArray, values: ComplexArray) -> FloatArray:
    """Return values over bins (k, m, ..., K) as coordinates (k, m, ..., s, 2) in the tracks' bases."""
    shape = values.shape
    flat = np.moveaxis(values, 1, 0).reshape(shape[1], math.prod(shape[:1] + shape[2:-1]), shape[-1])  # (m, k..., K)
    turned = flat @ np.swapaxes(basis, 1, 2)
    back = np.moveaxis(turned.reshape(shape[1], shape[0], *shape[2:-1], basis.shape[1]), 0, 1)
    return np.stack([back.real, back.imag], axis=-1)


def _nearest(field: WindowField, world: ComplexArray) -> IntArray:
    scene = field.scene
    if field.neighbours == 0:
        return np.empty((*world.shape[:2], 0), dtype=np.int64)
    found = np.empty((*world.shape[:2], field.neighbours), dtype=np.int64)
    for knot in np.unique(scene.middle_bin):
        rows = np.flatnonzero(scene.middle_bin == knot)
        at = world[:, rows, knot]
        _, near = field.trees[knot].query(np.stack([at.real, at.imag], axis=-1), k=field.neighbours)
        found[:, rows] = near.reshape(len(world), len(rows), field.neighbours)
    return found


def _variance(field: WindowField, mark: IntArray, rows: int) -> FloatArray:
    """Return variances (k, m, q, s, 2): mean n s_c^2 + s_w^2, line S_tt s_s^2 + s_w^2, scatter s_w^2."""
    scene, model = field.scene, field.model
    white = scene.white_m2[None, :, None, :] + field.aged_m2[mark][..., None]
    variance = np.repeat(white[..., None, :], rows, axis=3)
    constant = scene.constant_m2[None, :, None, :] + (scene.paths.constant_m[mark] ** 2)[..., None]
    variance[..., 0, :] += scene.bins[None, :, None, None] * constant
    if rows > 1:
        variance[..., 1, :] += (scene.spread_s2 * model.slope_mps**2)[None, :, None, None]
    return variance


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
    log_scatter, weight = _scatter(field, path, np.broadcast_to(scene.white_m2[None, :, None, :], path.shape))
    if scene.knots == 1:
        return Clutter(log_scatter, np.zeros((3, *log_scatter.shape)), weight)
    by_kind = np.log(field.line_share)[:, None, None] + _log_normal(path[None, ..., 1, :], field.line_m2[:, None])
    log_line = np.where(field.has_line[None], np.logaddexp.reduce(by_kind, axis=0), 0.0)
    kind = np.where(field.has_line[None, None], np.exp(by_kind - log_line[None]), 0.0)
    return Clutter(log_line + log_scatter, kind, weight)


def log_fit(
    field: WindowField, fit: Fit, widening: float = 1.0, position_only: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return ln density (k, m, q) of every track on its marks, its mean per m^2, and the weight of its scatter."""
    scene = field.scene
    variance = fit.variance_m2
    mean = _log_normal(fit.misfit[..., 0, :], variance[..., 0, :] * widening**2) + np.log(scene.bins)[None, :, None]
    if position_only or scene.knots == 1:
        return mean, np.zeros_like(mean)
    line = _log_normal(fit.misfit[..., 1, :], variance[..., 1, :] * widening**2)
    log_scatter, weight = _scatter(field, fit.misfit, variance)
    return mean + np.where(field.has_line[None, :, None], line, 0.0) + log_scatter, weight


def _scatter(field: WindowField, coordinates: FloatArray, variance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ln density of the scatter (a t distribution: tracks swap and turn) and its weight in the adjustment."""
    used = field.scatter[None, :, None, :, None] if coordinates.ndim == 5 else field.scatter[None, :, :, None]
    count = 2.0 * used.sum(axis=(-2, -1))
    nu = field.model.scatter_dof
    square = np.where(used, coordinates**2 / variance, 0.0).sum(axis=(-2, -1))
    log_det = np.where(used, np.log(variance), 0.0).sum(axis=(-2, -1))
    log_density = -0.5 * (nu + count) * np.log1p(square / nu) - 0.5 * log_det
    return log_density, (nu + count) / (nu + square)


def _log_normal(offset: FloatArray, variance: FloatArray) -> FloatArray:
    """Return ln of the normal density (...) of offsets (..., 2) with variances (..., 2)."""
    log_density: FloatArray = -0.5 * (offset**2 / variance + np.log(variance)).sum(axis=-1) - LOG_2PI
    return log_density


Mask = NDArray[np.bool_]
