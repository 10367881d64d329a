"""How own ship turned, scan by scan: what the bearings of all targets change by together."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque

from navfix.association.window.tracks import epoch_time
from navfix.association.window.yaw import Report, turn_between
from navfix.catalog import WindowModel, window_model
from navfix.types import Epoch

_KEPT_S = 900.0


class YawLog:
    """Own ship's turning since it began to be watched, for some minutes back; true bearings hold no yaw.

    A place knows its heading at its own instant; carried to another one it lies turned by what was seen in between.
    """

    def __init__(self, model: WindowModel | str = "joint") -> None:
        self._model = window_model(model)
        self._time_s: deque[float] = deque()
        self._turned_deg: deque[float] = deque()
        self._scan: dict[str, Report] = {}

    def feed(self, epoch: Epoch) -> None:
        """Take the next epoch in: what its relative bearings changed by together, eq. (6.17)."""
        now_s = epoch_time(epoch)
        scan: dict[str, Report] = {t.label: (now_s, t) for t in epoch.targets if t.bearing_reference == "relative"}
        turned_deg = math.degrees(turn_between(self._scan, scan, self._model))
        self._scan = scan or self._scan
        self._time_s.append(now_s)
        self._turned_deg.append((self._turned_deg[-1] if self._turned_deg else 0.0) + turned_deg)
        while now_s - self._time_s[0] > _KEPT_S:
            self._time_s.popleft()
            self._turned_deg.popleft()

    def between_deg(self, from_s: float, to_s: float) -> float:
        """Return the turn [deg] to starboard between two instants, by the newest scans before them."""
        return self._at(to_s) - self._at(from_s)

    def _at(self, time_s: float) -> float:
        if not self._time_s:
            return 0.0
        return self._turned_deg[max(bisect_right(self._time_s, time_s + 1e-3) - 1, 0)]
