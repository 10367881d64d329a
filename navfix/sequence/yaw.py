"""How own ship turned, scan by scan: what the bearings of all targets change by together."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque

from navfix.association.window.tracks import epoch_time
from navfix.association.window.yaw import Report, turn_between
from navfix.catalog import WindowModel, window_model
from navfix.types import Epoch


class YawLog:
    """Own ship's turning since it began to be watched, for some minutes back; true bearings hold no yaw.

    A place knows its heading at its own instant; carried to another one it lies turned by what was seen in between.
    Nothing is known of a turn in a time without scans.
    """

    def __init__(self, model: WindowModel | str = "joint") -> None:
        self._model = window_model(model)
        self._time_s: deque[float] = deque()
        self._turned_deg: deque[float] = deque()
        self._scan: dict[str, Report] = {}
        self._scan_s = -math.inf
        self._unseen: deque[tuple[float, float]] = deque()

    def feed(self, epoch: Epoch) -> None:
        """Take the next epoch in: what its relative bearings changed by together, eq. (6.17)."""
        now_s = epoch_time(epoch)
        scan: dict[str, Report] = {t.label: (now_s, t) for t in epoch.targets if t.bearing_reference == "relative"}
        bridged = now_s - self._scan_s <= self._model.silence_s  # else the bearings change by the way too
        turned_deg = math.degrees(turn_between(self._scan, scan, self._model)) if bridged else 0.0
        if scan and not bridged:
            self._unseen.append((self._scan_s, now_s))
        if scan:
            self._scan, self._scan_s = scan, now_s
        self._time_s.append(now_s)
        self._turned_deg.append((self._turned_deg[-1] if self._turned_deg else 0.0) + turned_deg)
        while now_s - self._time_s[0] > self._model.yaw_kept_s:
            self._time_s.popleft()
            self._turned_deg.popleft()
        while self._unseen and now_s - self._unseen[0][1] > self._model.yaw_kept_s:
            self._unseen.popleft()

    def watched(self, from_s: float, to_s: float) -> bool:
        """Tell whether relative bearings showed the turn all the time between two instants."""
        last_seen = to_s - self._scan_s <= self._model.silence_s
        return last_seen and not any(begin_s < to_s and end_s > from_s for begin_s, end_s in self._unseen)

    def missed(self, from_s: float, to_s: float) -> bool:
        """Tell whether a turn between two instants went unseen; true bearings do not turn, so nothing is missed."""
        return math.isfinite(self._scan_s) and not self.watched(from_s, to_s)

    def between_deg(self, from_s: float, to_s: float) -> float:
        """Return the turn [deg] to starboard between two instants, by the newest scans before them."""
        return self._at(to_s) - self._at(from_s)

    def _at(self, time_s: float) -> float:
        if not self._time_s:
            return 0.0
        return self._turned_deg[max(bisect_right(self._time_s, time_s + 1e-3) - 1, 0)]
