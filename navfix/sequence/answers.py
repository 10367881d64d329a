"""Answers over time: by the navigator, with dead reckoning beside each of them, and all of them smoothed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from navfix.answering import beside, watched
from navfix.catalog import RadarModel
from navfix.errors import Ambiguous, NoAgreement, NoFix, TooFewPairs
from navfix.integrity import GnssMonitor, gnss_verdict, with_integrity
from navfix.kernels import Kernel
from navfix.report.answer import Answer
from navfix.sequence.dead_reckoning import DeadReckoner
from navfix.sequence.navigator import Navigator
from navfix.sequence.smoother import smooth
from navfix.types import Epoch, Fix


def navigated(navigator: Navigator, epoch: Epoch) -> Answer:
    """Return the navigator's outcome at the newest epoch, which was fed to it, as an answer."""
    began_s = time.perf_counter()
    outcome = navigator.step()
    timing_ms = {"epoch": epoch.build_ms or 0.0, "navigate": round(1e3 * (time.perf_counter() - began_s), 3)}
    if outcome.fix is not None:
        answer = beside(outcome.fix, outcome.association, epoch, timing_ms=timing_ms)
        return replace(answer, track=outcome.track, dead_reckoning=outcome.dead_reckoning)
    error: NoFix
    if outcome.track.status == "dead_reckoning":
        error = TooFewPairs(outcome.reason, observations=0, unknowns=3)
    elif outcome.track.status == "conflict":
        error = Ambiguous(outcome.reason, alternatives=navigator.alternatives())
    else:
        error = NoAgreement(outcome.reason, evidence=outcome.track.score or 0.0, alternatives=navigator.alternatives())
    return Answer(
        epoch=epoch,
        error=error,
        timing_ms=timing_ms,
        track=outcome.track,
        dead_reckoning=outcome.dead_reckoning,
    )


def reckoned(answer: Answer, reckoner: DeadReckoner) -> Answer:
    """Return the answer with the dead reckoning of its instant beside it, made before its fix counts.

    Feed the answers in their order: the fix of this one is what the next is reckoned from. The navigator's answers
    bring their own, which knows what it doubts.
    """
    if answer.epoch is None or answer.track is not None:
        return answer
    return replace(answer, dead_reckoning=reckoner.feed(answer.epoch, answer.fix))


def smoothed(
    answers: Sequence[Answer], *, radar: RadarModel | str = "imo", kernel: Kernel | str = "hampel"
) -> tuple[Answer, ...]:
    """Return the answers of a whole log with smoothed fixes in place of their own, the GNSS judged anew by them.

    An epoch between fixes gets one too. An epoch with a fix of its own that the minutes about it contradict gets none;
    without any of its own its reason stays.
    """
    epochs = [answer.epoch for answer in answers]
    if any(epoch is None for epoch in epochs):
        return tuple(answers)
    fixes = smooth(
        [epoch for epoch in epochs if epoch is not None], [a.fix for a in answers], radar=radar, kernel=kernel
    )
    monitor, result = GnssMonitor(), []
    for answer, fix in zip(answers, fixes, strict=True):
        result.append(watched(_with_fix(answer, fix), monitor))
    return tuple(result)


def _with_fix(answer: Answer, fix: Fix | None) -> Answer:
    if fix is None:
        error = answer.error or NoAgreement(
            "the fixes of the minutes about this scan contradict the one that it gives alone", evidence=0.0
        )
        return replace(answer, fix=None, error=error, plain_mean=None, gnss=None)
    gnss = None if answer.epoch is None else answer.epoch.gnss
    found = with_integrity(fix)
    return replace(answer, fix=found, error=None, gnss=None if gnss is None else gnss_verdict(found, gnss))
