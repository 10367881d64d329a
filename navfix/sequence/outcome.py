"""What a step of the navigator gives: a status, a fix or the reason why there is none, and the state of the track."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.types import Association, DeadReckoning, Fix
from navfix.types.track import TrackState, TrackStatus


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
