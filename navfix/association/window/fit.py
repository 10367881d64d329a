"""Tracks laid over the paths of the marks: how well each track fits each mark near it, and how well it fits clutter.

A track is judged in its own basis (mean, line, scatter). On a mark: normal with the variances of track and mark
together. As clutter: any place (the local density), a mixture of still and moving over ground for the line, and the
same scatter about it. Whatever own motion explains badly makes both small, so own motion is a part of the evidence
too.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from navfix.association.em import NOMINAL_LEVEL, Field
from navfix.association.scene import BoolArray, ComplexArray
from navfix.association.window.knots import Knots
from navfix.association.window.scene import WindowScene
from navfix.catalog import AssociationModel, WindowModel
from navfix.types import FloatArray, IntArray

LOG_2PI = float(np.log(2.0 * np.pi))
MEAN, LINE, SCATTER = range(3)


class WindowField:
    """What every own motion in one window is tried against."""

    def __init__(self, scene: WindowScene, model: WindowModel, shared: AssociationModel) -> None:
        self.scene, self.model, self.shared = scene, model, shared
        self.flat = Field(scene.flat, shared)
        self.neighbours = min(model.neighbours, len(scene.paths.marks))
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
    def middle_rho(self) -> ComplexArray:
        """Every track (m,) at the bin in the middle of its life, in the de-rotated ship's frame [m]."""
        middle: ComplexArray = self.scene.rho[np.arange(len(self.scene.rho)), self.scene.middle_bin]
        return middle

    @property
    def coordinates(self) -> tuple[int, int, int]:
        """How many coordinates a basis over all bins has of each kind: mean, line, scatter."""
        return 1, min(self.scene.knots - 1, 1), max(self.scene.knots - 2, 0)

    @cached_property
    def scatters(self) -> FloatArray:
        """How many coordinates of each track (m,) are scatter, on both axes together."""
        return np.asarray(2.0 * self.scene.used[:, SCATTER:].sum(axis=1))

    @cached_property
    def basis_of_unknowns(self) -> FloatArray:
        """Basis (m, s, 3 K): by what each bin, and so each of its three unknowns, counts in a coordinate."""
        return np.repeat(self.scene.basis, 3, axis=2)

    def odds(self, mark: IntArray, level: float) -> FloatArray:
        """Return the detection odds Pd_j / (1 - Pd_j) (k, m, q) of tracks as the marks (k, m, q)."""
        flat = self.scene.flat
        pd = level * self.flat.detection(flat.range_m[None, :, None], flat.conspicuity[mark])
        return np.asarray(pd / (1.0 - pd))

    @cached_property
    def means(self) -> Means:
        """Every track beside every mark by their means."""
        scene, to_mean = self.scene, self.scene.basis[:, 0]
        every = np.broadcast_to(np.arange(len(scene.paths.marks)), (1, len(scene.bins), len(scene.paths.marks)))
        variance = _variance(self, every)[0, :, :, MEAN]
        log_ratio = np.log(self.odds(every, NOMINAL_LEVEL)[0]) - 0.5 * over_axes(np.log(variance)) - LOG_2PI
        log_ratio += np.log(scene.bins / self.flat.clutter_per_m2)[:, None]
        return Means(to_mean @ scene.paths.z.T, to_mean @ scene.paths.v.T, 1.0 / variance, log_ratio)

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
class Means:
    """Every track beside every mark (m, n), by its mean over the bins.

    ``z`` and ``v`` the mark's place and velocity; ``information`` (m, n, 2) the inverse variance of the misfit, radial
    and tangential; ``log_ratio`` ln of the ratio of eq. (6.20) without misfit, of the places alone.
    """

    z: ComplexArray
    v: ComplexArray
    information: FloatArray
    log_ratio: FloatArray


@dataclass(frozen=True, eq=False)
class Fit:
    """k motions, m tracks, q neighbours, s basis vectors, 2 axes (radial, tangential at the track's middle).

    ``mark`` (k, m, q); ``misfit`` (k, m, q, s, 2) mark minus track; ``variance_m2`` (k, m, q, 3, 2) of mean, line and
    scatter; ``rate`` (k, m, q, s, 2) velocity of the mark: what a second of clock does; ``path`` (k, m, s, 2) minus the
    track's own way over ground; ``axis`` (k, m) complex; ``barred`` (k, m) which tracks are no mark, None: any may be.
    """

    mark: IntArray
    misfit: FloatArray
    variance_m2: FloatArray
    rate: FloatArray
    path: FloatArray
    axis: ComplexArray
    barred: BoolArray | None = None


