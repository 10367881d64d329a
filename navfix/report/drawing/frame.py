"""What stands around the data: range rings, scale bar, north arrow, latitude and longitude, title and legend."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from xml.etree import ElementTree as ET

from navfix.geodesy import direct
from navfix.report.drawing.labels import Labels
from navfix.report.drawing.view import GRID, INK, MUTED, OWN, Box, View, add, nice, path, text, text_width
from navfix.types import Position
from navfix.units import NM_M

_RING_STEPS_NM = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 6.0, 12.0, 24.0, 48.0)
_TICK_MINUTES = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0)


# ------------------------------------------------------------------------------------------------------ range rings


def ring_step_m(reach_m: float) -> tuple[float, str]:
    """Return the distance of the range rings [m] and its word, so that three to six rings fill ``reach_m``."""
    if reach_m < 3.0 * _RING_STEPS_NM[0] * NM_M:
        step_m = nice(reach_m / 3.0)
        return step_m, "m"
    step = max((step for step in _RING_STEPS_NM if step * NM_M * 3.0 <= reach_m), default=_RING_STEPS_NM[0])
    return step * NM_M, "NM"


def range_rings(parent: ET.Element, view: View) -> list[tuple[float, str]]:
    """Draw the range rings about own ship; return (radius [m], caption) of each."""
    box = view.box
    corners = [view.metres(x, y) for x in (box.x, box.x + box.width) for y in (box.y, box.y + box.height)]
    reach_m = max(math.hypot(north, east) for north, east in corners)
    nearest_m = max(min(math.hypot(north, east) for north, east in corners) * 0.9, reach_m / 4.0)
    step_m, unit = ring_step_m(nearest_m)
    x, y = view.point(0.0, 0.0)
    rings = []
    for number in range(1, int(reach_m / step_m) + 1):
        add(
            parent, "circle", cx=x, cy=y, r=number * step_m * view.units_per_m, fill="none", stroke=GRID, stroke_width=1
        )
        amount = number * step_m / (NM_M if unit == "NM" else 1.0)
        rings.append((number * step_m, f"{amount:g} {unit}"))
    return rings


def ring_captions(parent: ET.Element, view: View, rings: Sequence[tuple[float, str]], labels: Labels) -> None:
    """Write each ring's distance on the ring, at the first azimuth where there is room."""
    for radius_m, caption in rings:
        width = text_width(caption, 10.5)
        for azimuth_deg in (
            90,
            270,
            75,
            105,
            255,
            285,
            60,
            120,
            240,
            300,
            45,
            135,
            225,
            315,
            0,
            180,
            20,
            340,
            160,
            200,
        ):
            azimuth_rad = math.radians(azimuth_deg)
            x, y = view.point(radius_m * math.cos(azimuth_rad), radius_m * math.sin(azimuth_rad))
            box = Box(x - width / 2.0, y - 6.0, width, 12.0)
            if labels.free(box):
                text(parent, box.x, y + 3.8, caption, size=10.5, fill=MUTED)
                labels.take(box)
                break


# ---------------------------------------------------------------------------------------------- latitude, longitude


def position_ticks(parent: ET.Element, view: View, origin: Position, labels: Labels) -> None:
    """Tick latitude along the left edge and longitude along the lower edge; near a pole neither means anything."""
    if abs(origin.lat_deg) > 85.0:
        return
    box = view.box
    bottom, top = box.y + box.height, box.y
    latitude = _along(origin, lambda share: view.metres(box.x, bottom + share * (top - bottom)), longitude=False)
    for share, caption in _ticks(latitude, 2, "NS"):
        y = bottom + share * (top - bottom)
        add(parent, "line", x1=box.x, y1=y, x2=box.x + 8.0, y2=y, stroke=INK, stroke_width=1)
        _tick_caption(parent, box.x + 11.0, y + 3.5, caption, labels)
    longitude = _along(origin, lambda share: view.metres(box.x + share * box.width, bottom), longitude=True)
    for share, caption in _ticks(longitude, 3, "EW"):
        x = box.x + share * box.width
        add(parent, "line", x1=x, y1=bottom, x2=x, y2=bottom - 8.0, stroke=INK, stroke_width=1)
        _tick_caption(parent, x - text_width(caption, 9.5) / 2.0, bottom - 11.0, caption, labels)


def _tick_caption(parent: ET.Element, left: float, baseline: float, caption: str, labels: Labels) -> None:
    room = Box(left, baseline - 9.0, text_width(caption, 9.5), 11.0)
    if labels.free(room):
        text(parent, left, baseline, caption, size=9.5, fill=MUTED)
        labels.take(room)


