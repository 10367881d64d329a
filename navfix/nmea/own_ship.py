"""Sentences about own ship: heading, speed, turn, GNSS position and UTC.

Blank fields and sentences that call themselves not valid give no record, except a GNSS position (``valid`` False) and a
heading (THS, OSD: ``valid`` False), where the reader of the log may want to know that the sensor spoke.
"""

from __future__ import annotations

from typing import Literal

from navfix.nmea.fields import Fields
from navfix.nmea.framing import Frame, Unreadable
from navfix.nmea.records import OwnHeading, OwnPosition, OwnSpeed, OwnTurnRate, Record, UtcTime
from navfix.units import KMH_MPS, KNOT_MPS, MPH_MPS, wrap_360

_SPEED_UNITS = {"N": KNOT_MPS, "": KNOT_MPS, "K": KMH_MPS, "S": MPH_MPS}


def _angle_deg(fields: Fields, index: int, name: str) -> float | None:
    value = fields.number(index)
    if value is None:
        return None
    if not -360.0 <= value <= 360.0:
        raise Unreadable("field", f"{name} {fields.text(index)!r}, expected 0 .. 360 degrees")
    return wrap_360(value)


# --------------------------------------------------------------------------------------------------- heading


def hdt(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read HDT: field 1 true heading."""
    heading_deg = _angle_deg(fields, 1, "heading")
    return () if heading_deg is None else (OwnHeading(time_s, heading_deg, "true", "HDT", source=frame.source),)


def ths(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read THS: field 1 true heading, 2 mode; valid in A (autonomous) and E (estimated), not in M, S, V."""
    heading_deg = _angle_deg(fields, 1, "heading")
    if heading_deg is None:
        return ()
    return (OwnHeading(time_s, heading_deg, "true", "THS", valid=fields.flag(2, "AE"), source=frame.source),)


def hdg(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read HDG: field 1 magnetic sensor heading, 2-3 deviation, 4-5 variation, east positive."""
    heading_deg = _angle_deg(fields, 1, "heading")
    if heading_deg is None:
        return ()
    variation_deg, deviation_deg = fields.signed(4, "W"), fields.signed(2, "W")
    return (OwnHeading(time_s, heading_deg, "magnetic", "HDG", variation_deg, deviation_deg, source=frame.source),)


def hdm(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read HDM: field 1 magnetic heading."""
    heading_deg = _angle_deg(fields, 1, "heading")
    return () if heading_deg is None else (OwnHeading(time_s, heading_deg, "magnetic", "HDM", source=frame.source),)


def vhw(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read VHW: field 1 true heading, 3 magnetic heading, 5 knots and 7 km/h through the water."""
    records: list[Record] = []
    true_deg, magnetic_deg = _angle_deg(fields, 1, "heading"), _angle_deg(fields, 3, "heading")
    if true_deg is not None:
        records.append(OwnHeading(time_s, true_deg, "true", "VHW", source=frame.source))
    elif magnetic_deg is not None:
        records.append(OwnHeading(time_s, magnetic_deg, "magnetic", "VHW", source=frame.source))
    speed_mps = _first(fields.scaled(5, KNOT_MPS), fields.scaled(7, KMH_MPS))
    if speed_mps is not None:
        records.append(OwnSpeed(time_s, "water", "VHW", speed_mps=speed_mps, source=frame.source))
    return tuple(records)


def osd(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read OSD: field 1 true heading, 2 status, 3-4 course and its reference, 5-6 speed and its reference, 9 unit.

    References: B bottom tracking log, W water, R radar tracking of a fixed target, P positioning system (own GNSS),
    M manual input, which is no measurement and gives no speed.
    """
    records: list[Record] = []
    heading_deg = _angle_deg(fields, 1, "heading")
    if heading_deg is not None:
        records.append(OwnHeading(time_s, heading_deg, "true", "OSD", valid=fields.flag(2, "A"), source=frame.source))
    letter, unit = fields.text(6), _SPEED_UNITS.get(fields.text(9))
    speed_mps = fields.scaled(5, unit) if unit is not None else None
    if speed_mps is not None and letter in ("B", "W", "R", "P"):
        reference: Literal["water", "ground"] = "water" if letter == "W" else "ground"
        course_deg = _angle_deg(fields, 3, "course") if fields.text(4) == letter else None
        from_gnss = letter == "P"
        records.append(
            OwnSpeed(time_s, reference, "OSD", speed_mps, course_deg, source=frame.source, from_gnss=from_gnss)
        )
    return tuple(records)


def rot(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read ROT: field 1 deg/min, positive to starboard, 2 status A valid."""
    rate = fields.number(1)
    if rate is None or not fields.flag(2, "A"):
        return ()
    return (OwnTurnRate(time_s, rate, frame.source),)


# ----------------------------------------------------------------------------------------------------- speed


def vbw(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read VBW: fields 1-3 forward, starboard [kn] and status through the water, 4-6 the same over ground."""
    records: list[Record] = []
    references: tuple[tuple[int, Literal["water", "ground"]], ...] = ((1, "water"), (4, "ground"))
    for first, reference in references:
        forward_mps = fields.scaled(first, KNOT_MPS)
        if forward_mps is None or not fields.flag(first + 2, "A"):
            continue
        starboard_mps = fields.scaled(first + 1, KNOT_MPS)
        records.append(
            OwnSpeed(
                time_s,
                reference,
                "VBW",
                forward_mps=forward_mps,
                starboard_mps=starboard_mps,
                source=frame.source,
            )
        )
    return tuple(records)


def vtg(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read VTG (of own GNSS): field 1 true course, 5 knots and 7 km/h over ground, 9 mode (N: not valid)."""
    speed_mps = _first(fields.scaled(5, KNOT_MPS), fields.scaled(7, KMH_MPS))
    if speed_mps is None or fields.flag(9, "N"):
        return ()
    course_deg = _angle_deg(fields, 1, "course")
    return (OwnSpeed(time_s, "ground", "VTG", speed_mps, course_deg, source=frame.source, from_gnss=True),)


def _first(*values: float | None) -> float | None:
    return next((value for value in values if value is not None), None)


# ---------------------------------------------------------------------------------------- GNSS position, UTC


def rmc(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read RMC: field 1 UTC, 2 status, 3-6 position, 7 knots, 8 course, 9 date, 12 mode."""
    records: list[Record] = []
    utc_s = utc_of_rmc(fields)
    if utc_s is not None:
        records.append(UtcTime(time_s, utc_s, "RMC", frame.source))
    place = fields.position_deg(3)
    if place is not None:
        records.append(
            OwnPosition(
                time_s,
                *place,
                "RMC",
                valid=fields.flag(2, "A"),
                quality=fields.text(12) or None,
                speed_mps=fields.scaled(7, KNOT_MPS),
                course_deg=_angle_deg(fields, 8, "course"),
                utc_of_day_s=fields.utc_of_day_s(1),
                talker=frame.talker,
                source=frame.source,
            )
        )
    return tuple(records)


def gga(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read GGA: field 1 UTC, 2-5 position, 6 quality (0: no fix), 8 HDOP."""
    place = fields.position_deg(2)
    if place is None:
        return ()
    quality = fields.text(6)
    return (
        OwnPosition(
            time_s,
            *place,
            "GGA",
            valid=quality not in ("", "0"),
            quality=quality or None,
            hdop=fields.number(8),
            utc_of_day_s=fields.utc_of_day_s(1),
            talker=frame.talker,
            source=frame.source,
        ),
    )


def gll(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read GLL: fields 1-4 position, 5 UTC, 6 status, 7 mode; forms older than version 2 end after the position."""
    place = fields.position_deg(1)
    if place is None:
        return ()
    return (
        OwnPosition(
            time_s,
            *place,
            "GLL",
            valid=fields.text(6) in ("A", ""),
            quality=fields.text(7) or None,
            utc_of_day_s=fields.utc_of_day_s(5),
            talker=frame.talker,
            source=frame.source,
        ),
    )


def gns(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read GNS: field 1 UTC, 2-5 position, 6 one mode letter per satellite system (all N: no fix), 8 HDOP."""
    place = fields.position_deg(2)
    if place is None:
        return ()
    modes = fields.text(6)
    return (
        OwnPosition(
            time_s,
            *place,
            "GNS",
            valid=bool(modes.strip("N")),
            quality=modes or None,
            hdop=fields.number(8),
            utc_of_day_s=fields.utc_of_day_s(1),
            talker=frame.talker,
            source=frame.source,
        ),
    )


def zda(frame: Frame, fields: Fields, time_s: float | None) -> tuple[Record, ...]:
    """Read ZDA: field 1 UTC, 2 day, 3 month, 4 year."""
    utc_s = utc_of_zda(fields)
    return () if utc_s is None else (UtcTime(time_s, utc_s, "ZDA", frame.source),)


def utc_of_rmc(fields: Fields) -> float | None:
    """Return the POSIX seconds of RMC, None where UTC or date are blank."""
    date = fields.text(9)
    return _utc_s(fields, date[:2], date[2:4], date[4:]) if date else None


def utc_of_zda(fields: Fields) -> float | None:
    """Return the POSIX seconds of ZDA, None where UTC or date are blank."""
    return _utc_s(fields, fields.text(2), fields.text(3), fields.text(4)) if fields.text(4) else None


def _utc_s(fields: Fields, day: str, month: str, year: str) -> float | None:
    utc_of_day_s = fields.utc_of_day_s(1)
    if utc_of_day_s is None:
        return None
    midnight_s = fields.midnight_s(day, month, year)
    return None if midnight_s is None else midnight_s + utc_of_day_s
