"""What one epoch gave: the record that every writer takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

from navfix.errors import InputError, NoFix
from navfix.types import DeadReckoning, Epoch, Fix, GnssVerdict, MeanFix, Position, RadarErrors, TrackState


@dataclass(frozen=True, slots=True)
class Truth:
    """Where own ship really was, and how far the fix lies from it.

    ``error_m`` and ``heading_error_deg`` (fix minus truth, -180 .. 180) are None where there is no fix, as is
    ``in_ellipse``: whether the 95 % ellipse holds the truth. The heading is None where the truth file does not tell it.
    """

    position: Position
    heading_deg: float | None = None
    error_m: float | None = None
    heading_error_deg: float | None = None
    in_ellipse: bool | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """The fix of one epoch with everything that stands beside it, or the reason why there is none.

    Exactly one of ``fix`` and ``error`` is set. ``timing_ms`` holds milliseconds by step ("epoch", "associate",
    "adjust"). ``notes`` are sentences for the reader of the report; ``cautions`` are those that he must not miss.
    ``dead_reckoning`` is where own ship should be by the fixes before, whatever this epoch says; ``track`` is what the
    navigator knows of its place; ``radar_errors`` what minutes say of the radar's clock and ranges.

    Raises
    ------
    InputError : both or neither of ``fix`` and ``error``
    """

    epoch: Epoch | None
    fix: Fix | None = None
    error: NoFix | None = None
    plain_mean: MeanFix | None = None
    gnss: GnssVerdict | None = None
    timing_ms: Mapping[str, float] = field(default_factory=dict)
    truth: Truth | None = None
    notes: tuple[str, ...] = ()
    cautions: tuple[str, ...] = ()
    dead_reckoning: DeadReckoning | None = None
    track: TrackState | None = None
    radar_errors: RadarErrors | None = None

    def __post_init__(self) -> None:
        if (self.fix is None) == (self.error is None):
            raise InputError(
                "an answer is either a fix or the error that says why there is none: give exactly one of them"
            )
        object.__setattr__(self, "notes", tuple(self.notes))
        object.__setattr__(self, "cautions", tuple(self.cautions))

    @property
    def time_utc(self) -> datetime | None:
        """The instant of the answer, None where the log tells no time."""
        return None if self.epoch is None else self.epoch.time_utc
