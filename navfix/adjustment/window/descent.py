"""Robust Gauss-Newton over a whole window: the road of our own beside the factor graph."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from navfix.adjustment.window.rows import PAIRS, Plan, Rows
from navfix.errors import Unobservable
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray

DENSE_BELOW = 900  # unknowns: from here on the normal equations are factorised as sparse ones
ROUGH, COARSE, FINE = 0.1, 1e-2, 1e-5  # sigma: the last step of a descent
_ITERATIONS = 40
_LEAST_WEIGHT = 1e-8  # of constant errors: keeps them defined where a mark is given up altogether
_SMALLEST, _LARGEST = 1e-9, 1e9
_STANDS_STILL = 1e-6  # sigma: a step as short as this that does not help is one of rounding


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """Weight of each sighting (k, 2), of each mark's constant errors (M,), and of every row (m,)."""

    sighting: FloatArray
    static: FloatArray
    row: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Descended:
    """Where a descent ended, with the rows and weights there; ``step``: length of the last step in units of sigma."""

    state: FloatArray
    loss: float
    step: float
    iterations: int
    rows: Rows
    weights: Weights


@dataclass(frozen=True, slots=True, eq=False)
class Damper:
    """How rows are damped: each sighting by its own norm, the constant errors of each mark by theirs; eq. (10.7).

    ``taking_part`` (M,): marks that are left in.
    """

    plan: Plan
    kernel: Kernel
    damping: Damping
    components: FloatArray
    taking_part: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

    def rows(self, state: FloatArray) -> Rows:
        """Return the rows at a state."""
        return self.plan.rows(state, self.components)

    def judge(self, residual: FloatArray) -> tuple[float, Weights]:
        """Return the total loss and the weights for the residuals (m,) of `rows`."""
        plan, window = self.plan, self.plan.window
        radar, static = residual[plan.radar].reshape(-1, 2), residual[plan.static]
        used = self.taking_part[window.seen.mark]
        if self.damping == "joint":
            norm = np.hypot(radar[:, 0], radar[:, 1])
            loss, weight = self.kernel.loss(norm, "joint"), self.kernel.weight(norm, "joint")
            each, by_sighting = loss, np.column_stack([weight, weight])
        else:
            each = self.kernel.loss(np.abs(radar), "separate").sum(axis=1)
            by_sighting = self.kernel.weight(np.abs(radar), "separate")
        by_sighting = by_sighting * used[:, None]
        of_mark = plan.layout.static_mark(window)
        stretch = np.sqrt(np.maximum(np.bincount(window.tracks.mark, minlength=plan.layout.marks), 1.0))
        norm = np.sqrt(np.bincount(of_mark, static**2, plan.layout.marks)) / stretch
        by_mark = np.where(self.taking_part, np.maximum(self.kernel.weight(norm, "joint"), _LEAST_WEIGHT), 1.0)
        static_loss = np.where(
            self.taking_part, self.kernel.loss(norm, "joint") * stretch**2, 0.5 * norm**2 * stretch**2
        )
        row = np.ones(len(residual))
        row[plan.radar], row[plan.static] = by_sighting.ravel(), by_mark[of_mark]
        rest = residual.copy()
        rest[plan.radar] = rest[plan.static] = 0.0
        total = float(each @ used) + float(static_loss.sum()) + 0.5 * float(rest @ rest)
        return total, Weights(by_sighting, by_mark, row)

    def at(self, state: FloatArray, step: float = np.inf, iterations: int = 0) -> Descended:
        """Return a state with its loss, rows and weights."""
        rows = self.rows(state)
        loss, weights = self.judge(rows.residual)
        return Descended(state, loss, step, iterations, rows, weights)


