"""The fix as sentences: ``$INRMC`` (mode E) + ``$INHDT`` + ``$INGST``, which gpsd, Signal K and OpenCPN all read.

GGA is left out on purpose: with quality 6 and no satellites some readers drop the position. Nothing in these sentences
comes from own GNSS: speed and course over ground stay blank, they are not part of a fix of one epoch.
"""

from __future__ import annotations

import math
from datetime import datetime

from navfix.errors import InputError
from navfix.nmea import write
from navfix.report.answer import Answer
from navfix.types import Ellipse, Fix, Position

TALKER = "IN"  # integrated navigation; some readers pass over other talkers
_SAFE_PROBABILITY_WRONG = 4e-4  # just above the least that the association states
_ONE_SIGMA = -math.expm1(-0.5)  # the probability that an ellipse of radius 1 holds in two dimensions
_RMC_TIME, _RMC_DATE, _GST_TIME = 1, 9, 1


def nmea_text(answer: Answer) -> str:
    """Return the sentences of an answer, each ending in CR LF; for no fix an RMC that says "not valid".

    Where the time is unknown its fields are blank.

    Raises
    ------
    InputError : the fix lies in a plane frame: sentences carry latitude and longitude
    """
    return "".join(f"{line}\r\n" for line in sentences(answer))


def sentences(answer: Answer) -> list[str]:
    """Return RMC, HDT and GST of a fix, RMC alone without one.

    Raises
    ------
    InputError : the fix lies in a plane frame
    """
    time = answer.time_utc
    if answer.fix is None:
        return [_rmc(time, None, valid=False, mode="N", status="V")]
    fix = answer.fix
    if not isinstance(fix.position, Position):
        raise InputError("NMEA sentences carry latitude and longitude, the fix lies in a plane frame: write .json")
    lines = [_rmc(time, fix.position, valid=True, mode="E", status=navigation_status(fix))]
    if fix.heading_deg is not None:
        lines.append(write.hdt(fix.heading_deg, talker=TALKER))
    lines.append(_gst(time, fix))
    return lines


def navigation_status(fix: Fix) -> str:
    """Return field 13 of RMC: "S" safe or "C" caution; no fix is "V", not valid.

    Safe asks for everything at once: a protection level, a passed global test, no other place that explains the data,
    and less than 1 in 100 000 that the fix is another place.
    """
    found = fix.association
    safe = (
        fix.integrity is not None
        and fix.integrity.protection_level_m is not None
        and fix.global_test is not None
        and fix.global_test.passed
        and not fix.alternatives
        and found is not None
        and not found.alternatives
        and found.second_group is None
        and found.probability_wrong is not None
        and found.probability_wrong < _SAFE_PROBABILITY_WRONG
    )
    return "S" if safe else "C"


def _rmc(time: datetime | None, position: Position | None, *, valid: bool, mode: str, status: str) -> str:
    line = write.rmc(_seconds(time), position, valid=valid, mode=mode, navigation_status=status, talker=TALKER)
    return line if time is not None else _blanked(line, _RMC_TIME, _RMC_DATE)


def _gst(time: datetime | None, fix: Fix) -> str:
    ellipse = Ellipse.from_covariance(fix.covariance[:2, :2], _ONE_SIGMA)
    line = write.gst(
        _seconds(time),
        semi_major_m=ellipse.semi_major_m,
        semi_minor_m=ellipse.semi_minor_m,
        orientation_deg=ellipse.azimuth_deg,
        sigma_north_m=math.sqrt(fix.covariance[0, 0]),
        sigma_east_m=math.sqrt(fix.covariance[1, 1]),
        talker=TALKER,
    )
    return line if time is not None else _blanked(line, _GST_TIME)


def _seconds(time: datetime | None) -> float:
    return 0.0 if time is None else time.timestamp()


def _blanked(line: str, *numbers: int) -> str:
    """Return a sentence with some fields blank."""
    fields = line[1:].partition("*")[0].split(",")
    return write.sentence(*("" if number in numbers else field for number, field in enumerate(fields)))
