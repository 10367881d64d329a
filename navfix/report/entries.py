"""The lines of the text report: a label with its text, wrapped; lengths in metres."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator

from navfix.report import words

WIDTH = 100
LABEL = 16
LISTED = 10  # places, targets and outliers listed in full before the rest is only counted


def entry(label: str, text: str) -> Iterator[str]:
    """Yield a line, or some, that begin with a label; the rest stands below its text."""
    yield from wrapped(f"{label:<{LABEL}}{text}", indent=LABEL)


def wrapped(text: str, *, indent: int) -> Iterable[str]:
    """Return a text in lines of at most ``WIDTH`` columns, the later ones indented."""
    if len(text) <= WIDTH:
        return [text]
    return textwrap.wrap(text, WIDTH, subsequent_indent=" " * indent, break_long_words=True, replace_whitespace=False)


def in_metres(metres: float) -> str:
    """Return a length [m] with the digits that it deserves by its size."""
    return f"{metres:.3f} m" if metres < 1.0 else (f"{metres:.1f} m" if metres < 100.0 else f"{metres:.0f} m")


def about(metres: float) -> str:
    """Return a distance with two digits, as an "about" deserves."""
    if metres < 10.0:
        return f"{metres:.1f} m"
    return words.distance(round(metres, 1 - math.floor(math.log10(metres))))
