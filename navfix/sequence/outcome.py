"""What a step of the navigator gives: a status, a fix or the reason why there is none, and what is known of the track."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from navfix.types import Association, Fix

Status = Literal["cold", "tracking", "lapsed", "conflict"]


@dataclass(frozen=True, slots=True)
class TrackState:
    """The navigator's trust in its place.

    ``status`` cold: no place; tracking: a place that is held; lapsed: a place whose evidence has sunk, not given out;
    conflict: two places are accepted, none is given out. ``probability_wrong`` is at most this (None without a place);
    ``evidence`` of the newest window given the place; ``score`` of the place over minutes and ``ahead`` of every other;
    ``since_s`` how long the place has been held; ``source`` "blind" or "prior": whether the newest fix needed the track.
    """

    status: Status
    probability_wrong: float | None = None
    evidence: float | None = None
    score: float | None = None
    ahead: float | None = None
    since_s: float | None = None
    source: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """One step: ``fix`` or None with the ``reason`` in words; ``association`` behind the fix; the ``track``."""

    status: Status
    fix: Fix | None
    reason: str
    track: TrackState
    association: Association | None = None
