"""Values of options: what the text of one must be, and what it becomes."""

from __future__ import annotations

import argparse
import math
from datetime import UTC, datetime

STDIN = "-"  # the name of standard input among files


def positive(text: str) -> float:
    """Return a finite number > 0."""
    number = _number(text)
    if not number > 0.0:
        raise argparse.ArgumentTypeError(f"must be > 0, got {text}")
    return number


def not_negative(text: str) -> float:
    """Return a finite number >= 0."""
    number = _number(text)
    if number < 0.0:
        raise argparse.ArgumentTypeError(f"must be >= 0, got {text}")
    return number


def two_numbers(text: str) -> tuple[float, float]:
    """Return two finite numbers separated by a comma."""
    parts = text.split(",")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"must be two numbers like 12.5,-3, got {text!r}")
    return _number(parts[0]), _number(parts[1])


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number, got {text!r}") from None
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"must be finite, got {text}")
    return number


def pairs(text: str) -> tuple[tuple[str, str], ...]:
    """Return ("target", "mark") pairs of a text like "03=AtoN 7,05=211234560"."""
    found = tuple(tuple(side.strip() for side in part.partition("=")[::2]) for part in text.split(","))
    if not all(target and mark for target, mark in found):
        raise argparse.ArgumentTypeError(f"must be like 03=AtoN7,05=211234560, got {text!r}")
    return tuple((target, mark) for target, mark in found)


def instant(text: str) -> datetime:
    """Return an ISO 8601 time as aware UTC; a time without a zone is UTC."""
    try:
        time = datetime.fromisoformat(text)
        return time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
    except (ValueError, OverflowError):  # overflow: a zone that leads out of the years 1 .. 9999
        raise argparse.ArgumentTypeError(f"must be a time like 2026-01-01T12:00:00Z, got {text!r}") from None
