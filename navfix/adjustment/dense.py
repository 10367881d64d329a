"""Dense normal equations: Levenberg-Marquardt on iterated weights, for many starts at once.

The second road to every adjustment: it serves the trial starts, checks the factor graph, and stands in where GTSAM
has no wheel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from navfix.adjustment.network import BoolArray, Network, curvature, jacobian, prior_residual, residuals, sight
from navfix.adjustment.whitening import (
    back_to_units,
    spread_to_observations,
    target_norms,
    target_sums,
    whiten,
    whiten_one,
    whitened,
    whitener,
)
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray, IntArray

_SMALLEST_MU, _LARGEST_MU = 1e-9, 1e12
_FLATTEST = 1e-9  # smallest curvature, in units of that of one sigma
_FLOOR = np.array([1e-15, 1e-15, 1e-9])  # keeps the step defined where nothing depends on an unknown


@dataclass(frozen=True, slots=True, eq=False)
class Descent:
    """Where each start ended: ``pose`` (s, 3), ``loss`` (s,), ``step`` (s,) the last step in units of its own sigma."""

    pose: FloatArray
    loss: FloatArray
    step: FloatArray
    iterations: int


def total_loss(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> FloatArray:
    """Return the sum of the losses at each pose (..., 3), heading prior included: z^2 / 2 summed for good data."""
    seen = sight(network, pose)
    factor = whitener(network, jacobian(network, pose, seen), damping)
    v_white = whiten_one(network, factor, residuals(network, pose, seen))
    return _loss(network, kernel, damping, _norms(network, damping, v_white), prior_residual(network, pose))


def observation_weights(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> FloatArray:
    """Return the weight of each observation at ``pose`` (..., 3): (..., m) within 0 .. 1, zero where masked out."""
    return _weights(network, kernel, damping, _norms(network, damping, whitened(network, pose, damping)[0]))


def normal_matrix(network: Network, a_white: FloatArray, weights: FloatArray) -> FloatArray:
    """Return A'WA (..., 3, 3) with the heading prior; row and column 2 are zero where the heading is no unknown."""
    matrix: FloatArray = np.swapaxes(a_white * weights[..., None], -1, -2) @ a_white
    if network.prior_counts and network.heading_prior_rad is not None:
        matrix = matrix.copy()
        matrix[..., 2, 2] += 1.0 / network.heading_prior_rad[1] ** 2
    return matrix


