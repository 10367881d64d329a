"""AIS messages to records, decoded by pyais; message types that are of no use here are not decoded at all.

Not available becomes None: latitude 91, longitude 181, speed 102.3 kn, course 360, heading 511, turn -128, all four
dimensions zero (Recommendation ITU-R M.1371-5, annex 8).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from navfix.nmea.ais_parts import Payload
from navfix.nmea.framing import Unreadable
from navfix.nmea.records import AisKind, AisPosition, AisStatic, OtherMessage, Record
from navfix.types import Hull
from navfix.units import KNOT_MPS

# message type -> bits up to the end of the last field that is used (24: part A is checked on its own)
_BITS = {1: 143, 2: 143, 3: 143, 4: 134, 5: 270, 9: 134, 18: 139, 19: 301, 21: 270, 24: 46, 27: 94}
_PART_B_BITS = 162
_UNAVAILABLE_TURN = 127.0
_SAR_AIRCRAFT = range(111_000_000, 112_000_000)
_AUXILIARY_CRAFT = range(980_000_000, 990_000_000)


def records_of(payload: Payload) -> tuple[Record, ...]:
    """Read one whole message; an `OtherMessage` for types that are not used.

    Raises
    ------
    navfix.nmea.framing.Unreadable : "ais_short" (fewer bits than its type has), "ais_payload" (cannot be decoded)
    """
    kind = payload.message_type
    needed = _BITS.get(kind)
    if needed is None:
        return (OtherMessage(payload.time_s, "VDO" if payload.own else "VDM", payload.source),)
    if payload.bits < needed:
        raise Unreadable("ais_short", f"message type {kind} with {payload.bits} bits, expected at least {needed}")
    return _READERS[kind](_decode(payload), payload)


def _decode(payload: Payload) -> Any:
    classes, bit_vector, errors = _pyais()
    try:
        return classes[payload.message_type].from_vector(bit_vector(payload.text.encode("ascii"), payload.fill_bits))
    except errors as error:
        raise Unreadable("ais_payload", f"message type {payload.message_type}: {error}") from error


@cache
def _pyais() -> tuple[Any, Any, tuple[type[Exception], ...]]:
    """Import pyais at the first message: its import costs more than the reading of a short log."""
    from pyais.bit_vector import bit_vector
    from pyais.exceptions import AISBaseException
    from pyais.messages import MSG_CLASS

    return (
        MSG_CLASS,
        bit_vector,
        (AISBaseException, ValueError, LookupError, TypeError, AttributeError, ArithmeticError),
    )


# ----------------------------------------------------------------------------------- values that may be missing


def _place(message: Any) -> tuple[float | None, float | None]:
    lat_deg, lon_deg = float(message.lat), float(message.lon)
    if abs(lat_deg) > 90.0 or abs(lon_deg) > 180.0:
        return None, None
    return lat_deg, lon_deg


def _speed_mps(knots: float, missing: float = 102.3) -> float | None:
    return None if knots >= missing - 0.05 else float(knots) * KNOT_MPS


def _course_deg(course: float) -> float | None:
    return float(course) if course < 360.0 else None


def _heading_deg(heading: int) -> float | None:
    return float(heading) if heading < 360 else None


def _turn_rate(turn: float) -> float | None:
    """Return deg/min; None for -128 and for +-127, which tells only that she turns faster than 10 deg/min."""
    return None if abs(turn) in (_UNAVAILABLE_TURN, 128.0) else float(turn)


def _second(second: int) -> int | None:
    return int(second) if second <= 59 else None


def _text(text: str | None) -> str | None:
    """Return what stands before the first ``@``, the filler of the six-bit code."""
    return (text or "").partition("@")[0].strip() or None


def _hull(message: Any) -> Hull | None:
    """Return the dimensions; A = C = 0 with B and D given tells the size, not where the antenna is: amidships then."""
    bow, stern, port, starboard = (
        float(value) for value in (message.to_bow, message.to_stern, message.to_port, message.to_starboard)
    )
    if bow == stern == port == starboard == 0.0:
        return None
    if bow == port == 0.0 and stern > 0.0 and starboard > 0.0:
        return Hull(stern / 2.0, stern / 2.0, starboard / 2.0, starboard / 2.0)
    return Hull(bow, stern, port, starboard)


def _ship_type(code: int) -> int | None:
    return int(code) or None


def _ship_kind(mmsi: int) -> AisKind:
    return "aircraft" if mmsi in _SAR_AIRCRAFT else "ship"


# --------------------------------------------------------------------------------------------------- message types


def _position(message: Any, payload: Payload, kind: AisKind, **more: Any) -> AisPosition:
    """Make the record from what every position report has, and from ``more`` fields of it."""
    lat_deg, lon_deg = _place(message)
    return AisPosition(
        time_s=payload.time_s,
        mmsi=int(message.mmsi),
        message_type=payload.message_type,
        kind=kind,
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        accurate=bool(message.accuracy),
        own=payload.own,
        source=payload.source,
        **more,
    )


def _static(message: Any, payload: Payload, **more: Any) -> AisStatic:
    mmsi = int(message.mmsi)
    return AisStatic(payload.time_s, mmsi, payload.message_type, own=payload.own, source=payload.source, **more)


def _under_way(message: Any, payload: Payload, **more: Any) -> AisPosition:
    """Read what the position reports of class A and class B have in common."""
    return _position(
        message,
        payload,
        _ship_kind(message.mmsi),
        speed_mps=_speed_mps(message.speed),
        course_deg=_course_deg(message.course),
        heading_deg=_heading_deg(message.heading),
        utc_second=_second(message.second),
        **more,
    )


def _class_a(message: Any, payload: Payload) -> tuple[Record, ...]:
    turn_rate, status = _turn_rate(message.turn), int(message.status)
    return (_under_way(message, payload, turn_rate_deg_per_min=turn_rate, navigation_status=status, ais_class="A"),)


def _base_station(message: Any, payload: Payload) -> tuple[Record, ...]:
    return (_position(message, payload, "base_station"),)


def _static_a(message: Any, payload: Payload) -> tuple[Record, ...]:
    ship_type, name = _ship_type(message.ship_type), _text(message.shipname)
    return (_static(message, payload, hull=_hull(message), ship_type=ship_type, name=name),)


def _aircraft(message: Any, payload: Payload) -> tuple[Record, ...]:
    report = _position(
        message,
        payload,
        "aircraft",
        speed_mps=_speed_mps(message.speed, missing=1023.0),
        course_deg=_course_deg(message.course),
        utc_second=_second(message.second),
    )
    return (report,)


def _class_b(message: Any, payload: Payload, **static: Any) -> tuple[Record, ...]:
    return (_under_way(message, payload, ais_class="B", **static),)


def _class_b_extended(message: Any, payload: Payload) -> tuple[Record, ...]:
    ship = {"hull": _hull(message), "ship_type": _ship_type(message.ship_type), "name": _text(message.shipname)}
    return (*_class_b(message, payload, **ship), _static(message, payload, **ship))


def _aid(message: Any, payload: Payload) -> tuple[Record, ...]:
    """Read type 21: "off position" is valid only with a second that is a time; the name goes on in its extension."""
    second = _second(message.second)
    name = f"{message.name:20}{message.name_ext}" if message.name_ext else message.name
    report = _position(
        message,
        payload,
        "aton",
        utc_second=second,
        virtual=bool(message.virtual_aid),
        aid_type=int(message.aid_type),
        off_position=bool(message.off_position) and second is not None,
        hull=_hull(message),
        name=_text(name),
    )
    return (report,)


def _static_b(message: Any, payload: Payload) -> tuple[Record, ...]:
    """Read type 24: A the name, B ship type and dimensions (of an auxiliary craft its mother ship's MMSI instead)."""
    if message.partno == 0:
        return (_static(message, payload, name=_text(message.shipname)),)
    if payload.bits < _PART_B_BITS:
        raise Unreadable("ais_short", f"message type 24 B with {payload.bits} bits, expected at least {_PART_B_BITS}")
    hull = None if message.mmsi in _AUXILIARY_CRAFT else _hull(message)
    return (_static(message, payload, hull=hull, ship_type=_ship_type(message.ship_type)),)


def _long_range(message: Any, payload: Payload) -> tuple[Record, ...]:
    report = _position(
        message,
        payload,
        "long_range",
        speed_mps=_speed_mps(message.speed, missing=63.0),
        course_deg=_course_deg(message.course),
        navigation_status=int(message.status),
        ais_class="A",
    )
    return (report,)


_READERS: dict[int, Callable[[Any, Payload], tuple[Record, ...]]] = {
    1: _class_a,
    2: _class_a,
    3: _class_a,
    4: _base_station,
    5: _static_a,
    9: _aircraft,
    18: _class_b,
    19: _class_b_extended,
    21: _aid,
    24: _static_b,
    27: _long_range,
}
