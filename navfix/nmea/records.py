"""What a sentence says, in SI units and degrees: one frozen record per kind of sentence.

``time_s`` is the time of reception in POSIX seconds (TAG block, else the log's time stamp, else sentence time), None
where the log tells none. Anything that a sentence leaves blank or marks as not available is None.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from navfix.types import BearingReference, Hull


@dataclass(frozen=True, slots=True)
class TargetReport:
    """TTM: one tracked target. ``number`` is reused by the radar. ``status`` L lost, Q query, T tracking, None blank.

    ``speed_mps`` and ``course_deg`` as printed; ``course_reference`` says against what ("relative": the course and
    speed are relative to own ship). ``range_resolution_m`` is one unit of the last printed digit.
    ``utc_of_day_s``: the sentence's own UTC field.
    """

    time_s: float | None
    number: int
    range_m: float
    bearing_deg: float
    bearing_reference: BearingReference
    speed_mps: float | None = None
    course_deg: float | None = None
    course_reference: BearingReference | None = None
    status: str | None = None
    name: str | None = None
    utc_of_day_s: float | None = None
    range_resolution_m: float = 0.0
    bearing_resolution_deg: float = 0.0
    talker: str = "RA"
    source: str | None = None


AisKind = Literal["ship", "aton", "base_station", "aircraft", "long_range"]


@dataclass(frozen=True, slots=True)
class AisPosition:
    """A position report of AIS (types 1-3, 4, 9, 18, 19, 21, 27).

    ``own`` marks own ship's (VDO). ``accurate`` is the position accuracy flag: True better than 10 m.
    ``utc_second`` is the second of the minute of the position, None when it is not a time (60 .. 63).
    ``virtual`` is the flag of type 21, ``aid_type`` its type of aid (0: not specified, 1: reference point),
    ``off_position`` its flag where the time stamp makes it valid.
    """

    time_s: float | None
    mmsi: int
    message_type: int
    kind: AisKind
    lat_deg: float | None
    lon_deg: float | None
    accurate: bool = False
    speed_mps: float | None = None
    course_deg: float | None = None
    heading_deg: float | None = None
    turn_rate_deg_per_min: float | None = None
    utc_second: int | None = None
    navigation_status: int | None = None
    ais_class: Literal["A", "B"] | None = None
    own: bool = False
    virtual: bool = False
    aid_type: int | None = None
    off_position: bool = False
    hull: Hull | None = None
    name: str | None = None
    ship_type: int | None = None
    source: str | None = None


@dataclass(frozen=True, slots=True)
class AisStatic:
    """Static data of a ship (types 5, 19, 24): hull None when the four dimensions are all zero."""

    time_s: float | None
    mmsi: int
    message_type: int
    hull: Hull | None = None
    ship_type: int | None = None
    name: str | None = None
    own: bool = False
    source: str | None = None


@dataclass(frozen=True, slots=True)
class OwnHeading:
    """HDT, THS, HDG, HDM, OSD, VHW or RSD's own heading. A magnetic one carries the variation where it is known."""

    time_s: float | None
    heading_deg: float
    reference: Literal["true", "magnetic"]
    sentence: str
    variation_deg: float | None = None
    deviation_deg: float | None = None
    valid: bool = True
    source: str | None = None


@dataclass(frozen=True, slots=True)
class OwnSpeed:
    """VHW, VBW, VTG, OSD: speed through the water or over ground, along the bow and across where given, or by course.

    ``from_gnss``: the sentence says, or VTG implies, that own GNSS measured it: never evidence for a fix.
    """

    time_s: float | None
    reference: Literal["water", "ground"]
    sentence: str
    speed_mps: float | None = None
    course_deg: float | None = None
    forward_mps: float | None = None
    starboard_mps: float | None = None
    source: str | None = None
    from_gnss: bool = False


@dataclass(frozen=True, slots=True)
class OwnTurnRate:
    """ROT: rate of turn, positive to starboard."""

    time_s: float | None
    turn_rate_deg_per_min: float
    source: str | None = None


@dataclass(frozen=True, slots=True)
class OwnPosition:
    """Own GNSS (GGA, GLL, RMC, GNS; VDO comes as AisPosition): only ever compared with a fix, never evidence for it."""

    time_s: float | None
    lat_deg: float
    lon_deg: float
    sentence: str
    valid: bool = True
    quality: str | None = None
    hdop: float | None = None
    speed_mps: float | None = None
    course_deg: float | None = None
    utc_of_day_s: float | None = None
    talker: str = "GP"
    source: str | None = None


@dataclass(frozen=True, slots=True)
class UtcTime:
    """ZDA (and the date of RMC): the full UTC in POSIX seconds."""

    time_s: float | None
    utc_s: float
    sentence: str
    source: str | None = None


@dataclass(frozen=True, slots=True)
class RadarSettings:
    """RSD: range scale in use [m] and display rotation ("C", "H", "N")."""

    time_s: float | None
    range_scale_m: float | None = None
    rotation: str | None = None
    source: str | None = None


@dataclass(frozen=True, slots=True)
class OtherMessage:
    """A sentence or AIS message that reads well and that navfix has no use for: counted, not decoded."""

    time_s: float | None
    formatter: str
    source: str | None = None


Record = (
    TargetReport
    | AisPosition
    | AisStatic
    | OwnHeading
    | OwnSpeed
    | OwnTurnRate
    | OwnPosition
    | UtcTime
    | RadarSettings
    | OtherMessage
)
