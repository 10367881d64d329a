"""What is wrong with the radar as a whole, in words and for the JSON: its clock against AIS, its ranges."""

from __future__ import annotations

from typing import Any

from navfix.report import words
from navfix.report.numbers import plain
from navfix.types import CommonError, RadarErrors


def radar_errors_to_dict(found: RadarErrors | None) -> dict[str, Any] | None:
    """Return both errors with sigma and what is taken off, None where nobody looked.

    Value and sigma are None where the error is not observable: ``reason`` says why.
    """
    if found is None:
        return None
    return {"clock": _to_dict(found.clock, "s"), "range": _to_dict(found.ranges, "m")}


def radar_errors_words(found: RadarErrors, *, windows: bool = False) -> tuple[str, ...]:
    """Return a sentence for each error; with ``windows`` the clock is left to the windows that estimate it."""
    left = "left to the windows, which estimate it themselves" if windows else None
    return (
        _words("radar clock minus AIS clock", "s", found.clock, left),
        _words("radar range bias", "m", found.ranges, None),
    )


def _to_dict(error: CommonError, unit: str) -> dict[str, Any]:
    return {
        f"value_{unit}": plain(error.value) if error.observable else None,
        f"sigma_{unit}": plain(error.sigma) if error.observable else None,
        f"applied_{unit}": plain(error.applied),
        "observable": error.observable,
        "significant": error.significant,
        "separable": plain(error.separable),
        "marks": plain(error.marks),
        "fixes": error.fixes,
        "reason": error.reason,
    }


def _words(name: str, unit: str, error: CommonError, left: str | None) -> str:
    stands = f"{error.marks:.1f} marks in {words.plural(error.fixes, 'fix')}"
    if not error.observable:
        return f"{name}: not observable ({error.reason}; {stands})"
    found = f"{name}: {error.value:+.1f} {unit}, sigma {error.sigma:.1f} {unit} ({stands})"
    if error.applied:
        return f"{found}, {error.applied:+.1f} {unit} taken off"
    return f"{found}, not taken off: {error.reason or left or 'too large to be one'}"
