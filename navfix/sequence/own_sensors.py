"""The way since an earlier place by own sensors: turn of the gyro, speed of the log, current that the fixes show."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from navfix.association.window.tracks import epoch_time
from navfix.sequence.places import Place, Sailed
from navfix.sequence.sailing import through_water, turned
from navfix.sequence.yaw import YawLog
from navfix.types import Epoch
from navfix.units import wrap_180

_KEPT_S = 300.0
_CONTRADICTS_DEG = 20.0  # more than the bearings of near targets change by themselves in a quarter of a minute
_JUDGED_S = 20.0
_SAME_S = 0.05  # an epoch is that of a place within this


class OwnSensors:
    """Remembers gyro and log of some minutes. Only changes of the gyro count: its constant error cancels.

    Parameters
    ----------
    yaw : log of the turn that the bearings show; a gyro that turned otherwise is not heard
    """

    def __init__(self, yaw: YawLog) -> None:
        self._yaw = yaw
        self._heard: deque[tuple[float, float, float]] = deque()
        self._refuted_until_s = -np.inf

    def feed(self, epoch: Epoch) -> None:
        """Take the next epoch in."""
        hint, log = epoch.heading_hint, epoch.speed_hint
        gyro_deg = np.nan if hint is None else hint.heading_deg
        self._heard.append((epoch_time(epoch), gyro_deg, np.nan if log is None else log.speed_mps))
        while self._heard[-1][0] - self._heard[0][0] > _KEPT_S:
            self._heard.popleft()

    def believed(self, epoch: Epoch) -> Epoch:
        """Return the newest epoch as far as it is believed: without a gyro that has turned otherwise than the bearings.

        A refuted gyro is not heard for as long as its heading is remembered.
        """
        now_s = self._heard[-1][0]
        rows = [row for row in self._heard if now_s - row[0] <= _JUDGED_S]
        if self._refuted(float(wrap_180(rows[-1][1] - rows[0][1])), rows[0][0], now_s):
            self._refuted_until_s = now_s + _KEPT_S
        return replace(epoch, heading_hint=None) if now_s < self._refuted_until_s else epoch

    def _refuted(self, turned_deg: float, from_s: float, to_s: float) -> bool:
        """Tell whether the bearings show another turn than the gyro; not where they show none, nor of NaN."""
        off_deg = abs(float(wrap_180(turned_deg - self._yaw.between_deg(from_s, to_s))))
        return off_deg > _CONTRADICTS_DEG and self._yaw.watched(from_s, to_s)

    def since(self, place: Place, to_s: float) -> Sailed | None:
        """Return the way from a place to a later instant, None where the gyro was not heard all the time or is wrong.

        Log along the heading and current make the velocity; the current is what the velocity of the place has more than
        its log. Without a log the velocity of the place turns with the ship.
        """
        heard = [row for row in self._heard if place.time_s - _SAME_S <= row[0] <= to_s + _SAME_S]
        if len(heard) < 2 or abs(heard[0][0] - place.time_s) > _SAME_S or abs(heard[-1][0] - to_s) > _SAME_S:
            return None
        time_s, gyro_deg, log_mps = np.array(heard).T
        if np.isnan(gyro_deg).any():
            return None
        steps_deg = wrap_180(np.diff(gyro_deg))
        turned_deg = float(wrap_180(gyro_deg[-1] - gyro_deg[0]))
        if self._refuted(turned_deg, place.time_s, to_s):
            return None
        by_log = not np.isnan(log_mps).any()
        ahead = np.exp(1j * np.radians(place.heading_deg))
        velocity = place.velocity_mps - log_mps[0] * ahead if by_log else place.velocity_mps  # current, or over ground
        way_m, heading_deg = 0j, place.heading_deg
        for k, (step_s, step_deg) in enumerate(zip(np.diff(time_s), steps_deg, strict=True)):
            if by_log:
                way_m += through_water((log_mps[k], log_mps[k + 1]), heading_deg, step_deg, step_s) + velocity * step_s
            else:
                way_m += turned(velocity, 0.5 * step_deg) * step_s
                velocity = turned(velocity, step_deg)
            heading_deg += step_deg
        return Sailed(complex(way_m), turned_deg, "log and gyro" if by_log else "gyro")
