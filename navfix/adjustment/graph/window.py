"""A window of epochs as a factor graph: poses, what they share, and what stays with a mark, in GTSAM.

Keys: pose e at e, the globals at E, the errors that stay with mark j (its offset, then the constants of its tracks) at
E + 1 + j. One factor for each epoch, one for each step of own ship's motion, one prior for the globals and for each
mark. The weights of the kernel at a solution that is known already stand in the factors: what GTSAM adds is its own
linearisation on the manifold of poses, its own elimination, and the marginal covariance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from navfix.adjustment.graph.epoch import GraphSolution, _in_north_east, _marginal, _parameters
from navfix.errors import Unobservable
from navfix.types import FloatArray, IntArray

if TYPE_CHECKING:
    from navfix.adjustment.window.descent import Damper

_NO_WEIGHT = 1e-9
_SOLVED = 1e-4  # sigma: from so near, one more linearisation moves nothing


def solve(damper: Damper, start: FloatArray) -> tuple[GraphSolution, FloatArray]:
    """Minimise from a state under the weights that it has; return the newest pose and the whole state.

    Raises
    ------
    Unobservable : GTSAM found the linear system indeterminate
    """
    import gtsam

    blocks = _Blocks(damper, start)
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for key, columns in enumerate(blocks.columns):
        part = start[columns]
        values.insert(key, gtsam.Pose2(*part) if key < blocks.epochs else part)
    for factor in blocks.factors():
        graph.add(factor)
    try:
        newest = blocks.epochs - 1
        linear = graph.linearize(values)
        step = linear.optimize()
        if _length(linear, step) < _SOLVED:  # solved already: the same linear system gives step and covariance
            solution, iterations, error = values.retract(step), 1, linear.error(step)
            cofactor = _in_north_east(gtsam.Marginals(linear, values).marginalCovariance(newest), values, newest)
        else:
            optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values, _parameters())
            solution = optimizer.optimize()
            iterations, error = optimizer.iterations(), optimizer.error()
            cofactor = _marginal(graph, solution, newest)
        state = blocks.state(solution)
    except RuntimeError as failure:
        said = " ".join(str(failure).split()).partition(".")[0]
        raise Unobservable(f"GTSAM cannot solve this window: {said}", direction="not determined") from failure
    pose = state[blocks.columns[newest]]
    return GraphSolution(pose, cofactor, 2.0 * error, iterations), state


def _length(linear: Any, step: Any) -> float:
    """Return the length of a Gauss-Newton step in units of sigma: what it takes off the sum of squares, its root."""
    nothing = step.scale(0.0)
    return math.sqrt(max(2.0 * (linear.error(nothing) - linear.error(step)), 0.0))


class _Blocks:
    """The unknowns by key, and the rows of the window by factor."""

    def __init__(self, damper: Damper, start: FloatArray) -> None:
        self._damper, layout = damper, damper.plan.layout
        self.epochs = layout.epochs
        shared = layout.shared
        of_mark = layout.static_mark(damper.plan.window)
        static = np.arange(shared + 5, layout.size)
        self.columns: list[IntArray] = [np.arange(3 * e, 3 * e + 3) for e in range(layout.epochs)]
        self.columns.append(np.arange(shared, shared + 5))
        self.columns += [static[of_mark == mark] for mark in range(layout.marks)]
        self._key = np.empty(layout.size, np.int64)
        for key, columns in enumerate(self.columns):
            self._key[columns] = key
        self._start = np.array(start)
        rows = damper.rows(start)
        _, weights = damper.judge(rows.residual)
        self._root, self._rows = np.sqrt(weights.row), rows
        self._cache: tuple[FloatArray, Any] | None = None

    def factors(self) -> list[Any]:
        """Return the factors: rows that depend on the same group of unknowns belong together."""
        import gtsam

        plan, rows = self._damper.plan, self._rows
        groups: dict[int, list[int]] = {}
        for row in range(len(rows.residual)):
            if self._root[row] ** 2 > _NO_WEIGHT:
                groups.setdefault(self._group(row, plan), []).append(row)
        noise: dict[int, Any] = {}
        found = []
        for members in groups.values():
            index = np.array(members)
            keys = np.unique(self._key[rows.columns[index][rows.values[index] != 0.0]]).tolist()
            size = len(members)
            if size not in noise:
                noise[size] = gtsam.noiseModel.Unit.Create(size)
            found.append(gtsam.CustomFactor(noise[size], keys, self._error_function(index, keys)))
        return found

    def _group(self, row: int, plan: Any) -> int:
        """Return a number for the factor of a row: by epoch of a sighting, mark of a constant, step of a move."""
        if row < plan.radar.stop:
            return int(plan.window.seen.epoch[row // 2])
        if row < plan.static.stop:
            return 10**6 + int(self._key[self._rows.columns[row, 0]])
        return 2 * 10**6 + int(self._rows.columns[row].max() // 3) * 10 + int(self._rows.component[row])

    def _error_function(self, index: IntArray, keys: list[int]) -> Callable[[Any, Any, Any], FloatArray]:
        root = self._root[index]
        columns = np.concatenate([self.columns[key] for key in keys])
        place = np.zeros(self._damper.plan.layout.size, np.int64)
        place[columns] = np.arange(len(columns))
        splits = np.cumsum([len(self.columns[key]) for key in keys])[:-1]
        poses = [i for i, key in enumerate(keys) if key < self.epochs]

        def error(_factor: Any, values: Any, jacobians: Any) -> FloatArray:
            rows = self._at(values, keys, columns)
            if jacobians is not None:
                a = np.zeros((len(index), len(columns)))
                at = np.arange(len(index))[:, None]
                np.add.at(a, (at, place[rows.columns[index]]), rows.values[index] * root[:, None])
                for i, part in enumerate(np.split(a, splits, axis=1)):
                    if i in poses:
                        theta = values.atPose2(keys[i]).theta()
                        c, s = np.cos(theta), np.sin(theta)
                        part = np.column_stack([part[:, :2] @ np.array([[c, -s], [s, c]]), part[:, 2]])
                    jacobians[i] = np.asfortranarray(part)
            return np.asarray(rows.residual[index] * root)

        return error

    def _at(self, values: Any, keys: list[int], columns: IntArray) -> Any:
        """Return all rows at GTSAM's values, computed once for all factors that ask for the same.

        A factor's rows depend on its own unknowns only: where these have not changed, what is kept holds for it.
        """
        own = np.concatenate([self._of_key(values, key) for key in keys])
        if self._cache is None or not np.array_equal(self._cache[0][columns], own):
            state = self.state(values)
            self._cache = (state, self._damper.rows(state))
        return self._cache[1]

    def state(self, values: Any) -> FloatArray:
        """Return GTSAM's values as one vector; angles go on from those of the start."""
        state = np.array(self._start)
        for key, columns in enumerate(self.columns):
            if values.exists(key):
                state[columns] = self._of_key(values, key)
        return state

    def _of_key(self, values: Any, key: int) -> FloatArray:
        if key >= self.epochs:
            return np.asarray(values.atVector(key), np.float64)
        pose = values.atPose2(key)
        before = float(self._start[self.columns[key][2]])
        turn = (pose.theta() - before + math.pi) % (2.0 * math.pi) - math.pi
        return np.array([pose.x(), pose.y(), before + turn])
