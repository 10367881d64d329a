"""What is known of a place that is held over time: its status, what speaks for it, and how likely it is wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

TrackStatus = Literal["cold", "tracking", "dead_reckoning", "lapsed", "conflict"]


@dataclass(frozen=True, slots=True)
class TrackState:
    """The navigator's trust in its place.

    ``innovation`` squared distance of the newest window to its prior (chi-square, 3 degrees of freedom).
    ``status`` cold: no place; tracking: a place that is held; dead_reckoning: one that is held and that no echo shows
    now, so that only dead reckoning goes on; lapsed: a place whose evidence has sunk, not given out;
    conflict: two places are believed, none is given out. ``probability_wrong`` of what is given out is at most
    this, by its lead and the age of its last confirmation (None without a place, with an unproven or a lapsed one);
    ``confirmed_age_s`` since a solve that knew nothing of the track found it last; ``not_checked`` what no figure here
    covers;
    ``evidence`` of the newest window given the place; ``score`` of the place over minutes and ``ahead`` of every
    other; ``since_s`` how long the place has been held; ``source`` "blind" or "prior": whether the newest fix needed
    the track.
    """

    status: TrackStatus
    probability_wrong: float | None = None
    evidence: float | None = None
    score: float | None = None
    ahead: float | None = None
    since_s: float | None = None
    source: Literal["blind", "prior"] | None = None
    innovation: float | None = None
    confirmed_age_s: float | None = None
    not_checked: tuple[str, ...] = ()
