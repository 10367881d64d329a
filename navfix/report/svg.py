"""The fix as a picture like a chart: own ship, ellipses, marks, echoes, residual sticks; georeferenced SVG.

The picture is azimuthal equidistant about the fix (true distances and bearings from own ship), north up. ``<metadata>``
carries the corners and the scale, so that a chart display can lay it over its own chart.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree as ET

from navfix.report import words
from navfix.report.answer import Answer
from navfix.report.drawing import frame, inset, symbols, title
from navfix.report.drawing.georeference import georeference
from navfix.report.drawing.labels import Labels
from navfix.report.drawing.view import (
    FONT,
    INK,
    MUTED,
    OUTLIER,
    OWN,
    PAPER,
    PLACE,
    Box,
    View,
    add,
    box_around,
    nice,
    view_of,
)  # fmt: skip
from navfix.report.json_parts import ELLIPSE_PROBABILITIES
from navfix.report.scene import Scene, scene_of
from navfix.report.tables import clipped
from navfix.types import Fix, Position

WIDTH, HEIGHT = 1000.0, 1000.0
MAP = Box(0.0, 76.0, WIDTH, 836.0)
LEGEND = Box(0.0, 914.0, WIDTH, 86.0)
_STICK_LENGTH = 34.0  # what the larger residuals (90 % of them are shorter) measure in the picture


def svg_text(answer: Answer, *, paper: bool = True) -> str:
    """Return the picture of an answer as SVG; without ``paper`` its background is transparent (to lie over a chart)."""
    scene = scene_of(answer)
    view = _view(scene, answer.fix)
    root = ET.Element(
        "svg",
        {
            "xmlns": "http://www.w3.org/2000/svg",
            "viewBox": f"0 0 {WIDTH:.0f} {HEIGHT:.0f}",
            "width": f"{WIDTH:.0f}",
            "height": f"{HEIGHT:.0f}",
            "font-family": FONT,
        },
    )
    add(root, "title", " ".join(title.lines(answer)[:1]))
    georeference(root, answer, scene, view, MAP)
    if paper:
        add(root, "rect", id="paper", width=WIDTH, height=HEIGHT, fill=PAPER)
    add(add(root, "clipPath", id="map-clip"), "rect", x=MAP.x, y=MAP.y, width=MAP.width, height=MAP.height)
    _map(root, answer, scene, view)
    add(root, "rect", x=MAP.x, y=MAP.y, width=MAP.width, height=MAP.height, fill="none", stroke=INK, stroke_width=1)
    frame.title(add(root, "g", id="title"), title.lines(answer), title.right(answer), WIDTH)
    frame.legend(add(root, "g", id="legend"), LEGEND, list(title.legend(answer, scene, _factor(scene, view))))
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode") + "\n"


# ------------------------------------------------------------------------------------------------------------- map


def _view(scene: Scene, fix: Fix | None) -> View:
    """Return the view of own ship, the targets and their marks; marks far off (gross errors) may lie outside."""
    reach_m = max((target.range_m for target in scene.targets), default=0.0)
    near = [
        (mark.north_m, mark.east_m)
        for mark in scene.marks
        if mark.status != "unmatched" and math.hypot(mark.north_m, mark.east_m) < 1.5 * max(reach_m, 1.0)
    ]
    points = [(0.0, 0.0), *((target.north_m, target.east_m) for target in scene.targets), *near]
    if not scene.targets:
        points += [(place.north_m, place.east_m) for place in scene.places]
    if scene.origin is None:  # the radar's own picture: own ship in the middle
        points = [(side * reach_m, side * reach_m) for side in (-1.0, 1.0)] if reach_m > 0.0 else points
    ellipse_m = 1.0 if fix is None else 3.0 * fix.ellipse(ELLIPSE_PROBABILITIES[-1]).semi_major_m
    return view_of(points, MAP, margin=62.0, smallest_m=max(0.2 * reach_m, ellipse_m))


def _factor(scene: Scene, view: View) -> float:
    """Return the factor that lengthens the residual sticks: 1, 2, 5, 10, ..."""
    lengths_m = sorted(stick.length_m for stick in scene.sticks if not stick.row.outlier)
    if not lengths_m or lengths_m[-1] <= 0.0:
        return 1.0
    typical_m = max(lengths_m[int(0.9 * (len(lengths_m) - 1))], 0.01 * lengths_m[-1])
    return max(1.0, nice(_STICK_LENGTH / (typical_m * view.units_per_m)))


def _map(root: ET.Element, answer: Answer, scene: Scene, view: View) -> None:
    layer = add(root, "g", id="map", clip_path="url(#map-clip)")
    rings = frame.range_rings(add(layer, "g", id="range-rings"), view)
    graticule = add(layer, "g", id="graticule")
    _draw_data(layer, answer.fix, scene, view)
    furniture = add(layer, "g", id="furniture")
    obstacles = _obstacles(scene, view)
    obstacles.append(frame.scale_bar(furniture, view, MAP.x + 24.0, MAP.y + MAP.height - 18.0, 240.0))
    obstacles.append(frame.north_arrow(furniture, MAP.x + 36.0, MAP.y + 56.0, head_up=scene.head_up))
    if answer.fix is not None and inset.needed(answer.fix, view):
        box = inset.corner_with_room(MAP, [view.point(*at) for at in [*_places_of_symbols(scene), (0.0, 0.0)]])
        inset.draw(layer, box, answer.fix, scene, view)
        obstacles.append(box)
    labels = Labels(Box(MAP.x + 4.0, MAP.y + 4.0, MAP.width - 8.0, MAP.height - 8.0), obstacles)
    if isinstance(scene.origin, Position):
        frame.position_ticks(graticule, view, scene.origin, labels)
    _write_labels(add(layer, "g", id="labels"), answer, scene, view, labels)
    frame.ring_captions(add(layer, "g", id="ring-captions"), view, rings, labels)


def _draw_data(layer: ET.Element, fix: Fix | None, scene: Scene, view: View) -> None:
    echoes = add(layer, "g", id="targets")
    for target in scene.targets:
        symbols.echo(echoes, view, target)
    marks = add(layer, "g", id="marks")
    for mark in scene.marks:
        x, y = view.point(mark.north_m, mark.east_m)
        if MAP.holds(x, y, -20.0):
            symbol = symbols.mark(marks, x, y, mark.kind, mark.status, mark.pointing_deg)
            add(symbol, "title", clipped(mark.name, 60))
    sticks = add(layer, "g", id="residuals")
    factor = _factor(scene, view)
    for stick in scene.sticks:
        symbols.residual(sticks, view, stick, factor)
    if fix is not None:
        ellipses = add(layer, "g", id="ellipses")
        for probability in reversed(ELLIPSE_PROBABILITIES):
            symbols.confidence_ellipse(ellipses, view, fix.ellipse(probability))
    places = add(layer, "g", id="places")
    for place in scene.places:
        symbols.place(places, *view.point(place.north_m, place.east_m), place.kind)
    symbols.own_ship(layer, view, scene.heading_deg, 0.25 * MAP.height)


def _places_of_symbols(scene: Scene) -> list[tuple[float, float]]:
    """Return (north, east) [m] of every target and mark."""
    targets = [(target.north_m, target.east_m) for target in scene.targets]
    return targets + [(mark.north_m, mark.east_m) for mark in scene.marks]


def _obstacles(scene: Scene, view: View) -> list[Box]:
    """Return the room that symbols, the heading line and the outliers' sticks take."""
    boxes = [box_around(*view.point(*at), 6.0) for at in _places_of_symbols(scene)]
    x, y = view.point(0.0, 0.0)
    boxes.append(box_around(x, y, 12.0))
    if scene.heading_deg is not None:
        heading_rad = math.radians(scene.heading_deg)
        along = [0.05 * MAP.height * step / 4.0 for step in range(1, 21)]
        boxes += [box_around(x + d * math.sin(heading_rad), y - d * math.cos(heading_rad), 3.0) for d in along]
    for stick in scene.sticks:
        scale = 1.0 if stick.row.outlier else _factor(scene, view)
        for share in (0.25, 0.5, 0.75, 1.0):
            north_m, east_m = (
                stick.north_m + scale * share * stick.to_north_m,
                stick.east_m + scale * share * stick.to_east_m,
            )
            boxes.append(box_around(*view.point(north_m, east_m), 2.5))
    return boxes


