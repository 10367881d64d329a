"""Render docs/validation.md from docs/validation.toml: `python docs/make_validation.py`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent
STATUSES = ("done", "planned", "answered differently")
SOURCES = {
    "K": ("Knopp, thesis: position and heading of own ship by correlation of AIS and radar", 39),
    "A": ("AARFS: system level design of an AIS and ARPA radar fusion system", 16),
    "G": ("Gdynia stand (Czaplewski et al.): automated radar navigation by comparison and M-estimation", 25),
    "U": ("AIS track correction by an unscented Kalman filter", 12),
    "E": ("Xia, Zhu, Zheng (2025): radar and AIS fusion with the hull's extent", 13),
}
INTRODUCTION = """\
# Validation

Every feature that the five sources of navfix describe, one row each: whether it is there, which test or command shows
it, and the figure that this gives. Where a source is wrong or cannot be reproduced, the row says what was done in its
place and why. Figures are printed by the tests and commands named; nothing here is typed from memory.

Rendered from `docs/validation.toml` by `python docs/make_validation.py`; a test keeps the two together.
"""

Row = Mapping[str, object]


def expected_ids() -> list[str]:
    """Return the ids of all features: K1 .. K39, A1 .. A16, G1 .. G25, U1 .. U12, E1 .. E13."""
    return [f"{letter}{number}" for letter, (_, count) in SOURCES.items() for number in range(1, count + 1)]


def load() -> dict[str, Row]:
    """Return the rows of validation.toml by id."""
    return tomllib.loads((HERE / "validation.toml").read_text(encoding="utf-8"))


def render(rows: Mapping[str, Row]) -> str:
    """Return the page."""
    parts = [INTRODUCTION, summary(rows)]
    for letter, (title, _) in SOURCES.items():
        lines = [
            f"## {letter}: {title}",
            "",
            "| ID | feature | status | shown by | figure, or why |",
            "|---|---|---|---|---|",
        ]
        lines += [_line(key, row) for key, row in rows.items() if key[0] == letter]
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def summary(rows: Mapping[str, Row]) -> str:
    """Return the table of counts."""
    lines = ["| source | " + " | ".join(STATUSES) + " |", "|---|" + "---|" * len(STATUSES)]
    for letter in SOURCES:
        counts = [sum(row["status"] == status for key, row in rows.items() if key[0] == letter) for status in STATUSES]
        lines.append(f"| {letter} | " + " | ".join(map(str, counts)) + " |")
    totals = [sum(row["status"] == status for row in rows.values()) for status in STATUSES]
    return "\n".join([*lines, "| all | " + " | ".join(map(str, totals)) + " |"]) + "\n"


def shown_by(row: Row) -> list[str]:
    """Return the tests and commands of a row."""
    value = row.get("shown_by", [])
    return [str(item) for item in value] if isinstance(value, list) else [str(value)]


def _line(key: str, row: Row) -> str:
    proofs = "<br>".join(f"`{proof}`" for proof in shown_by(row))
    return f"| {key} | {row['feature']} | {row['status']} | {proofs} | {row.get('figure', '')} |"


if __name__ == "__main__":
    (HERE / "validation.md").write_text(render(load()), encoding="utf-8")
