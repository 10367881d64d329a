"""Own ship's yaw between the scans of a window: what all relative bearings change by together.

Target numbers tell which echo is which from scan to scan, as long as they are kept. After a restart of the tracker most
of them stand for something else: then the two pictures are laid over each other whatever their numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from navfix.catalog import WindowModel, window_model
from navfix.types import FloatArray, RadarTarget
from navfix.units import wrap_pi

Report = tuple[float, RadarTarget]
Scan = Mapping[str, Report]
_VOTE_RAD = np.radians(2.0)  # echoes of one picture turn alike within this
_LEAST_VOTES = 3


@dataclass(frozen=True, eq=False)
class Yaw:
    """Own ship's turning since the first scan, by scan: times [POSIX s] (s,) and angles [rad] (s,)."""

    time_s: FloatArray
    turn_rad: FloatArray

    def at(self, time_s: float) -> float:
        """Return the angle [rad] that own ship has turned by since the first scan."""
        return float(np.interp(time_s, self.time_s, self.turn_rad))


def common_yaw(scans: Sequence[Scan], model: WindowModel | str = "joint") -> FloatArray:
    """Return the angle [rad] that own ship has turned since the first scan (s,): eq. (6.17) of the theory.

    A scan without echoes shows no turn: the next one that has some is compared with the last that had.
    """
    constants = window_model(model)
    turned, before = np.zeros(len(scans)), scans[0] if scans else {}
    for k in range(1, len(scans)):
        turned[k] = turned[k - 1] + (turn_between(before, scans[k], constants) if before and scans[k] else 0.0)
        before = scans[k] or before
    return turned


def turn_between(before: Scan, now: Scan, model: WindowModel) -> float:
    """Return the angle [rad] by which own ship turned between two scans, 0 where they do not tell.

    The range-weighted median of the bearing changes of the targets that both scans number alike: a far target's bearing
    changes by own yaw alone. A number whose range has changed by more than any ship sails stands for something else.
    Where less than half of the numbers agree on an angle, it is the one that lays most echoes of a scan on the other's.
    """
    shared = [label for label in now if label in before]
    was, new = _reports(before, shared), _reports(now, shared)
    farthest_m = _farthest_m(new[:, 0] - was[:, 0], model)
    kept = np.abs(new[:, 1] - was[:, 1]) <= farthest_m
    if np.any(kept):
        change = wrap_pi(was[kept, 2] - new[kept, 2])
        angle = _weighted_median(change, new[kept, 1])
        agree = np.abs(wrap_pi(change - angle)) <= _VOTE_RAD + farthest_m[kept] / np.maximum(new[kept, 1], 1.0)
        if 2 * np.count_nonzero(agree) >= len(shared):
            return angle
    return _laid_over(_reports(before, list(before)), _reports(now, list(now)), model)


def _reports(scan: Scan, labels: Sequence[str]) -> FloatArray:
    """Return time [s], range [m] and bearing [rad] of the targets named (n, 3)."""
    rows = [(scan[label][0], scan[label][1].range_m, scan[label][1].bearing_deg) for label in labels]
    found = np.array(rows, dtype=np.float64).reshape(-1, 3)
    found[:, 2] = np.radians(found[:, 2])
    return found


def _farthest_m(since_s: FloatArray, model: WindowModel) -> FloatArray:
    return np.asarray(model.number_m + model.number_mps * np.maximum(since_s, 0.0))


def _laid_over(was: FloatArray, new: FloatArray, model: WindowModel) -> float:
    """Return the angle [rad] that most pairs of like range agree on, 0 where no angle stands out."""
    first, second = (index.ravel() for index in np.indices((len(was), len(new))))
    near = np.abs(new[second, 1] - was[first, 1]) <= _farthest_m(new[second, 0] - was[first, 0], model)
    change = wrap_pi(was[first[near], 2] - new[second[near], 2])
    if len(change) < _LEAST_VOTES:
        return 0.0
    apart = np.abs(wrap_pi(change[:, None] - change))
    votes = np.count_nonzero(apart <= _VOTE_RAD, axis=1)
    best = int(np.argmax(votes))
    others = votes[apart[best] > 2.0 * _VOTE_RAD]
    if votes[best] < _LEAST_VOTES or (len(others) and votes[best] < 2 * np.max(others)):
        return 0.0
    agreed = apart[best] <= _VOTE_RAD
    return _weighted_median(wrap_pi(change[agreed] - change[best]), new[second[near][agreed], 1]) + float(change[best])


def _weighted_median(value: FloatArray, weight: FloatArray) -> float:
    """Return the weighted median of at least one value."""
    order = np.argsort(value)
    total = np.cumsum(weight[order])
    return float(value[order][np.searchsorted(total, 0.5 * total[-1])])
