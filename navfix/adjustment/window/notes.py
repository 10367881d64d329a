"""What a window estimated beside the pose, in words: clock, biases, current, sigmas, marks that stand off."""

from __future__ import annotations

import math

import numpy as np

from navfix.adjustment.window.components import Judged
from navfix.adjustment.window.motion import logged
from navfix.adjustment.window.problem import WindowNetwork, gyro_steps
from navfix.adjustment.window.rows import (
    MOVE,
    NEW_BEARING,
    NEW_RANGE,
    OFFSET,
    STEADY_BEARING,
    STEADY_RANGE,
    TURN,
)
from navfix.adjustment.window.state import CLOCK, COMPASS, CURRENT_EAST, CURRENT_NORTH, RANGE_BIAS
from navfix.types import FloatArray
from navfix.types.adjusted import LEAST_REDUNDANCY

_LISTED = 6  # marks whose offsets are told one by one
_STANDS_OFF = 3.0  # sigma
_UNSTEADY = 4.0  # variance component of own sensors from which on the notes say so


def window_notes(window: WindowNetwork, found: Judged, solver: str, at: int) -> tuple[str, ...]:
    """Return what a window says beside its pose, for the epoch ``at``."""
    span_s = window.time_s[-1] - window.time_s[0]
    road = "GTSAM" if solver == "gtsam" else "dense normal equations"
    said = [f"window of {window.epochs} scans over {span_s:.0f} s, {len(window.tracks.label)} tracks; solved by {road}"]
    said += _globals(window, found)
    said += _components(window, found)
    said += _offsets(window, found)
    before = window.seen.epoch[window.seen.epoch <= at]
    silent_s = window.time_s[at] - window.time_s[before.max()] if len(before) else 0.0
    if silent_s > 0.0:
        said.append(f"no track was seen for the last {silent_s:.0f} s: the pose is carried on by own motion")
    return tuple(said)


def _shared_errors(window: WindowNetwork, found: Judged) -> tuple[FloatArray, FloatArray]:
    """Return what all sightings share (5,) with 1 sigma (5,): clock [s], range bias [m], compass [rad], current."""
    first = found.damper.plan.layout.shared
    at, spread = slice(first, first + 5), window.global_sigma
    value: FloatArray = spread * found.descended.state[at]
    sigma: FloatArray = spread * np.sqrt(np.diagonal(found.cofactor[at, at]))
    return value, sigma


def compass_error_deg(window: WindowNetwork, found: Judged) -> tuple[float, float]:
    """Return what must be added to the true bearings, and its 1 sigma [deg]."""
    value, sigma = _shared_errors(window, found)
    return math.degrees(float(value[COMPASS])), math.degrees(float(sigma[COMPASS]))


def _globals(window: WindowNetwork, found: Judged) -> list[str]:
    value, sigma = _shared_errors(window, found)
    said = [
        f"radar clock offset {value[CLOCK]:+.2f} s +- {sigma[CLOCK]:.2f}, "
        f"range bias {value[RANGE_BIAS]:+.0f} m +- {sigma[RANGE_BIAS]:.0f} (1 sigma)"
    ]
    if np.any(window.seen.is_true):
        error, spread_deg = compass_error_deg(window, found)
        said.append(f"compass error {error:+.2f}° +- {spread_deg:.2f} (1 sigma), to be added to the true bearings")
    if np.any(logged(window)):
        word = "current" if np.any(window.own.through_water) else "drift of the log"
        speed = math.hypot(value[CURRENT_NORTH], value[CURRENT_EAST])
        towards = math.degrees(math.atan2(value[CURRENT_EAST], value[CURRENT_NORTH])) % 360.0
        larger = max(sigma[CURRENT_NORTH], sigma[CURRENT_EAST])
        said.append(f"{word} {speed:.2f} m/s towards {towards:03.0f}° +- {larger:.2f} m/s (1 sigma)")
    return said


def _components(window: WindowNetwork, found: Judged) -> list[str]:
    root = np.sqrt(found.damper.components)
    said = [
        "errors in units of their models: new in each scan "
        f"{root[NEW_RANGE]:.2f} (range), {root[NEW_BEARING]:.2f} (bearing); staying with a track "
        f"{root[STEADY_RANGE]:.2f}, {root[STEADY_BEARING]:.2f}; of the marks {root[OFFSET]:.2f}"
    ]
    if root[TURN] ** 2 > _UNSTEADY and np.any(np.isfinite(gyro_steps(window))):
        said.append(f"the turns of the gyro do not fit: their sigma was taken {root[TURN]:.1f} times as large")
    if root[MOVE] ** 2 > _UNSTEADY and np.any(logged(window)):
        said.append(f"the log does not fit: its sigma was taken {root[MOVE]:.1f} times as large")
    return said


def _offsets(window: WindowNetwork, found: Judged) -> list[str]:
    """Name the marks that stand off by more than chance: an estimate beyond `_STANDS_OFF` times its own spread.

    The estimate is drawn towards 0 by the mark's own sigma, so its spread is what the data have taken off that.
    """
    layout, state = found.damper.plan.layout, found.descended.state
    prior = found.damper.components[OFFSET]
    told = []
    for mark, label in enumerate(window.mark_labels):
        at, sigma_m = int(layout.offset(np.array(mark))), float(window.mark_sigma_m[mark])
        spread = np.sqrt(np.maximum(prior - np.diagonal(found.cofactor)[at : at + 2], LEAST_REDUNDANCY))
        size = float(np.max(np.abs(state[at : at + 2]) / spread))
        if size > _STANDS_OFF and found.damper.taking_part[mark]:
            north, east = sigma_m * state[at : at + 2]
            left = sigma_m * math.sqrt(float(np.diagonal(found.cofactor)[at : at + 2].max()))
            told.append((size, f"{label} {north:+.0f} N {east:+.0f} E +- {left:.0f}"))
    if not told:
        return []
    named = ", ".join(text for _, text in sorted(told, reverse=True)[:_LISTED])
    more = f" and {len(told) - _LISTED} more" if len(told) > _LISTED else ""
    return [f"marks that stand off from where they are said to be [m]: {named}{more}"]
