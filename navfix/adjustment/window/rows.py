"""The rows of the normal equations: what radar saw, how own ship moved, what is known beforehand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.adjustment.window.motion import motion_rows
from navfix.adjustment.window.problem import Window
from navfix.adjustment.window.state import CLOCK, COMPASS, RANGE_BIAS, Layout
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi

NEW_RANGE, NEW_BEARING, STEADY_RANGE, STEADY_BEARING, OFFSET, TURN, MOVE, GIVEN = range(8)
COMPONENTS = 8
WIDTH = 8  # the most unknowns that one row depends on
_NEAREST_M = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """m rows of at most `WIDTH` unknowns each: residual in units of sigma, its derivatives, its variance component."""

    residual: FloatArray
    columns: IntArray
    values: FloatArray
    component: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """What of the rows does not depend on the state, made once for a window: columns (m, 8) and components (m,).

    The rows of the radar come first, range and bearing of each sighting in turn, then one for each global, offset and
    constant, then own motion. ``place`` (64 m,) is where each product of two derivatives of a row stands in the normal
    matrix.
    """

    window: Window
    layout: Layout
    columns: IntArray
    component: IntArray
    place: IntArray

    @classmethod
    def of(cls, window: Window) -> Plan:
        """Return the plan of a window."""
        layout = Layout.of(window)
        given = np.zeros((layout.size - layout.shared, WIDTH), np.int64)
        given[:, 0] = np.arange(layout.shared, layout.size)
        _, moved, _, moving = motion_rows(window, layout, np.zeros(layout.size))
        columns = np.concatenate([_radar_columns(window, layout), given, moved])
        static = [GIVEN] * 5 + [OFFSET] * (2 * layout.marks) + [STEADY_RANGE, STEADY_BEARING] * layout.tracks
        radar = [NEW_RANGE, NEW_BEARING] * len(window.seen.epoch)
        place = (columns[:, :, None] * layout.size + columns[:, None, :]).ravel()
        return cls(window, layout, columns, np.concatenate([radar, static, moving]), place)

    @property
    def radar(self) -> slice:
        """Return where the rows of the radar stand."""
        return slice(0, 2 * len(self.window.seen.epoch))

    @property
    def static(self) -> slice:
        """Return where the rows of offsets and constants stand."""
        first = self.radar.stop + 5
        return slice(first, first + 2 * (self.layout.marks + self.layout.tracks))

    def rows(self, state: FloatArray, components: FloatArray) -> Rows:
        """Return all rows at a state; eq. (10.1) to (10.6)."""
        radar_v, radar_a = radar_rows(self.window, self.layout, state)
        move_v, _, move_a, _ = motion_rows(self.window, self.layout, state)
        given_a = np.zeros((self.layout.size - self.layout.shared, WIDTH))
        given_a[:, 0] = 1.0
        scale = 1.0 / np.sqrt(components[self.component])
        residual = np.concatenate([radar_v, state[self.layout.shared :], move_v]) * scale
        values = np.concatenate([radar_a, given_a, move_a]) * scale[:, None]
        return Rows(residual, self.columns, values, self.component)


def _radar_columns(window: Window, layout: Layout) -> IntArray:
    seen = window.seen
    pose, offset, constant = 3 * seen.epoch, layout.offset(seen.mark), layout.constant(seen.track)
    shared = np.full_like(pose, layout.shared)
    common = [pose, pose + 1, pose + 2, offset, offset + 1]
    by_range = np.column_stack([*common, constant, shared + CLOCK, shared + RANGE_BIAS])
    by_bearing = np.column_stack([*common, constant + 1, shared + CLOCK, shared + COMPASS])
    return np.stack([by_range, by_bearing], axis=1).reshape(-1, WIDTH)


def radar_rows(window: Window, layout: Layout, state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return residuals (2 k,) in units of sigma and derivatives (2 k, 8); eq. (10.1) and (10.2)."""
    seen, shared = window.seen, state[layout.shared : layout.shared + 5]
    spread = window.global_sigma
    pose = layout.poses(state)[seen.epoch]
    offset_sigma, constant_sigma = window.mark_sigma_m[seen.mark], window.tracks.sigma[seen.track]
    offset, constant = layout.offset(seen.mark), layout.constant(seen.track)
    moved = seen.place_ne_m + seen.velocity_ne_mps * (spread[CLOCK] * shared[CLOCK])
    moved = moved + offset_sigma[:, None] * np.column_stack([state[offset], state[offset + 1]])
    sight = moved - pose[:, :2]
    distance = np.maximum(np.hypot(sight[:, 0], sight[:, 1]), _NEAREST_M)
    cos, sin = sight[:, 0] / distance, sight[:, 1] / distance
    relative = np.where(seen.is_true, 0.0, 1.0)
    range_v = distance + constant_sigma[:, 0] * state[constant] + spread[RANGE_BIAS] * shared[RANGE_BIAS]
    turn = relative * pose[:, 2] + (1.0 - relative) * spread[COMPASS] * shared[COMPASS]
    bearing_v = np.arctan2(sight[:, 1], sight[:, 0]) - turn + constant_sigma[:, 1] * state[constant + 1]
    values = np.zeros((len(cos), 2, WIDTH))
    along, across = np.column_stack([cos, sin]), np.column_stack([-sin, cos]) / distance[:, None]
    for row, to_mark in ((0, along), (1, across)):
        values[:, row, :2] = -to_mark
        values[:, row, 3:5] = to_mark * offset_sigma[:, None]
        values[:, row, 5] = constant_sigma[:, row]
        values[:, row, 6] = spread[CLOCK] * np.sum(to_mark * seen.velocity_ne_mps, axis=1)
    values[:, 0, 7] = spread[RANGE_BIAS]
    values[:, 1, 2] = -relative
    values[:, 1, 7] = -(1.0 - relative) * spread[COMPASS]
    sigma = radar_sigma(window)
    residual = np.column_stack([range_v - seen.value[:, 0], wrap_pi(bearing_v - seen.value[:, 1])]) / sigma
    return residual.ravel(), (values / sigma[:, :, None]).reshape(-1, WIDTH)


def radar_sigma(window: Window) -> FloatArray:
    """Return 1 sigma (k, 2) of what is new in each sighting, m and rad: radar, and the mark's age; eq. (10.3)."""
    seen = window.seen
    at_distance = seen.fresh_m / np.maximum(seen.value[:, 0], 50.0)
    return np.column_stack([np.hypot(seen.sigma[:, 0], seen.fresh_m), np.hypot(seen.sigma[:, 1], at_distance)])
