"""Which AIS stations may serve as marks: what must never be matched with an echo, and why."""

from __future__ import annotations

from navfix.nmea.records import AisPosition

REFERENCE_POINT_TYPES = (0, 1)  # type of aid: not specified, reference point


def why_never_a_mark(report: AisPosition, own_mmsi: frozenset[int]) -> str | None:
    """Return the reason why a station can never be a mark, None when it may be one.

    Virtual aids are told by the flag or by the MMSI (99xxx6xxx): real data have each sign without the other, and one
    converter drops the flag, so an aid of unspecified type without a charted mark is left out too.
    """
    if report.own or report.mmsi in own_mmsi:
        return "own ship"
    if report.kind == "base_station":
        return "base station"
    if report.kind == "aircraft":
        return "aircraft"
    if report.kind == "long_range":
        return "long-range report"
    if report.lat_deg is None or report.lon_deg is None:
        return "position not available"
    if report.kind == "aton":
        return _why_not_this_aid(report)
    if 970_000_000 <= report.mmsi <= 979_999_999:
        return "distress beacon"
    return None


def _why_not_this_aid(report: AisPosition) -> str | None:
    digits = f"{report.mmsi:09d}"
    if report.virtual or (digits.startswith("99") and digits[5] == "6"):
        return "virtual aid to navigation"
    if report.off_position:
        return "aid off position"
    if report.aid_type in REFERENCE_POINT_TYPES or report.aid_type is None:
        return "aid of unspecified type"
    return None
