"""What radar, AIS or both together say of one ship, in one format: range, bearing, speed and course with variances."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from navfix.types.checks import require
from navfix.types.observed import BearingReference
from navfix.types.places import Position

Sensor = Literal["radar", "ais", "fused"]
Pairing = Literal["fix", "grey"]


@dataclass(frozen=True, slots=True)
class TrackedShip:
    """One ship as a sensor sees it from own ship, or as both do together ("fused").

    Bearings and courses are true where own heading is known; ``bearing_reference`` says of what the bearing counts.
    What a sensor does not say is None; a value and its variance are None together. ``target`` is the radar's label,
    ``mark`` that of the AIS station. ``probability`` is that of the pair.
    """

    sensor: Sensor
    label: str
    time_utc: datetime | None = None
    range_m: float | None = None
    range_variance_m2: float | None = None
    bearing_deg: float | None = None
    bearing_variance_deg2: float | None = None
    bearing_reference: BearingReference = "true"
    speed_mps: float | None = None
    speed_variance_m2ps2: float | None = None
    course_deg: float | None = None
    course_variance_deg2: float | None = None
    position: Position | None = None
    target: str | None = None
    mark: str | None = None
    mmsi: int | None = None
    name: str | None = None
    kind: str | None = None
    probability: float | None = None

    def __post_init__(self) -> None:
        for value, variance in (
            ("range_m", "range_variance_m2"),
            ("bearing_deg", "bearing_variance_deg2"),
            ("speed_mps", "speed_variance_m2ps2"),
            ("course_deg", "course_variance_deg2"),
        ):
            both = (getattr(self, value) is None) == (getattr(self, variance) is None)
            require(both, f"{self.label}: {value}", f"must come with {variance}", getattr(self, variance))
            spread = getattr(self, variance)
            require(spread is None or spread > 0.0, f"{self.label}: {variance}", "must be > 0", spread)


@dataclass(frozen=True, slots=True)
class TargetList:
    """All ships of one instant. Without a fix (``reason`` and ``message`` say why) radar and AIS stand apart.

    ``pairing`` says what has told which target is which ship: the fix, or the grey relation of the tracks.
    """

    time_utc: datetime | None
    ships: tuple[TrackedShip, ...]
    own_position: Position | None = None
    own_heading_deg: float | None = None
    reason: str | None = None
    message: str | None = None
    pairing: Pairing = "fix"

    def __post_init__(self) -> None:
        object.__setattr__(self, "ships", tuple(self.ships))

    def of(self, sensor: Sensor) -> tuple[TrackedShip, ...]:
        """Return the ships that this sensor alone, or both together, see."""
        return tuple(ship for ship in self.ships if ship.sensor == sensor)
