"""Which writer belongs to which suffix."""

from __future__ import annotations

from collections.abc import Callable

from navfix.errors import InputError
from navfix.report.answer import Answer
from navfix.report.csv_table import csv_text
from navfix.report.fix_json import answer_to_dict
from navfix.report.geojson import geojson_text
from navfix.report.gpx import gpx_text
from navfix.report.html import html_text
from navfix.report.json_parts import to_json_line
from navfix.report.nmea_out import nmea_text
from navfix.report.svg import svg_text
from navfix.report.text import report_text


def json_text(answer: Answer) -> str:
    """Return the object ``navfix.fix/1`` as one line, ending in a line feed."""
    return to_json_line(answer_to_dict(answer)) + "\n"


WRITERS: dict[str, Callable[[Answer], str]] = {
    ".txt": report_text,
    ".json": json_text,
    ".svg": svg_text,
    ".geojson": geojson_text,
    ".html": html_text,
    ".nmea": nmea_text,
    ".gpx": gpx_text,
    ".csv": csv_text,
}
SUFFIXES = tuple(WRITERS)


def render(answer: Answer, suffix: str) -> str:
    """Return the answer as text in the format that a file suffix (".svg", case ignored) asks for.

    Raises
    ------
    InputError : no format has this suffix; a format of places on the globe for a fix in a plane frame
    """
    writer = WRITERS.get(suffix.lower())
    if writer is None:
        raise InputError(f"no format has the suffix {suffix!r}; there are {' '.join(SUFFIXES)}")
    return writer(answer)
