"""AIS sentences out: the records that the reader returns, encoded by pyais as AIVDM (AIVDO for own ship).

Bit layouts and the values for "not available" are those of ITU-R M.1371-5, annex 8. Names that six-bit ASCII does not
have become ``?``; dimensions are rounded to metres and cut to what their fields hold.
"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any, Literal

from pyais.encode import encode_dict

from navfix.errors import InputError
from navfix.nmea.records import AisPosition, AisStatic
from navfix.types import Hull
from navfix.units import KNOT_MPS

Channel = Literal["A", "B"]
_NO_LATITUDE, _NO_LONGITUDE, _NO_HEADING, _NO_SECOND, _NO_TURN = 91.0, 181.0, 511, 60, -128.0


def position_report(report: AisPosition, *, channel: Channel = "A") -> list[str]:
    """Return the sentence (two for type 21 with a long name) of a position report.

    Types 1, 2, 3 (class A), 4 (base station; ``time_s`` is its UTC), 9 (aircraft), 18, 19 (class B), 21 (aid to
    navigation) and 27 (long range). Blanks are sent as the type's "not available".

    Raises
    ------
    InputError : another message type, a base station without time
    """
    if report.message_type not in _FIELDS:
        raise InputError(f"message type {report.message_type} is not written; known are {', '.join(map(str, _FIELDS))}")
    place = {
        "lat": _NO_LATITUDE if report.lat_deg is None else report.lat_deg,
        "lon": _NO_LONGITUDE if report.lon_deg is None else report.lon_deg,
        "accuracy": report.accurate,
    }
    return _encode(
        report.message_type, report.mmsi, place | _FIELDS[report.message_type](report), report.own, channel, 0
    )


def static_report(report: AisStatic, *, channel: Channel = "A", sequence: int = 0) -> list[str]:
    """Return the sentences of static data: two parts of one type 5, or the messages A and B of type 24.

    ``sequence`` (0 .. 9) ties the parts of a type 5 together.

    Raises
    ------
    InputError : a message type other than 5 and 24 (type 19 is a position report with a hull)
    """
    name = {"shipname": _six_bit(report.name)}
    rest = {"ship_type": report.ship_type or 0, **_dimensions(report.hull)}
    if report.message_type == 5:
        return _encode(5, report.mmsi, name | rest, report.own, channel, sequence)
    if report.message_type == 24:
        part_a = _encode(24, report.mmsi, {"partno": 0, **name}, report.own, channel, 0)
        return part_a + _encode(24, report.mmsi, {"partno": 1, **rest}, report.own, channel, 0)
    raise InputError(f"static data are written as type 5 or 24, got {report.message_type}")


def _encode(
    message_type: int, mmsi: int, content: dict[str, Any], own: bool, channel: Channel, sequence: int
) -> list[str]:
    message = {"msg_type": message_type, "mmsi": mmsi, **content}
    return encode_dict(
        message, talker_id="AI", sentence_type="VDO" if own else "VDM", radio_channel=channel, seq_id=sequence
    )


# ------------------------------------------------------------------------------------------------- fields by type


def _class_a(report: AisPosition) -> dict[str, Any]:
    status = report.navigation_status
    return {"status": 15 if status is None else status, "turn": _turn(report.turn_rate_deg_per_min), **_motion(report)}


def _class_b(report: AisPosition) -> dict[str, Any]:
    return {"cs": True, **_motion(report)}  # a carrier-sense unit


def _class_b_extended(report: AisPosition) -> dict[str, Any]:
    return _motion(report) | {
        "shipname": _six_bit(report.name),
        "ship_type": report.ship_type or 0,
        **_dimensions(report.hull),
    }


def _base_station(report: AisPosition) -> dict[str, Any]:
    if report.time_s is None:
        raise InputError(f"base station {report.mmsi}: type 4 carries its UTC; give time_s")
    utc = datetime.fromtimestamp(int(report.time_s), UTC)
    return {name: getattr(utc, name) for name in ("year", "month", "day", "hour", "minute", "second")} | {"epfd": 7}


def _aircraft(report: AisPosition) -> dict[str, Any]:
    speed_kn = 1023 if report.speed_mps is None else min(round(report.speed_mps / KNOT_MPS), 1022)
    return {"alt": 4095, **_motion(report), "speed": speed_kn}


def _aid(report: AisPosition) -> dict[str, Any]:
    name = _six_bit(report.name)
    return {
        "aid_type": report.aid_type or 0,
        "name": name[:20],
        "name_ext": name[20:34],
        "second": _second(report),
        "off_position": report.off_position,
        "virtual_aid": report.virtual,
        "epfd": 7,
        **_dimensions(report.hull),
    }


def _long_range(report: AisPosition) -> dict[str, Any]:
    status = report.navigation_status
    return {
        "status": 15 if status is None else status,
        "speed": 63 if report.speed_mps is None else min(round(report.speed_mps / KNOT_MPS), 62),
        "course": 511 if report.course_deg is None else round(report.course_deg) % 360,
        "gnss": False,
    }


_FIELDS = {
    1: _class_a,
    2: _class_a,
    3: _class_a,
    4: _base_station,
    9: _aircraft,
    18: _class_b,
    19: _class_b_extended,
    21: _aid,
    27: _long_range,
}


def _motion(report: AisPosition) -> dict[str, Any]:
    return {
        "speed": 102.3 if report.speed_mps is None else min(round(report.speed_mps / KNOT_MPS, 1), 102.2),
        "course": 360.0 if report.course_deg is None else round(report.course_deg % 360.0, 1) % 360.0,
        "heading": _NO_HEADING if report.heading_deg is None else round(report.heading_deg) % 360,
        "second": _second(report),
    }


def _second(report: AisPosition) -> int:
    return _NO_SECOND if report.utc_second is None else report.utc_second


def _turn(rate_deg_per_min: float | None) -> float:
    """Return the rate for the encoder, which takes +-127 and 128 for its special values: 1 deg/min beside them."""
    if rate_deg_per_min is None:
        return _NO_TURN
    rate = max(-708.0, min(708.0, float(round(rate_deg_per_min))))
    return rate - 2.0 if rate in (127.0, 128.0) else rate + 2.0 if rate in (-127.0, -128.0) else rate


def _dimensions(hull: Hull | None) -> dict[str, int]:
    if hull is None:
        return {"to_bow": 0, "to_stern": 0, "to_port": 0, "to_starboard": 0}
    return {
        "to_bow": min(round(hull.bow_m), 511),
        "to_stern": min(round(hull.stern_m), 511),
        "to_port": min(round(hull.port_m), 63),
        "to_starboard": min(round(hull.starboard_m), 63),
    }


def _six_bit(name: str | None) -> str:
    return "".join(char if " " <= char <= "_" and char != "@" else "?" for char in (name or "").upper())
