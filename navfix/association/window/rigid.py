"""Step 6a: while own motion is far off only the pose of the whole is moved, by the mean places of the tracks.

Hundreds of starts are moved at once, so nothing but the mean of a track over its bins is looked at.
"""

from __future__ import annotations

import numpy as np

from navfix.association.em import NOMINAL_SHARE
from navfix.association.scene import ComplexArray
from navfix.association.window.field import WindowField
from navfix.association.window.fit import axes, by_axis, near_middle, over_axes
from navfix.association.window.knots import LOOSE_M, LOOSE_RAD, Knots
from navfix.types import FloatArray


def rigid_step(field: WindowField, knots: Knots, widening: float) -> tuple[Knots, FloatArray]:
    """Move k own motions as a whole; return them and ln of the total likelihood before."""
    scene, means = field.scene, field.means
    turn = np.exp(1j * knots.heading_rad)
    mark = near_middle(field, knots)
    on = np.arange(mark.shape[1])[None, :, None] * len(scene.paths.marks) + mark  # as one number: quicker than two
    back = np.conj(axes(field, turn))
    to_mean = scene.basis[:, 0]  # (m, K)
    world = knots.p @ to_mean.T + turn @ (to_mean * scene.rho).T  # (k, m)
    there = means.z.take(on) + means.v.take(on) * knots.clock_s[:, None, None]
    misfit = by_axis((there - world[:, :, None]) * back[:, :, None])

    information = means.information.reshape(-1, 2).take(on, axis=0) / widening**2  # (k, m, q, 2)
    square = over_axes(information * misfit**2)
    ratio = np.exp(means.log_ratio.take(on) - 0.5 * square) / widening**2
    total = NOMINAL_SHARE + ratio.sum(axis=2)
    weight = (ratio / total[:, :, None])[..., None] * information

    arm = 1j * (world - np.sqrt(scene.bins) * knots.p[:, scene.gauge, None]) * back
    pull = np.einsum("kmqa,kmqa->kma", weight, misfit)
    step = _solved(_jacobian(np.sqrt(scene.bins) * back, arm), np.einsum("kmqa->kma", weight), pull)
    return _moved(knots, step, scene.gauge), np.log(total).sum(axis=1)


def _jacobian(place: ComplexArray, arm: ComplexArray) -> FloatArray:
    """Return what a step of the whole (north, east, heading) does to the mean of each track: (k, 3, m, 2)."""
    return by_axis(np.stack([place, 1j * place, arm], axis=1))


def _solved(J: FloatArray, weight: FloatArray, pull: FloatArray) -> FloatArray:
    """Return the Gauss-Newton step (k, 3) for weights and weighted misfits (k, m, 2)."""
    J, weight, pull = (part.reshape(*part.shape[:-2], -1) for part in (J, weight, pull))
    information = (J * weight[:, None]) @ J.swapaxes(1, 2)
    information += np.diag([1.0 / LOOSE_M**2, 1.0 / LOOSE_M**2, 1.0 / LOOSE_RAD**2])[None]
    return np.asarray(np.linalg.solve(information, J @ pull[:, :, None])[:, :, 0], dtype=np.float64)


def _moved(knots: Knots, step: FloatArray, gauge: int) -> Knots:
    """Return own motions shifted and turned about their gauge knot."""
    turn = np.exp(1j * step[:, 2])[:, None]
    centre = knots.p[:, gauge, None]
    return Knots(
        centre + (step[:, 0] + 1j * step[:, 1])[:, None] + turn * (knots.p - centre),
        knots.heading_rad + step[:, 2, None],
        knots.clock_s,
    )
