"""From metres about own ship to units of the picture, and the few helpers that every part of the picture uses."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree as ET

from navfix.report.tables import clipped

INK, GRID, MUTED, PAPER = "#1d2733", "#b9c6d2", "#7f8c99", "#f5f9fc"
OWN, ELLIPSE, ECHO, MARK, OUTLIER, STICK = "#0b2a4a", "#7a1fa2", "#e08a00", "#1b7f3b", "#d11f2d", "#1560bd"
PLACE = {"plain_mean": "#00838f", "gnss": "#5d4037", "truth": "#1b7f3b", "alternative": "#7a1fa2"}
FONT = "DejaVu Sans, Verdana, Arial, sans-serif"
# Widths of letters of the widest of these fonts, in units of the font's size.
_NARROW, _NARROW_LETTERS, _WIDE, _SMALL = 0.40, frozenset(" .,:;'|!iIjlftr()[]-"), 0.70, 0.63


@dataclass(frozen=True, slots=True)
class Box:
    """An upright rectangle in units of the picture, y downwards."""

    x: float
    y: float
    width: float
    height: float

    @property
    def centre(self) -> tuple[float, float]:
        return self.x + self.width / 2.0, self.y + self.height / 2.0

    def overlaps(self, other: Box) -> bool:
        """Tell whether two boxes share an area."""
        return (
            self.x < other.x + other.width
            and other.x < self.x + self.width
            and self.y < other.y + other.height
            and other.y < self.y + self.height
        )

    def holds(self, x: float, y: float, margin: float = 0.0) -> bool:
        """Tell whether a point lies inside, at least ``margin`` from the edge."""
        return (
            self.x + margin <= x <= self.x + self.width - margin
            and self.y + margin <= y <= self.y + self.height - margin
        )

    def contains(self, other: Box) -> bool:
        """Tell whether the other box lies inside."""
        return self.holds(other.x, other.y) and self.holds(other.x + other.width, other.y + other.height)


def box_around(x: float, y: float, half: float) -> Box:
    """Return a square box about a point."""
    return Box(x - half, y - half, 2.0 * half, 2.0 * half)


@dataclass(frozen=True, slots=True)
class View:
    """Where the metres (north, east) about own ship lie in the picture: up is north (or the radar's zero mark)."""

    box: Box
    centre_north_m: float
    centre_east_m: float
    units_per_m: float

    def point(self, north_m: float, east_m: float) -> tuple[float, float]:
        """Return (x, y) in the picture."""
        x, y = self.box.centre
        return (
            x + (east_m - self.centre_east_m) * self.units_per_m,
            y - (north_m - self.centre_north_m) * self.units_per_m,
        )

    def metres(self, x: float, y: float) -> tuple[float, float]:
        """Return (north, east) [m] of a point of the picture."""
        middle_x, middle_y = self.box.centre
        return (
            self.centre_north_m - (y - middle_y) / self.units_per_m,
            self.centre_east_m + (x - middle_x) / self.units_per_m,
        )


def view_of(points_ne_m: Iterable[tuple[float, float]], box: Box, *, margin: float, smallest_m: float) -> View:
    """Return the view that holds all points (north, east) [m] with ``margin`` units around, at least ``smallest_m``."""
    points = list(points_ne_m)
    norths, easts = [north for north, _ in points], [east for _, east in points]
    height_m = max(max(norths) - min(norths), smallest_m)
    width_m = max(max(easts) - min(easts), smallest_m)
    scale = min((box.width - 2.0 * margin) / width_m, (box.height - 2.0 * margin) / height_m)
    return View(box, (max(norths) + min(norths)) / 2.0, (max(easts) + min(easts)) / 2.0, scale)


def nice(value: float, steps: Sequence[float] = (1.0, 2.0, 5.0)) -> float:
    """Return the largest of 1, 2, 5 x 10^k that is not above ``value``."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * max((step for step in steps if step <= value / power * (1.0 + 1e-9)), default=steps[0])


# -------------------------------------------------------------------------------------------------------- elements


def add(parent: ET.Element, tag: str, content: str | None = None, **attributes: Any) -> ET.Element:
    """Add one element; ``stroke_width`` becomes ``stroke-width``, numbers get two decimals, None is left out."""
    named = {
        name.rstrip("_").replace("_", "-"): _value(value) for name, value in attributes.items() if value is not None
    }
    element = ET.SubElement(parent, tag, named)
    element.text = content
    return element


def _value(value: object) -> str:
    if isinstance(value, float):
        return f"{round(value, 2) + 0.0:.2f}".rstrip("0").rstrip(".")
    return str(value)


def text(
    parent: ET.Element, x: float, y: float, content: str, *, size: float = 12.0, fill: str = INK, halo: bool = True,
    **attributes: Any,
) -> ET.Element:  # fmt: skip
    """Add a text with a light halo; characters that XML does not know become blanks."""
    edge: dict[str, Any] = (
        {"stroke": PAPER, "stroke_width": 3.0, "stroke_linejoin": "round", "paint_order": "stroke"} if halo else {}
    )
    shown = clipped(content, 1000)
    return add(parent, "text", shown, x=x, y=y, font_size=size, fill=fill, **edge, **attributes)


def text_width(content: str, size: float) -> float:
    """Return about how wide a text is."""
    shares = (_NARROW if c in _NARROW_LETTERS else (_SMALL if c.islower() or c.isdigit() else _WIDE) for c in content)
    return size * sum(shares)


def path(points: Iterable[tuple[float, float]], *, closed: bool = False) -> str:
    """Return the path data of a line through points."""
    line = " L".join(f"{x:.2f},{y:.2f}" for x, y in points)
    return f"M{line}{' Z' if closed else ''}"
