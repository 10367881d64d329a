"""Step 6b: the EM of one scan, over a window: responsibilities of whole tracks, Gauss-Newton on the whole own motion.

E-step: each track is one of the marks near it, or clutter that stands or moves. M-step: one Gauss-Newton step on all
knots and the clock, with the priors of own motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.association.em import NOMINAL_LEVEL, NOMINAL_SHARE
from navfix.association.window.fit import LINE, SCATTER, Clutter, Fit, WindowField, as_clutter, lay_over, log_fit
from navfix.association.window.knots import Knots, MotionPrior
from navfix.types import FloatArray


@dataclass(frozen=True, eq=False)
class Expectation:
    """Responsibilities (k, m, q) of the marks and (k, m) of clutter."""

    on_mark: FloatArray
    on_clutter: FloatArray
    scatter_weight: FloatArray
    clutter: Clutter


def density_ratio(
    field: WindowField, fit: Fit, clutter: Clutter, widening: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Return N_ij / (lambda_i V_i) (k, m, q), and the weight of the scatter: eq. (6.20) at detection odds of one."""
    log_density, weight = log_fit(field, fit, widening)
    against = np.log(field.flat.clutter_per_m2)[None, :] + clutter.log_density
    ratio = np.exp(np.minimum(log_density - against[:, :, None], 200.0))
    return (ratio if fit.barred is None else np.where(fit.barred[:, :, None], 0.0, ratio)), weight


def expect(field: WindowField, fit: Fit, widening: float = 1.0) -> Expectation:
    """Return the E-step at nominal clutter share and detection level."""
    clutter = as_clutter(field, fit.path)
    density, weight = density_ratio(field, fit, clutter, widening)
    ratio = field.odds(fit.mark, NOMINAL_LEVEL) * density
    total = NOMINAL_SHARE + ratio.sum(axis=2)
    return Expectation(ratio / total[:, :, None], NOMINAL_SHARE / total, weight, clutter)


def knot_step(field: WindowField, knots: Knots, widening: float, prior: MotionPrior) -> tuple[Knots, FloatArray]:
    """One E-step and one M-step over all unknowns; return the moved motions and the information (k, d, d).

    k sets of barred tracks on one motion make k of it.
    """
    fit = lay_over(field, knots)
    information, gradient = normal_equations(field, knots, fit, expect(field, fit, widening), widening)
    information += prior.full_information
    gradient += prior.gradient(knots)
    step: FloatArray = np.asarray(np.linalg.solve(information, gradient[:, :, None])[:, :, 0], dtype=np.float64)
    return knots.moved(step), information


def normal_equations(
    field: WindowField, knots: Knots, fit: Fit, expected: Expectation, widening: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Return A'WA (k, d, d) and A'Wl (k, d) of the tracks, without priors."""
    J = _jacobian(field, knots, fit)  # (k, (m s a), 3 K)
    weight = _mark_weight(field, fit, expected, widening)  # (k, m, q, s, 2)
    of_clutter = _clutter_weight(field, expected)
    drift = weight * fit.rate
    total = np.einsum("kmqsa->kmsa", weight) + of_clutter
    pull = np.einsum("kmqsa,kmqsa->kmsa", weight, fit.misfit) + of_clutter * fit.path
    with_clock = -np.einsum("kmqsa->kmsa", drift)
    clock_square, clock_pull = (np.einsum("kmqsa,kmqsa->km", drift, by) for by in (fit.rate, -fit.misfit))
    count, d = len(total), J.shape[2] + 1
    information, gradient = np.zeros((count, d, d)), np.zeros((count, d))
    back = np.swapaxes(J, 1, 2)
    right = np.stack([with_clock.reshape(count, -1), pull.reshape(count, -1)], axis=2)
    by_clock, by_pull = np.moveaxis(back @ right, 2, 0)
    information[:, :-1, :-1] = back @ (J * total.reshape(count, J.shape[1], 1))
    information[:, :-1, -1] = information[:, -1, :-1] = by_clock
    information[:, -1, -1] = clock_square.sum(axis=1)
    gradient[:, :-1], gradient[:, -1] = by_pull, clock_pull.sum(axis=1)
    return information, gradient


def _jacobian(field: WindowField, knots: Knots, fit: Fit) -> FloatArray:
    """Return what every unknown does to the coordinates of every track: (k, m s 2, 3 K)."""
    scene = field.scene
    back = np.conj(fit.axis)[:, :, None]
    lever = 1j * np.exp(1j * knots.heading_rad)[:, None] * scene.rho * back  # (k, m, b)
    place = np.broadcast_to(back, lever.shape)
    columns = np.stack([place, 1j * place, lever], axis=-1).reshape(*lever.shape[:2], 1, 3 * scene.knots)
    parts = np.stack([columns.real, columns.imag], axis=3)  # (k, m, 1, a, 3 K)
    J: FloatArray = field.basis_of_unknowns[:, :, None] * parts  # (k, m, s, a, 3 K)
    return J.reshape(len(J), math.prod(J.shape[1:4]), 3 * scene.knots)


def _mark_weight(field: WindowField, fit: Fit, expected: Expectation, widening: float) -> FloatArray:
    """Return the weight (k, m, q, s, 2) of every coordinate on every mark."""
    weight = expected.on_mark[..., None, None] / fit.variance_m2
    weight[..., :SCATTER, :] /= widening**2
    weight[..., SCATTER, :] *= expected.scatter_weight[..., None]
    of_every = np.repeat(weight, field.coordinates, axis=3)
    return np.where(field.scene.used[:, None, :, None], of_every, 0.0)


def _clutter_weight(field: WindowField, expected: Expectation) -> FloatArray:
    """Return what an echo that is no mark says of own motion: still ones hold it, the scatter smooths it."""
    scene, clutter = field.scene, expected.clutter
    weight = np.zeros((*expected.on_clutter.shape, scene.knots, 2))
    if scene.knots == 1:
        return weight
    line = (clutter.kind[..., None] / field.line_m2[:, None]).sum(axis=0)
    weight[..., LINE, :] = expected.on_clutter[..., None] * line
    weight[..., SCATTER:, :] = (expected.on_clutter * clutter.scatter_weight)[..., None, None] / scene.white_m2[
        None, :, None, :
    ]
    return np.where(scene.used[None, :, :, None], weight, 0.0)
