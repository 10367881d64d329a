"""What a step of the navigator gives: a status, a fix or the reason why there is none, and the state of the track."""

from __future__ import annotations

from dataclasses import dataclass, replace

from navfix.sequence.doubt import NOT_CHECKED
from navfix.sequence.track import Held, Track
from navfix.types import Association, DeadReckoning, Fix, TrackState, TrackStatus
from navfix.types.found import LARGEST_MARGIN


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """One step: ``fix`` or None with the ``reason`` in words; ``association`` behind the fix; the ``track``.

    ``dead_reckoning`` stands apart from the fix: the way on from the fixes before, None where none of them carries it.
    """

    status: TrackStatus
    fix: Fix | None
    reason: str
    track: TrackState
    association: Association | None = None
    dead_reckoning: DeadReckoning | None = None


def outcome_of(
    track: Track,
    held: Held | None,
    reckoned: DeadReckoning | None,
    now_s: float,
    *,
    score: float | None,
    ahead: float | None,
    why_none: str,
) -> Outcome:
    """Return what a step gives out of a held place: a fix, or none with the reason and dead reckoning apart from it.

    Parameters
    ----------
    track, held : the place, and what this step found at it
    score, ahead : of the place in the bank [nats], None where the bank does not hold it
    why_none : the reason where nothing speaks against the place and there is no fix all the same
    """
    silent = track.standing.why_silent(now_s) if track.proven else ""
    doubted = track.given_up or track.why_lapsed or silent
    given_out = track.proven and not track.lapsed and not silent
    fix = held.fix if held is not None and given_out and not track.given_up else None
    state = TrackState(
        _status(fix, reckoned, given_out=given_out),
        None if fix is None else track.probability_wrong,
        None if held is None else held.evidence,
        score,
        None if ahead is None else min(ahead, LARGEST_MARGIN),
        now_s - track.since_s,
        None if held is None else held.source,
        track.protection.innovation,
        now_s - track.standing.confirmed_s if track.proven else None,
        NOT_CHECKED,
    )
    if fix is None or held is None:
        unproven = "" if track.proven else "the place that was given is not confirmed yet by any solve without it"
        return Outcome(state.status, None, doubted or unproven or why_none, state, dead_reckoning=reckoned)
    track.standing.stated = state.probability_wrong
    return Outcome("tracking", _doubted(fix, state), "", state, held.association, reckoned)


def _status(fix: Fix | None, reckoned: DeadReckoning | None, *, given_out: bool) -> TrackStatus:
    if not given_out:
        return "lapsed"
    return "tracking" if fix is not None or reckoned is None else "dead_reckoning"


def _doubted(fix: Fix, state: TrackState) -> Fix:
    """Return the fix with what the track knows of being wrong in place of what its one window says."""
    if fix.association is None:
        return fix
    return replace(fix, association=replace(fix.association, probability_wrong=state.probability_wrong))
