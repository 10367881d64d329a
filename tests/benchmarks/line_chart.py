"""A small line chart as SVG: panels side by side, logarithmic ordinate, lines named at their ends."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape

Point = tuple[float, float]
_WIDTH, _HEIGHT, _LEFT, _TOP, _BOTTOM, _NAMES, _GAP = 330.0, 300.0, 62.0, 34.0, 46.0, 118.0, 40.0
_COLOURS = ("#8c2d04", "#d95f02", "#b8860b", "#7570b3", "#1f78b4", "#33a02c", "#000000", "#e7298a")


@dataclass(frozen=True)
class Panel:
    """One panel: its title, and points (x, y > 0) by the name of their line."""

    title: str
    lines: Mapping[str, Sequence[Point]]


def line_chart(panels: Sequence[Panel], *, x_title: str, y_title: str, emphasised: str = "") -> str:
    """Return the chart as a self-contained SVG document; the ``emphasised`` line is drawn thicker."""
    points = [point for panel in panels for line in panel.lines.values() for point in line]
    x_range = (min(x for x, _ in points), max(x for x, _ in points))
    y_range = (0.9 * min(y for _, y in points), 1.15 * max(y for _, y in points))
    step = _LEFT + _WIDTH + _NAMES
    width, height = step * len(panels) + _GAP * (len(panels) - 1), _TOP + _HEIGHT + _BOTTOM
    body = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
        f'font-family="Helvetica, Arial, sans-serif" font-size="12">',
        f"<title>{escape(y_title)} against {escape(x_title)}</title>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    for number, panel in enumerate(panels):
        body.append(f'<g transform="translate({number * (step + _GAP) + _LEFT:.1f} {_TOP:.1f})">')
        body += _axes(panel.title, x_range, y_range, x_title, y_title)
        body += _lines(panel, x_range, y_range, emphasised)
        body.append("</g>")
    return "\n".join([*body, "</svg>"]) + "\n"


def _x(value: float, x_range: Point) -> float:
    return (value - x_range[0]) / (x_range[1] - x_range[0]) * _WIDTH


def _y(value: float, y_range: Point) -> float:
    share = math.log(value / y_range[0]) / math.log(y_range[1] / y_range[0])
    return (1.0 - share) * _HEIGHT


def _axes(title: str, x_range: Point, y_range: Point, x_title: str, y_title: str) -> Iterator[str]:
    yield f'<text x="{_WIDTH / 2:.1f}" y="-14" text-anchor="middle" font-weight="bold">{escape(title)}</text>'
    for value in (1, 2, 5, 10, 20, 50, 100):
        if y_range[0] <= value <= y_range[1]:
            y = _y(value, y_range)
            yield f'<line x1="0" x2="{_WIDTH}" y1="{y:.1f}" y2="{y:.1f}" stroke="#dddddd"/>'
            yield f'<text x="-8" y="{y + 4:.1f}" text-anchor="end">{value}</text>'
    for value in range(int(x_range[0]), int(x_range[1]) + 1, 10):
        x = _x(value, x_range)
        yield f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{_HEIGHT}" y2="{_HEIGHT + 5}" stroke="#444444"/>'
        yield f'<text x="{x:.1f}" y="{_HEIGHT + 19:.1f}" text-anchor="middle">{value}</text>'
    yield f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="none" stroke="#444444"/>'
    yield f'<text x="{_WIDTH / 2:.1f}" y="{_HEIGHT + 38:.1f}" text-anchor="middle">{escape(x_title)}</text>'
    turned = f"translate(-42 {_HEIGHT / 2:.1f}) rotate(-90)"
    yield f'<text transform="{turned}" text-anchor="middle">{escape(y_title)}</text>'


def _lines(panel: Panel, x_range: Point, y_range: Point, emphasised: str) -> Iterator[str]:
    ends = _apart({name: _y(line[-1][1], y_range) for name, line in panel.lines.items()})
    for colour, (name, line) in zip(_COLOURS, panel.lines.items(), strict=False):
        path = " ".join(f"{_x(x, x_range):.1f},{_y(y, y_range):.1f}" for x, y in line)
        width = 3.0 if name == emphasised else 1.6
        yield f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
        for x, y in line:
            yield f'<circle cx="{_x(x, x_range):.1f}" cy="{_y(y, y_range):.1f}" r="{width + 0.6}" fill="{colour}"/>'
        last_x, last_y = _x(line[-1][0], x_range), _y(line[-1][1], y_range)
        yield (
            f'<line x1="{last_x:.1f}" y1="{last_y:.1f}" x2="{_WIDTH + 10}" y2="{ends[name]:.1f}" '
            f'stroke="{colour}" stroke-width="0.6"/>'
        )
        weight = ' font-weight="bold"' if name == emphasised else ""
        yield f'<text x="{_WIDTH + 13}" y="{ends[name] + 4:.1f}" fill="{colour}"{weight}>{escape(name)}</text>'


def _apart(wanted: Mapping[str, float], *, gap: float = 15.0) -> dict[str, float]:
    """Return ordinates near the wanted ones and at least ``gap`` apart."""
    placed: dict[str, float] = {}
    for name, y in sorted(wanted.items(), key=lambda item: -item[1]):
        placed[name] = min(y, min(placed.values(), default=math.inf) - gap)
    lowest = 0.0
    for name in sorted(placed, key=placed.__getitem__):  # none above the frame
        placed[name] = max(placed[name], lowest)
        lowest = placed[name] + gap
    return placed
