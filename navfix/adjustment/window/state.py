"""The unknowns of a window in one vector: poses, what all observations share, what stays with a mark and a track."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from navfix.types import FloatArray, IntArray

if TYPE_CHECKING:
    from navfix.adjustment.window.problem import WindowNetwork

GLOBALS = ("clock", "range_bias", "compass", "current_north", "current_east")
CLOCK, RANGE_BIAS, COMPASS, CURRENT_NORTH, CURRENT_EAST = range(len(GLOBALS))


@dataclass(frozen=True, slots=True)
class Layout:
    """Where each unknown stands: 3 E poses (m, m, rad), 5 globals, 2 M offsets of marks, 2 T constants of tracks.

    Globals, offsets and constants are counted in units of their own prior sigma.
    """

    epochs: int
    marks: int
    tracks: int

    @classmethod
    def of(cls, window: WindowNetwork) -> Layout:
        """Return the layout of a window."""
        return cls(window.epochs, len(window.mark_labels), len(window.tracks.label))

    @property
    def size(self) -> int:
        return 3 * self.epochs + len(GLOBALS) + 2 * self.marks + 2 * self.tracks

    @property
    def shared(self) -> int:
        """Return the index of the first global."""
        return 3 * self.epochs

    def offset(self, mark: IntArray) -> IntArray:
        """Return the indices (k,) of the north offset of marks; east follows."""
        return self.shared + len(GLOBALS) + 2 * np.asarray(mark)

    def constant(self, track: IntArray) -> IntArray:
        """Return the indices (k,) of the constant range error of tracks; that of the bearing follows."""
        return self.shared + len(GLOBALS) + 2 * self.marks + 2 * np.asarray(track)

    def poses(self, state: FloatArray) -> FloatArray:
        """Return the poses (E, 3), a view."""
        return state[: self.shared].reshape(-1, 3)

    def newest(self) -> slice:
        """Return where the newest pose stands."""
        return slice(self.shared - 3, self.shared)

    def static_mark(self, window: WindowNetwork) -> IntArray:
        """Return the mark of each unknown behind the globals, (2 M + 2 T,)."""
        return np.repeat(np.concatenate([np.arange(self.marks), window.tracks.mark]), 2)
