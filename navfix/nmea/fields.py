"""Reading the fields of one sentence: blank is None; nonsense is None and noted, an error only where it is required."""

from __future__ import annotations

import re
from datetime import UTC, datetime

from navfix.nmea.framing import Unreadable

_NUMBER = re.compile(r"[+-]?(?:[0-9]{1,15}\.?[0-9]*|\.[0-9]+)")
_UTC = re.compile(r"([01][0-9]|2[0-3])([0-5][0-9])([0-5][0-9]|60)(\.[0-9]*)?")
_DEGREES_MINUTES = re.compile(r"([0-9]{1,3})([0-5][0-9](?:\.[0-9]*)?)")


class Fields:
    """The fields of one sentence; index 0 is the address, so that an index is the field number of the standard.

    ``notes`` collects what an optional field said that could not be read.
    """

    __slots__ = ("notes", "values")

    def __init__(self, values: list[str]) -> None:
        self.values = values
        self.notes: list[str] = []

    def text(self, index: int) -> str:
        """Return the field without blanks around it, "" where the sentence is shorter."""
        return self.values[index].strip() if index < len(self.values) else ""

    def number(self, index: int) -> float | None:
        """Return a finite number, None where blank; None and a note where it is none (``-1.-5``)."""
        text = self.text(index)
        if not text:
            return None
        if _NUMBER.fullmatch(text):
            return float(text)
        self.notes.append(f"field {index} is {text[:24]!r}, expected a number")
        return None

    def required(self, index: int, name: str) -> float | None:
        """Return a number, None where blank.

        Raises
        ------
        Unreadable : the field is there and is no number, or the sentence ends before it
        """
        if index >= len(self.values):
            raise Unreadable("too_short", f"the sentence ends before field {index} ({name})")
        value = self.number(index)
        if value is None and self.text(index):
            raise Unreadable("field", f"{name}: {self.notes.pop()}")
        return value

    def scaled(self, index: int, unit: float) -> float | None:
        """Return the number times ``unit``, None where blank."""
        value = self.number(index)
        return None if value is None else value * unit

    def signed(self, index: int, negative: str) -> float | None:
        """Return the number, negative where the next field is ``negative`` (W of a variation); None without it."""
        value, letter = self.number(index), self.text(index + 1)
        if value is None or not letter:
            return None
        return -value if letter == negative else value

    def flag(self, index: int, yes: str) -> bool:
        """Return whether the field is one of the letters ``yes``."""
        text = self.text(index)
        return bool(text) and text in yes

    def utc_of_day_s(self, index: int) -> float | None:
        """Return seconds of the day of ``hhmmss`` with or without decimals."""
        text = self.text(index)
        if not text:
            return None
        match = _UTC.fullmatch(text)
        if match is None:
            self.notes.append(f"field {index} is {text[:24]!r}, expected UTC as hhmmss or hhmmss.ss")
            return None
        hours, minutes, seconds, fraction = match.groups()
        return int(hours) * 3600.0 + int(minutes) * 60.0 + int(seconds) + float(f"0{fraction or ''}")

    def midnight_s(self, day: str, month: str, year: str) -> float | None:
        """Return the POSIX seconds at which a day begins; a year of two digits is 1980 .. 2079."""
        try:
            number = int(year)
            if len(year) == 2:
                number += 1900 if number >= 80 else 2000
            return datetime(number, int(month), int(day), tzinfo=UTC).timestamp()
        except ValueError:
            self.notes.append(f"{day}-{month}-{year} is no date"[:48])
            return None

    def position_deg(self, index: int) -> tuple[float, float] | None:
        """Return latitude and longitude of four fields ``ddmm.mm,N,dddmm.mm,E``, None where one of them is blank.

        Raises
        ------
        Unreadable : a field is there and cannot be right
        """
        texts = [self.text(index + offset) for offset in range(4)]
        if not all(texts):
            return None
        return _angle_deg(texts[0], texts[1], "NS", 90.0), _angle_deg(texts[2], texts[3], "EW", 180.0)


def _angle_deg(text: str, hemisphere: str, letters: str, limit_deg: float) -> float:
    match = _DEGREES_MINUTES.fullmatch(text)
    if match is None or hemisphere not in letters:
        raise Unreadable(
            "field",
            f"position {text[:24]!r},{hemisphere[:4]!r}, expected degrees and minutes and {letters[0]} or {letters[1]}",
        )
    value_deg = int(match[1]) + float(match[2]) / 60.0
    if value_deg > limit_deg:
        raise Unreadable("field", f"position {text!r},{hemisphere!r} lies beyond {limit_deg:.0f} degrees")
    return -value_deg if hemisphere == letters[1] else value_deg
