"""How far own ship has turned between two looks: the change of bearing that all targets share."""

from __future__ import annotations

import numpy as np

from navfix.types import FloatArray
from navfix.units import wrap_180

LEAST_TRACKS = 3
LEAST_ORBITING = 5
_TOGETHER_DEG = 2.5


def weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """Return the value that half of the weight lies below."""
    order = np.argsort(values)
    below = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(below, 0.5 * below[-1])])


def common_change_deg(
    before: tuple[FloatArray, FloatArray], now: tuple[FloatArray, FloatArray], *, gate_m: FloatArray, widest_deg: float
) -> float | None:
    """Return by how many degrees the bearings of what was seen ``before`` have grown ``now``: eq. (11.1).

    Every pair of like range proposes its own change; the change that most of the tracks share within 2.5 deg wins, each
    track counted once, and of its pairs the range-weighted median is taken. None where fewer than three tracks agree,
    or not a third of those that propose anything: then nothing is proven.

    Parameters
    ----------
    before, now : ranges [m] (n,), (m,) and bearings [deg] (n,), (m,): predicted for this look, and seen
    gate_m : (n,) how far a range may be off [m]
    widest_deg : the largest change that is looked for
    """
    change_deg = wrap_180(now[1][None, :] - before[1][:, None])
    like = (np.abs(now[0][None, :] - before[0][:, None]) <= gate_m[:, None]) & (np.abs(change_deg) <= widest_deg)
    track, plot = np.nonzero(like)
    if len(track) == 0:
        return None
    proposed_deg, weight = change_deg[track, plot], before[0][track]
    together = np.abs(proposed_deg[:, None] - proposed_deg[None, :]) <= _TOGETHER_DEG
    support = np.array([len(np.unique(track[row])) for row in together], dtype=np.float64)
    best = int(np.argmax(support - 0.5 * np.abs(proposed_deg) / widest_deg))  # of equals, the smallest change
    if support[best] < max(LEAST_TRACKS, len(np.unique(track)) / 3.0):
        return None
    chosen = together[best]
    return weighted_median(proposed_deg[chosen], weight[chosen])


def orbit_rate_rad_s(position: FloatArray, velocity: FloatArray) -> float:
    """Return the rate [rad/s] at which all targets seem to circle about own ship, eq. (11.10).

    Positions and velocities (n, 2) of the tracks. A turn of own ship that was taken for theirs looks like this: nothing
    but their speeds tells the two apart. Fitted beside a common velocity, by least squares with Huber weights; 0 for
    fewer than five.
    """
    if len(position) < LEAST_ORBITING:
        return 0.0
    orbit = np.stack([-position[:, 1], position[:, 0]], axis=1)
    design = np.zeros((2 * len(position), 3))
    design[0::2, 0], design[1::2, 1], design[:, 2] = 1.0, 1.0, orbit.ravel()
    weight = np.ones(2 * len(position))
    solution = np.zeros(3, dtype=np.float64)
    for _ in range(5):
        root = np.sqrt(weight)
        solution[:] = np.linalg.lstsq(design * root[:, None], velocity.ravel() * root, rcond=None)[0]
        misfit = np.hypot(*(velocity.ravel() - design @ solution).reshape(-1, 2).T)
        scale = max(float(np.median(misfit)), 0.1)
        weight = np.repeat(np.minimum(1.0, scale / np.maximum(misfit, 1e-9)), 2)
    return float(solution[2])


class Yaw:
    """By how many degrees own ship has turned since the first look, with a rate between the looks."""

    def __init__(self) -> None:
        self._time_s: float | None = None
        self._angle_deg = 0.0
        self._rate_deg_s = 0.0

    def at(self, time_s: float) -> float:
        """Return the angle [deg] at a time [POSIX s], to starboard positive."""
        if self._time_s is None:
            return 0.0
        return self._angle_deg + self._rate_deg_s * (time_s - self._time_s)

    def correct(self, time_s: float, by_deg: float | None) -> None:
        """Turn the angle at a look; the rate follows by half. None: nothing was seen of a turn, the rate fades."""
        if self._time_s is not None and time_s > self._time_s:
            angle_deg = self.at(time_s) + (by_deg or 0.0)
            seen_deg_s = 0.0 if by_deg is None else (angle_deg - self._angle_deg) / (time_s - self._time_s)
            self._rate_deg_s = 0.5 * (self._rate_deg_s + seen_deg_s)
            self._angle_deg = angle_deg
        self._time_s = time_s

    def slow_down(self, rate_deg_s: float) -> None:
        """Take a rate from the rate."""
        self._rate_deg_s -= rate_deg_s
