"""Step 6c: the normal equations of the M-step, for k own motions at once.

A track has one weight for its mean, one for its line and one for all of its scatter (eq. 6.18). So with the basis
vectors b_0 and b_1 of mean and line, over the bins in which it lives,

    B' W B = w_2 I + (w_0 - w_2) b_0 b_0' + (w_1 - w_2) b_1 b_1',

and of the product of all coordinates only the mean, the line, and what each bin has by itself are ever made.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from navfix.association.scene import ComplexArray
from navfix.association.window.field import LINE, MEAN, SCATTER, WindowField
from navfix.association.window.fit import Clutter, Fit, by_axis
from navfix.association.window.knots import Knots
from navfix.types import FloatArray

if TYPE_CHECKING:
    from navfix.association.window.em import Expectation

NEGLIGIBLE = 1e-12  # of a responsibility


@dataclass(frozen=True, eq=False)
class _OnMarks:
    """Sums over the marks near each track: ``weight`` (k, m, 3, 2) of mean, line and scatter.

    ``pull`` and ``with_clock`` (k, m, s, 2) are weighted misfits and rates; ``clock_square`` and
    ``clock_pull`` (k,) are of the clock's own equation.
    """

    weight: FloatArray
    pull: FloatArray
    with_clock: FloatArray
    clock_square: FloatArray
    clock_pull: FloatArray


def normal_equations(
    field: WindowField, knots: Knots, fit: Fit, expected: Expectation, widening: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Return A'WA (k, d, d) and A'Wl (k, d) of the tracks, without priors."""
    on_marks = _on_marks(field, fit, expected, widening)
    of_clutter = _clutter_weight(field, expected.clutter, expected.on_clutter)
    arms = _arms(field, knots, fit.axis)
    pull = on_marks.pull + np.repeat(of_clutter, field.coordinates, axis=2) * fit.path
    by_clock, by_pull = _by_unknown(field, arms, on_marks.with_clock), _by_unknown(field, arms, pull)
    count, d = len(pull), 3 * field.scene.knots + 1
    information, gradient = np.empty((count, d, d)), np.empty((count, d))
    information[:, :-1, :-1] = _squares(field, arms, on_marks.weight + of_clutter)
    information[:, :-1, -1] = information[:, -1, :-1] = by_clock
    information[:, -1, -1] = on_marks.clock_square
    gradient[:, :-1], gradient[:, -1] = by_pull, on_marks.clock_pull
    return information, gradient


def clutter_equations(
    field: WindowField, knots: Knots, axis: ComplexArray, path: FloatArray, clutter: Clutter
) -> tuple[FloatArray, FloatArray]:
    """Return A'WA (k, d, d) and A'Wl (k, d) of tracks that are all clutter: nothing of it depends on the clock."""
    weight, arms = _clutter_weight(field, clutter, np.ones(path.shape[:2])), _arms(field, knots, axis)
    count, d = len(path), 3 * field.scene.knots + 1
    information, gradient = np.zeros((count, d, d)), np.zeros((count, d))
    information[:, :-1, :-1] = _squares(field, arms, weight)
    gradient[:, :-1] = _by_unknown(field, arms, np.repeat(weight, field.coordinates, axis=2) * path)
    return information, gradient


