"""Observations in units of their sigma, alone or decorrelated within one target."""

from __future__ import annotations

import numpy as np

from navfix.adjustment.network import Network
from navfix.adjustment.sights import effective_sigma, jacobian, residuals, sight
from navfix.kernels import Damping
from navfix.types import FloatArray


def whitener(network: Network, jacobian_: FloatArray, damping: Damping = "joint") -> FloatArray:
    """Return what turns residuals into uncorrelated ones of unit variance, for `whiten`.

    Range and bearing of one mark are uncorrelated when the mark's sigma is the same in every direction: the inverse
    sigma (..., m), zero where masked out. Otherwise joint damping decorrelates the observations of each target by the
    inverse Cholesky factor of their covariance, (..., g, K, K); separate damping looks at each observation by itself
    and leaves the correlation out.
    """
    if network.diagonal or damping == "separate":
        return np.asarray(network.mask / effective_sigma(network, jacobian_))
    return np.linalg.inv(np.linalg.cholesky(block_covariance(network, jacobian_)))


def whiten(network: Network, whitener_: FloatArray, columns: FloatArray) -> FloatArray:
    """Return ``columns`` (..., m, c) in units of sigma, zero where masked out; leading axes as in the whitener."""
    if whitener_.ndim < columns.ndim:
        return columns * whitener_[..., None]
    used = network.blocks >= 0
    padded = np.where(used[..., None], columns[..., network.blocks, :], 0.0)
    result = np.zeros_like(columns)
    result[..., network.blocks[used], :] = (whitener_ @ padded)[..., used, :]
    return result


def whiten_one(network: Network, whitener_: FloatArray, column: FloatArray) -> FloatArray:
    """Return one column (..., m) in units of sigma."""
    if whitener_.ndim == column.ndim:
        return column * whitener_
    return whiten(network, whitener_, column[..., None])[..., 0]


def back_to_units(network: Network, whitener_: FloatArray, white: FloatArray) -> FloatArray:
    """Return the transposed whitener times ``white`` (..., m): derivatives by the observations in their own units."""
    if whitener_.ndim == white.ndim:
        return white * whitener_
    used = network.blocks >= 0
    padded = np.where(used, white[..., network.blocks], 0.0)
    result = np.zeros_like(white)
    result[..., network.blocks[used]] = (np.swapaxes(whitener_, -1, -2) @ padded[..., None])[..., used, 0]
    return result


def whitened(network: Network, pose: FloatArray, damping: Damping = "joint") -> tuple[FloatArray, FloatArray]:
    """Return residuals (..., m) and Jacobian (..., m, 3) in units of their sigma at ``pose`` (..., 3)."""
    seen = sight(network, pose)
    a = jacobian(network, pose, seen)
    factor = whitener(network, a, damping)
    return whiten_one(network, factor, residuals(network, pose, seen)), whiten(network, factor, a)


def normal_matrix(network: Network, a_white: FloatArray, weights: FloatArray) -> FloatArray:
    """Return A'WA (..., 3, 3) with the heading prior; row and column 2 are zero where the heading is no unknown."""
    matrix: FloatArray = np.swapaxes(a_white * weights[..., None], -1, -2) @ a_white
    if network.prior_counts and network.heading_prior_rad is not None:
        matrix = matrix.copy()
        matrix[..., 2, 2] += 1.0 / network.heading_prior_rad[1] ** 2
    return matrix


def white_residuals(network: Network, pose: FloatArray, damping: Damping = "joint") -> FloatArray:
    """Return residuals (..., m) in units of their sigma at ``pose`` (..., 3)."""
    seen = sight(network, pose)
    factor = whitener(network, jacobian(network, pose, seen), damping)
    return whiten_one(network, factor, residuals(network, pose, seen))


def block_covariance(network: Network, jacobian_: FloatArray) -> FloatArray:
    """Return the covariance of the observations of each target, (..., g, K, K); unused places have variance 1."""
    used = network.blocks >= 0
    j = np.where(used[..., None], jacobian_[..., network.blocks, :2], 0.0)
    mark = network.mark[network.blocks[:, 0]]
    variance = np.where(used, network.sigma[network.blocks] ** 2, 1.0)
    covariance: FloatArray = j @ network.mark_covariance_m2[mark] @ np.swapaxes(j, -1, -2)
    return covariance + variance[..., None] * np.eye(network.blocks.shape[1])


def target_sums(network: Network, per_observation: FloatArray) -> FloatArray:
    """Add up what belongs to one target: (..., m) -> (..., g)."""
    if network.in_order:
        return np.asarray(per_observation.reshape(*per_observation.shape[:-1], *network.blocks.shape).sum(axis=-1))
    return np.asarray(np.where(network.blocks >= 0, per_observation[..., network.blocks], 0.0).sum(axis=-1))


def target_norms(network: Network, v_white: FloatArray) -> FloatArray:
    """Return the norm of each target's whitened residuals, (..., g): chi with as many dof as it has observations."""
    return np.asarray(np.sqrt(target_sums(network, v_white**2)))


def spread_to_observations(network: Network, per_target: FloatArray) -> FloatArray:
    """Give each observation the value of its target: (..., g) -> (..., m); zero where it does not take part."""
    if network.in_order:
        return np.repeat(per_target, network.blocks.shape[1], axis=-1)
    used = network.blocks >= 0
    result = np.zeros((*per_target.shape[:-1], len(network.kind)))
    repeated = np.broadcast_to(per_target[..., None], (*per_target.shape, used.shape[1]))
    result[..., network.blocks[used]] = repeated[..., used]
    return result
