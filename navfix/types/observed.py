"""What goes in: radar targets, marks, hints, own GNSS for comparison, and the epoch that joins them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

from navfix.types.charted import ChartCheck, MethodChoice
from navfix.types.checks import require
from navfix.types.places import Hull, Position
from navfix.units import wrap_360

BearingReference = Literal["relative", "true"]
MarkKind = Literal["ship", "aton", "charted"]
TargetPoint = Literal["echo", "hull_centre"]


@dataclass(frozen=True, slots=True)
class RadarTarget:
    """What the radar sees: range [m] and bearing [deg] from own ship.

    ``bearing_reference`` "relative" counts from the radar's zero mark, "true" from north.
    ``speed_mps`` and ``course_deg`` are true and over ground (None where the radar does not say so).
    A sigma given here (1 sigma) overrides the radar model's. ``point`` says what of a ship was measured: its echo, on
    the side that faces own ship, or by its outline the "hull_centre". ``length_m`` is how long the echo is, where the
    radar tells.
    """

    label: str
    range_m: float
    bearing_deg: float
    bearing_reference: BearingReference = "relative"
    time_utc: datetime | None = None
    speed_mps: float | None = None
    course_deg: float | None = None
    range_sigma_m: float | None = None
    bearing_sigma_deg: float | None = None
    status: str | None = None
    point: TargetPoint = "echo"
    length_m: float | None = None

    def __post_init__(self) -> None:
        who = f"target {self.label}"
        require(math.isfinite(self.range_m) and self.range_m > 0.0, f"{who}: range_m", "must be > 0", self.range_m)
        require(math.isfinite(self.bearing_deg), f"{who}: bearing_deg", "must be finite", self.bearing_deg)
        require(
            self.bearing_reference in ("relative", "true"),
            f"{who}: bearing_reference",
            "must be 'relative' or 'true'",
            self.bearing_reference,
        )
        require(self.point in ("echo", "hull_centre"), f"{who}: point", "must be 'echo' or 'hull_centre'", self.point)
        for name in ("range_sigma_m", "bearing_sigma_deg", "length_m"):
            value = getattr(self, name)
            require(value is None or (math.isfinite(value) and value > 0.0), f"{who}: {name}", "must be > 0", value)
        _require_finite(self, who, ("speed_mps", "course_deg"))
        object.__setattr__(self, "bearing_deg", wrap_360(float(self.bearing_deg)))


@dataclass(frozen=True, slots=True)
class Mark:
    """What has a known position: an AIS ship, an aid to navigation, a charted object.

    ``sigma_m`` is 1 sigma per axis and complete: age and hull enter when the epoch is built, not later.
    ``age_s`` is the age of the report that the position was carried forward from. ``hull_sigma_m`` is the part of
    ``sigma_m`` that a hull adds while it is not known from where it is seen: the position is then that of the hull's
    centre. At 0 the position is where the echo is expected.
    """

    label: str
    position: Position
    sigma_m: float
    kind: MarkKind = "ship"
    mmsi: int | None = None
    time_utc: datetime | None = None
    speed_mps: float | None = None
    course_deg: float | None = None
    heading_deg: float | None = None
    hull: Hull | None = None
    name: str | None = None
    ais_class: Literal["A", "B"] | None = None
    ship_type: int | None = None
    age_s: float | None = None
    hull_sigma_m: float = 0.0

    def __post_init__(self) -> None:
        require(
            math.isfinite(self.sigma_m) and self.sigma_m >= 0.0,
            f"mark {self.label}: sigma_m",
            "must be >= 0",
            self.sigma_m,
        )
        require(
            0.0 <= self.hull_sigma_m <= self.sigma_m,
            f"mark {self.label}: hull_sigma_m",
            "must be within 0 .. sigma_m",
            self.hull_sigma_m,
        )
        require(
            self.kind in ("ship", "aton", "charted"),
            f"mark {self.label}: kind",
            "must be 'ship', 'aton' or 'charted'",
            self.kind,
        )
        _require_finite(self, f"mark {self.label}", ("speed_mps", "course_deg", "heading_deg", "age_s"))


def _require_finite(record: object, who: str, names: tuple[str, ...]) -> None:
    """Raise InputError where one of the values is neither a number nor None: what is not known is None."""
    for name in names:
        value = getattr(record, name)
        require(value is None or math.isfinite(value), f"{who}: {name}", "must be finite, or None if unknown", value)


@dataclass(frozen=True, slots=True)
class HeadingHint:
    """A heading [deg] with its sigma [deg] from a gyro or an earlier fix: checked against the data, never believed."""

    heading_deg: float
    sigma_deg: float

    def __post_init__(self) -> None:
        require(math.isfinite(self.heading_deg), "heading_deg", "must be finite", self.heading_deg)
        require(math.isfinite(self.sigma_deg) and self.sigma_deg > 0.0, "sigma_deg", "must be > 0", self.sigma_deg)


@dataclass(frozen=True, slots=True)
class PositionHint:
    """A position with its sigma per axis [m] from dead reckoning or an earlier fix: checked, never believed."""

    position: Position
    sigma_m: float

    def __post_init__(self) -> None:
        require(math.isfinite(self.sigma_m) and self.sigma_m > 0.0, "sigma_m", "must be > 0", self.sigma_m)


@dataclass(frozen=True, slots=True)
class SpeedHint:
    """Own speed along the bow [m/s] with its sigma [m/s] from a log: checked against the data, never believed.

    ``reference`` "water" moves with the current; "ground" is a log with bottom track. Never from GNSS.
    """

    speed_mps: float
    sigma_mps: float
    reference: Literal["water", "ground"] = "water"

    def __post_init__(self) -> None:
        require(math.isfinite(self.speed_mps), "speed_mps", "must be finite", self.speed_mps)
        require(math.isfinite(self.sigma_mps) and self.sigma_mps > 0.0, "sigma_mps", "must be > 0", self.sigma_mps)


@dataclass(frozen=True, slots=True)
class GnssReport:
    """Own GNSS position of the log, carried to the epoch. Never evidence for a fix: only compared with it."""

    position: Position
    sigma_m: float
    time_utc: datetime | None = None


@dataclass(frozen=True, slots=True)
class Epoch:
    """Everything reduced to one instant: targets, marks, and the hints that a log may hold.

    ``left_out`` counts the stations that could not serve as marks, by reason. ``build_ms`` is how long it took to
    reduce everything to the instant [ms]. ``chart`` says how charted marks and AIS aids agree (None without a chart),
    ``choice`` which data are used and why.
    """

    time_utc: datetime | None
    targets: tuple[RadarTarget, ...]
    marks: tuple[Mark, ...]
    heading_hint: HeadingHint | None = None
    position_hint: PositionHint | None = None
    speed_hint: SpeedHint | None = None
    gnss: GnssReport | None = None
    left_out: tuple[tuple[str, int], ...] = ()
    build_ms: float | None = field(default=None, compare=False)
    chart: ChartCheck | None = None
    choice: MethodChoice | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "targets", tuple(self.targets))
        object.__setattr__(self, "marks", tuple(self.marks))
        if self.time_utc is not None:
            require(self.time_utc.tzinfo is not None, "time_utc", "must carry a time zone (UTC)", self.time_utc)
