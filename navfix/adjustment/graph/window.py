"""A window of epochs as a factor graph: poses, what they share, and what stays with a mark, in GTSAM.

Keys: pose e at e, the globals at E, the errors that stay with mark j (its offset, then the constants of its tracks) at
E + 1 + j. One factor for each sighting, for each step of own ship's motion, for the globals and for each mark, of three
keys at most. The weights of the kernel at a solution that is known already stand in the factors: what GTSAM adds is its
own linearisation on the manifold of poses, its own elimination, and the marginal covariance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from navfix.adjustment.graph.epoch import GraphSolution, _in_north_east, _marginal, _parameters
from navfix.errors import Unobservable
from navfix.types import FloatArray, IntArray

if TYPE_CHECKING:
    from navfix.adjustment.window.descent import Damper
    from navfix.adjustment.window.rows import Rows

_NO_WEIGHT = 1e-9
_SOLVED = 1e-4  # sigma: from so near, one more linearisation moves nothing
_KEYS = 3  # the most that one factor depends on


def solve(damper: Damper, start: FloatArray) -> tuple[GraphSolution, FloatArray]:
    """Minimise from a state under the weights that it has; return the newest pose and the whole state.

    Raises
    ------
    Unobservable : GTSAM found the linear system indeterminate
    """
    import gtsam

    window = _Window(damper, start)
    values, newest = window.values(), window.epochs - 1
    try:
        linear = window.linear()
        newest_last = gtsam.Ordering.ColamdConstrainedLastGaussianFactorGraph(linear, [newest])
        tree = linear.eliminateMultifrontal(newest_last)
        step = tree.optimize()
        if _length(linear, step) < _SOLVED:  # solved already: what was eliminated gives step and covariance
            solution, iterations, error = values.retract(step), 1, linear.error(step)
            cofactor = _in_north_east(tree.marginalCovariance(newest), values, newest)
        else:
            graph = window.graph()
            optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values, _parameters())
            solution = optimizer.optimize()
            iterations, error = optimizer.iterations(), optimizer.error()
            cofactor = _marginal(graph, solution, newest)
        state = window.state(solution)
    except RuntimeError as failure:
        said = " ".join(str(failure).split()).partition(".")[0]
        raise Unobservable(f"GTSAM cannot solve this window: {said}", direction="not determined") from failure
    return GraphSolution(state[window.columns[newest]], cofactor, 2.0 * error, iterations), state


def _length(linear: Any, step: Any) -> float:
    """Return the length of a Gauss-Newton step in units of sigma: what it takes off the sum of squares, its root."""
    nothing = step.scale(0.0)
    return math.sqrt(max(2.0 * (linear.error(nothing) - linear.error(step)), 0.0))


class _Window:
    """The unknowns by key, and the rows of the window by factor."""

    def __init__(self, damper: Damper, start: FloatArray) -> None:
        self._damper, self._start, layout = damper, np.array(start), damper.plan.layout
        self.epochs = layout.epochs
        static, of_mark = np.arange(layout.shared + 5, layout.size), layout.static_mark(damper.plan.window)
        self.columns: list[IntArray] = [np.arange(3 * e, 3 * e + 3) for e in range(layout.epochs)]
        self.columns.append(np.arange(layout.shared, layout.shared + 5))
        self.columns += [static[of_mark == mark] for mark in range(layout.marks)]
        key, place = np.empty(layout.size, np.int64), np.empty(layout.size, np.int64)
        for number, columns in enumerate(self.columns):
            key[columns], place[columns] = number, np.arange(len(columns))
        self._rows = damper.rows(start)
        _, weights = damper.judge(self._rows.residual)
        self._root = np.sqrt(weights.row)
        self._at_state = self._start
        used = self._rows.values != 0.0
        used[damper.plan.radar] = True  # a sighting is one factor, though a range does not show the heading
        used &= (weights.row > _NO_WEIGHT)[:, None]
        self._row, self._entry = np.nonzero(used)
        column = self._rows.columns[self._row, self._entry]
        wanted, which = np.unique(self._row * len(self.columns) + key[column], return_inverse=True)
        owner, key_of = np.divmod(wanted, len(self.columns))
        slot = np.arange(len(owner)) - np.searchsorted(owner, owner)
        self._slot, self._place = slot[which], place[column]
        self._keys = np.full((len(used), _KEYS), -1)
        self._keys[owner, slot] = key_of
        self._factors = _factors(self._keys)
        self._blocks = self._blocks_of(self._rows, self._start)

    def values(self) -> Any:
        """Return the start as GTSAM's values."""
        import gtsam

        values = gtsam.Values()
        for key, columns in enumerate(self.columns):
            part = self._start[columns]
            values.insert(key, gtsam.Pose2(*part) if key < self.epochs else part)
        return values

    def linear(self) -> Any:
        """Return the linear factor graph at the start."""
        import gtsam

        graph = gtsam.GaussianFactorGraph()
        factor: Any = gtsam.JacobianFactor  # its stubs know no keys that come as a list
        noise = cache(gtsam.noiseModel.Unit.Create)
        order = np.concatenate([rows for rows, _ in self._factors])
        blocks = [np.ascontiguousarray(self._blocks[order, slot]) for slot in range(_KEYS)]
        right, widths = (-self._rows.residual * self._root)[order], [len(columns) for columns in self.columns]
        begin = 0
        for rows, keys in self._factors:
            end = begin + len(rows)
            terms = [(key, blocks[slot][begin:end, : widths[key]]) for slot, key in enumerate(keys)]
            graph.add(factor(*chain.from_iterable(terms), right[begin:end], noise(len(rows))))
            begin = end
        return graph

    def graph(self) -> Any:
        """Return the factor graph itself, linearised anew by GTSAM at every step."""
        import gtsam

        graph, noise = gtsam.NonlinearFactorGraph(), gtsam.noiseModel.Unit.Create
        for rows, keys in self._factors:
            graph.add(gtsam.CustomFactor(noise(len(rows)), keys, self._error_function(rows, keys)))
        return graph

    def _error_function(self, index: IntArray, keys: list[int]) -> Callable[[Any, Any, Any], FloatArray]:
        columns = np.concatenate([self.columns[key] for key in keys])

        def error(_factor: Any, values: Any, jacobians: Any) -> FloatArray:
            self._linearise_at(values, keys, columns)
            if jacobians is not None:
                for slot, key in enumerate(keys):
                    jacobians[slot] = np.asfortranarray(self._blocks[index, slot, : len(self.columns[key])])
            return np.asarray(self._rows.residual[index] * self._root[index])

        return error

    def _linearise_at(self, values: Any, keys: list[int], columns: IntArray) -> None:
        """Make all rows at GTSAM's values, once for all factors that ask for the same.

        A factor's rows depend on its own unknowns only: where these have not changed, what is kept holds for it.
        """
        own = np.concatenate([self._of_key(values, key) for key in keys])
        if not np.array_equal(self._at_state[columns], own):
            self._at_state = self.state(values)
            self._rows = self._damper.rows(self._at_state)
            self._blocks = self._blocks_of(self._rows, self._at_state)

    def _blocks_of(self, rows: Rows, state: FloatArray) -> FloatArray:
        """Return the weighted derivatives of every row (m,) by the unknowns of its keys: (m, 3, widest key).

        GTSAM's increments of a pose are in the ship's axes.
        """
        blocks = np.zeros((len(rows.residual), _KEYS, max(len(columns) for columns in self.columns)))
        blocks[self._row, self._slot, self._place] = rows.values[self._row, self._entry] * self._root[self._row]
        for slot in range(_KEYS):
            row = np.flatnonzero((self._keys[:, slot] >= 0) & (self._keys[:, slot] < self.epochs))
            heading = state[3 * self._keys[row, slot] + 2]
            c, s, north, east = np.cos(heading), np.sin(heading), blocks[row, slot, 0], blocks[row, slot, 1]
            blocks[row, slot, 0], blocks[row, slot, 1] = north * c + east * s, east * c - north * s
        return blocks

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


def _factors(keys: IntArray) -> list[tuple[IntArray, list[int]]]:
    """Return rows and keys of every factor: rows (m,) that depend on the same keys (m, 3) belong together."""
    order = np.lexsort(keys.T[::-1])
    begins = np.flatnonzero(np.any(np.diff(keys[order], axis=0, prepend=-2), axis=1))
    rows = [order[begin:end] for begin, end in pairwise([*begins.tolist(), len(order)])]
    together = keys[order[begins]].tolist()
    return [(r, [key for key in k if key >= 0]) for r, k in zip(rows, together, strict=True) if k[0] >= 0]
