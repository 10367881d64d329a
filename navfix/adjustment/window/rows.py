"""The rows of the normal equations: what radar saw, how own ship moved, what is known beforehand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.adjustment.window.motion import OwnMotion
from navfix.adjustment.window.problem import WindowNetwork
from navfix.adjustment.window.state import CLOCK, COMPASS, RANGE_BIAS, Layout
from navfix.types import FloatArray, IntArray

NEW_RANGE, NEW_BEARING, STEADY_RANGE, STEADY_BEARING, OFFSET, TURN, MOVE, GIVEN = range(8)
COMPONENTS = 8
WIDTH = 8  # the most unknowns that one row depends on
PAIRS = np.triu_indices(WIDTH)
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
    constant, then own motion. ``place`` (36 m,) is where each product of two derivatives of a row, `PAIRS`, stands in
    the upper half of the normal matrix, counted row by row; the matrix is symmetric.
    """

    window: WindowNetwork
    layout: Layout
    sights: Sights
    motion: OwnMotion
    columns: IntArray
    component: IntArray
    place: IntArray

    @classmethod
    def of(cls, window: WindowNetwork) -> Plan:
        """Return the plan of a window."""
        layout = Layout.of(window)
        sights, motion = Sights(window, layout), OwnMotion(window, layout)
        given = np.zeros((layout.size - layout.shared, WIDTH), np.int64)
        given[:, 0] = np.arange(layout.shared, layout.size)
        static = [GIVEN] * 5 + [OFFSET] * (2 * layout.marks) + [STEADY_RANGE, STEADY_BEARING] * layout.tracks
        radar = [NEW_RANGE, NEW_BEARING] * len(window.seen.epoch)
        columns = np.concatenate([sights.columns, given, motion.columns])
        component = np.concatenate([radar, static, motion.component])
        one, other = columns.T[PAIRS[0]], columns.T[PAIRS[1]]
        place = (np.minimum(one, other) * layout.size + np.maximum(one, other)).ravel()
        return cls(window, layout, sights, motion, columns, component, place)

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
        radar_v, radar_a = self.sights.rows(state)
        move_v, move_a = self.motion.rows(state)
        given_a = np.zeros((self.layout.size - self.layout.shared, WIDTH))
        given_a[:, 0] = 1.0
        scale = 1.0 / np.sqrt(components[self.component])
        residual = np.concatenate([radar_v, state[self.layout.shared :], move_v]) * scale
        values = np.concatenate([radar_a, given_a, move_a]) * scale[:, None]
        return Rows(residual, self.columns, values, self.component)


class Sights:
    """The rows of the radar: range and bearing of each of k sightings; eq. (10.1) and (10.2).

    All but the direction to the mark is linear in the unknowns, and made once for a window.
    """

    def __init__(self, window: WindowNetwork, layout: Layout) -> None:
        seen, spread = window.seen, window.global_sigma
        self._window, self._layout = window, layout
        self.sigma = radar_sigma(window)
        self._offset_sigma = window.mark_sigma_m[seen.mark][:, None]
        self._offset = layout.offset(seen.mark)[:, None] + np.arange(2)
        self._drift_m = seen.velocity_ne_mps * spread[CLOCK]
        self.columns = _radar_columns(window, layout)
        relative = np.where(seen.is_true, 0.0, 1.0)
        linear = np.zeros((len(relative), 2, WIDTH))
        linear[:, :, 5] = window.tracks.sigma[seen.track]
        linear[:, 0, 7] = spread[RANGE_BIAS]
        linear[:, 1, 2] = -relative
        linear[:, 1, 7] = -(1.0 - relative) * spread[COMPASS]
        self._linear = linear / self.sigma[:, :, None]
        self._turn = 2.0 * np.pi / self.sigma[:, 1]

    def rows(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residuals (2 k,) in units of sigma and derivatives (2 k, 8)."""
        seen, layout = self._window.seen, self._layout
        place = (
            seen.place_ne_m + self._drift_m * state[layout.shared + CLOCK] + self._offset_sigma * state[self._offset]
        )
        sight = place - layout.poses(state)[seen.epoch, :2]
        distance = np.maximum(np.hypot(sight[:, 0], sight[:, 1]), _NEAREST_M)
        polar = np.stack([distance, np.arctan2(sight[:, 1], sight[:, 0])], axis=1)
        unknowns = state[self.columns].reshape(self._linear.shape)
        residual = (polar - seen.value) / self.sigma + np.einsum("kac,kac->ka", self._linear, unknowns)
        residual[:, 1] -= self._turn * np.round(residual[:, 1] / self._turn)
        values, to_mark = self._linear.copy(), np.empty((len(distance), 2, 2))
        along = sight / distance[:, None]
        to_mark[:, 0], to_mark[:, 1] = along, along[:, ::-1] * [-1.0, 1.0] / distance[:, None]
        to_mark /= self.sigma[:, :, None]
        values[:, :, :2] = -to_mark
        values[:, :, 3:5] = to_mark * self._offset_sigma[:, None]
        values[:, :, 6] = np.einsum("kad,kd->ka", to_mark, self._drift_m)
        return residual.ravel(), values.reshape(-1, WIDTH)


def _radar_columns(window: WindowNetwork, layout: Layout) -> IntArray:
    seen = window.seen
    pose, offset, constant = 3 * seen.epoch, layout.offset(seen.mark), layout.constant(seen.track)
    shared = np.full_like(pose, layout.shared)
    common = [pose, pose + 1, pose + 2, offset, offset + 1]
    by_range = np.column_stack([*common, constant, shared + CLOCK, shared + RANGE_BIAS])
    by_bearing = np.column_stack([*common, constant + 1, shared + CLOCK, shared + COMPASS])
    return np.stack([by_range, by_bearing], axis=1).reshape(-1, WIDTH)


def radar_sigma(window: WindowNetwork) -> FloatArray:
    """Return 1 sigma (k, 2) of what is new in each sighting, m and rad: radar, and the mark's age; eq. (10.3)."""
    seen = window.seen
    at_distance = seen.fresh_m / np.maximum(seen.value[:, 0], 50.0)
    return np.column_stack([np.hypot(seen.sigma[:, 0], seen.fresh_m), np.hypot(seen.sigma[:, 1], at_distance)])
