"""Charted objects from CSV: a header names the columns, comma, semicolon or tab between them."""

from __future__ import annotations

import csv

from navfix.chart.properties import NAMES, make_object, place, value_of
from navfix.chart.records import BadRow, ChartObject, Problem
from navfix.chart.tally import Tally
from navfix.errors import InputError

_DELIMITERS = ",;\t"


def read_csv(text: str, *, source: str) -> tuple[list[ChartObject], tuple[Problem, ...]]:
    """Return the objects of a CSV text and what was passed over.

    Raises
    ------
    InputError : no header with a column for latitude and longitude
    """
    lines = text.splitlines()
    header = next((i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), None)
    if header is None:
        raise InputError(f"{source}: is empty, expected CSV with a header lat,lon,...", source=source)
    delimiter = max(_DELIMITERS, key=lines[header].count)
    rows = csv.reader(lines[header:], delimiter=delimiter)
    columns = [column.strip().lower() for column in next(rows)]
    for wanted in ("lat", "lon"):
        if not set(columns) & set(NAMES[wanted]):
            raise InputError(
                f"{source}:{header + 1}: no column for {wanted}; expected a header with lat and lon, "
                f"got {', '.join(columns)[:80]!r}",
                source=source,
                line=header + 1,
            )
    objects, tally = [], Tally()
    try:
        for cells in rows:
            line = header + rows.line_num
            try:
                if made := _row(columns, cells, source, line):
                    objects.append(made)
            except BadRow as bad:
                tally.add(bad, line)
    except csv.Error as error:
        raise InputError(f"{source}:{header + rows.line_num}: not CSV: {error}", source=source) from error
    return objects, tally.problems()


def _row(columns: list[str], cells: list[str], source: str, line: int) -> ChartObject | None:
    """Return the object of one row, None for a blank line or a comment."""
    if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
        return None
    if len(cells) > len(columns):
        raise BadRow("more cells than columns", ",".join(cells))
    properties = dict(zip(columns, cells, strict=False))
    position = place(value_of(properties, "lat"), value_of(properties, "lon"))
    return make_object(properties, position, source=source, line=line)
