"""When an AIS position held, in the clock of the log: its own second of the minute tells better than its reception.

A report tells the second of the minute (UTC) of its position; it is received some seconds later, over a network perhaps
ten. Where a log shows positions before they held, its clock and the seconds contradict each other: then the receptions
count, because the radar's sentences are timed by them too, and their scatter widens the sigma of moving marks.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median

MINUTE_S = 60.0
SLOWEST_S, LATEST_S = -3.0, 15.0  # median of reception minus position: beyond it the clock of the log is off
ASTRAY_S = 12.0  # a second farther than this from what the others say is wrong
STATION_REPORTS, LOG_REPORTS = 15, 400
LEARN_EVERY = 20
LEAST_STATION = 5


class AisClock:
    """Learns how receptions lie to the seconds that the reports tell, over all stations and for each one."""

    def __init__(self) -> None:
        self._all: deque[float] = deque(maxlen=LOG_REPORTS)
        self._stations: dict[int, deque[float]] = {}
        self._count = 0
        self._delay_s = 0.0
        self._scatter_s = 0.0

    @property
    def offset_s(self) -> float:
        """Clock of the log minus UTC [s] as the seconds tell it: 0 unless they contradict it.

        A median delay of -3 to 15 s is how reports come; with less, positions would be received before they held.
        """
        return 0.0 if SLOWEST_S <= self._delay_s <= LATEST_S else self._delay_s

    @property
    def scatter_s(self) -> float:
        """1 sigma [s] of the receptions about the positions where they have to time them, else 0."""
        return self._scatter_s if self.offset_s else 0.0

    def position_time(self, mmsi: int, received_s: float, utc_second: int | None) -> float:
        """Return when a position held [POSIX s, clock of the log]; without a second it is taken as received."""
        if utc_second is None:
            return received_s
        self._learn(mmsi, delay(received_s, utc_second))
        return received_s if self.offset_s else position_time(received_s, utc_second, self._offset_of(mmsi))

    def _learn(self, mmsi: int, delay_s: float) -> None:
        self._all.append(delay_s)
        self._stations.setdefault(mmsi, deque(maxlen=STATION_REPORTS)).append(delay_s)
        self._count += 1
        if self._count % LEARN_EVERY == 0:
            self._delay_s = circular_median(self._all)
            self._scatter_s = 1.4826 * median(abs(delay_from(d, self._delay_s)) for d in self._all)

    def _offset_of(self, mmsi: int) -> float:
        """Return how receptions lie to the seconds of a station whose own clock is more than `ASTRAY_S` off, else 0."""
        own = self._stations[mmsi]
        apart_s = circular_median(own) if len(own) >= LEAST_STATION else 0.0
        return apart_s if abs(apart_s) > ASTRAY_S else 0.0


def position_time(received_s: float, utc_second: int | None, offset_s: float = 0.0) -> float:
    """Return when a position held [POSIX s]: its own second of the minute, where the reception makes that plausible.

    ``offset_s`` is how the clock of the receptions lies to that of the seconds.
    """
    if utc_second is None:
        return received_s
    late_s = delay_from(delay(received_s, utc_second), offset_s)
    return received_s - late_s if -ASTRAY_S <= late_s <= LATEST_S else received_s


def delay(received_s: float, utc_second: int) -> float:
    """Return reception minus second of the minute [s], -30 <= delay < 30."""
    return delay_from(received_s, float(utc_second))


def delay_from(time_s: float, other_s: float) -> float:
    """Return the difference of two times [s] modulo a minute, -30 <= difference < 30."""
    return (time_s - other_s + MINUTE_S / 2.0) % MINUTE_S - MINUTE_S / 2.0


def circular_median(delays_s: deque[float]) -> float:
    """Return the median [s] of delays that are known modulo a minute, -30 <= median < 30."""
    angles = [2.0 * math.pi * d / MINUTE_S for d in delays_s]
    centre_s = MINUTE_S / (2.0 * math.pi) * math.atan2(sum(map(math.sin, angles)), sum(map(math.cos, angles)))
    return delay_from(centre_s + median(delay_from(d, centre_s) for d in delays_s), 0.0)
