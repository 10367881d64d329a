"""One target more, or one less: neighbours of a minimum where a kernel gives up targets that nearly agree."""

from __future__ import annotations

import numpy as np

from navfix.adjustment.dense import linearise
from navfix.adjustment.network import Network
from navfix.adjustment.whitening import normal_matrix
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray

_KEPT = 0.5  # weight from which on a target counts as kept


def exchanges(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> FloatArray:
    """Return poses (e, 3), e <= g: about ``pose`` (3,) each kept target is given up once, and each other one taken in.

    One linear step with the other weights as they are; a target without which nothing determines the pose is left out.
    The exchange of least trimmed squares (Rousseeuw and Van Driessen, 2006), for kernels with soft edges.
    """
    linear, u = linearise(network, kernel, damping, pose), network.unknowns
    used = network.blocks >= 0
    weights = np.tile(linear.weights, (len(network.blocks), 1))
    kept = linear.weights[network.blocks[:, 0]] > _KEPT
    rows = np.broadcast_to(np.arange(len(kept))[:, None], used.shape)[used]
    weights[rows, network.blocks[used]] = np.where(kept, 0.0, 1.0)[rows]
    a, v = linear.a_white, linear.v_white
    matrix = normal_matrix(network, np.broadcast_to(a, (len(kept), *a.shape)), weights)[:, :u, :u]
    scale = 1.0 / np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), 1e-30))
    scaled = matrix * scale[:, :, None] * scale[:, None, :]
    fine = np.linalg.cond(scaled) < 1e9
    gradient = ((weights * v) @ a)[:, :u] * scale
    poses = np.tile(pose, (int(np.count_nonzero(fine)), 1))
    poses[:, :u] -= np.linalg.solve(scaled[fine], gradient[fine][..., None])[..., 0] * scale[fine]
    return poses