def saddle_exits(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Tell which poses (s, 3) are saddles, and return two poses for each, a little down either side.

    Between a place and its mirror image there is a place where no slope leads away.
    """
    u, local = network.unknowns, _local(network, kernel, damping, pose)
    scale = 1.0 / np.sqrt(np.diagonal(local.matrix, axis1=-2, axis2=-1)[..., :u] + _FLOOR[:u])
    values, vectors = np.linalg.eigh(local.newton[..., :u, :u] * scale[..., :, None] * scale[..., None, :])
    saddles = values[:, 0] < -1e-6
    exits = np.zeros((int(np.count_nonzero(saddles)), 3))
    exits[:, :u] = scale[saddles] * vectors[saddles, :, 0]
    nearby_m = 0.01 * np.median(sight(network, pose[saddles]).distance, axis=-1)
    exits *= np.minimum(1.0, nearby_m / np.maximum(np.hypot(exits[:, 0], exits[:, 1]), 1e-9))[:, None]
    return saddles, np.concatenate([pose[saddles] + exits, pose[saddles] - exits])


def minimise(
    network: Network,
    kernel: Kernel,
    damping: Damping,
    starts: FloatArray,
    *,
    tolerance: float = 1e-9,
    iterations: int = 200,
) -> Descent:
    """Go down from each start (s, 3) until a step is shorter than ``tolerance`` sigma.

    Levenberg-Marquardt: a step counts only if it lowers the loss, so ranges alone or nearly collinear marks do not
    make it oscillate. The combined sigma belongs to the pose of the current iteration; both poses of a comparison are
    judged with the same one.
    """
    pose = np.array(starts, np.float64).reshape(-1, 3)
    mu, last = np.full(len(pose), _SMALLEST_MU), np.full(len(pose), np.inf)
    active, count = np.arange(len(pose)), 0
    while len(active) and count < iterations:
        count += 1
        pose[active], mu[active], last[active] = _iterate(network, kernel, damping, pose[active], mu[active])
        active = active[(last[active] > tolerance) & (mu[active] < _LARGEST_MU)]
    return Descent(pose, total_loss(network, kernel, damping, pose), last, count)


class _Local(NamedTuple):
    """The total loss about a pose: its whitener, norms, slope, A'WA and full second derivative."""

    whitener: FloatArray
    z: FloatArray
    gradient: FloatArray
    matrix: FloatArray
    newton: FloatArray


def _local(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> _Local:
    seen = sight(network, pose)
    a = jacobian(network, pose, seen)
    factor = whitener(network, a, damping)
    v_white, a_white = whiten_one(network, factor, residuals(network, pose, seen)), whiten(network, factor, a)
    z = _norms(network, damping, v_white)
    weights = _weights(network, kernel, damping, z)
    matrix = normal_matrix(network, a_white, weights)
    newton = matrix.copy()
    newton[..., :2, :2] += curvature(network, seen, back_to_units(network, factor, weights * v_white))
    if kernel.family != "none":
        newton += _kernel_curvature(network, kernel, damping, a_white, v_white, z)
    return _Local(factor, z, _gradient(network, a_white, weights * v_white, pose), matrix, newton)


def _iterate(
    network: Network, kernel: Kernel, damping: Damping, pose: FloatArray, mu: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Try one step from each pose; return poses, damping parameters and lengths of the steps in sigma."""
    factor, z, gradient, matrix, newton = _local(network, kernel, damping, pose)
    step, length = _step(network, matrix, newton, gradient, mu)
    tried = pose + step
    z_tried = _norms(network, damping, whiten_one(network, factor, residuals(network, tried)))
    before = _loss(network, kernel, damping, z, prior_residual(network, pose))
    after = _loss(network, kernel, damping, z_tried, prior_residual(network, tried))
    better = after <= before * (1.0 + 1e-13)
    mu = np.where(better, np.maximum(mu * 0.1, _SMALLEST_MU), np.maximum(mu * 10.0, 1e-3))
    return np.where(better[:, None], tried, pose), mu, np.where(better | (length < 1e-6), length, np.inf)


def _gradient(network: Network, a_white: FloatArray, damped_v: FloatArray, pose: FloatArray) -> FloatArray:
    """Return A'Wv (s, 3), the slope of the total loss."""
    gradient: FloatArray = (damped_v[..., None, :] @ a_white)[..., 0, :]
    if network.prior_counts and network.heading_prior_rad is not None:
        gradient[..., 2] += prior_residual(network, pose) / network.heading_prior_rad[1]
    return gradient


def _step(
    network: Network, matrix: FloatArray, newton: FloatArray, gradient: FloatArray, mu: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Solve (H + mu D) dx = -A'Wv; return dx (s, 3) and its length sqrt(-g'dx), the decrement in sigma.

    H is the full second derivative of the loss with the absolute values of its eigenvalues (a direction that curves
    down is descended, not climbed), D the diagonal of A'WA: converges quadratically, also with large residuals.
    """
    u = network.unknowns
    scale = 1.0 / np.sqrt(np.diagonal(matrix, axis1=-2, axis2=-1)[..., :u] + _FLOOR[:u])
    values, vectors = np.linalg.eigh(newton[..., :u, :u] * scale[..., :, None] * scale[..., None, :])
    values = np.maximum(np.abs(values), _FLATTEST) + mu[:, None]
    along = (np.swapaxes(vectors, -1, -2) @ (scale * gradient[..., :u])[..., None])[..., 0]
    step = np.zeros((*gradient.shape[:-1], 3))
    step[..., :u] = -scale * (vectors @ (along / values)[..., None])[..., 0]
    return step, np.sqrt(np.sum(along**2 / values, axis=-1))


# ---------------------------------------------------------------------------------------- the kernel over a network


def kernel_arguments(network: Network, damping: Damping, pose: FloatArray) -> FloatArray:
    """Return what the kernel acts on at ``pose`` (..., 3), (..., g) or (..., m)."""
    return np.asarray(_norms(network, damping, whitened(network, pose, damping)[0]) / own_sigma(network, damping))


def own_sigma(network: Network, damping: Damping) -> FloatArray | float:
    """Return the sigma of the residuals in units of that of the observations, (g,) or (m,); 1 by default.

    The squared norm of a target's residuals is on average the sum of their redundancy numbers.
    """
    if network.standard is None:
        return 1.0
    if damping == "separate":
        return network.standard
    sizes = np.maximum(network.block_sizes, 1)
    return np.asarray(np.sqrt(target_sums(network, network.standard**2) / sizes))


def _norms(network: Network, damping: Damping, v_white: FloatArray) -> FloatArray:
    """Return the norm of each target (..., g), or each residual's size (..., m)."""
    return target_norms(network, v_white) if damping == "joint" else np.abs(v_white)


def _stretch(network: Network) -> tuple[IntArray, FloatArray | float]:
    """Return the sizes of the targets and the factor that brings a norm of more than two residuals to that of two."""
    sizes = network.block_sizes
    return sizes, 1.0 if network.blocks.shape[1] <= 2 else np.sqrt(np.maximum(sizes, 2) / 2.0)


def _loss(network: Network, kernel: Kernel, damping: Damping, z: FloatArray, prior: FloatArray) -> FloatArray:
    own = own_sigma(network, damping)
    z = z / own
    if damping == "separate":
        return np.asarray((kernel.loss(z, "separate") * own**2).sum(axis=-1) + 0.5 * prior**2)
    sizes, stretch = _stretch(network)
    joint = kernel.loss(z / stretch, "joint") * stretch**2
    return np.asarray((_mixed(sizes, joint, kernel.loss, z) * own**2).sum(axis=-1) + 0.5 * prior**2)


def _weights(network: Network, kernel: Kernel, damping: Damping, z: FloatArray) -> FloatArray:
    """Return one weight per observation (..., m) from the norms."""
    z = z / own_sigma(network, damping)
    if damping == "separate":
        return kernel.weight(z, "separate") * network.mask
    sizes, stretch = _stretch(network)
    joint = kernel.weight(z / stretch, "joint")
    return spread_to_observations(network, _mixed(sizes, joint, kernel.weight, z))


def _kernel_curvature(
    network: Network, kernel: Kernel, damping: Damping, a_white: FloatArray, v_white: FloatArray, z: FloatArray
) -> FloatArray:
    """Return the part of the second derivative that comes from the falling weight, (..., 3, 3).

    The loss of the norm z of v has the second derivative w I + (dw/dz / z) v v'.
    """
    slopes, own = a_white * v_white[..., None], own_sigma(network, damping)
    z = z / own
    if damping == "separate":
        bend = _weight_slope(kernel, "separate", z) * network.mask
    else:
        slopes = np.swapaxes(target_sums(network, np.swapaxes(slopes, -1, -2)), -1, -2)
        sizes, stretch = _stretch(network)
        joint = _weight_slope(kernel, "joint", z / stretch) / stretch**2
        bend = _mixed(sizes, joint, lambda single: _weight_slope(kernel, "separate", single), z)
    bend = bend / own**2
    return np.asarray(np.swapaxes(slopes * bend[..., None], -1, -2) @ slopes)


def _weight_slope(kernel: Kernel, damping: Damping, z: FloatArray) -> FloatArray:
    """Return dw/dz / z, by differences."""
    z = np.maximum(z, 1e-3)
    return np.asarray((kernel.weight(z + 1e-5, damping) - kernel.weight(z, damping)) / (1e-5 * z))


def _mixed(
    sizes: IntArray, joint: FloatArray, separate: Callable[[FloatArray], FloatArray], z: FloatArray
) -> FloatArray:
    """Take the one-dimensional constants for targets of which only one observation takes part."""
    return joint if sizes.min(initial=2) > 1 else np.where(sizes == 1, separate(z), joint)
