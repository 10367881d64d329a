"""One network to one solution: count, find the minima, choose, check, solve by graph, check again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from navfix.adjustment import graph
from navfix.adjustment.checks import Place, check_counts, check_solution, same_place
from navfix.adjustment.damped import observation_weights
from navfix.adjustment.dense import Linear, linearise, step_from
from navfix.adjustment.landscape import landscape_of
from navfix.adjustment.network import Network
from navfix.adjustment.start import Minimum, find_minima, follow_given
from navfix.errors import InputError
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray
from navfix.units import wrap_pi

Solver = Literal["auto", "gtsam", "dense"]
_AGREE = 1e-4  # sigma: how well the two roads must agree
_COFACTORS_AGREE = 1e-3  # of the cofactors


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """Where a network was solved.

    ``pose`` (3,) north m, east m, heading rad (0 where it is not an unknown); ``linear``: the observations about it;
    ``cofactor`` (u, u) = (A'WA)^-1; ``loss`` in units of z^2 / 2; ``others``: the other distinct minima,
    lowest loss first; ``settled`` False where the descent went on and on: the sigmas change with the pose, and
    residuals of a great many sigmas can chase them in circles.
    """

    pose: FloatArray
    loss: float
    linear: Linear
    cofactor: FloatArray
    start: str
    solver: str
    others: tuple[Minimum, ...]
    settled: bool = True

    @property
    def weights(self) -> FloatArray:
        """Weight of each observation (m,)."""
        return self.linear.weights


def solve(
    network: Network,
    kernel: Kernel,
    damping: Damping = "joint",
    *,
    start: FloatArray | None = None,
    candidates: Sequence[tuple[str, FloatArray]] = (),
    solver: Solver = "auto",
    place: Place | None = None,
) -> Solution:
    """Solve a network.

    Parameters
    ----------
    start : pose (3,); the minimum reached from it is the solution and the others are only listed. Without it the
        lowest loss is the solution, if nothing else explains the data nearly as well.
    candidates : named poses that are starts among others
    solver : "gtsam", "dense", or "auto": GTSAM where it is installed
    place : turns a pose into a place and a heading [deg] for the alternatives of `Ambiguous`; default a plane position

    Raises
    ------
    TooFewPairs : fewer observations than unknowns
    Unobservable : the geometry, or what the kernel has left of it, leaves a direction free
    NoAgreement : the kernel has given up so much that the rest does not determine the unknowns
    Ambiguous : another place explains the data nearly as well (not with ``start``)
    """
    check_counts(network)
    minima = find_minima(network, kernel, damping, given=tuple(candidates))
    if start is not None:
        best = follow_given(network, kernel, damping, np.asarray(start, np.float64), minima)
        minima = [best, *(m for m in minima if not same_place(network, m.pose, best.pose))]
    check_solution(network, kernel, damping, minima, place=place, rivals=start is None)
    return finish(network, kernel, damping, minima[0], others=tuple(minima[1:]), solver=solver)


def finish(
    network: Network,
    kernel: Kernel,
    damping: Damping,
    minimum: Minimum,
    *,
    others: tuple[Minimum, ...] = (),
    solver: Solver = "auto",
) -> Solution:
    """Solve from a minimum that is known already, by the graph or by dense normal equations, and check the result.

    GTSAM reports success also where nothing was solved. So its pose must be a stationary point of the dense equations
    (the next step shorter than 1e-4 sigma), its loss not above that of the start and its marginal covariance theirs to
    1e-3; else the dense solution stands. The cofactor matrix is that of the dense equations at the graph's pose: held
    marks cost the marginals up to four digits (one random case of 300).

    Raises
    ------
    InputError : ``solver`` "gtsam" where it is not installed
    """
    if solver == "gtsam" and not graph.available():
        raise InputError("solver 'gtsam' needs GTSAM, which is not installed here; take 'dense' (the same answer)")
    if solver != "dense" and graph.available():
        known = observation_weights(network, kernel, damping, minimum.pose)
        found = graph.solve(network, kernel, damping, minimum.pose, weights=known)
        local = landscape_of(network, kernel, damping).about(found.pose[None, :])
        loss, step = float(local.loss[0]), float(step_from(network, local)[1][0])
        if step < _AGREE and loss <= minimum.loss + 1e-6 * (1.0 + minimum.loss):
            solution = _at(network, kernel, damping, replace(minimum, pose=found.pose, loss=loss), "gtsam", others)
            if _cofactors_agree(solution.cofactor, found.cofactor):
                return solution
    local = landscape_of(network, kernel, damping).about(minimum.pose[None, :])
    settled = float(step_from(network, local)[1][0]) < _AGREE
    return replace(_at(network, kernel, damping, minimum, "dense", others), settled=settled)


def _cofactors_agree(cofactor: FloatArray, other: FloatArray) -> bool:
    sigma = np.sqrt(np.diag(cofactor))
    apart = np.abs(other[: len(cofactor), : len(cofactor)] - cofactor) / np.outer(sigma, sigma)
    return bool(np.max(apart) < _COFACTORS_AGREE)


def _at(
    network: Network, kernel: Kernel, damping: Damping, minimum: Minimum, solver: str, others: tuple[Minimum, ...]
) -> Solution:
    """Return the solution at a minimum, with the cofactors of the normal equations there."""
    pose = _tidy(network, minimum.pose)
    linear = linearise(network, kernel, damping, pose)
    cofactor = np.asarray(np.linalg.inv(linear.normal_matrix(network)), np.float64)
    return Solution(pose, minimum.loss, linear, cofactor, minimum.start, solver, others)


def _tidy(network: Network, pose: FloatArray) -> FloatArray:
    """Return the pose with its heading within -pi .. pi, zero where it is not an unknown."""
    return np.array([pose[0], pose[1], float(wrap_pi(pose[2])) if network.heading_unknown else 0.0])
