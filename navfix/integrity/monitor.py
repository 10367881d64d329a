"""GNSS against the fixes over time: one lasting verdict, one alert for each change, jumps and slow drags both."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace
from datetime import datetime

from navfix.errors import InputError
from navfix.integrity.drift import Difference, ErrorModel, Slow, slow_difference
from navfix.integrity.gnss import ONE_INSTANT, difference, gnss_verdict
from navfix.types import Fix, GnssReport, GnssVerdict, Verdict

_WORDS: dict[Verdict, str] = {"ok": "ok", "caution": "caution", "unsafe": "unsafe", "not_available": "not available"}
SLOW_PROBABILITY = 1e-4  # of one test over a window; a window of minutes is tested anew in every epoch


@dataclass(frozen=True, slots=True)
class MonitorSettings:
    """How the verdict lasts.

    Attributes
    ----------
    needed, of : so many of the last so many comparisons make a verdict "unsafe" or "not_available"; ``of`` in a row
        make it "caution", and as many in a row without an alarm end an alarm
    decisive : an unsafe comparison at so many times its threshold counts twice
    windows_s : lengths of the windows whose mean and trend are tested
    slow_probability : that one such test fails with a good receiver
    model : how errors of successive comparisons belong together
    """

    needed: int = 3
    of: int = 5
    decisive: float = 2.0
    windows_s: tuple[float, ...] = (60.0, 300.0)
    slow_probability: float = SLOW_PROBABILITY
    model: ErrorModel = field(default_factory=ErrorModel)

    def __post_init__(self) -> None:
        if not 1 <= self.needed <= self.of:
            raise InputError(f"needed must be within 1 .. of, got {self.needed} of {self.of}")
        if not self.decisive >= 1.0:
            raise InputError(f"decisive must be >= 1, got {self.decisive!r}")
        if not 0.0 < self.slow_probability < 1.0:
            raise InputError(f"slow_probability must be within 0 .. 1, got {self.slow_probability!r}")


class GnssMonitor:
    """Follows the comparison of GNSS and fix; reads no clock: times come with what is fed.

    References
    ----------
    Theory 7, eq. (7.7) to (7.10).
    """

    def __init__(self, settings: MonitorSettings | None = None) -> None:
        self._settings = settings or MonitorSettings()
        self._verdicts: deque[Verdict] = deque(maxlen=self._settings.of)
        self._counts: deque[int] = deque(maxlen=self._settings.of)
        self._slow_flags: deque[bool] = deque(maxlen=self._settings.of)
        self._differences: deque[Difference] = deque()
        self._lasting: Verdict | None = None
        self._silent = 0

    @property
    def verdict(self) -> Verdict | None:
        """The lasting verdict; None before the first comparison."""
        return self._lasting

    def feed(self, fix: Fix | None, gnss: GnssReport | None, at: datetime | None = None) -> GnssVerdict | None:
        """Take one epoch in and return its verdict: lasting, with that of the instant beside it.

        Parameters
        ----------
        fix, gnss : what the epoch gave; None where it gave none. Without both there is nothing to compare: the lasting
            verdict is kept for ``of`` epochs, then it is "not_available" - unless an alarm stands, which stays.
        at : time of the epoch, default that of the fix; without one, offset and drift over time are not tested

        Returns
        -------
        GnssVerdict - None where the epoch has no GNSS

        Raises
        ------
        InputError : what `gnss_verdict` refuses
        """
        if gnss is None or fix is None:
            return self._silence(gnss)
        self._silent = 0
        instant = gnss_verdict(fix, gnss)
        slow = self._slow(fix, gnss, at or (None if fix.epoch is None else fix.epoch.time_utc))
        self._verdicts.append(instant.verdict)
        self._counts.append(self._counted(instant))
        self._slow_flags.append(any(window.beyond for window in slow))
        before, self._lasting = self._lasting, self._decide()
        why = self._why(slow)
        return replace(
            instant,
            verdict=self._lasting,
            instant=instant.verdict,
            reasons=(why, *(r for r in instant.reasons if r != ONE_INSTANT), _slow_words(slow)),
            alert=_alert(before, self._lasting, why),
            drift_mps=slow[-1].drift_mps if slow else None,
        )

    # ------------------------------------------------------------------------------------------------ what follows

    def _decide(self) -> Verdict:
        """Eq. (7.7): k of n, and no end of an alarm before n quiet epochs."""
        k, n = self._settings.needed, self._settings.of
        verdicts, slow = list(self._verdicts), list(self._slow_flags)
        if sum(self._counts) >= k or sum(slow) >= k:
            return "unsafe"
        if self._lasting == "unsafe" and ("unsafe" in verdicts or any(slow) or len(verdicts) < n):
            return "unsafe"
        if verdicts.count("not_available") >= k or (self._lasting is None and verdicts[-1] == "not_available"):
            return "not_available"
        if len(verdicts) == n and all(v in ("caution", "unsafe") for v in verdicts):
            return "caution"
        if self._lasting in ("caution", "not_available") and verdicts[-1] == "ok" and verdicts.count("ok") < k:
            return self._lasting
        return "ok" if "ok" in verdicts or self._lasting == "ok" else "caution"

    def _counted(self, instant: GnssVerdict) -> int:
        """Return for how many a comparison counts: two where it lies far beyond its threshold, as after a jump."""
        if instant.verdict != "unsafe":
            return 0
        return 2 if instant.distance_m > self._settings.decisive * instant.threshold_m else 1

    def _why(self, slow: tuple[Slow, ...]) -> str:
        """Return the reason of the lasting verdict, in one sentence."""
        k, n = self._settings.needed, self._settings.of
        verdicts, beyond = list(self._verdicts), [window for window in slow if window.beyond]
        if sum(self._counts) >= k:
            far = ", far beyond" if max(self._counts) > 1 else " are beyond"
            return f"{verdicts.count('unsafe')} of the last {len(verdicts)} comparisons{far} the threshold"
        if sum(self._slow_flags) >= k and beyond:
            return beyond[-1].in_words
        if self._lasting == "unsafe":
            return f"the alarm stands until {n} comparisons in a row are without one"
        if self._lasting == "caution" and len(verdicts) == n and "ok" not in verdicts:
            return f"{n} comparisons in a row beyond what good receivers usually show, or with doubts about the fix"
        if self._lasting == verdicts[-1]:
            return f"this verdict has lasted: {verdicts.count(self._lasting)} of the last {len(verdicts)} comparisons"
        return f"this epoch alone: {_WORDS[verdicts[-1]]}; a change needs {k} of {n} comparisons"

    def _slow(self, fix: Fix, gnss: GnssReport, at: datetime | None) -> tuple[Slow, ...]:
        if at is None:
            self._differences.clear()
            return ()
        now_s, windows_s = at.timestamp(), self._settings.windows_s
        if self._differences and now_s <= self._differences[-1].time_s:
            self._differences.clear()
        self._differences.append(Difference(now_s, *difference(fix, gnss)))
        while now_s - self._differences[0].time_s > max(windows_s, default=0.0):
            self._differences.popleft()
        tests = []
        for window_s in windows_s:
            inside = [d for d in self._differences if now_s - d.time_s <= window_s]
            test = slow_difference(inside, self._settings.model, self._settings.slow_probability)
            if test is not None and test not in tests:
                tests.append(test)
        return tuple(tests)

    def _silence(self, gnss: GnssReport | None) -> GnssVerdict | None:
        """Nothing to compare: an alarm stays, everything else fades to "not_available"."""
        self._silent += 1
        before = self._lasting
        if self._silent >= self._settings.of and before not in (None, "unsafe"):
            self._lasting = "not_available"
            self._verdicts.clear()
            self._counts.clear()
            self._slow_flags.clear()
        if gnss is None:
            return None
        missing = f"no fix to compare with, {self._silent} epochs in a row"
        return GnssVerdict(
            position=gnss.position,
            distance_m=math.nan,
            verdict=self._lasting or "not_available",
            threshold_m=math.nan,
            smallest_detectable_m=math.inf,
            reasons=(missing, *(("the alarm from before still stands",) if before == "unsafe" else ())),
            instant="not_available",
            alert=_alert(before, self._lasting or "not_available", missing),
        )


def _alert(before: Verdict | None, now: Verdict, why: str) -> str | None:
    if now == before or (before is None and now != "unsafe"):
        return None
    came = "" if before is None else f"{_WORDS[before]} -> "
    return f"GNSS {came}{_WORDS[now]}: {why}"


def _slow_words(slow: tuple[Slow, ...]) -> str:
    if not slow:
        return "not checked yet: offset and drift over time, for want of comparisons"
    said = "; ".join(
        f"over {w.window_s:.0f} s offset {w.offset_m:.0f} m (up to {w.offset_limit_m:.0f} m explained) and drift "
        f"{w.drift_mps:.2f} m/s (up to {w.drift_limit_mps:.2f})"
        for w in slow
    )
    return f"checked: {said}; a slower drag is not seen"
