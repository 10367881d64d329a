"""One epoch as a factor graph.

Own ship is a Pose2 (x = north, y = east, theta = heading: its angle is the heading and its bearings are the relative
bearings), every mark a Point2.

A mark's own uncertainty is folded into the noise of its factors and the mark is held where it was given. With a free
mark and a prior the mark would move to meet its observation and swallow a part of the residual: the kernel, which sits
on the factor between ship and mark, would see v / sigma of what is left and damp too little, and the prior would still
pull with full weight when the observation is long given up. Folded in, the residual is that against the mark as given,
the sigma is that of radar and mark together, and the dense road gives the same answer. The noise depends on the
bearing and distance of the mark; it is renewed at the solution until that stands still.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from navfix.adjustment.damped import own_sigma
from navfix.adjustment.network import RANGE, RELATIVE_BEARING, Network
from navfix.adjustment.sights import effective_sigma, jacobian, residuals
from navfix.adjustment.whitening import block_covariance
from navfix.errors import Unobservable
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

POSE = 0  # keys: the pose, then mark i at 1 + i
_STANDS_STILL = 1e-8  # m and rad
_RENEWALS = 20
_NO_WEIGHT = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class GraphSolution:
    """Pose (3,), covariance (3, 3) in (north m, east m, heading rad) without sigma0, and twice the error (chi2)."""

    pose: FloatArray
    cofactor: FloatArray
    chi2: float
    iterations: int


@cache
def available() -> bool:
    """Tell whether GTSAM is installed (there are no wheels for Windows and for macOS on Intel)."""
    return importlib.util.find_spec("gtsam") is not None


def load() -> None:
    """Import GTSAM now where it is installed: a quarter of a second that the first solve would pay for otherwise."""
    if available():
        importlib.import_module("gtsam")


def solve(
    network: Network, kernel: Kernel, damping: Damping, start: FloatArray, *, weights: FloatArray | None = None
) -> GraphSolution:
    """Minimise the losses of all factors from ``start`` (3,) and take the joint marginal covariance of the pose.

    With ``weights`` (m,), those of the kernel at a minimum that is known already, the factors carry them as they are:
    no kernel is called back, and the minimum is one of weighted least squares. Whoever gives them checks that the
    result is stationary under the kernel too.

    Without relative bearings no factor depends on the heading; a prior holds it at the start, and its row and column
    of the covariance are to be ignored.

    Raises
    ------
    Unobservable : GTSAM found the linear system indeterminate (ranks are checked before this is called)
    """
    pose, iterations = np.asarray(start, np.float64), 0
    try:
        for _ in range(_RENEWALS):
            graph, solution, count, error = _optimise(network, kernel, damping, pose, weights)
            iterations += count
            found = solution.atPose2(POSE)
            moved = np.array([found.x(), found.y(), found.theta()]) - pose
            moved[2] = math.remainder(moved[2], 2.0 * math.pi)
            pose = pose + moved
            if np.all(np.abs(moved) < _STANDS_STILL) or not np.any(network.mark_covariance_m2):
                break
        return GraphSolution(pose, _marginal(graph, solution), 2.0 * error, iterations)
    except RuntimeError as failure:
        said = " ".join(str(failure).split()).partition(".")[0]
        raise Unobservable(f"GTSAM cannot solve this graph: {said}", direction="not determined") from failure


def _optimise(
    network: Network, kernel: Kernel, damping: Damping, pose: FloatArray, weights: FloatArray | None
) -> tuple[Any, Any, int, float]:
    import gtsam

    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    values.insert(POSE, gtsam.Pose2(*pose))
    taking_part = network.mask if weights is None else network.mask & (weights > _NO_WEIGHT)
    held = gtsam.noiseModel.Constrained.All(2)
    for mark in np.unique(network.mark[taking_part]).tolist():
        place = network.mark_ne_m[mark]
        values.insert(1 + mark, place)
        graph.add(gtsam.PriorFactorPoint2(1 + mark, place, held))
    factors = (
        _factors(network, kernel, damping, pose) if weights is None else _weighted(network, damping, pose, weights)
    )
    for factor in factors:
        graph.add(factor)
    for heading_rad, sigma_rad in _heading_priors(network, pose):
        noise = gtsam.noiseModel.Isotropic.Sigma(1, sigma_rad)
        graph.add(gtsam.PoseRotationPrior2D(POSE, gtsam.Rot2(heading_rad), noise))
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values, _parameters())
    solution = optimizer.optimize()
    return graph, solution, optimizer.iterations(), optimizer.error()


@cache
def _parameters() -> Any:
    import gtsam

    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-13)
    parameters.setAbsoluteErrorTol(1e-13)
    parameters.setMaxIterations(200)
    return parameters


def _heading_priors(network: Network, pose: FloatArray) -> Sequence[tuple[float, float]]:
    if not network.heading_unknown:
        return [(float(pose[2]), 1.0)]
    return [] if network.heading_prior_rad is None else [network.heading_prior_rad]


def _marginal(graph: Any, solution: Any, key: int = POSE) -> FloatArray:
    """Return the marginal covariance of the pose in north and east."""
    import gtsam

    return _in_north_east(gtsam.Marginals(graph, solution).marginalCovariance(key), solution, key)


def _in_north_east(marginal: FloatArray, solution: Any, key: int) -> FloatArray:
    """Rotate the marginal covariance of the pose from the ship's axes into north and east."""
    heading_rad = solution.atPose2(key).theta()
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(rotation @ marginal @ rotation.T)


# ---------------------------------------------------------------------------------------------------------- factors


