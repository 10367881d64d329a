"""Plots -> antenna turns: how long one turn takes, as the echoes themselves tell, and which plots belong to which."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from navfix.nmea.plots import RadarPlot
from navfix.picture.scans import LONGEST_TURN_S, SHORTEST_TURN_S
from navfix.units import wrap_180

_PLOTS_LOOKED_AT = 1500
_SAME_ECHO_M, _SAME_ECHO_DEG = 100.0, 4.0
_LEAST_RETURNS = 10
_ALIKE = 0.1
_SILENCE = 0.3  # of a turn without plots: a good place to cut


def turn_length_s(plots: Sequence[RadarPlot], otherwise_s: float) -> float:
    """Return the time [s] after which an echo most often comes back at its range and bearing.

    ``otherwise_s`` where fewer than ten echoes come back at all. Works for a sweeping antenna and for whole images with
    one time each.
    """
    looked_at = plots[:_PLOTS_LOOKED_AT]
    time_s = np.array([plot.time_s for plot in looked_at])
    range_m = np.array([plot.range_m for plot in looked_at])
    bearing_deg = np.array([plot.bearing_deg for plot in looked_at])
    gaps = [_return_s(index, time_s, range_m, bearing_deg) for index in range(len(time_s))]
    gap_s = np.array([gap for gap in gaps if gap is not None])
    if len(gap_s) < _LEAST_RETURNS:
        return otherwise_s
    alike = np.abs(gap_s[:, None] - gap_s[None, :]) <= _ALIKE * gap_s[:, None]
    commonest = int(np.argmax(np.count_nonzero(alike, axis=1)))
    return float(np.median(gap_s[alike[commonest]]))


def _return_s(
    index: int, time_s: np.ndarray, range_m: np.ndarray, bearing_deg: np.ndarray
) -> float | None:  # fmt: skip
    """Return after how many seconds the echo ``index`` is seen again, None where it is not."""
    later = slice(
        int(np.searchsorted(time_s, time_s[index] + SHORTEST_TURN_S)),
        int(np.searchsorted(time_s, time_s[index] + LONGEST_TURN_S, side="right")),
    )
    same = (np.abs(range_m[later] - range_m[index]) <= _SAME_ECHO_M) & (
        np.abs(wrap_180(bearing_deg[later] - bearing_deg[index])) <= _SAME_ECHO_DEG
    )
    found = np.flatnonzero(same)
    return float(time_s[later][found[0]] - time_s[index]) if len(found) else None


def turns(plots: Sequence[RadarPlot], turn_s: float) -> Iterator[list[RadarPlot]]:
    """Yield the plots of each turn: it ends after ``turn_s`` [s], or in its second half at a silence of 0.3 turns.

    Plots must be in the order of time.
    """
    current: list[RadarPlot] = []
    for plot in plots:
        if current:
            lasted_s, silent_s = plot.time_s - current[0].time_s, plot.time_s - current[-1].time_s
            if lasted_s >= turn_s or (lasted_s > 0.5 * turn_s and silent_s > _SILENCE * turn_s):
                yield current
                current = []
        current.append(plot)
    if current:
        yield current
