"""The magnifier: the confidence ellipses where they are too small to be seen in the picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from navfix.report import words
from navfix.report.drawing import symbols
from navfix.report.drawing.frame import scale_bar
from navfix.report.drawing.labels import Labels
from navfix.report.drawing.view import INK, MUTED, OUTLIER, OWN, PLACE, Box, View, add, box_around, path, text
from navfix.report.json_parts import ELLIPSE_PROBABILITIES
from navfix.report.scene import Scene
from navfix.types import Fix

SIDE = 210.0
_SMALLEST = 16.0  # an ellipse with a shorter semi-major axis in the picture gets a magnifier
_HIDDEN = 25.0  # what lies nearer to own ship in the picture is hidden by its symbol


def needed(fix: Fix, view: View) -> bool:
    """Tell whether the 95 % ellipse is too small to be seen."""
    return fix.ellipse(ELLIPSE_PROBABILITIES[0]).semi_major_m * view.units_per_m < _SMALLEST


def corner_with_room(inside: Box, symbols_at: Sequence[tuple[float, float]]) -> Box:
    """Return the corner of the picture that covers the fewest symbols; the upper right one first."""
    right, bottom = inside.x + inside.width - SIDE - 12.0, inside.y + inside.height - SIDE - 26.0
    corners = [
        Box(x, y, SIDE, SIDE)
        for x, y in ((right, inside.y + 12.0), (right, bottom), (inside.x + 64.0, inside.y + 12.0))
    ]
    return min(corners, key=lambda corner: sum(corner.holds(x, y, -12.0) for x, y in symbols_at))


def draw(parent: ET.Element, box: Box, fix: Fix, scene: Scene, view: View) -> None:
    """Draw the magnifier: ellipses, protection level, and the other places where they lie near enough."""
    ellipses = [fix.ellipse(probability) for probability in ELLIPSE_PROBABILITIES]
    reach_m = _reach_m(fix, scene)
    close = View(box, 0.0, 0.0, 0.5 * box.width / reach_m)
    group = add(parent, "g", id="inset")
    add(group, "path", d=path([view.point(0.0, 0.0), _nearest_corner(box, view)]), stroke=MUTED, stroke_dasharray="2 3")
    add(
        group,
        "rect",
        x=box.x,
        y=box.y,
        width=box.width,
        height=box.height,
        fill="#ffffff",
        stroke=INK,
        fill_opacity=0.94,
    )
    clip = add(group, "clipPath", id="inset-clip")
    add(clip, "rect", x=box.x, y=box.y, width=box.width, height=box.height)
    inner = add(group, "g", clip_path="url(#inset-clip)")
    for ellipse in reversed(ellipses):
        symbols.confidence_ellipse(inner, close, ellipse)
    _heading(inner, close, fix)
    level_m = None if fix.integrity is None else fix.integrity.protection_level_m
    x, y = box.centre
    if level_m is not None and level_m < reach_m:
        radius = level_m * close.units_per_m
        add(inner, "circle", cx=x, cy=y, r=radius, fill="none", stroke=OUTLIER, stroke_width=1, stroke_dasharray="8 4")
    _places(inner, close, scene, view)
    magnified = close.units_per_m / view.units_per_m
    text(inner, box.x + 8.0, box.y + 16.0, f"own ship, × {magnified:.0f}", size=11.5, font_weight="bold")
    scale_bar(inner, close, box.x + 10.0, box.y + box.height - 9.0, 0.35 * box.width)
    if level_m is not None and level_m < reach_m:
        caption = f"protection level {level_m:.0f} m"
        right, bottom = box.x + box.width - 7.0, box.y + box.height - 8.0
        text(inner, right, bottom, caption, size=9.0, fill=OUTLIER, text_anchor="end")


def _reach_m(fix: Fix, scene: Scene) -> float:
    """Return half the side of the magnifier [m]: the 99 % ellipse, and what lies not much farther out."""
    ellipse_m = fix.ellipse(ELLIPSE_PROBABILITIES[-1]).semi_major_m
    level_m = None if fix.integrity is None else fix.integrity.protection_level_m
    near = [math.hypot(place.north_m, place.east_m) for place in scene.places] + [level_m or 0.0]
    return 1.35 * max([ellipse_m, *(distance for distance in near if distance < 3.0 * ellipse_m)])


def _heading(parent: ET.Element, close: View, fix: Fix) -> None:
    x, y = close.box.centre
    add(parent, "path", d=path([(x - 5.0, y), (x + 5.0, y)]), stroke=OWN, stroke_width=1.5)
    add(parent, "path", d=path([(x, y - 5.0), (x, y + 5.0)]), stroke=OWN, stroke_width=1.5)
    if fix.heading_deg is not None:
        turn = f"rotate({fix.heading_deg:.3f} {x:.2f} {y:.2f})"
        add(parent, "path", d=path([(x, y), (x, y - close.box.height)]), transform=turn, stroke=OWN, stroke_opacity=0.5)


def _places(parent: ET.Element, close: View, scene: Scene, view: View) -> None:
    """Draw the other places; one beyond the magnifier, yet hidden under own ship in the picture, at its edge."""
    box = close.box
    inside = Box(box.x + 8.0, box.y + 26.0, box.width - 16.0, box.height - 62.0)
    labels = Labels(Box(box.x, box.y + 20.0, box.width, box.height - 50.0), [box_around(*box.centre, 8.0)])
    for place in scene.places:
        distance_m = math.hypot(place.north_m, place.east_m)
        x, y = close.point(place.north_m, place.east_m)
        caption = place.caption
        if not inside.holds(x, y):
            if distance_m * view.units_per_m > _HIDDEN:
                continue
            x, y = _at_edge(inside, x, y)
            caption = f"{caption}, {words.short_distance(distance_m)} this way"
        symbols.place(parent, x, y, place.kind)
        labels.take(box_around(x, y, 6.0))
        labels.put(parent, x, y, caption, size=9.5, fill=PLACE[place.kind], clear=3.0)


def _at_edge(inside: Box, x: float, y: float) -> tuple[float, float]:
    """Return where the line from the middle of a box to a point outside leaves it."""
    middle_x, middle_y = inside.centre
    share = min(
        inside.width / 2.0 / max(abs(x - middle_x), 1e-9),
        inside.height / 2.0 / max(abs(y - middle_y), 1e-9),
    )
    return middle_x + share * (x - middle_x), middle_y + share * (y - middle_y)


def _nearest_corner(box: Box, view: View) -> tuple[float, float]:
    x, y = view.point(0.0, 0.0)
    corners = [(cx, cy) for cx in (box.x, box.x + box.width) for cy in (box.y, box.y + box.height)]
    return min(corners, key=lambda corner: math.hypot(corner[0] - x, corner[1] - y))
