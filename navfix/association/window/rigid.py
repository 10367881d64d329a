"""Step 6a: while own motion is far off only the pose of the whole is moved, by the mean places of the tracks.

Hundreds of starts are moved at once, so nothing but the mean of a track over its bins is looked at.
"""

from __future__ import annotations

import numpy as np

from navfix.association.em import NOMINAL_LEVEL, NOMINAL_SHARE
from navfix.association.scene import ComplexArray
from navfix.association.window.fit import WindowField, by_axis, log_normal, near_middle
from navfix.association.window.knots import LOOSE_M, LOOSE_RAD, Knots
from navfix.types import FloatArray


def rigid_step(field: WindowField, knots: Knots, widening: float) -> tuple[Knots, FloatArray]:
    """Move k own motions as a whole; return them and ln of the total likelihood before."""
    scene = field.scene
    turn = np.exp(1j * knots.heading_rad)
    mark, axis = near_middle(field, knots, turn)
    back = np.conj(axis)
    to_mean = scene.basis[:, 0]  # (m, K)
    world = knots.p @ to_mean.T + turn @ (to_mean * scene.rho).T  # (k, m)
    track = np.arange(mark.shape[1])[None, :, None]
    z, v = ((to_mean @ path.T)[track, mark] for path in (scene.paths.z, scene.paths.v))
    misfit = by_axis((z + v * knots.clock_s[:, None, None] - world[:, :, None]) * back[:, :, None])
    constant = scene.constant_m2[None, :, None, :] + (scene.paths.constant_m[mark] ** 2)[..., None]
    variance = scene.white_m2[None, :, None, :] + field.aged_m2[mark][..., None]
    variance = (variance + scene.bins[None, :, None, None] * constant) * widening**2  # (k, m, q, 2)

    log_density = log_normal(misfit, variance) + np.log(scene.bins / field.flat.clutter_per_m2)[None, :, None]
    ratio = field.odds(mark, NOMINAL_LEVEL) * np.exp(np.minimum(log_density, 200.0))
    total = NOMINAL_SHARE + ratio.sum(axis=2)
    weight = (ratio / total[:, :, None])[..., None] / variance

    arm = 1j * (world - np.sqrt(scene.bins) * knots.p[:, scene.gauge, None]) * back
    step = _solved(_jacobian(np.sqrt(scene.bins) * back, arm), weight.sum(axis=2), (weight * misfit).sum(axis=2))
    return _moved(knots, step, scene.gauge), np.log(total).sum(axis=1)


def _jacobian(place: ComplexArray, arm: ComplexArray) -> FloatArray:
    """Return what a step of the whole (north, east, heading) does to the mean of each track: (k, m, 3, 2)."""
    return by_axis(np.stack([place, 1j * place, arm], axis=2))


def _solved(J: FloatArray, weight: FloatArray, pull: FloatArray) -> FloatArray:
    """Return the Gauss-Newton step (k, 3) for weights and weighted misfits (k, m, 2)."""
    information = np.einsum("kmca,kma,kmda->kcd", J, weight, J, optimize=["einsum_path", (0, 1), (0, 1)])
    information += np.diag([1.0 / LOOSE_M**2, 1.0 / LOOSE_M**2, 1.0 / LOOSE_RAD**2])[None]
    gradient = np.einsum("kmca,kma->kc", J, pull)
    return np.asarray(np.linalg.solve(information, gradient[:, :, None])[:, :, 0], dtype=np.float64)


def _moved(knots: Knots, step: FloatArray, gauge: int) -> Knots:
    """Return own motions shifted and turned about their gauge knot."""
    turn = np.exp(1j * step[:, 2])[:, None]
    centre = knots.p[:, gauge, None]
    return Knots(
        centre + (step[:, 0] + 1j * step[:, 1])[:, None] + turn * (knots.p - centre),
        knots.heading_rad + step[:, 2, None],
        knots.clock_s,
    )