def _along(
    origin: Position, place_m: Callable[[float], tuple[float, float]], *, longitude: bool
) -> list[tuple[float, float]]:
    """Return (share, latitude or longitude [deg]) along an edge; longitudes are continuous about the origin."""
    found = []
    for step in range(33):
        north_m, east_m = place_m(step / 32.0)
        position = direct(origin, math.degrees(math.atan2(east_m, north_m)), math.hypot(north_m, east_m))
        east_deg = origin.lon_deg + (position.lon_deg - origin.lon_deg + 180.0) % 360.0 - 180.0
        found.append((step / 32.0, east_deg if longitude else position.lat_deg))
    return found


def _ticks(along: Sequence[tuple[float, float]], width: int, sides: str) -> Iterator[tuple[float, str]]:
    """Yield (share, caption) of round values between the ends of an edge."""
    low, high = along[0][1], along[-1][1]
    step_deg = next((step for step in _TICK_MINUTES if (high - low) * 60.0 / step <= 7.0), 60.0) / 60.0
    for number in range(math.ceil(low / step_deg), math.floor(high / step_deg) + 1):
        value = number * step_deg
        for (share, here), (next_share, there) in pairwise(along):
            if here <= value < there:
                yield share + (value - here) / (there - here) * (next_share - share), _caption(value, width, sides)
                break


def _caption(value_deg: float, width: int, sides: str) -> str:
    wrapped = (value_deg + 180.0) % 360.0 - 180.0
    hundredths = round(abs(wrapped) * 6000.0)
    whole, minutes = divmod(hundredths, 6000)
    shown = f"{minutes // 100:02d}" if minutes % 100 == 0 else f"{minutes / 100.0:05.2f}"
    return f"{whole:0{width}d}°{shown}'{sides[wrapped < 0.0]}"


# ---------------------------------------------------------------------------------------- scale bar and north arrow


def scale_bar(parent: ET.Element, view: View, x: float, y: float, longest: float) -> Box:
    """Draw a scale bar whose lower left corner is (x, y); return the room it takes."""
    longest_m = longest / view.units_per_m
    nautical = longest_m >= 0.1 * NM_M
    length_m = nice(longest_m / NM_M) * NM_M if nautical else nice(longest_m)
    length = length_m * view.units_per_m
    for part in range(4):
        fill = INK if part % 2 == 0 else "#ffffff"
        add(parent, "rect", x=x + part * length / 4.0, y=y - 7.0, width=length / 4.0, height=7, fill=fill, stroke=INK)
    caption = f"{length_m / NM_M:g} NM = {length_m:.0f} m" if nautical else f"{length_m:g} m"
    text(parent, x, y - 12.0, caption, size=12.0)
    return Box(x - 4.0, y - 28.0, max(length, text_width(caption, 12.0)) + 8.0, 34.0)


def north_arrow(parent: ET.Element, x: float, y: float, *, head_up: bool) -> Box:
    """Draw the arrow that points up: N for north, or the radar's zero mark where north is unknown."""
    group = add(parent, "g", id="north-arrow")
    add(group, "path", d=path([(x, y - 24), (x + 9, y + 14), (x, y + 7)], closed=True), fill=OWN, stroke=OWN)
    add(group, "path", d=path([(x, y - 24), (x - 9, y + 14), (x, y + 7)], closed=True), fill="#ffffff", stroke=OWN)
    caption = "zero mark" if head_up else "N"
    anchor = "start" if head_up else "middle"
    left, size = (x - 9.0, 12.0) if head_up else (x, 15.0)
    text(group, left, y - 29.0, caption, size=size, font_weight="bold", text_anchor=anchor)
    return Box(x - 16.0, y - 46.0, 110.0 if head_up else 32.0, 64.0)


# ------------------------------------------------------------------------------------------------- title and legend


def title(parent: ET.Element, left: Sequence[str], right: Sequence[tuple[str, str]], width: float) -> None:
    """Write the title's lines on the left and (text, colour) on the right."""
    for number, line in enumerate(left):
        size, weight = (17.0, "bold") if number == 0 else (12.5, "normal")
        text(parent, 14.0, 24.0 + 20.0 * number, line, size=size, font_weight=weight, halo=False)
    for number, (line, colour) in enumerate(right):
        y = 24.0 + 20.0 * number
        text(parent, width - 14.0, y, line, size=12.5, fill=colour, halo=False, text_anchor="end", font_weight="bold")


def legend(
    parent: ET.Element, box: Box, entries: Sequence[tuple[str, Callable[[ET.Element, float, float], object]]]
) -> None:
    """Draw the legend in rows of five: each entry draws its own symbol about a point."""
    columns = 5
    for number, (caption, draw) in enumerate(entries):
        row, column = divmod(number, columns)
        x, y = box.x + 22.0 + column * (box.width - 10.0) / columns, box.y + 20.0 + 24.0 * row
        draw(parent, x, y)
        text(parent, x + 20.0, y + 4.0, caption, size=11.0, halo=False)
