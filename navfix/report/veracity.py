"""AIS veracity as a table for people and as rows for programs."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import Any

from navfix.report.numbers import plain
from navfix.types import ShipVeracity, VeracityStatus

SCHEMA = "navfix.veracity/1"
_STATUS: dict[VeracityStatus, str] = {
    "disagrees": "DISAGREES",
    "elsewhere": "ELSEWHERE",
    "no_echo": "NO ECHO",
    "agrees": "agrees",
    "too_little": "too little",
}
_HEADER = f"{'ship':<24}{'status':<11}{'seen':>6}{'missing':>9}{'offset m':>10}{'towards':>9}{'sigma m':>9}{'p':>10}"
_RELATIVE = "Radar against AIS, relative to the fix: a shift that most AIS positions share is not seen here."


def veracity_text(ships: Sequence[ShipVeracity], *, all_ships: bool = False) -> str:
    """Return the table (within 100 columns): ships that radar contradicts, and with ``all_ships`` the others too."""
    shown = [s for s in ships if all_ships or s.status in ("disagrees", "elsewhere", "no_echo")]
    lines = [f"AIS veracity: {summary(ships)}", _RELATIVE]
    if shown:
        lines += ["", _HEADER]
    for ship in shown:
        lines.append(_line(ship))
        if ship.note:
            lines.append(f"{'':<24}{ship.note}"[:100])
    return "\n".join(lines) + "\n"


def summary(ships: Sequence[ShipVeracity]) -> str:
    """Return the counts in one line."""
    counts = Counter(ship.status for ship in ships)
    worded = (f"{counts[status]} {word.lower()}" for status, word in _STATUS.items() if counts[status])
    return f"{len(ships)} stations in radar range: {', '.join(worded)}" if ships else "no station in radar range"


def veracity_rows(ships: Sequence[ShipVeracity]) -> list[dict[str, Any]]:
    """Return one object for each ship, keys as in the record; numbers are finite or null."""
    return [
        {
            "mark": ship.mark,
            "mmsi": ship.mmsi,
            "name": ship.name,
            "status": ship.status,
            "epochs": ship.epochs,
            "seen": ship.seen,
            "expected": ship.expected,
            "missing": ship.missing,
            "offset_m": plain(ship.offset_m),
            "azimuth_deg": plain(ship.azimuth_deg),
            "sigma_m": plain(ship.sigma_m),
            "p_value": plain(ship.p_value),
            "target": ship.target,
            "note": ship.note,
        }
        for ship in ships
    ]


def veracity_json(ships: Sequence[ShipVeracity]) -> str:
    """Return the whole as one JSON object (`navfix.veracity/1`)."""
    content = {"schema": SCHEMA, "ships": veracity_rows(ships)}
    return json.dumps(content, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def _line(ship: ShipVeracity) -> str:
    name = f"{ship.mark} {ship.name}" if ship.name and ship.name != ship.mark else ship.mark
    missing = f"{ship.missing}/{ship.expected}" if ship.expected else "-"
    start = f"{name[:23]:<24}{_STATUS[ship.status]:<11}{ship.seen:>6}{missing:>9}"
    if ship.offset_m is None or ship.azimuth_deg is None or ship.sigma_m is None or ship.p_value is None:
        return start
    return f"{start}{ship.offset_m:>10.0f}{ship.azimuth_deg:>9.0f}{ship.sigma_m:>9.0f}{ship.p_value:>10.1e}"