def _on_marks(field: WindowField, fit: Fit, expected: Expectation, widening: float) -> _OnMarks:
    """Return the sums over the marks, of which one or none counts for most tracks."""
    count, tracks, _ = expected.on_mark.shape
    k, m, q = np.nonzero(expected.on_mark > NEGLIGIBLE)
    laid = (k if len(fit.mark) == count else np.zeros_like(k), m, q)
    weight = expected.on_mark[k, m, q][:, None, None] / fit.variance_m2[laid]
    weight[:, :SCATTER] /= widening**2
    weight[:, SCATTER] *= expected.scatter_weight[laid][:, None]
    misfit, rate = fit.misfit[laid], fit.rate[laid]
    of_every = np.repeat(weight, field.coordinates, axis=1)
    drift = of_every * rate
    begins = np.flatnonzero(np.diff(k * tracks + m, prepend=-1))
    sums = np.zeros((count, tracks, SCATTER + 1 + 2 * rate.shape[1], 2))
    if len(begins):
        parts = np.concatenate([weight, of_every * misfit, -drift], axis=1)
        sums[k[begins], m[begins]] = np.add.reduceat(parts, begins, axis=0)
    by_kind, pull, with_clock = np.split(sums, [SCATTER + 1, SCATTER + 1 + rate.shape[1]], axis=2)
    squares = np.bincount(k, np.einsum("nsa,nsa->n", drift, rate), count).astype(np.float64)
    pulls = np.bincount(k, -np.einsum("nsa,nsa->n", drift, misfit), count).astype(np.float64)
    return _OnMarks(by_kind, pull, with_clock, squares, pulls)


def _clutter_weight(field: WindowField, clutter: Clutter, share: FloatArray) -> FloatArray:
    """Return what echoes that are no mark say of own motion (k, m, 3, 2): still ones hold it, scatter smooths it."""
    scene = field.scene
    weight = np.zeros((*share.shape, SCATTER + 1, 2))
    if scene.knots == 1:
        return weight
    line = (clutter.kind[..., None] / field.line_m2[:, None]).sum(axis=0)
    weight[..., LINE, :] = share[..., None] * line
    weight[..., SCATTER, :] = (share * clutter.scatter_weight)[..., None] / scene.white_m2
    return weight


def _arms(field: WindowField, knots: Knots, axis: ComplexArray) -> FloatArray:
    """Return what each unknown of a knot does to every track there: (k, K, 3, m, 2)."""
    scene, back = field.scene, np.conj(axis)
    arms = np.empty((len(knots), scene.knots, 3, *by_axis(back).shape[1:]))
    arms[:, :, 0], arms[:, :, 1] = by_axis(back)[:, None], by_axis(1j * back)[:, None]
    arms[:, :, 2] = by_axis(1j * np.exp(1j * knots.heading_rad)[:, :, None] * scene.rho.T * back[:, None])
    return arms


def _squares(field: WindowField, arms: FloatArray, weight: FloatArray) -> FloatArray:
    """Return A'WA (k, 3 K, 3 K) for weights (k, m, 3, 2) of mean, line and scatter."""
    scene, count, knots = field.scene, len(weight), field.scene.knots
    rest = weight[:, :, SCATTER]
    total = np.zeros((count, 3 * knots, 3 * knots))
    for kind in (MEAN, LINE)[:knots]:
        vector = arms * scene.basis[:, kind].T[:, None, :, None]  # (k, K, 3, m, 2)
        vector = vector.reshape(len(arms), 3 * knots, -1)
        more = (weight[:, :, kind] - rest).reshape(count, 1, -1)
        total += (vector * more) @ vector.swapaxes(1, 2)
    in_bin = rest[:, None] * scene.alive.T[:, :, None]  # (k, K, m, 2)
    alone = arms.reshape(*arms.shape[:3], -1)
    of_bin = (alone * in_bin.reshape(count, knots, 1, -1)) @ alone.swapaxes(2, 3)  # (k, K, 3, 3)
    for knot in range(knots):
        own = slice(3 * knot, 3 * knot + 3)
        total[:, own, own] += of_bin[:, knot]
    return total


def _by_unknown(field: WindowField, arms: FloatArray, coordinates: FloatArray) -> FloatArray:
    """Return A'y (k, 3 K) of weighted coordinates y (k, m, s, 2) in the tracks' bases."""
    count, tracks, size, _ = coordinates.shape
    by_track = coordinates.transpose(1, 2, 0, 3).reshape(tracks, size, -1)
    in_bins = (field.scene.basis.swapaxes(1, 2) @ by_track).reshape(tracks, size, count, 2)
    y = in_bins.transpose(2, 1, 0, 3).reshape(count, size, -1, 1)
    return (arms.reshape(*arms.shape[:3], -1) @ y).reshape(count, 3 * size)
