"""Radar sentences: TTM (tracked target) and RSD (radar system data).

TLL tells a target's latitude and longitude, which the radar computes with the own GNSS: no evidence, never read.
"""

from __future__ import annotations

from typing import TypeVar

from navfix.nmea.fields import Fields
from navfix.nmea.framing import Frame, Unreadable
from navfix.nmea.records import RadarSettings, TargetReport
from navfix.types import BearingReference
from navfix.units import KMH_MPS, KNOT_MPS, MPH_MPS, NM_M, STATUTE_MILE_M, wrap_360

# unit letter -> metres, metres per second; a blank unit is read as the usual one
_UNITS = {
    "N": (NM_M, KNOT_MPS),
    "": (NM_M, KNOT_MPS),
    "K": (1000.0, KMH_MPS),
    "S": (STATUTE_MILE_M, MPH_MPS),
}
_REFERENCES: dict[str, BearingReference] = {"T": "true", "": "true", "R": "relative"}
_STATUS = {"L": "L", "Q": "Q", "T": "T"}

T = TypeVar("T")


def target(frame: Frame, fields: Fields, time_s: float | None) -> tuple[TargetReport, ...]:
    """Read TTM; nothing where range or bearing are blank or the range is zero (a target without echo).

    Fields: 1 number, 2 range, 3 bearing, 4 T/R or blank = true, 5 speed, 6 course, 7 T/R, 8 CPA, 9 TCPA, 10 unit of
    range and speed (K km, N nautical miles, S statute miles), 11 name, 12 status, 13 reference target, 14 UTC, 15 how
    acquired.

    Raises
    ------
    Unreadable : number, range, bearing, reference or unit cannot be right, or the sentence ends before the unit
    """
    unit_m, unit_mps = _letter(fields, 10, _UNITS, "unit")
    reference = _letter(fields, 4, _REFERENCES, "bearing reference")
    number = fields.required(1, "target number")
    distance = fields.required(2, "range")
    bearing_deg = fields.required(3, "bearing")
    if distance is None or bearing_deg is None or distance == 0.0:
        return ()
    if number is None or number < 0 or number != int(number):
        raise Unreadable("field", f"target number {fields.text(1)[:24]!r}, expected a whole number")
    if distance < 0.0 or not -360.0 <= bearing_deg <= 360.0:
        raise Unreadable("field", f"range {fields.text(2)!r}, bearing {fields.text(3)!r}: expected > 0 and 0 .. 360")
    course_deg = fields.number(6)
    return (
        TargetReport(
            time_s=time_s,
            number=int(number),
            range_m=distance * unit_m,
            bearing_deg=wrap_360(bearing_deg),
            bearing_reference=reference,
            speed_mps=fields.scaled(5, unit_mps),
            course_deg=course_deg,
            course_reference=_REFERENCES.get(fields.text(7)),
            status=_STATUS.get(fields.text(12)),
            name=_name(fields.text(11)),
            utc_of_day_s=fields.utc_of_day_s(14),
            range_resolution_m=_resolution(fields.text(2)) * unit_m,
            bearing_resolution_deg=_resolution(fields.text(3)),
            talker=frame.talker,
            source=frame.source,
        ),
    )


def settings(frame: Frame, fields: Fields, time_s: float | None) -> tuple[RadarSettings, ...]:
    """Read RSD: field 11 range scale, 12 its unit, 13 display rotation (C course up, H head up, N north up)."""
    unit_m, _ = _letter(fields, 12, _UNITS, "unit")
    return (RadarSettings(time_s, fields.scaled(11, unit_m), fields.text(13) or None, frame.source),)


def _letter(fields: Fields, index: int, table: dict[str, T], name: str) -> T:
    if index >= len(fields.values):
        raise Unreadable("too_short", f"the sentence ends before field {index} ({name})")
    letter = fields.text(index)
    if letter not in table:
        raise Unreadable("field", f"{name} {letter[:24]!r}, expected {', '.join(key for key in table if key)} or blank")
    return table[letter]


def _resolution(text: str) -> float:
    """Return one unit of the last printed digit: 0.01 for ``1.07``."""
    _, _, decimals = text.partition(".")
    return float(10.0 ** -len(decimals))


def _name(text: str) -> str | None:
    return text.encode("latin-1").decode("utf-8", "replace") if text else None
