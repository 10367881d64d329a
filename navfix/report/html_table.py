"""Tables of a self-contained page: style, cells and numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np

from navfix.types import FloatArray

STYLE = """
body { margin: 1.2rem; color: #1d2733; background: #ffffff; font-family: sans-serif; line-height: 1.35; }
h1 { font-size: 1.3rem; margin: 0 0 0.4rem; } h2 { font-size: 1.05rem; margin: 1.6rem 0 0.4rem; }
article + article { margin-top: 2.5rem; padding-top: 1.5rem; border-top: 3px solid #c9d3dc; }
section { overflow-x: auto; } p { margin: 0.3rem 0; max-width: 60rem; } p.small { font-size: 0.85rem; }
table { border-collapse: separate; border-spacing: 0; font-size: 0.85rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.15rem 0.6rem; border-bottom: 1px solid #c9d3dc; text-align: right; white-space: nowrap; }
th { background: #eef3f7; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: #ffffff; }
th:first-child { background: #eef3f7; } td.text, th.text { text-align: left; }
table.facts td { text-align: left; white-space: normal; } table.facts td:first-child { font-weight: bold; }
tr.damped td, tr.damped td:first-child { background: #fdeee2; } tr.out td { color: #6b7680; }
td.bad, b.bad { color: #b42318; font-weight: bold; }
svg { width: 100%; max-width: 34rem; height: auto; } svg text { font-size: 11px; fill: #1d2733; }
.sight { stroke: #8aa0b4; } .sight.damped { stroke: #d2691e; stroke-dasharray: 5 4; }
.sight.out { stroke: #b9c3cc; stroke-dasharray: 2 4; } .mark { fill: #1f6feb; }
.ellipse { fill: none; stroke: #b42318; }
.frame { stroke: #1d2733; }
@media (prefers-color-scheme: dark) {
  body { color: #dbe3ea; background: #0d1117; } th, th:first-child { background: #1c2530; }
  td:first-child { background: #0d1117; } th, td, article + article { border-color: #39434f; }
  tr.damped td, tr.damped td:first-child { background: #3b2a1c; } tr.out td { color: #8d99a5; }
  td.bad, b.bad { color: #ff7b72; } svg text { fill: #dbe3ea; } .ellipse { stroke: #ff7b72; }
  .sight { stroke: #5c7186; } .frame { stroke: #dbe3ea; }
}
@media (max-width: 40rem) {
  td:first-child { white-space: normal; min-width: 5.5rem; } th, td { padding: 0.15rem 0.35rem; }
}
@media print { section { overflow: visible; } h2 { break-after: avoid; } tr { break-inside: avoid; } }
"""
Row = tuple[str, Sequence[str]]  # class of the row, cells


def page(articles: Iterable[str], title: str) -> str:
    """Return a page of articles that needs nothing else."""
    body = "".join(f"<article>\n{article}</article>\n" for article in articles)
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{escape(title)}</title>\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )


def heading(text: str) -> str:
    """Return the title of a section."""
    return f"<h2>{escape(text)}</h2>\n"


def remark(text: str) -> str:
    """Return a line of explanation below a table."""
    return f'<p class="small">{escape(text)}</p>\n'


def facts(pairs: Iterable[tuple[str, str]], *, bad: Sequence[str] = ()) -> str:
    """Return a table of names and what they are; the names in ``bad`` are shown as alarms."""
    cells = [(escape(name), "bad" if name in bad else "text", escape(value)) for name, value in pairs]
    rows = "\n".join(f'<tr><td>{name}</td><td class="{kind}">{value}</td></tr>' for name, kind, value in cells)
    return f'<section><table class="facts">\n{rows}\n</table></section>\n'


def table(names: Sequence[str], rows: Iterable[Row], *, text: Sequence[int] = (0,), bad: Sequence[str] = ()) -> str:
    """Return a table; the columns ``text`` stand to the left, a cell that is one of ``bad`` is an alarm."""

    def cell(tag: str, column: int, content: str) -> str:
        name = "bad" if tag == "td" and content in bad else "text" if column in text else ""
        return f'<{tag} class="{name}">{escape(content)}</{tag}>' if name else f"<{tag}>{escape(content)}</{tag}>"

    def line(tag: str, cells: Sequence[str]) -> str:
        return "".join(cell(tag, column, content) for column, content in enumerate(cells))

    body = "\n".join(f'<tr class="{state}">{line("td", cells)}</tr>' for state, cells in rows)
    return f"<section><table>\n<tr>{line('th', names)}</tr>\n{body}\n</table></section>\n"


def matrix(values: FloatArray, labels: Sequence[str]) -> str:
    """Return a square matrix, five digits of each number."""
    rows = [("", (label, *(digits(float(x), 5) for x in line))) for label, line in zip(labels, values, strict=True)]
    return table(("", *labels), rows)


def digits(value: float | None, significant: int) -> str:
    """Return a number with so many significant digits; "-" where there is none."""
    return "-" if value is None or not np.isfinite(value) else f"{value + 0.0:.{significant}g}"


def decimals(value: float | None, places: int, *, sign: bool = False) -> str:
    """Return a number with so many decimals, never "-0"; "-" where there is none."""
    if value is None or not np.isfinite(value):
        return "-"
    return f"{round(value, places) + 0.0:{'+' if sign else ''}.{places}f}"
