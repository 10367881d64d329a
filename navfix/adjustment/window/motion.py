"""How own ship moved: by log and gyro where there are any, else by what ships can do, from a known pose if any."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from navfix.adjustment.window.prior import known_pose_rows
from navfix.adjustment.window.problem import WindowNetwork, gyro_steps
from navfix.adjustment.window.state import CURRENT_EAST, CURRENT_NORTH, Layout
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi

Part = tuple[FloatArray, IntArray, FloatArray]
_TURN, _MOVE, _GIVEN = 5, 6, 7  # variance components, as in `rows`
_WIDTH = 8


@dataclass(frozen=True, slots=True, eq=False)
class _Linear:
    """Rows that are linear in the unknowns: residual = values . unknowns - offset, less whole turns of ``turn``."""

    columns: IntArray
    values: FloatArray
    offset: FloatArray
    turn: FloatArray
    component: IntArray

    @classmethod
    def of(cls, *parts: _Linear) -> _Linear:
        """Return the rows of all parts as one."""
        return cls(*(np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)))

    def residual(self, state: FloatArray) -> FloatArray:
        off = np.einsum("rc,rc->r", self.values, state[self.columns]) - self.offset
        return np.asarray(off - self.turn * np.round(off / np.where(self.turn > 0.0, self.turn, np.inf)))


class OwnMotion:
    """The rows of own ship's motion: those that are linear are made once for a window, the others at every state."""

    def __init__(self, window: WindowNetwork, layout: Layout) -> None:
        self._window, self._layout = window, layout
        self._logged = np.flatnonzero(logged(window))
        self._linear = _Linear.of(_turns(window), _by_inertia(window), _first_speed(window))
        parts = self._others(np.zeros(layout.size))
        self.columns = np.concatenate([self._linear.columns, *(part[1] for part in parts)])
        others = np.repeat((_MOVE, _GIVEN, _GIVEN), [len(part[0]) for part in parts])
        self.component = np.concatenate([self._linear.component, others])

    def rows(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residuals (m,) and derivatives (m, 8) in units of sigma."""
        parts = self._others(state)
        residual = np.concatenate([self._linear.residual(state), *(part[0] for part in parts)])
        return residual, np.concatenate([self._linear.values, *(part[2] for part in parts)])

    def _others(self, state: FloatArray) -> list[Part]:
        window, layout = self._window, self._layout
        return [
            _by_log(window, layout, self._logged, state),
            _unseen_heading(window, layout, state),
            known_pose_rows(window, layout, state, _WIDTH),
        ]


def logged(window: WindowNetwork) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Tell for each step (E - 1,) whether the log was heard at both ends and a heading turns it to north."""
    log = np.isfinite(window.own.log_mps)
    heading = window.any_relative | np.isfinite(window.own.gyro_rad)
    both = (log & heading)[1:] & (log & heading)[:-1]
    return np.asarray(both & (np.diff(window.time_s) <= window.model.longest_step_s))


def _connected(window: WindowNetwork) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.asarray(np.diff(window.time_s) <= window.model.longest_step_s)


def _turns(window: WindowNetwork) -> _Linear:
    """The turn of a step: that of the gyro, whose constant error cancels, else a walk about none; eq. (10.4)."""
    model, step_s = window.model, np.diff(window.time_s)
    turned = gyro_steps(window)
    told = np.isfinite(turned)
    walk_rad = math.radians(model.heading_walk_deg) * np.sqrt(step_s / model.walk_time_s)
    gyro_rad = math.radians(model.gyro_step_sigma_deg) * np.ones_like(step_s)
    sigma = np.where(told, np.minimum(gyro_rad, np.hypot(walk_rad, gyro_rad)), walk_rad)
    at = 3 * np.arange(len(step_s)) + 2
    columns, values = _empty(len(step_s))
    columns[:, 0], columns[:, 1] = at, at + 3
    values[:, 0], values[:, 1] = -1.0 / sigma, 1.0 / sigma
    use = _connected(window)
    offset = np.where(told, turned, 0.0) / sigma
    whole = 2.0 * math.pi / sigma
    return _Linear(columns[use], values[use], offset[use], whole[use], np.full(np.count_nonzero(use), _TURN))


def _by_log(window: WindowNetwork, layout: Layout, use: IntArray, state: FloatArray) -> Part:
    """Displacement = speed by log along the heading + current; eq. (10.5). The current is an unknown of the window."""
    if not len(use):
        return np.zeros(0), *_empty(0)
    poses, step_s = layout.poses(state), np.diff(window.time_s)[use]
    log, spread = window.own.log_mps, window.global_sigma
    turn = wrap_pi(poses[use + 1, 2] - poses[use, 2])
    middle = poses[use, 2] + 0.5 * turn
    run_m = 0.5 * (log[use] + log[use + 1]) * step_s
    sigma = np.maximum(window.own.log_sigma_mps[use], 1e-3) * step_s
    parts = []
    for axis, ahead, turned, current in (
        (0, np.cos(middle), -np.sin(middle), CURRENT_NORTH),
        (1, np.sin(middle), np.cos(middle), CURRENT_EAST),
    ):
        at = layout.shared + current
        drift_m = spread[current] * state[at] * step_s
        v = (poses[use + 1, axis] - poses[use, axis] - run_m * ahead - drift_m) / sigma
        columns, values = _empty(len(use))
        columns[:, 0], columns[:, 1] = 3 * use + axis, 3 * use + 3 + axis
        columns[:, 2], columns[:, 3], columns[:, 4] = 3 * use + 2, 3 * use + 5, at
        values[:, 0], values[:, 1] = -1.0, 1.0
        values[:, 2] = values[:, 3] = -0.5 * run_m * turned
        values[:, 4] = -spread[current] * step_s
        parts.append((v, columns, values / sigma[:, None]))
    return _joined(parts)


def _by_inertia(window: WindowNetwork) -> _Linear:
    """Without a log the velocity wanders: its change over three epochs is that of a Wiener process; eq. (10.6)."""
    model, step_s, joined = window.model, np.diff(window.time_s), _connected(window)
    by_log = logged(window)
    use = np.flatnonzero(joined[1:] & joined[:-1] & ~(by_log[1:] & by_log[:-1]))
    before, after = step_s[use], step_s[use + 1]
    sigma = model.velocity_walk_mps * np.sqrt((before + after) / (3.0 * model.walk_time_s))
    columns, values = _empty(2 * len(use))
    for axis in (0, 1):
        rows = slice(axis * len(use), (axis + 1) * len(use))
        for place, factor in ((0, 1.0 / before), (1, -1.0 / before - 1.0 / after), (2, 1.0 / after)):
            columns[rows, place] = 3 * (use + place) + axis
            values[rows, place] = factor / sigma
    return _unbiased(columns, values, _MOVE)


def _first_speed(window: WindowNetwork) -> _Linear:
    """A ship's speed is known beforehand within the fastest of ships: one row per axis where no log tells it."""
    use = np.flatnonzero(_connected(window) & ~logged(window))[:1]
    per = 1.0 / (np.diff(window.time_s)[use] * window.model.own_speed_sigma_mps)
    columns, values = _empty(2 * len(use))
    for axis in range(2 * len(use)):
        columns[axis, 0], columns[axis, 1] = 3 * use[0] + axis, 3 * use[0] + 3 + axis
        values[axis, 0], values[axis, 1] = -per[0], per[0]
    return _unbiased(columns, values, _GIVEN)


def _unbiased(columns: IntArray, values: FloatArray, component: int) -> _Linear:
    return _Linear(columns, values, np.zeros(len(columns)), np.zeros(len(columns)), np.full(len(columns), component))


def _unseen_heading(window: WindowNetwork, layout: Layout, state: FloatArray) -> Part:
    """Where all bearings are true no radar row depends on the heading: the gyro alone says it, else nothing does."""
    columns, values = _empty(0)
    if window.any_relative:
        return np.zeros(0), columns, values
    heading, told = layout.poses(state)[:, 2], np.flatnonzero(np.isfinite(window.own.gyro_rad))
    newest = int(told[-1]) if len(told) else window.epochs - 1
    expected = float(window.own.gyro_rad[newest]) if len(told) else float(heading[newest])
    sigma = float(window.own.gyro_sigma_rad[newest]) if len(told) else math.pi
    columns, values = _empty(1)
    columns[0, 0], values[0, 0] = 3 * newest + 2, 1.0 / sigma
    return np.array([wrap_pi(heading[newest] - expected) / sigma]), columns, values


def _empty(count: int) -> tuple[IntArray, FloatArray]:
    return np.zeros((count, _WIDTH), np.int64), np.zeros((count, _WIDTH))


def _joined(parts: list[Part]) -> Part:
    residual, columns, values = (np.concatenate([part[i] for part in parts]) for i in range(3))
    return residual, columns, values
