"""Dense normal equations: Levenberg-Marquardt on iterated weights, for many starts at once.

The second road to every adjustment: it serves the trial starts, checks the factor graph, and stands in where GTSAM
has no wheel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.adjustment.damped import loss_of_norms, norms, weights_of_norms
from navfix.adjustment.landscape import Local, landscape_of
from navfix.adjustment.network import BoolArray, Network
from navfix.adjustment.sights import jacobian, prior_residual, residuals, sight
from navfix.adjustment.whitening import normal_matrix, white_residuals, whiten, whiten_one, whitener
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray

_SMALLEST_MU, _LARGEST_MU = 1e-9, 1e12
_FLATTEST = 1e-9  # smallest curvature, in units of that of one sigma
_FLOOR = np.array([1e-15, 1e-15, 1e-9])  # keeps the step defined where nothing depends on an unknown


@dataclass(frozen=True, slots=True, eq=False)
class Descent:
    """Where each start ended.

    ``pose`` (s, 3), ``loss`` (s,), ``step`` (s,) the last step in units of its own sigma; ``local``: the landscape
    about the poses.
    """

    pose: FloatArray
    loss: FloatArray
    step: FloatArray
    iterations: int
    local: Local

    def take(self, indices: FloatArray | list[int]) -> Descent:
        """Return some of the starts."""
        chosen = np.asarray(indices)
        local = Local(*(array[chosen] for array in self.local))
        return Descent(self.pose[chosen], self.loss[chosen], self.step[chosen], self.iterations, local)


def total_loss(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> FloatArray:
    """Return the sum of the losses at each pose (..., 3), heading prior included: z^2 / 2 summed for good data."""
    z = norms(network, damping, white_residuals(network, pose, damping))
    return loss_of_norms(network, kernel, damping, z, prior_residual(network, pose))


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
    judged with the same one. Only where a step was taken the landscape is looked at anew.
    """
    landscape, pose = landscape_of(network, kernel, damping), np.array(starts, np.float64).reshape(-1, 3)
    local = landscape.about(pose)
    mu, last = np.full(len(pose), _SMALLEST_MU), np.full(len(pose), np.inf)
    active, count = np.arange(len(pose)), 0
    while len(active) and count < iterations:
        count += 1
        here = local if len(active) == len(pose) else Local(*(array[active] for array in local))
        step, length = step_from(network, here, mu[active])
        tried = pose[active] + step
        view = landscape.view(tried)
        better = landscape.loss(tried, view, here.scale) <= here.loss * (1.0 + 1e-13)
        mu[active] = np.where(better, np.maximum(mu[active] * 0.1, _SMALLEST_MU), np.maximum(mu[active] * 10.0, 1e-3))
        last[active] = np.where(better | (length < 1e-6), length, np.inf)
        moved = active[better]
        if len(moved):
            pose[moved] = tried[better]
            if len(moved) < len(active):
                view = tuple(array[better] for array in view)
            for kept, new in zip(local, landscape.about(pose[moved], view), strict=True):
                kept[moved] = new
        active = active[(last[active] > tolerance) & (mu[active] < _LARGEST_MU)]
    return Descent(pose, local.loss, last, count, local)


def step_from(network: Network, local: Local, mu: FloatArray | float = _SMALLEST_MU) -> tuple[FloatArray, FloatArray]:
    """Solve (H + mu D) dx = -A'Wv; return dx (s, 3) and its length sqrt(-g'dx), the decrement in sigma.

    H is the full second derivative of the loss with the absolute values of its eigenvalues (a direction that curves
    down is descended, not climbed), D the diagonal of A'WA: converges quadratically, also with large residuals.
    """
    u = network.unknowns
    scale, values, vectors = _principal_curvatures(network, local)
    values = np.maximum(np.abs(values), _FLATTEST) + np.asarray(mu)[..., None]
    along = (np.swapaxes(vectors, -1, -2) @ (scale * local.gradient[:, :u])[..., None])[..., 0]
    step = np.zeros_like(local.gradient)
    step[:, :u] = -scale * (vectors @ (along / values)[..., None])[..., 0]
    return step, np.sqrt(np.sum(along**2 / values, axis=-1))


def saddle_exits(network: Network, descent: Descent) -> tuple[BoolArray, FloatArray]:
    """Tell which starts (s,) ended in a saddle, and return two poses for each, a little down either side.

    Between a place and its mirror image there is a place where no slope leads away.
    """
    u, pose = network.unknowns, descent.pose
    scale, values, vectors = _principal_curvatures(network, descent.local)
    saddles = values[:, 0] < -1e-6
    exits = np.zeros((int(np.count_nonzero(saddles)), 3))
    if not len(exits):
        return saddles, exits
    exits[:, :u] = scale[saddles] * vectors[saddles, :, 0]
    nearby_m = 0.01 * np.median(sight(network, pose[saddles]).distance, axis=-1)
    exits *= np.minimum(1.0, nearby_m / np.maximum(np.hypot(exits[:, 0], exits[:, 1]), 1e-9))[:, None]
    return saddles, np.concatenate([pose[saddles] + exits, pose[saddles] - exits])


def _principal_curvatures(network: Network, local: Local) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return units (s, u) in which each unknown has one sigma, and the curvatures and their directions in them."""
    u = network.unknowns
    scale = 1.0 / np.sqrt(local.diagonal[:, :u] + _FLOOR[:u])
    return scale, *np.linalg.eigh(local.newton[:, :u, :u] * scale[:, :, None] * scale[:, None, :])


# ---------------------------------------------------------------------------------------------------------- one pose


@dataclass(frozen=True, slots=True, eq=False)
class Linear:
    """The observations about one pose (3,): all that checks, graph and report ask for, made once.

    ``residual`` (m,) and ``jacobian`` (m, 3) in m and rad, the same in units of sigma (``v_white``, ``a_white``), what
    whitens them, and the kernel's ``weights`` (m,).
    """

    pose: FloatArray
    residual: FloatArray
    jacobian: FloatArray
    whitener: FloatArray
    v_white: FloatArray
    a_white: FloatArray
    weights: FloatArray

    def normal_matrix(self, network: Network) -> FloatArray:
        """Return A'WA (u, u)."""
        u = network.unknowns
        return normal_matrix(network, self.a_white, self.weights)[:u, :u]


def linearise(network: Network, kernel: Kernel | None, damping: Damping, pose: FloatArray) -> Linear:
    """Return the observations about a pose (3,), undamped without a kernel."""
    seen = sight(network, pose)
    a, v = jacobian(network, pose, seen), residuals(network, pose, seen)
    factor = whitener(network, a, damping)
    v_white = whiten_one(network, factor, v)
    if kernel is None:
        weights = network.mask.astype(np.float64)
    else:
        weights = weights_of_norms(network, kernel, damping, norms(network, damping, v_white))
    return Linear(pose, v, a, factor, v_white, whiten(network, factor, a), weights)
