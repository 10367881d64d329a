"""Step 6: the EM of one scan, over a window: responsibilities of whole tracks, Gauss-Newton on the whole own motion.

E-step: each track is one of the marks near it, or clutter that stands or moves. M-step: one Gauss-Newton step on all
knots and the clock, with the priors of own motion. While it is far off, only the pose of the whole is moved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.association.em import NOMINAL_LEVEL, NOMINAL_SHARE
from navfix.association.window.fit import Clutter, Fit, WindowField, as_clutter, lay_over, log_fit
from navfix.association.window.knots import Knots, MotionPrior
from navfix.types import FloatArray


@dataclass(frozen=True, eq=False)
class Expectation:
    """Responsibilities (k, m, q) of the marks and (k, m) of clutter; ``log_total`` (k,) at nominal shares."""

    on_mark: FloatArray
    on_clutter: FloatArray
    scatter_weight: FloatArray
    clutter: Clutter
    log_total: FloatArray


def likelihood_ratio(
    field: WindowField, fit: Fit, clutter: Clutter, level: float, widening: float = 1.0, position_only: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return w_ij = Pd_j / (1 - Pd_j) N_ij / (lambda_i V_i) (k, m, q), and the weight of the scatter: eq. (6.20)."""
    flat = field.scene.flat
    pd = level * field.flat.detection(flat.range_m[None, :, None], flat.conspicuity[fit.mark])
    log_density, weight = log_fit(field, fit, widening, position_only)
    against = np.log(field.flat.clutter_per_m2)[None, :]
    if not position_only:
        against = against + clutter.log_density
    return pd / (1.0 - pd) * np.exp(np.minimum(log_density - against[:, :, None], 200.0)), weight


def expect(field: WindowField, fit: Fit, widening: float = 1.0, position_only: bool = False) -> Expectation:
    """Return the E-step at nominal clutter share and detection level."""
    none = np.zeros(fit.mark.shape[:2])
    clutter = Clutter(none, none[None], none) if position_only else as_clutter(field, fit.path)
    ratio, weight = likelihood_ratio(field, fit, clutter, NOMINAL_LEVEL, widening, position_only)
    total = NOMINAL_SHARE + ratio.sum(axis=2)
    log_total = np.log(total).sum(axis=1)
    if not position_only:
        log_total = log_total + clutter.log_density.sum(axis=1)
    return Expectation(ratio / total[:, :, None], NOMINAL_SHARE / total, weight, clutter, log_total)


def rigid_step(field: WindowField, knots: Knots, widening: float) -> tuple[Knots, FloatArray]:
    """Move k own motions as a whole, by the places of the tracks only; return them and ln of the total before."""
    fit = lay_over(field, knots, position_only=True)
    expected = expect(field, fit, widening, position_only=True)
    weight = expected.on_mark[..., None] / (fit.variance_m2[..., 0, :] * widening**2)
    pull = (weight * fit.misfit[..., 0, :]).sum(axis=2)  # (k, m, 2)
    J = _rigid_jacobian(field, fit, knots)
    information = np.einsum("kmac,kma,kmad->kcd", J, weight.sum(axis=2), J)
    gradient = np.einsum("kmac,kma->kc", J, pull)
    information += np.diag([1.0 / 3000.0**2, 1.0 / 3000.0**2, 1.0 / 0.5**2])[None]
    step = np.linalg.solve(information, gradient[:, :, None])[:, :, 0]
    turn = np.exp(1j * step[:, 2])[:, None]
    centre = knots.p[:, field.scene.gauge, None]
    moved = Knots(
        centre + (step[:, 0] + 1j * step[:, 1])[:, None] + turn * (knots.p - centre),
        knots.heading_rad + step[:, 2, None],
        knots.clock_s,
    )
    return moved, expected.log_total


def _rigid_jacobian(field: WindowField, fit: Fit, knots: Knots) -> FloatArray:
    """Return what a step of the whole (north, east, heading) does to the mean of each track: (k, m, 2, 3)."""
    scene = field.scene
    back = np.conj(fit.axis)
    root = np.sqrt(scene.bins)[None, :]
    arm = np.where(scene.alive[None], 1j * (knots.p - knots.p[:, scene.gauge, None])[:, None, :] * back[..., None], 0.0)
    turn = np.einsum("mb,kmb->km", scene.basis[:, 0, :], arm + fit.lever)
    columns = np.stack([root * back, 1j * root * back, turn], axis=-1)
    return np.stack([columns.real, columns.imag], axis=2)


