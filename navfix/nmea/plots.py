"""Raw radar plots beside a log: a CSV file of time, range and bearing, its columns and units named by the header.

Recognised by the words of a column's name, in any order and case: the time by ``unix``, ``time``, ``timestamp`` or
``utc`` (POSIX seconds, milliseconds with ``ms``, or ISO 8601), the range by ``range`` or ``distance`` (metres, with
``km`` or ``nm`` kilometres or nautical miles), the bearing by ``bearing`` or ``azimuth`` (degrees, with ``rad``
radians). Columns of variances and sigmas and all others are passed over.
"""

from __future__ import annotations

import csv
import logging
import math
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from navfix.errors import InputError
from navfix.types import BearingReference
from navfix.units import NM_M, wrap_360

_TIME_WORDS = {"unix", "time", "timestamp", "utc", "posix", "epoch"}
_RANGE_WORDS = {"range", "distance", "rng", "dist"}
_BEARING_WORDS = {"bearing", "azimuth", "brg", "az"}
_SPREAD_WORDS = {"var", "variance", "sigma", "std", "stdev", "cov", "error", "rate", "resolution"}
_TRUE_WORDS = {"true", "north", "northup", "north-up"}
_RANGE_UNITS_M = {"km": 1000.0, "nm": NM_M, "nmi": NM_M}
_FARTHEST_M = 500_000.0
_LAST_S = 4_102_444_800.0  # the year 2100: a larger number is not in seconds
_logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RadarPlot:
    """One echo of one antenna turn: time [POSIX s], range [m], bearing [deg, 0 .. 360] from zero mark or north."""

    time_s: float
    range_m: float
    bearing_deg: float


@dataclass(frozen=True, slots=True)
class PlotFile:
    """The plots of a file by time, what their bearings count from, and how many rows could not be read, by reason.

    ``reference`` is what the header says ("true" where it names north or true), "relative" where it says nothing.
    """

    name: str
    plots: tuple[RadarPlot, ...]
    reference: BearingReference
    bad_rows: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True)
class _Columns:
    time: int
    time_unit_s: float
    range: int
    range_unit_m: float
    bearing: int
    bearing_unit_deg: float
    reference: BearingReference


class _BadRow(ValueError):
    """A row that cannot be right; the message is its reason, without the row's own numbers: reasons are counted."""


def read_plots(path: str | Path) -> PlotFile:
    """Read a file of plots. Rows that cannot be read are counted and logged as one warning.

    Raises
    ------
    InputError : no such file, no header with time, range and bearing, or not one row that can be read
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file", source=str(path)) from error
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read: {error}", source=str(path)) from error
    found = parse_plots(text.splitlines(), name=str(path))
    if found.bad_rows:
        reasons = ", ".join(f"{count} x {reason}" for reason, count in found.bad_rows)
        _logger.warning("%s: rows that cannot be read: %s", path, reasons)
    return found


def parse_plots(lines: Iterable[str], *, name: str = "plots") -> PlotFile:
    """Read the lines of a CSV file of plots, separated by commas, semicolons or tabs; the first one names the columns.

    Raises
    ------
    InputError : no header with time, range and bearing, or not one row that can be read
    """
    rows = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not rows:
        raise InputError(f"{name}: is empty, expected a CSV file of plots (time, range, bearing)", source=name)
    delimiter = max(",;\t", key=rows[0].count)
    columns = _columns(_cells(rows[0], delimiter), name)
    plots: set[RadarPlot] = set()
    bad: Counter[str] = Counter()
    for row in rows[1:]:
        try:
            plots.add(_plot(_cells(row, delimiter), columns))
        except _BadRow as reason:
            bad[str(reason)] += 1
    if not plots:
        reasons = ", ".join(f"{count} x {reason}" for reason, count in bad.most_common()) or "no rows below the header"
        raise InputError(f"{name}: not one plot: {reasons}", source=name)
    ordered = tuple(sorted(plots, key=lambda plot: (plot.time_s, plot.bearing_deg, plot.range_m)))
    return PlotFile(name, ordered, columns.reference, tuple(bad.most_common()))


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    except csv.Error:
        return []


def _columns(header: list[str], name: str) -> _Columns:
    words = [set(re.split(r"[^a-z0-9-]+", cell.lower())) - {""} for cell in header]
    found = {
        what: next((i for i, w in enumerate(words) if w & wanted and not w & _SPREAD_WORDS), None)
        for what, wanted in (("time", _TIME_WORDS), ("range", _RANGE_WORDS), ("bearing", _BEARING_WORDS))
    }
    missing = [what for what, index in found.items() if index is None]
    if missing:
        raise InputError(
            f"{name}: the header must name time, range and bearing, such as unix,range_m,bearing_deg; "
            f"missing {', '.join(missing)}",
            source=name,
            line=1,
        )
    time, distance, bearing = (found[what] or 0 for what in ("time", "range", "bearing"))
    return _Columns(
        time=time,
        time_unit_s=1e-3 if "ms" in words[time] else 1.0,
        range=distance,
        range_unit_m=next((m for unit, m in _RANGE_UNITS_M.items() if unit in words[distance]), 1.0),
        bearing=bearing,
        bearing_unit_deg=math.degrees(1.0) if "rad" in words[bearing] else 1.0,
        reference="true" if words[bearing] & _TRUE_WORDS else "relative",
    )


def _plot(cells: list[str], columns: _Columns) -> RadarPlot:
    if len(cells) <= max(columns.time, columns.range, columns.bearing):
        raise _BadRow("too few columns")
    time_s = _time_s(cells[columns.time], columns.time_unit_s)
    range_m = _number(cells[columns.range], "range") * columns.range_unit_m
    bearing_deg = _number(cells[columns.bearing], "bearing") * columns.bearing_unit_deg
    if not 0.0 < range_m <= _FARTHEST_M:
        raise _BadRow("range not in 0 .. 500 km")
    if not -360.0 <= bearing_deg <= 360.0:
        raise _BadRow("bearing not in -360 .. 360°")
    return RadarPlot(time_s, range_m, wrap_360(bearing_deg))


def _time_s(text: str, unit_s: float) -> float:
    if re.fullmatch(r"[-+]?[0-9.]+([eE][-+]?[0-9]+)?", text):
        time_s = _number(text, "time") * unit_s
    else:
        try:
            told = datetime.fromisoformat(text)
            time_s = (told.replace(tzinfo=UTC) if told.tzinfo is None else told).timestamp()
        except (ValueError, OverflowError):
            raise _BadRow("time neither POSIX seconds nor ISO 8601") from None
    if not 0.0 <= time_s <= _LAST_S:
        raise _BadRow("time not in the years 1970 .. 2100")
    return time_s


def _number(text: str, what: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise _BadRow(f"{what} is not a number")
    return number
