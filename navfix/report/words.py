"""Values in a navigator's words: degrees and decimal minutes, nautical miles, odds."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from navfix.types import PlanePosition, Position
from navfix.types.found import LARGEST_MARGIN
from navfix.units import NM_M, wrap_360

REASONS = {
    "too_few_pairs": "too few targets have a mark",
    "unobservable": "the geometry leaves a direction free",
    "no_agreement": "no place explains the data better than chance",
    "ambiguous": "more than one place explains the data",
}
ADVICE = {
    "too_few_pairs": "Acquire more radar targets, or give a chart: fixed marks count as well as ships.",
    "unobservable": "Acquire targets in another direction.",
    "no_agreement": "Acquire targets that carry AIS, shorten the radar range to where AIS ships are, or give a chart.",
    "ambiguous": "More targets, a gyro heading or a rough position would decide between them.",
}


def degrees_minutes(position: Position) -> tuple[str, str]:
    """Return latitude and longitude in degrees and decimal minutes: ("59°24.1241' N", "010°35.2359' E")."""
    return (
        _degrees_minutes(position.lat_deg, 2, "NS"),
        _degrees_minutes(position.lon_deg, 3, "EW"),
    )


def _degrees_minutes(angle_deg: float, width: int, sides: str) -> str:
    ten_thousandths = round(abs(angle_deg) * 60.0e4)
    whole, minutes = divmod(ten_thousandths, 60 * 10_000)
    return f"{whole:0{width}d}°{minutes / 1e4:07.4f}' {sides[angle_deg < 0.0]}"


def place(position: Position | PlanePosition) -> str:
    """Return a place on one line, without the decimal degrees."""
    if isinstance(position, PlanePosition):
        return f"N {position.north_m:.3f} m   E {position.east_m:.3f} m"
    return "   ".join(degrees_minutes(position))


def direction(azimuth_deg: float) -> str:
    """Return a direction in three digits: "045°"."""
    return f"{round(wrap_360(azimuth_deg)) % 360:03d}°"


def bearing(angle_deg: float) -> str:
    """Return an angle 0 .. 360 with a tenth: "123.4°", never "360.0°"."""
    return f"{round(wrap_360(angle_deg), 1) % 360.0:05.1f}°"


def distance(metres: float) -> str:
    """Return a distance: metres, above one nautical mile with nautical miles: "3210 m (1.73 NM)"."""
    if metres < 9.95:
        return f"{metres:.1f} m"
    return f"{metres:.0f} m" if metres < NM_M else f"{metres:.0f} m ({metres / NM_M:.2f} NM)"


def short_distance(metres: float) -> str:
    """Return a distance in metres below one nautical mile, in nautical miles above: "1.73 NM"."""
    return f"{metres:.1f} m" if metres < 9.95 else (f"{metres:.0f} m" if metres < NM_M else f"{metres / NM_M:.2f} NM")


def odds(probability: float) -> str:
    """Return a probability as the limit in words that it is: 2e-6 is "at most 2 in a million"; rounded up."""
    if not probability > 0.0 or probability < 1e-12:
        return "less than 1 in a million million"
    for limit, scale, words in (
        (1e-9, 1e12, "a million million"),
        (1e-6, 1e9, "a billion"),
        (1e-4, 1e6, "a million"),
        (1e-3, 1e4, "ten thousand"),
        (1e-2, 1e3, "a thousand"),
    ):
        if probability < limit:
            return f"at most {_one_or_two_digits_up(probability * scale)} in {words}"
    return f"at most {min(_one_or_two_digits_up(probability * 100.0), 99)} in a hundred"


def margin(nats: float) -> str:
    """Return by how much a place is ahead of the next: "margin 54.9", or that there is no other."""
    return "no other place" if nats >= LARGEST_MARGIN else f"margin {nats:.1f}"


def _one_or_two_digits_up(value: float) -> int:
    digits = max(0, math.floor(math.log10(value)) - 1)
    step = int(10**digits)
    return max(1, math.ceil(value / step - 1e-6) * step)


def utc(time_utc: datetime | None) -> str:
    """Return "2026-03-04 05:06:07.2 UTC", or that no time is known."""
    if time_utc is None:
        return "time unknown"
    at = time_utc.astimezone(UTC)
    return f"{at:%Y-%m-%d %H:%M:%S}.{at.microsecond // 100_000} UTC"


def plural(count: int, word: str) -> str:
    """Return "1 target", "2 targets", "2 fixes"."""
    return f"{count} {word}" if count == 1 else f"{count} {word}{'es' if word.endswith('x') else 's'}"
