"""Labels that do not overlap: greedy placement around a point, what matters most first."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree as ET

from navfix.report.drawing.view import INK, Box, add, text, text_width

# Directions in which a label may stand, as shares of (label width, label height), the usual best first.
_SIDES = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (1, 1), (-1, -1), (-1, 1))
_GAPS = (8.0, 15.0, 24.0)


class Labels:
    """The places that are taken; `put` adds a label where there is room."""

    def __init__(self, inside: Box, obstacles: Iterable[Box] = ()) -> None:
        self._inside = inside
        self._taken = list(obstacles)

    def free(self, box: Box) -> bool:
        """Tell whether a box lies inside the picture and touches nothing."""
        return self._inside.contains(box) and not any(box.overlaps(other) for other in self._taken)

    def take(self, box: Box) -> None:
        """Keep other labels away from a box."""
        self._taken.append(box)

    def put(
        self, parent: ET.Element, x: float, y: float, content: str, *, size: float = 11.0, fill: str = INK,
        must: bool = False, clear: float = 0.0, **attributes: Any,
    ) -> bool:  # fmt: skip
        """Write a label near a point where it overlaps nothing; tell whether it was written.

        It stands beside the point, ``clear`` units farther than usual for a large symbol. Where there is no room it is
        left out, unless it ``must`` stand: then it goes farther away, with a leader.
        """
        width, height = text_width(content, size), 1.15 * size
        for gap in _GAPS if not must else (*_GAPS, 40.0, 60.0, 85.0, 120.0):
            for side, rise in _SIDES:
                box = _box_beside(x, y, width, height, side, rise, gap + clear)
                if self.free(box):
                    self._write(parent, box, content, size, fill, attributes)
                    if gap > _GAPS[0]:
                        _leader(parent, x, y, box, fill)
                    return True
        if must:
            box = _box_beside(x, y, width, height, 1, 0, _GAPS[0] + clear)
            self._write(parent, box, content, size, fill, attributes)
        return must

    def _write(
        self, parent: ET.Element, box: Box, content: str, size: float, fill: str, attributes: dict[str, Any]
    ) -> None:
        text(parent, box.x, box.y + 0.88 * size, content, size=size, fill=fill, **attributes)
        self.take(box)


def _box_beside(x: float, y: float, width: float, height: float, side: int, rise: int, gap: float) -> Box:
    near = 0.7 * gap if side and rise else gap
    left = x - width / 2.0 + side * (width / 2.0 + near)
    top = y - height / 2.0 + rise * (height / 2.0 + near)
    return Box(left, top, width, height)


def _leader(parent: ET.Element, x: float, y: float, box: Box, colour: str) -> None:
    """Draw a thin line from the point to the nearest point of the label's edge."""
    to_x = min(max(x, box.x), box.x + box.width)
    to_y = min(max(y, box.y), box.y + box.height)
    add(parent, "line", x1=x, y1=y, x2=to_x, y2=to_y, stroke=colour, stroke_width=0.6, stroke_opacity=0.7)
