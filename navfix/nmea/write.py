"""Sentences out: SI units and degrees in, NMEA 0183 (IEC 61162-1) text out. AIS is in `navfix.nmea.write_ais`.

Pure functions: no sentence ends with CR LF, a blank field is None. Every printed angle is wrapped after rounding
(359.96 with one decimal is 0.0) and every time, latitude and longitude is rounded before it is cut into fields
(59.99996 minutes become the next degree, never 60.0000).

TAG blocks and the field order follow IEC 61162-1 and NMEA 0183 version 4.10.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import Literal

from navfix.errors import InputError
from navfix.nmea.records import TargetReport
from navfix.types import Position
from navfix.units import KMH_MPS, KNOT_MPS, NM_M

_DAY_S = 86400.0


def checksum(body: str) -> str:
    """Return the checksum of what stands between ``$`` or ``!`` (or the backslashes of a TAG block) and ``*``."""
    value = 0
    for byte in body.encode("ascii"):
        value ^= byte
    return f"{value:02X}"


def sentence(*fields: str) -> str:
    """Return ``$field,field,...*hh``; the first field is talker and formatter."""
    body = ",".join(fields)
    return f"${body}*{checksum(body)}"


def tag_block(time_s: float, source: str) -> str:
    r"""Return the TAG block ``\s:SOURCE,c:TIME*hh\`` of a line received at ``time_s``, cut to whole POSIX seconds."""
    body = f"s:{source},c:{math.floor(time_s)}"
    return f"\\{body}*{checksum(body)}\\"


# ------------------------------------------------------------------------------------------------- fields


def number(value: float | None, decimals: int, *, width: int = 0) -> str:
    """Return a number with fixed decimals, blank for None; never ``-0.0``.

    Raises
    ------
    InputError : NaN or infinite
    """
    if value is None:
        return ""
    if not math.isfinite(value):
        raise InputError(f"a sentence holds finite numbers only, got {value!r}; leave the field blank with None")
    return f"{round(value, decimals) + 0.0:0{width}.{decimals}f}"


def angle(angle_deg: float | None, decimals: int, *, width: int = 0) -> str:
    """Return an angle in 0 <= angle < 360 **as printed**, blank for None."""
    return "" if angle_deg is None else number(round(angle_deg % 360.0, decimals) % 360.0, decimals, width=width)


def utc_of_day(time_s: float | None) -> str:
    """Return ``hhmmss.ss`` of POSIX seconds or of seconds of the day, blank for None."""
    if time_s is None:
        return ""
    hundredths = round(time_s * 100.0) % round(_DAY_S * 100.0)
    minutes, rest = divmod(hundredths, 6000)
    return f"{minutes // 60:02d}{minutes % 60:02d}{rest / 100.0:05.2f}"


def _date(time_s: float) -> datetime:
    """Return the UTC date that belongs to the rounded `utc_of_day`."""
    return datetime.fromtimestamp(round(time_s * 100.0) // 100, UTC)


def _degrees_minutes(value_deg: float, degree_digits: int, hemispheres: str, decimals: int) -> tuple[str, str]:
    units = 60 * 10**decimals
    total = round(abs(value_deg) * units)
    degrees, minutes = divmod(total, units)
    text = f"{degrees:0{degree_digits}d}{minutes / 10**decimals:0{decimals + 3}.{decimals}f}"
    return text, hemispheres[1 if value_deg < 0.0 and total else 0]


def _place(position: Position | None, decimals: int = 5) -> tuple[str, str, str, str]:
    """Return latitude, N/S, longitude, E/W; five decimals of a minute are 2 cm."""
    if position is None:
        return "", "", "", ""
    latitude = _degrees_minutes(position.lat_deg, 2, "NS", decimals)
    return *latitude, *_degrees_minutes(position.lon_deg, 3, "EW", decimals)


def _scaled(value: float | None, unit: float) -> float | None:
    return None if value is None else value / unit


def _decimals(resolution: float, default: int) -> int:
    """Return the number of decimals whose last digit is ``resolution``."""
    return max(0, round(-math.log10(resolution))) if resolution > 0.0 else default


# ------------------------------------------------------------------------------------------------- sentences


def ttm(
    report: TargetReport, *, cpa_m: float | None = None, tcpa_s: float | None = None, acquisition: str = "A"
) -> str:
    """Return TTM, tracked target message, in nautical miles and knots.

    The decimals of range and bearing follow from the report's resolutions; without them 0.01 NM and 0.1 deg.

    Raises
    ------
    InputError : a target number outside 0 .. 999
    """
    if not 0 <= report.number <= 999:
        raise InputError(f"TTM: target number must be 0 .. 999, got {report.number}")
    reference = {"relative": "R", "true": "T"}
    moving = report.speed_mps is not None or report.course_deg is not None
    return sentence(
        f"{report.talker}TTM",
        f"{report.number:02d}",
        number(report.range_m / NM_M, _decimals(report.range_resolution_m / NM_M, 2)),
        angle(report.bearing_deg, _decimals(report.bearing_resolution_deg, 1)),
        reference[report.bearing_reference],
        number(_scaled(report.speed_mps, KNOT_MPS), 1),
        angle(report.course_deg, 1),
        reference[report.course_reference or "true"] if moving else "",
        number(_scaled(cpa_m, NM_M), 2),
        number(_scaled(tcpa_s, 60.0), 1),
        "N",
        report.name or "",
        report.status or "",
        "",
        utc_of_day(report.utc_of_day_s),
        acquisition,
    )


def hdt(heading_deg: float | None, *, talker: str = "HE") -> str:
    """Return HDT, true heading."""
    return sentence(f"{talker}HDT", angle(heading_deg, 1), "T")


def ths(heading_deg: float | None, *, mode: Literal["A", "E", "M", "S", "V"] = "A", talker: str = "HE") -> str:
    """Return THS, true heading and mode (A autonomous, E estimated, M manual, S simulator, V not valid)."""
    return sentence(f"{talker}THS", angle(heading_deg, 1), mode)


def vhw(
    *, heading_deg: float | None, speed_mps: float | None, magnetic_deg: float | None = None, talker: str = "VW"
) -> str:
    """Return VHW, heading and speed through the water."""
    return sentence(
        f"{talker}VHW",
        angle(heading_deg, 1),
        "T",
        angle(magnetic_deg, 1),
        "M",
        number(_scaled(speed_mps, KNOT_MPS), 2),
        "N",
        number(_scaled(speed_mps, KMH_MPS), 2),
        "K",
    )


def rmc(
    time_s: float,
    position: Position | None,
    *,
    speed_mps: float | None = None,
    course_deg: float | None = None,
    valid: bool = True,
    mode: str = "A",
    navigation_status: str | None = None,
    talker: str = "GP",
) -> str:
    """Return RMC. ``mode`` A autonomous, D differential, E estimated, S simulator, N none.

    ``navigation_status`` is field 13 of NMEA 4.10: S safe, C caution, U unsafe, V not valid; left out for None.
    """
    fields = (
        utc_of_day(time_s),
        "A" if valid and position is not None else "V",
        *_place(position),
        number(_scaled(speed_mps, KNOT_MPS), 2),
        angle(course_deg, 2),
        f"{_date(time_s):%d%m%y}",
        "",
        "",
        mode,
    )
    return sentence(f"{talker}RMC", *fields, *([] if navigation_status is None else [navigation_status]))


def gga(
    time_s: float,
    position: Position | None,
    *,
    quality: int = 1,
    satellites: int | None = 9,
    hdop: float | None = 0.9,
    altitude_m: float | None = None,
    geoid_m: float | None = None,
    talker: str = "GP",
) -> str:
    """Return GGA. ``quality`` 0 no fix, 1 GNSS, 2 differential, 6 estimated."""
    return sentence(
        f"{talker}GGA",
        utc_of_day(time_s),
        *_place(position),
        str(quality),
        "" if satellites is None else f"{satellites:02d}",
        number(hdop, 1),
        number(altitude_m, 1),
        "M",
        number(geoid_m, 1),
        "M",
        "",
        "",
    )


def zda(time_s: float, *, talker: str = "GP") -> str:
    """Return ZDA, time and date in UTC."""
    date = _date(time_s)
    return sentence(f"{talker}ZDA", utc_of_day(time_s), f"{date:%d}", f"{date:%m}", f"{date:%Y}", "00", "00")


def gst(
    time_s: float,
    *,
    semi_major_m: float | None,
    semi_minor_m: float | None,
    orientation_deg: float | None,
    sigma_north_m: float | None,
    sigma_east_m: float | None,
    sigma_up_m: float | None = None,
    rms: float | None = None,
    talker: str = "GP",
) -> str:
    """Return GST, position error statistics: the ellipse at 1 sigma [m], its major axis counted from true north."""
    return sentence(
        f"{talker}GST",
        utc_of_day(time_s),
        number(rms, 2),
        number(semi_major_m, 2),
        number(semi_minor_m, 2),
        angle(orientation_deg, 1),
        number(sigma_north_m, 2),
        number(sigma_east_m, 2),
        number(sigma_up_m, 2),
    )
