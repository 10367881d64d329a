"""Numbers for other programs: plain, finite, rounded to what they carry."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 9


def plain(value: float | None, digits: int = DIGITS) -> float | None:
    """Return the value with ``digits`` significant digits; None for None and for anything not finite.

    Significant digits and not decimals: the same writer serves ranges of kilometres and networks of millimetres.
    """
    if value is None or not math.isfinite(value):
        return None
    return float(f"{float(value):.{digits}g}")


def plain_matrix(matrix: ArrayLike) -> list[list[float | None]]:
    """Return a matrix as lists of plain numbers, row by row."""
    return [[plain(float(entry)) for entry in row] for row in np.atleast_2d(np.asarray(matrix, dtype=np.float64))]


def degrees(value: float) -> float:
    """Return a latitude or longitude to 9 decimals (0.1 mm)."""
    return round(float(value), 9) + 0.0


def iso_utc(time_utc: datetime | None) -> str | None:
    """Return "2026-01-01T00:00:00.000Z", None for None."""
    if time_utc is None:
        return None
    return time_utc.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
