"""How own ship moved: by log and gyro where there are any, else by what ships can do, from a known pose if any."""

from __future__ import annotations

import math

import numpy as np

from navfix.adjustment.window.prior import known_pose_rows
from navfix.adjustment.window.problem import Window, gyro_steps
from navfix.adjustment.window.state import CURRENT_EAST, CURRENT_NORTH, Layout
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi

Part = tuple[FloatArray, IntArray, FloatArray]
_TURN, _MOVE, _GIVEN = 5, 6, 7  # variance components, as in `rows`
_WIDTH = 8


def motion_rows(window: Window, layout: Layout, state: FloatArray) -> tuple[FloatArray, IntArray, FloatArray, IntArray]:
    """Return residuals (m,), columns (m, 8), derivatives (m, 8) in units of sigma, and the components (m,)."""
    parts = [
        (*_turns(window, layout, state), _TURN),
        (*_by_log(window, layout, state), _MOVE),
        (*_by_inertia(window, layout, state), _MOVE),
        (*_first_speed(window, layout, state), _GIVEN),
        (*_unseen_heading(window, layout, state), _GIVEN),
        (*known_pose_rows(window, layout, state, _WIDTH), _GIVEN),
    ]
    component = np.concatenate([np.full(len(part[0]), part[3]) for part in parts])
    residual, columns, values = (np.concatenate([part[i] for part in parts]) for i in range(3))
    return residual, columns, values, component


def logged(window: Window) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Tell for each step (E - 1,) whether the log was heard at both ends and a heading turns it to north."""
    log = np.isfinite(window.own.log_mps)
    heading = window.any_relative | np.isfinite(window.own.gyro_rad)
    both = (log & heading)[1:] & (log & heading)[:-1]
    return np.asarray(both & (np.diff(window.time_s) <= window.model.longest_step_s))


def _connected(window: Window) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.asarray(np.diff(window.time_s) <= window.model.longest_step_s)


def _turns(window: Window, layout: Layout, state: FloatArray) -> Part:
    """The turn of a step: that of the gyro, whose constant error cancels, else a walk about none; eq. (10.4)."""
    model, step_s = window.model, np.diff(window.time_s)
    turned = gyro_steps(window)
    told = np.isfinite(turned)
    walk_rad = math.radians(model.heading_walk_deg) * np.sqrt(step_s / model.walk_time_s)
    gyro_rad = math.radians(model.gyro_step_sigma_deg) * np.ones_like(step_s)
    sigma = np.where(told, np.minimum(gyro_rad, np.hypot(walk_rad, gyro_rad)), walk_rad)
    heading = layout.poses(state)[:, 2]
    v = wrap_pi(np.diff(heading) - np.where(told, turned, 0.0)) / sigma
    at = 3 * np.arange(len(step_s)) + 2
    columns, values = _empty(len(step_s))
    columns[:, 0], columns[:, 1] = at, at + 3
    values[:, 0], values[:, 1] = -1.0 / sigma, 1.0 / sigma
    use = _connected(window)
    return v[use], columns[use], values[use]


def _by_log(window: Window, layout: Layout, state: FloatArray) -> Part:
    """Displacement = speed by log along the heading + current; eq. (10.5). The current is an unknown of the window."""
    use = np.flatnonzero(logged(window))
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


def _by_inertia(window: Window, layout: Layout, state: FloatArray) -> Part:
    """Without a log the velocity wanders: its change over three epochs is that of a Wiener process; eq. (10.6)."""
    model, step_s, joined = window.model, np.diff(window.time_s), _connected(window)
    by_log = logged(window)
    use = np.flatnonzero(joined[1:] & joined[:-1] & ~(by_log[1:] & by_log[:-1]))
    if not len(use):
        return np.zeros(0), *_empty(0)
    before, after = step_s[use], step_s[use + 1]
    sigma = model.velocity_walk_mps * np.sqrt((before + after) / (3.0 * model.walk_time_s))
    poses, parts = layout.poses(state), []
    for axis in (0, 1):
        p = poses[:, axis]
        v = ((p[use + 2] - p[use + 1]) / after - (p[use + 1] - p[use]) / before) / sigma
        columns, values = _empty(len(use))
        for place, factor in ((0, 1.0 / before), (1, -1.0 / before - 1.0 / after), (2, 1.0 / after)):
            columns[:, place] = 3 * (use + place) + axis
            values[:, place] = factor / sigma
        parts.append((v, columns, values))
    return _joined(parts)


def _first_speed(window: Window, layout: Layout, state: FloatArray) -> Part:
    """A ship's speed is known beforehand within the fastest of ships: one row per axis where no log tells it."""
    step_s = np.diff(window.time_s)
    use = np.flatnonzero(_connected(window) & ~logged(window))[:1]
    if not len(use):
        return np.zeros(0), *_empty(0)
    poses, parts = layout.poses(state), []
    for axis in (0, 1):
        per = 1.0 / (step_s[use] * window.model.own_speed_sigma_mps)
        columns, values = _empty(len(use))
        columns[:, 0], columns[:, 1] = 3 * use + axis, 3 * use + 3 + axis
        values[:, 0], values[:, 1] = -per, per
        parts.append(((poses[use + 1, axis] - poses[use, axis]) * per, columns, values))
    return _joined(parts)


def _unseen_heading(window: Window, layout: Layout, state: FloatArray) -> Part:
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
