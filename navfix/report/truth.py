"""Where own ship really was: the truth CSV (``unix,lat,lon,heading_deg,...``) and the error of an answer against it."""

from __future__ import annotations

import csv
import math
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass, replace

from navfix.errors import InputError
from navfix.geodesy import direct, inverse
from navfix.report.answer import Answer, Truth
from navfix.types import Position
from navfix.units import wrap_180, wrap_360

LONGEST_GAP_S = 30.0


@dataclass(frozen=True, slots=True)
class TruthTrack:
    """Own track in time order: POSIX seconds, places, headings [deg] or None."""

    times_s: tuple[float, ...]
    positions: tuple[Position, ...]
    headings_deg: tuple[float | None, ...]

    @classmethod
    def parse(cls, lines: Iterable[str], *, source: str = "truth") -> TruthTrack:
        """Read a truth CSV: the header names the columns, ``heading`` is read too, others are passed over.

        Raises
        ------
        InputError : no header with unix, lat and lon, no rows, or a number that cannot be right
        """
        reader = csv.DictReader(lines)
        try:
            return cls._read(reader, source)
        except csv.Error as error:
            raise InputError(f"{source}: not a CSV file: {error}", source=source) from error
        except UnicodeDecodeError as error:
            raise InputError(f"{source}: not text; expected a CSV file with unix, lat, lon", source=source) from error

    @classmethod
    def _read(cls, reader: csv.DictReader[str], source: str) -> TruthTrack:
        missing = {"unix", "lat", "lon"} - set(reader.fieldnames or ())
        if missing:
            raise InputError(
                f"{source}: the header must name unix, lat and lon; missing {', '.join(sorted(missing))}",
                source=source,
                line=1,
            )
        rows = sorted((_row(row, source, reader.line_num) for row in reader), key=lambda row: row[0])
        if not rows:
            raise InputError(f"{source}: no rows below the header", source=source)
        times_s, positions, headings_deg = zip(*rows, strict=True)
        return cls(times_s, positions, headings_deg)

    def at(self, time_s: float) -> Truth | None:
        """Return place and heading at an instant, on the geodesic between its rows; None outside or in a gap."""
        after = bisect_left(self.times_s, time_s)
        if after == len(self.times_s) or (after == 0 and self.times_s[0] != time_s):
            return None
        before = max(after - 1, 0)
        gap_s = self.times_s[after] - self.times_s[before]
        if gap_s > LONGEST_GAP_S:
            return None
        share = 1.0 if gap_s <= 0.0 else (time_s - self.times_s[before]) / gap_s
        distance_m, azimuth_deg = inverse(self.positions[before], self.positions[after])
        position = direct(self.positions[before], azimuth_deg, share * distance_m)
        return Truth(position, self._heading(before, after, share))

    def _heading(self, before: int, after: int, share: float) -> float | None:
        first, second = self.headings_deg[before], self.headings_deg[after]
        if first is None or second is None:
            return None
        return wrap_360(first + share * wrap_180(second - first))


def with_truth(answer: Answer, track: TruthTrack) -> Answer:
    """Return the answer with the truth of its instant and its error against it, where the track tells it."""
    if answer.time_utc is None:
        return answer
    truth = track.at(answer.time_utc.timestamp())
    if truth is None:
        return answer
    found = answer.fix
    if found is None or not isinstance(found.position, Position):
        return replace(answer, truth=truth)
    error_m, azimuth_deg = inverse(found.position, truth.position)
    azimuth = math.radians(azimuth_deg)
    inside = found.ellipse(0.95).holds(error_m * math.cos(azimuth), error_m * math.sin(azimuth))
    known = truth.heading_deg is not None and found.heading_deg is not None
    heading_error_deg = wrap_180(found.heading_deg - truth.heading_deg) if known else None  # type: ignore[operator]
    told = replace(truth, error_m=error_m, heading_error_deg=heading_error_deg, in_ellipse=inside)
    return replace(answer, truth=told)


def _row(row: dict[str, str | None], source: str, line: int) -> tuple[float, Position, float | None]:
    heading = row.get("heading_deg") or row.get("heading") or ""
    try:
        position = Position(_number(row["lat"], "lat"), _number(row["lon"], "lon"))
        heading_deg = _number(heading, "heading_deg") if heading.strip() else None
        return _number(row["unix"], "unix"), position, heading_deg
    except InputError as error:
        raise InputError(f"{source}:{line}: {error}", source=source, line=line) from error


def _number(text: str | None, column: str) -> float:
    try:
        number = float(text or "")
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{column} must be a finite number, got {text or 'nothing'}")
    return number
