"""The kernel over a network: norms of the targets, their total loss, weights and the curvature of the loss."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from navfix.adjustment.network import Network
from navfix.adjustment.whitening import spread_to_observations, target_norms, target_sums, white_residuals
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray, IntArray


def observation_weights(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> FloatArray:
    """Return the weight of each observation at ``pose`` (..., 3): (..., m) within 0 .. 1, zero where masked out."""
    return weights_of_norms(network, kernel, damping, norms(network, damping, white_residuals(network, pose, damping)))


def kernel_arguments(network: Network, damping: Damping, pose: FloatArray) -> FloatArray:
    """Return what the kernel acts on at ``pose`` (..., 3), (..., g) or (..., m)."""
    return np.asarray(norms(network, damping, white_residuals(network, pose, damping)) / own_sigma(network, damping))


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


def norms(network: Network, damping: Damping, v_white: FloatArray) -> FloatArray:
    """Return the norm of each target (..., g), or each residual's size (..., m)."""
    return target_norms(network, v_white) if damping == "joint" else np.abs(v_white)


def _stretch(network: Network) -> tuple[IntArray, FloatArray | float]:
    """Return the sizes of the targets and the factor that brings a norm of more than two residuals to that of two."""
    sizes = network.block_sizes
    return sizes, 1.0 if network.blocks.shape[1] <= 2 else np.sqrt(np.maximum(sizes, 2) / 2.0)


def loss_of_norms(network: Network, kernel: Kernel, damping: Damping, z: FloatArray, prior: FloatArray) -> FloatArray:
    """Return the total loss (...) from the norms and the heading prior's residual in units of its sigma."""
    own = own_sigma(network, damping)
    z = z / own
    if damping == "separate":
        return np.asarray((kernel.loss(z, "separate") * own**2).sum(axis=-1) + 0.5 * prior**2)
    sizes, stretch = _stretch(network)
    joint = kernel.loss(z / stretch, "joint") * stretch**2
    return np.asarray((_mixed(sizes, joint, kernel.loss, z) * own**2).sum(axis=-1) + 0.5 * prior**2)


def weights_of_norms(network: Network, kernel: Kernel, damping: Damping, z: FloatArray) -> FloatArray:
    """Return one weight per observation (..., m) from the norms."""
    z = z / own_sigma(network, damping)
    if damping == "separate":
        return kernel.weight(z, "separate") * network.mask
    sizes, stretch = _stretch(network)
    joint = kernel.weight(z / stretch, "joint")
    return spread_to_observations(network, _mixed(sizes, joint, kernel.weight, z))


def kernel_curvature(
    network: Network, kernel: Kernel, damping: Damping, a_white: FloatArray, v_white: FloatArray, z: FloatArray
) -> FloatArray:
    """Return the part of the second derivative that comes from the falling weight, (..., 3, 3).

    The loss of the norm z of v has the second derivative w I + (dw/dz / z) v v'.
    """
    slopes, own = a_white * v_white[..., None], own_sigma(network, damping)
    z = z / own
    if damping == "separate":
        bend = weight_slope(kernel, "separate", z) * network.mask
    else:
        slopes = np.swapaxes(target_sums(network, np.swapaxes(slopes, -1, -2)), -1, -2)
        sizes, stretch = _stretch(network)
        joint = weight_slope(kernel, "joint", z / stretch) / stretch**2
        bend = _mixed(sizes, joint, lambda single: weight_slope(kernel, "separate", single), z)
    bend = bend / own**2
    return np.asarray(np.swapaxes(slopes * bend[..., None], -1, -2) @ slopes)


def weight_slope(kernel: Kernel, damping: Damping, z: FloatArray) -> FloatArray:
    """Return dw/dz / z, by differences."""
    z = np.maximum(z, 1e-3)
    return np.asarray((kernel.weight(z + 1e-5, damping) - kernel.weight(z, damping)) / (1e-5 * z))


def _mixed(
    sizes: IntArray, joint: FloatArray, separate: Callable[[FloatArray], FloatArray], z: FloatArray
) -> FloatArray:
    """Take the one-dimensional constants for targets of which only one observation takes part."""
    return joint if sizes.min(initial=2) > 1 else np.where(sizes == 1, separate(z), joint)