def lay_over(field: WindowField, knots: Knots) -> Fit:
    """Place the tracks by k own motions and measure their misfit to the marks nearest at their middle."""
    scene = field.scene
    turn = np.exp(1j * knots.heading_rad)
    mark, axis = near_middle(field, knots, turn)
    back = np.conj(axis)[:, :, None]
    rows = scene.basis.reshape(-1, scene.knots).T
    own = scene.rho[:, None, :] * scene.basis
    world = (knots.p @ rows + turn @ own.reshape(-1, scene.knots).T).reshape(*axis.shape, -1)  # (k, m, s)
    z, v = (_in_basis(scene.basis, path, mark) for path in (scene.paths.z, scene.paths.v))
    misfit = (z + v * knots.clock_s[:, None, None, None] - world[:, :, None]) * back[..., None]
    rate, path = by_axis(v * back[..., None]), by_axis(-world * back)
    return Fit(mark, by_axis(misfit), _variance(field, mark), rate, path, axis, knots.barred)


def near_middle(field: WindowField, knots: Knots, turn: ComplexArray) -> tuple[IntArray, ComplexArray]:
    """Return the marks (k, m, q) nearest to every track in the middle of its life, and its axis (k, m) there."""
    scene = field.scene
    sight = turn[:, scene.middle_bin] * field.middle_rho
    at = knots.p[:, scene.middle_bin] + sight
    mark = np.empty((*at.shape, field.neighbours), dtype=np.int64)
    for knot in np.unique(scene.middle_bin) if field.neighbours else ():
        rows = np.flatnonzero(scene.middle_bin == knot)
        _, near = field.trees[knot].query(by_axis(at[:, rows]), k=field.neighbours)
        mark[:, rows] = near.reshape(len(at), len(rows), field.neighbours)
    return mark, sight / np.maximum(np.abs(sight), 1e-9)


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


def _variance(field: WindowField, mark: IntArray) -> FloatArray:
    """Return variances (k, m, q, 3, 2): mean n s_c^2 + s_w^2, line S_tt s_s^2 + s_w^2, scatter s_w^2."""
    scene = field.scene
    white = scene.white_m2[None, :, None, :] + field.aged_m2[mark][..., None]
    constant = scene.constant_m2[None, :, None, :] + (scene.paths.constant_m[mark] ** 2)[..., None]
    mean = white + scene.bins[None, :, None, None] * constant
    line = white + (scene.spread_s2 * field.model.slope_mps**2)[None, :, None, None]
    return np.stack([mean, line, white], axis=3)


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
    log_scatter, weight = _scatter(field, path, scene.white_m2, field.scatters)
    if scene.knots == 1:
        return Clutter(log_scatter, np.zeros((3, *log_scatter.shape)), weight)
    by_kind = np.log(field.line_share)[:, None, None] + log_normal(path[None, ..., LINE, :], field.line_m2[:, None])
    log_line = np.where(field.has_line[None], np.logaddexp.reduce(by_kind, axis=0), 0.0)
    kind = np.where(field.has_line[None, None], np.exp(by_kind - log_line[None]), 0.0)
    return Clutter(log_line + log_scatter, kind, weight)


def log_fit(field: WindowField, fit: Fit, widening: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return ln density (k, m, q) of every track on its marks, its mean per m^2, and the weight of its scatter."""
    scene = field.scene
    variance = fit.variance_m2[..., :SCATTER, :] * widening**2
    mean = log_normal(fit.misfit[..., MEAN, :], variance[..., MEAN, :]) + np.log(scene.bins)[None, :, None]
    if scene.knots == 1:
        return mean, np.zeros_like(mean)
    line = log_normal(fit.misfit[..., LINE, :], variance[..., LINE, :])
    log_scatter, weight = _scatter(field, fit.misfit, fit.variance_m2[..., SCATTER, :], field.scatters[:, None])
    return mean + np.where(field.has_line[None, :, None], line, 0.0) + log_scatter, weight


def _scatter(
    field: WindowField, coordinates: FloatArray, variance: FloatArray, count: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return ln density of the scatter (a t distribution: tracks swap and turn) and its weight in the adjustment.

    ``coordinates`` (..., s, 2) in a track's basis, ``variance`` (..., 2), ``count`` (...) how many of them are scatter.
    """
    nu = field.model.scatter_dof
    scattered = coordinates[..., SCATTER:, :]
    square = over_axes(np.einsum("...sa,...sa->...a", scattered, scattered) / variance)
    log_det = 0.5 * count * over_axes(np.log(variance))
    return -0.5 * (nu + count) * np.log1p(square / nu) - 0.5 * log_det, (nu + count) / (nu + square)


def log_normal(offset: FloatArray, variance: FloatArray) -> FloatArray:
    """Return ln of the normal density (...) of offsets (..., 2) with variances (..., 2)."""
    log_density: FloatArray = -0.5 * over_axes(offset**2 / variance + np.log(variance)) - LOG_2PI
    return log_density
