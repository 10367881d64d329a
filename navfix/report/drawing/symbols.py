"""Symbols after the manner of navigation displays: echoes, AIS triangles, diamonds of aids, own ship, ellipses."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree as ET

from navfix.report.drawing.view import ECHO, ELLIPSE, MARK, MUTED, OUTLIER, OWN, PLACE, STICK, View, add, path
from navfix.report.scene import PlaceKind, SceneTarget, Status, Stick
from navfix.types import Ellipse, MarkKind

MARK_COLOUR = {"matched": MARK, "outlier": OUTLIER, "unmatched": MUTED}
_BEAM_DEG = 1.2  # width of the echo symbol as the antenna smears it


def echo(parent: ET.Element, view: View, target: SceneTarget) -> None:
    """Draw a radar target as a transparent echo: wide across the bearing, thin along the range."""
    x, y = view.point(target.north_m, target.east_m)
    across = max(5.0, math.radians(_BEAM_DEG) * target.range_m * view.units_per_m / 2.0)
    echo_at(parent, x, y, across, target.bearing_deg, OUTLIER if target.status == "outlier" else ECHO)


def echo_at(parent: ET.Element, x: float, y: float, across: float, bearing_deg: float, colour: str = ECHO) -> None:
    """Draw an echo at a point of the picture, ``across`` units to both sides."""
    turn = f"rotate({bearing_deg:.2f} {x:.2f} {y:.2f})"
    look: dict[str, Any] = {
        "fill": colour,
        "fill_opacity": 0.45,
        "stroke": colour,
        "stroke_opacity": 0.8,
        "stroke_width": 0.8,
    }
    add(parent, "ellipse", cx=x, cy=y, rx=across, ry=3.6, transform=turn, **look)


def mark(
    parent: ET.Element, x: float, y: float, kind: MarkKind, status: Status, pointing_deg: float | None = None
) -> ET.Element:
    """Draw a mark: triangle for a ship (pointing ahead), diamond for an aid, ring with a dot from the chart."""
    colour, thin = MARK_COLOUR[status], status == "unmatched"
    group = add(
        parent,
        "g",
        transform=f"translate({x:.2f} {y:.2f})",
        stroke=colour,
        stroke_width=1.0 if thin else 1.6,
        fill="none",
        opacity=0.75 if thin else None,
    )
    if kind == "ship":
        turn = None if pointing_deg is None else f"rotate({pointing_deg:.1f})"
        add(group, "path", d="M0,-8 L4.6,6 L-4.6,6 Z", transform=turn)
        if pointing_deg is not None and not thin:
            add(group, "path", d="M0,-8 L0,-16", transform=turn)
    elif kind == "aton":
        add(group, "path", d="M0,-7 L7,0 L0,7 L-7,0 Z M-3,0 L3,0 M0,-3 L0,3")
    else:
        add(group, "circle", r=5.5)
        add(group, "circle", r=1.4, fill=colour)
    return group


def own_ship(parent: ET.Element, view: View, heading_deg: float | None, reach: float) -> None:
    """Draw own ship as two rings with a heading line of ``reach`` units and a short beam line."""
    x, y = view.point(0.0, 0.0)
    group = add(parent, "g", id="own-ship", stroke=OWN, fill="none", stroke_width=1.8)
    if heading_deg is not None:
        turn = f"rotate({heading_deg:.3f} {x:.2f} {y:.2f})"
        add(group, "path", id="heading-line", d=path([(x, y), (x, y - reach)]), transform=turn, stroke_width=1.6)
        add(group, "path", d=path([(x - 12.0, y), (x + 12.0, y)]), transform=turn, stroke_width=1.6)
    add(group, "circle", cx=x, cy=y, r=8.0)
    add(group, "circle", cx=x, cy=y, r=4.5)


def confidence_ellipse(parent: ET.Element, view: View, ellipse: Ellipse) -> None:
    """Draw a confidence ellipse about own ship: the 95 % one solid, wider ones dashed."""
    x, y = view.point(0.0, 0.0)
    add(
        parent,
        "ellipse",
        cx=x,
        cy=y,
        rx=ellipse.semi_minor_m * view.units_per_m,
        ry=ellipse.semi_major_m * view.units_per_m,
        transform=f"rotate({ellipse.azimuth_deg:.3f} {x:.2f} {y:.2f})",
        fill=ELLIPSE if ellipse.probability < 0.97 else "none",
        fill_opacity=0.12,
        stroke=ELLIPSE,
        stroke_width=1.4,
        stroke_dasharray=None if ellipse.probability < 0.97 else "5 3",
        class_=f"ellipse-{100.0 * ellipse.probability:.0f}",
    )


def residual(parent: ET.Element, view: View, stick: Stick, factor: float) -> None:
    """Draw a residual stick from the mark towards the echo, lengthened by ``factor``; an outlier dashed, to scale."""
    start = view.point(stick.north_m, stick.east_m)
    scale = 1.0 if stick.row.outlier else factor
    end = view.point(stick.north_m + scale * stick.to_north_m, stick.east_m + scale * stick.to_east_m)
    residual_at(parent, start, end, outlier=stick.row.outlier)


def residual_at(parent: ET.Element, start: tuple[float, float], end: tuple[float, float], *, outlier: bool) -> None:
    """Draw a stick between two points of the picture."""
    if outlier:
        add(parent, "path", d=path([start, end]), stroke=OUTLIER, stroke_width=1.8, stroke_dasharray="6 4", fill="none")
        return
    add(parent, "path", d=path([start, end]), stroke=STICK, stroke_width=1.8, fill="none")
    add(parent, "circle", cx=end[0], cy=end[1], r=2.0, fill=STICK)


def place(parent: ET.Element, x: float, y: float, kind: PlaceKind) -> None:
    """Draw another place: x plain mean, + truth, square GNSS, open ring alternative."""
    look: dict[str, Any] = {"stroke": PLACE[kind], "stroke_width": 2.0, "fill": "none"}
    if kind == "plain_mean":
        add(parent, "path", d=f"M{x - 5:.2f},{y - 5:.2f} l10,10 m0,-10 l-10,10", **look)
    elif kind == "truth":
        add(parent, "path", d=f"M{x - 7:.2f},{y:.2f} l14,0 m-7,-7 l0,14", **look)
    elif kind == "gnss":
        add(parent, "rect", x=x - 5.0, y=y - 5.0, width=10, height=10, **look)
    else:
        add(parent, "circle", cx=x, cy=y, r=5.0, stroke_dasharray="2 2", **look)
