"""The residual table of the text report: one line for each pair, 100 columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from navfix.report.rows import PairRow
from navfix.types import AdjustedObservation

_REPEAT_HEADER = 40  # lines after which a long table shows its header again
_RANGE_WIDTHS, _BEARING_WIDTHS = (9, 8, 7, 5, 5), (9, 7, 7, 5, 5)
_NAME_WIDTH = 22
_LEGEND = (
    "v = adjusted - observed   w = v / (sigma sqrt(r))   r redundancy number   p weight by the kernel",
    "R relative, T true bearing   * outlier",
)


def residual_table(rows: Sequence[PairRow], *, heading_known: bool = True) -> Iterator[str]:
    """Yield the header, one line for each pair, and the legend; nothing for no pairs."""
    if not rows:
        return
    for number, row in enumerate(rows):
        if number % _REPEAT_HEADER == 0:
            if number:
                yield ""
            yield from _header()
        yield _line(row)
    yield from _LEGEND


def _header() -> Iterator[str]:
    titles = _cells(("range m", "v m", "w", "r", "p"), _RANGE_WIDTHS) + _cells(
        ("bearing °", "v °", "w", "r", "p"), (10, *_BEARING_WIDTHS[1:])
    )
    head = f"  {'target':<7}{'mark':<{_NAME_WIDTH}}{titles}"
    yield head
    yield "-" * len(head)


def _line(row: PairRow) -> str:
    flag = "*" if row.outlier else " "
    head = f"{flag} {clipped(row.target, 6):<7}{clipped(row.name, _NAME_WIDTH - 1):<{_NAME_WIDTH}}"
    reference = " " if row.bearing is None else ("T" if row.bearing.kind == "true_bearing" else "R")
    range_ = _observation(row.range, _RANGE_WIDTHS, observed_decimals=1, residual_decimals=1)
    bearing = _observation(row.bearing, _BEARING_WIDTHS, observed_decimals=2, residual_decimals=2)
    # The letter of the reference stands right behind the observed bearing.
    return f"{head}{range_}{bearing[: _BEARING_WIDTHS[0]]}{reference}{bearing[_BEARING_WIDTHS[0] :]}"


def _observation(
    observation: AdjustedObservation | None, widths: Sequence[int], *, observed_decimals: int, residual_decimals: int
) -> str:
    if observation is None:
        return " " * sum(widths)
    w = observation.standardized
    return _cells(
        (
            number(observation.observed, widths[0] - 1, observed_decimals),
            number(observation.residual, widths[1] - 1, residual_decimals, sign=True),
            "-" if w is None else number(w, widths[2] - 1, 1, sign=True),
            number(observation.redundancy_number, widths[3] - 1, 2),
            number(observation.weight, widths[4] - 1, 2),
        ),
        widths,
    )


def _cells(texts: Sequence[str], widths: Sequence[int]) -> str:
    return "".join(f"{text:>{width}}" for text, width in zip(texts, widths, strict=True))


def number(value: float, width: int, decimals: int, *, sign: bool = False) -> str:
    """Return a number that fits into ``width``: fewer decimals, then powers of ten, before it may burst a column."""
    plus = "+" if sign else ""
    for places in range(decimals, -1, -1):
        text = f"{round(value, places) + 0.0:{plus}.{places}f}"  # + 0.0: never "-0.0"
        if len(text) <= width:
            return text
    return f"{value:{plus}.0e}".replace("e+0", "e").replace("e+", "e")


def printable(text: str) -> str:
    """Return the text with a blank for every control character (names come over the air)."""
    return "".join(letter if letter.isprintable() else " " for letter in text)


def clipped(text: str, width: int) -> str:
    """Return the printable text, its end replaced by an ellipsis where it is longer than ``width``."""
    shown = printable(text)
    return shown if len(shown) <= width else shown[: width - 1] + "…"