def knot_step(
    field: WindowField, knots: Knots, widening: float, prior: MotionPrior, track_weight: FloatArray | None = None
) -> tuple[Knots, FloatArray]:
    """One E-step and one M-step over all unknowns; return the moved motions and the information (k, d, d).

    ``track_weight`` (k, m) leaves tracks out (0) or counts them (1).
    """
    fit = lay_over(field, knots)
    information, gradient = normal_equations(field, fit, expect(field, fit, widening), widening, track_weight)
    information += prior.full_information
    gradient += prior.gradient(knots)
    step: FloatArray = np.asarray(np.linalg.solve(information, gradient[:, :, None])[:, :, 0], dtype=np.float64)
    return knots.moved(step), information


def normal_equations(
    field: WindowField, fit: Fit, expected: Expectation, widening: float, track_weight: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return A'WA (k, d, d) and A'Wl (k, d) of the tracks, without priors."""
    J = _jacobian(field, fit)  # (k, (m s a), 3 K)
    weight = _mark_weight(field, fit, expected, widening)  # (k, m, q, s, 2)
    of_clutter = _clutter_weight(field, expected)
    total = weight.sum(axis=2) + of_clutter
    pull = (weight * fit.misfit).sum(axis=2) + of_clutter * fit.path
    with_clock = -(weight * fit.rate).sum(axis=2)
    clock_square = (weight * fit.rate**2).sum(axis=2)
    clock_pull = -(weight * fit.rate * fit.misfit).sum(axis=2)
    if track_weight is not None:
        scale = track_weight[:, :, None, None]
        total, pull, with_clock = total * scale, pull * scale, with_clock * scale
        clock_square, clock_pull = clock_square * scale, clock_pull * scale
    count, d = len(J), J.shape[2] + 1
    information, gradient = np.zeros((count, d, d)), np.zeros((count, d))
    back = np.swapaxes(J, 1, 2)
    information[:, :-1, :-1] = back @ (J * total.reshape(count, J.shape[1], 1))
    information[:, :-1, -1] = information[:, -1, :-1] = (back @ with_clock.reshape(count, J.shape[1], 1))[:, :, 0]
    information[:, -1, -1] = clock_square.sum(axis=(1, 2, 3))
    gradient[:, :-1] = (back @ pull.reshape(count, J.shape[1], 1))[:, :, 0]
    gradient[:, -1] = clock_pull.sum(axis=(1, 2, 3))
    return information, gradient


def _jacobian(field: WindowField, fit: Fit) -> FloatArray:
    """Return what every unknown does to the coordinates of every track: (k, m s 2, 3 K)."""
    scene = field.scene
    back = np.broadcast_to(np.conj(fit.axis)[:, :, None], fit.lever.shape)
    columns = np.stack([back, 1j * back, fit.lever], axis=-1)  # (k, m, b, 3)
    parts = np.stack([columns.real, columns.imag], axis=2)  # (k, m, a, b, 3)
    J: FloatArray = scene.basis[None, :, :, None, :, None] * parts[:, :, None]  # (k, m, s, a, b, 3)
    return J.reshape(len(J), math.prod(J.shape[1:4]), 3 * scene.knots)


def _mark_weight(field: WindowField, fit: Fit, expected: Expectation, widening: float) -> FloatArray:
    scene = field.scene
    weight = expected.on_mark[..., None, None] / fit.variance_m2
    weight[..., :2, :] /= widening**2
    weight[..., 2:, :] *= expected.scatter_weight[..., None, None]
    return np.where(scene.used[None, :, None, :, None], weight, 0.0)


def _clutter_weight(field: WindowField, expected: Expectation) -> FloatArray:
    """Return what an echo that is no mark says of own motion: still ones hold it, the scatter smooths it."""
    scene, clutter = field.scene, expected.clutter
    weight = np.zeros((*expected.on_clutter.shape, scene.knots, 2))
    if scene.knots == 1:
        return weight
    line = (clutter.kind[..., None] / field.line_m2[:, None]).sum(axis=0)
    weight[..., 1, :] = expected.on_clutter[..., None] * line
    weight[..., 2:, :] = (expected.on_clutter * clutter.scatter_weight)[..., None, None] / scene.white_m2[
        None, :, None, :
    ]
    return np.where(scene.used[None, :, :, None], weight, 0.0)
