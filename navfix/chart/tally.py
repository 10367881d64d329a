"""Rows that were passed over, counted by reason, the first of each kept as the example."""

from __future__ import annotations

from navfix.chart.records import BadRow, Problem


class Tally:
    """Counts what a reader passes over."""

    def __init__(self) -> None:
        self._found: dict[str, tuple[int, int | None, str, bool]] = {}

    def add(self, row: BadRow, line: int | None) -> None:
        """Count one row; the first of its reason is the example."""
        count, first, example, harmless = self._found.get(row.reason, (0, line, row.example[:60], row.harmless))
        self._found[row.reason] = (count + 1, first, example, harmless)

    def problems(self) -> tuple[Problem, ...]:
        """Return one problem for each reason, in the order of their first rows."""
        return tuple(Problem(reason, *found) for reason, found in self._found.items())