def _write_labels(parent: ET.Element, answer: Answer, scene: Scene, view: View, labels: Labels) -> None:
    """Write the labels, what matters most first: what finds no room is left out, outliers never are."""
    x, y = view.point(0.0, 0.0)
    labels.put(parent, x, y, "OWN SHIP", fill=OWN, must=True, clear=13.0, font_weight="bold")
    captions = {stick.row.mark_label: stick for stick in scene.sticks}
    ordered = sorted(scene.marks, key=lambda mark: ("outlier", "matched", "unmatched").index(mark.status))
    for place in scene.places:
        at = view.point(place.north_m, place.east_m)
        if MAP.holds(*at, 10.0) and math.hypot(at[0] - x, at[1] - y) > 12.0:
            labels.put(parent, *at, place.caption, fill=PLACE[place.kind], must=place.kind == "gnss")
    for mark in ordered:
        at = view.point(mark.north_m, mark.east_m)
        if mark.status == "unmatched" or not MAP.holds(*at, 4.0):
            continue
        stick = captions.get(mark.label)
        outlier = mark.status == "outlier"
        caption = mark.name if stick is None else f"{stick.row.target} {mark.name}".strip()
        if outlier and stick is not None:
            caption += f": {words.short_distance(stick.length_m)} off"
        colour = OUTLIER if outlier else INK
        if not labels.put(parent, *at, caption, fill=colour, must=outlier) and stick is not None:
            labels.put(parent, *at, stick.row.target, fill=colour)
    for target in scene.targets:
        if target.status == "unmatched" or not any(stick.row.target == target.label for stick in scene.sticks):
            labels.put(parent, *view.point(target.north_m, target.east_m), target.label, fill="#8a5500")
    if answer.fix is None:
        return
    for mark in ordered:
        at = view.point(mark.north_m, mark.east_m)
        if mark.status == "unmatched" and MAP.holds(*at, 4.0):
            labels.put(parent, *at, mark.name, size=9.0, fill=MUTED)