def normal_of(damper: Damper, rows: Rows, weights: Weights) -> tuple[Any, FloatArray]:
    """Return A'WA and A'Wv of rows with their weights.

    A'WA is dense for few unknowns, and then only its lower half is filled; for many it is sparse and whole.
    """
    size, weighted = damper.plan.layout.size, rows.values * weights.row[:, None]
    gradient = np.bincount(rows.columns.ravel(), (weighted * rows.residual[:, None]).ravel(), size)
    products = products_of(rows.values, weighted).ravel()
    matrix: Any
    if size < DENSE_BELOW:
        matrix = np.bincount(damper.plan.place, products, size * size).reshape(size, size).T
    else:
        from scipy.sparse import coo_matrix, triu

        half = coo_matrix((products, np.divmod(damper.plan.place, size)), shape=(size, size)).tocsc()
        matrix = half + triu(half, 1).T
    return matrix, np.asarray(gradient, np.float64)


def products_of(left: FloatArray, right: FloatArray) -> FloatArray:
    """Return the products (36, m) of every two derivatives (m, 8) of a row, in the order of `PAIRS`."""
    left, right = np.ascontiguousarray(left.T), np.ascontiguousarray(right.T)
    products = np.empty((len(PAIRS[0]), left.shape[1]))
    begin = 0
    for number, column in enumerate(left):
        end = begin + len(left) - number
        np.multiply(column, right[number:], out=products[begin:end])
        begin = end
    return products


def descend(damper: Damper, start: FloatArray, *, tolerance: float = FINE, iterations: int = _ITERATIONS) -> Descended:
    """Go down from a start until a step is shorter than ``tolerance`` sigma (Levenberg-Marquardt on iterated weights).

    Raises
    ------
    Unobservable : the normal matrix is singular
    """
    here, mu, length, count = damper.at(np.array(start, np.float64)), _SMALLEST, np.inf, 0
    matrix, gradient = normal_of(damper, here.rows, here.weights)
    while count < iterations and length > tolerance and mu < _LARGEST:
        count += 1
        step = -solve_normal(matrix, gradient, mu)
        length = float(np.sqrt(max(-float(gradient @ step), 0.0)))
        there = damper.at(here.state + step)
        if there.loss <= here.loss * (1.0 + 1e-12) + 1e-12:
            here, mu = there, max(mu * 0.1, _SMALLEST)
            if length > tolerance:
                matrix, gradient = normal_of(damper, here.rows, here.weights)
        elif length < _STANDS_STILL:
            break
        else:
            mu, length = max(mu * 10.0, 1e-4), np.inf
    return replace(here, step=length, iterations=count)


def solve_normal(matrix: Any, right: FloatArray, mu: float = 0.0) -> FloatArray:
    """Solve (N + mu diag N) x = right, dense for small N, of which the lower half is read, and sparse for large.

    Raises
    ------
    Unobservable : N is singular
    """
    if isinstance(matrix, np.ndarray):
        from scipy.linalg.lapack import dpotrs

        damped = matrix.copy(order="F")
        damped[np.diag_indices_from(damped)] *= 1.0 + mu
        return np.asarray(dpotrs(_lower_factor(damped), right, lower=True)[0])
    from scipy.sparse import diags
    from scipy.sparse.linalg import splu

    try:
        return np.asarray(splu((matrix + mu * diags(matrix.diagonal())).tocsc()).solve(right))
    except RuntimeError as failure:
        raise Unobservable("the window leaves a direction free", direction="not determined") from failure


def inverse_of(matrix: Any) -> FloatArray:
    """Return the whole inverse of the normal matrix, the cofactor matrix of all unknowns.

    Raises
    ------
    Unobservable : it is singular
    """
    from scipy.linalg.lapack import dpotri

    whole = matrix.copy(order="F") if isinstance(matrix, np.ndarray) else matrix.toarray(order="F")
    half, _ = dpotri(_lower_factor(whole), lower=True, overwrite_c=True)
    lower = np.tril(half)
    return np.asarray(lower + np.tril(lower, -1).T)


def _lower_factor(matrix: FloatArray) -> FloatArray:
    """Return L in the lower half, N = L L', written over ``matrix`` where that is in Fortran's order.

    Straight from LAPACK: on matrices so small scipy's own checks take half of the time.
    """
    from scipy.linalg.lapack import dpotrf

    factor, fails_at = dpotrf(matrix, lower=True, clean=False, overwrite_a=True)
    if fails_at != 0:
        raise Unobservable("the window leaves a direction free", direction="not determined")
    return np.asarray(factor)
