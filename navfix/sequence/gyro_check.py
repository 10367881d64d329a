"""Is the gyro heard? Not where it has turned otherwise than the bearings show: a frozen or a jumping one."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from navfix.association.window.tracks import epoch_time
from navfix.catalog import NavigatorModel
from navfix.sequence.yaw import YawLog
from navfix.types import Epoch
from navfix.units import wrap_180


class GyroCheck:
    """Compares turns, never headings: a constant error of the gyro cancels in dead reckoning.

    Parameters
    ----------
    yaw : log of the turn that the bearings show
    model : constants of the navigator
    """

    def __init__(self, yaw: YawLog, model: NavigatorModel) -> None:
        self._yaw, self._model = yaw, model
        self._heard: deque[tuple[float, float]] = deque()
        self._refuted_until_s = -np.inf

    def believed(self, epoch: Epoch) -> Epoch:
        """Take the next epoch in and return it as far as it is believed: without a gyro that is refuted, for minutes.

        The turn that the bearings show must have the epoch already.
        """
        hint, now_s = epoch.heading_hint, epoch_time(epoch)
        self._heard.append((now_s, np.nan if hint is None else hint.heading_deg))
        while now_s - self._heard[0][0] > self._model.gyro_judged_s:
            self._heard.popleft()
        first_s, first_deg = self._heard[0]
        if self._refuted(float(wrap_180(self._heard[-1][1] - first_deg)), first_s, now_s):
            self._refuted_until_s = now_s + self._model.gyro_refuted_s
        return replace(epoch, heading_hint=None) if now_s < self._refuted_until_s else epoch

    def _refuted(self, turned_deg: float, from_s: float, to_s: float) -> bool:
        """Tell whether the bearings show another turn than the gyro; not where they show none, nor of NaN."""
        off_deg = abs(float(wrap_180(turned_deg - self._yaw.between_deg(from_s, to_s))))
        return off_deg > self._model.gyro_differs_deg and self._yaw.watched(from_s, to_s)
