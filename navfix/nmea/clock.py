"""The time line of a log whose lines carry no time: taken from the UTC that its sentences tell, over midnight too.

Several instruments tell the time and disagree by seconds. One of them leads (GNSS with date, then GNSS, then the
radar); the others are heard only when the leader has stood still for `SILENCE_S` by their own reckoning. Time never
runs backwards, except where the instrument that tells the date shows that another recording begins; without date a jump
of more than `SUDDEN_S` must be told twice.
"""

from __future__ import annotations

import math
from typing import Literal

ClockBasis = Literal["none", "time_of_day", "sentence"]

DAY_S = 86400.0
SILENCE_S = 10.0
SUDDEN_S = 60.0
_NEW_RECORDING_S = 43200.0


class SentenceClock:
    """Follows the sentence times of one log.

    ``now_s`` is None before the first time, else POSIX seconds; ``basis`` "time_of_day" says that no date was told
    and that the first day is 1 January 1970. ``start_s`` is a date and time [POSIX s] known beforehand.
    """

    def __init__(self, start_s: float | None = None) -> None:
        self.now_s = start_s
        self.basis: ClockBasis = "none" if start_s is None else "sentence"
        self._date_speaker: str | None = None
        self._leader_rank = math.inf
        self._told_s: dict[str, float] = {}
        self._sudden_s: dict[str, float] = {}
        self._heard_since_s: dict[str, float] = {}

    def dated(self, utc_s: float, *, speaker: str, rank: int = 0) -> None:
        """Hear date and time [POSIX s] of a sentence; the first ``speaker`` of a date is the one whose date counts."""
        self._date_speaker = self._date_speaker or speaker
        if speaker != self._date_speaker:
            self.time_of_day(utc_s % DAY_S, rank=rank, speaker=speaker)
            return
        if self.now_s is None or self.basis != "sentence" or abs(utc_s - self.now_s) > _NEW_RECORDING_S:
            self._begin(utc_s)
        self.basis = "sentence"
        self._hear(utc_s, rank, speaker)

    def time_of_day(self, utc_of_day_s: float, *, rank: int, speaker: str) -> None:
        """Hear the seconds of the day of a sentence; ``speaker`` is the instrument, a low ``rank`` is preferred."""
        if self.now_s is None:
            self.basis = "time_of_day"
            self._begin(utc_of_day_s)
        assert self.now_s is not None
        # On the day that puts it closest to now: 00:00:01 after 23:59:59 is tomorrow.
        days = round((self.now_s - utc_of_day_s) / DAY_S)
        told_s = utc_of_day_s + DAY_S * days
        if told_s - self.now_s <= SUDDEN_S or self._confirmed(told_s, speaker):
            self._hear(told_s, rank, speaker)

    def _confirmed(self, told_s: float, speaker: str) -> bool:
        """Return whether the same speaker told nearly this time before: one wild time alone moves nothing."""
        before_s = self._sudden_s.get(speaker, math.inf)
        self._sudden_s[speaker] = told_s
        return 0.0 <= told_s - before_s <= SUDDEN_S

    def _begin(self, now_s: float) -> None:
        self.now_s = now_s
        self._leader_rank = math.inf
        self._told_s.clear()
        self._heard_since_s.clear()

    def _hear(self, told_s: float, rank: int, speaker: str) -> None:
        stands_still = told_s <= self._told_s.get(speaker, -math.inf)
        self._told_s[speaker] = told_s
        if stands_still:
            return
        if rank > self._leader_rank and told_s - self._heard_since_s.setdefault(speaker, told_s) <= SILENCE_S:
            return
        assert self.now_s is not None
        self.now_s = max(self.now_s, told_s)
        self._leader_rank = rank
        self._heard_since_s.clear()