def _factors(network: Network, kernel: Kernel, damping: Damping, pose: FloatArray) -> Iterator[Any]:
    """Yield one factor per target (joint damping) or per observation (separate damping)."""
    import gtsam

    at_pose = jacobian(network, pose)
    if damping == "separate":
        sigma, own = effective_sigma(network, at_pose), np.broadcast_to(own_sigma(network, damping), network.kind.shape)
        for index in np.flatnonzero(network.mask).tolist():
            robust = _robust(kernel, "separate", float(own[index]))
            yield _factor(network, [index], robust(gtsam.noiseModel.Isotropic.Sigma(1, float(sigma[index]))))
        return
    covariance = block_covariance(network, at_pose)
    own = np.broadcast_to(own_sigma(network, damping), network.block_sizes.shape)
    stretch = own * np.sqrt(np.maximum(network.block_sizes, 2) / 2.0)
    for block, size, matrix, by in zip(network.blocks, network.block_sizes, covariance, stretch, strict=True):
        robust = _robust(kernel, "separate" if size == 1 else "joint", float(by))
        members, matrix = _in_gtsam_order(network, [int(i) for i in block[:size]], matrix[:size, :size])
        yield _factor(network, members, robust(gtsam.noiseModel.Gaussian.Covariance(matrix)))


def _weighted(network: Network, damping: Damping, pose: FloatArray, weights: FloatArray) -> Iterator[Any]:
    """Yield the same factors with variances divided by their weights, and none where nothing is left."""
    import gtsam

    at_pose = jacobian(network, pose)
    if damping == "separate" or network.diagonal:
        sigma = effective_sigma(network, at_pose) / np.sqrt(np.maximum(weights, _NO_WEIGHT))
        groups = np.arange(len(weights))[network.mask, None] if damping == "separate" else network.blocks
        for group in groups.tolist():
            members = [index for index in group if index >= 0]
            if weights[members[0]] > _NO_WEIGHT:
                members.sort(key=lambda index: bool(network.is_range[index]))
                yield _factor(network, members, gtsam.noiseModel.Diagonal.Sigmas(sigma[members]))
        return
    covariance = block_covariance(network, at_pose)
    for block, size, matrix in zip(network.blocks, network.block_sizes, covariance, strict=True):
        weight = float(weights[block[0]])
        if weight > _NO_WEIGHT:
            members, part = _in_gtsam_order(network, [int(i) for i in block[:size]], matrix[:size, :size])
            yield _factor(network, members, gtsam.noiseModel.Gaussian.Covariance(part / weight))


def _in_gtsam_order(network: Network, members: list[int], covariance: FloatArray) -> tuple[list[int], FloatArray]:
    """Put bearings before ranges, as BearingRangeFactor2D wants them."""
    order = sorted(range(len(members)), key=lambda i: network.kind[members[i]] == RANGE)
    return [members[i] for i in order], covariance[np.ix_(order, order)]


def _factor(network: Network, members: list[int], noise: Any) -> Any:
    """Return GTSAM's own factor where it has one, else a custom one (true bearings, more than two observations)."""
    import gtsam

    kinds, value = [int(network.kind[i]) for i in members], network.value
    key = 1 + int(network.mark[members[0]])
    if kinds == [RELATIVE_BEARING, RANGE]:
        return gtsam.BearingRangeFactor2D(POSE, key, gtsam.Rot2(value[members[0]]), float(value[members[1]]), noise)
    if kinds == [RELATIVE_BEARING]:
        return gtsam.BearingFactor2D(POSE, key, gtsam.Rot2(value[members[0]]), noise)
    if kinds == [RANGE]:
        return gtsam.RangeFactor2D(POSE, key, float(value[members[0]]), noise)
    keys = [POSE, *(1 + int(mark) for mark in np.unique(network.mark[members]))]
    return gtsam.CustomFactor(noise, keys, _error_function(_part(network, members)))


def _part(network: Network, members: list[int]) -> Network:
    return replace(
        network,
        standard=None,
        **{name: getattr(network, name)[members] for name in ("kind", "mark", "value", "sigma", "target", "mask")},
    )


def _error_function(part: Network) -> Callable[[Any, Any, Any], FloatArray]:
    """Make the error and its derivatives of the observations in ``part`` from the arrays of the network.

    A true bearing does not depend on the heading, which no factor of GTSAM on a Pose2 offers. GTSAM's increments of a
    pose are in the ship's axes, so the position part of the Jacobian is turned by the heading.
    """

    marks = np.unique(part.mark)

    def error(_factor: Any, values: Any, jacobians: Any) -> FloatArray:
        own = values.atPose2(POSE)
        pose = np.array([own.x(), own.y(), own.theta()])
        if jacobians is not None:
            a = jacobian(part, pose)
            c, s = math.cos(pose[2]), math.sin(pose[2])
            jacobians[0] = np.asfortranarray(np.column_stack([a[:, :2] @ np.array([[c, -s], [s, c]]), a[:, 2]]))
            for place, mark in enumerate(marks, start=1):
                jacobians[place] = np.asfortranarray(np.where((part.mark == mark)[:, None], -a[:, :2], 0.0))
        return residuals(part, pose)

    return error


def _robust(kernel: Kernel, damping: Damping, stretch: float) -> Callable[[Any], Any]:
    """Return what wraps a noise model in the kernel; its norm is divided by ``stretch`` first."""
    import gtsam

    if kernel.family == "none":
        return lambda noise: noise
    estimator = gtsam.noiseModel.mEstimator.Custom.Create(
        weight=lambda z: float(kernel.weight(abs(float(z)) / stretch, damping)),
        loss=lambda z: float(kernel.loss(abs(float(z)) / stretch, damping)) * stretch**2,
        reweight=gtsam.noiseModel.mEstimator.Base.ReweightScheme.Block,
        name=kernel.name,
    )
    return lambda noise: gtsam.noiseModel.Robust.Create(estimator, noise)
