"""A sketch of an adjusted case: own ship, marks, lines of sight, and the confidence ellipse, enlarged."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from html import escape

import numpy as np

from navfix.adjustment.case import Case
from navfix.geodesy import LocalPlane
from navfix.report import words
from navfix.types import Fix, FloatArray, PlanePosition, Position

_SIZE, _MARGIN = 480.0, 95.0
_ELLIPSE_PX = 45.0  # the semi-major axis at most
_STEPS = (1.0, 2.0, 5.0)


def sketch(case: Case, fix: Fix, state: Mapping[str, str]) -> str:
    """Return an SVG with north up; ``state`` by mark label: "" used, "damped" or "out"."""
    places = np.array([_from_own(fix, mark.position) for mark in case.marks])
    labels = [mark.label for mark in case.marks]
    low, high = np.vstack([places, [0.0, 0.0]]).min(axis=0), np.vstack([places, [0.0, 0.0]]).max(axis=0)
    per_m = (_SIZE - 2.0 * _MARGIN) / max(float((high - low).max()), 1.0)
    middle = 0.5 * (low + high)

    def xy(north_east: FloatArray) -> tuple[float, float]:
        north, east = (north_east - middle) * per_m
        return _SIZE / 2.0 + float(east), _SIZE / 2.0 - float(north)

    parts = [*_sights(places, labels, state, xy(np.zeros(2)), [xy(place) for place in places])]
    parts += [*_ellipse(fix, xy(np.zeros(2)), per_m), *_scale(per_m)]
    return f'<svg viewBox="0 0 {_SIZE:.0f} {_SIZE:.0f}" role="img">\n' + "\n".join(parts) + "\n</svg>\n"


def _from_own(fix: Fix, place: Position | PlanePosition) -> FloatArray:
    own = fix.position
    if isinstance(own, PlanePosition) and isinstance(place, PlanePosition):
        return np.array([place.north_m - own.north_m, place.east_m - own.east_m])
    assert isinstance(own, Position)  # a case has one frame
    assert isinstance(place, Position)
    return LocalPlane(own).to_plane(place)


def _sights(
    places: FloatArray,
    labels: list[str],
    state: Mapping[str, str],
    own: tuple[float, float],
    ends: list[tuple[float, float]],
) -> Iterator[str]:
    for label, (x, y) in zip(labels, ends, strict=True):
        name = f"sight {state.get(label, 'out')}".strip()
        yield f'<line class="{name}" x1="{own[0]:.1f}" y1="{own[1]:.1f}" x2="{x:.1f}" y2="{y:.1f}"/>'
        yield f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="4"/>'
        anchor, shift = ("end", -7.0) if x < own[0] else ("start", 7.0)  # away from own ship: off the lines
        below = 13.0 if y > own[1] else -5.0
        yield f'<text x="{x + shift:.1f}" y="{y + below:.1f}" text-anchor="{anchor}">{escape(_short(label))}</text>'


def _short(label: str) -> str:
    return label if len(label) <= 16 else label[:15] + "…"


def _ellipse(fix: Fix, own: tuple[float, float], per_m: float) -> Iterator[str]:
    """Yield the 95 % ellipse, enlarged by 1, 2 or 5 times a power of ten to be seen."""
    ellipse = fix.ellipse(0.95)
    factor = _round_below(_ELLIPSE_PX / max(ellipse.semi_major_m * per_m, 1e-9))
    rx, ry = (axis * per_m * factor for axis in (ellipse.semi_major_m, ellipse.semi_minor_m))
    turn = ellipse.azimuth_deg - 90.0
    place = f'cx="{own[0]:.1f}" cy="{own[1]:.1f}" rx="{rx:.1f}" ry="{ry:.1f}"'
    yield f'<ellipse class="ellipse" {place} transform="rotate({turn:.1f} {own[0]:.1f} {own[1]:.1f})"/>'
    yield f'<circle class="ellipse" cx="{own[0]:.1f}" cy="{own[1]:.1f}" r="2"/>'
    size = "in scale" if factor == 1.0 else f"{factor:g} times enlarged"
    yield f'<text x="8" y="{_SIZE - 26.0:.0f}">ellipse 95 %, {size}</text>'


def _scale(per_m: float) -> Iterator[str]:
    length_m = _round_below(120.0 / per_m)
    x, y = _SIZE - 16.0, _SIZE - 14.0
    yield f'<line class="frame" x1="{x - length_m * per_m:.1f}" y1="{y:.1f}" x2="{x:.1f}" y2="{y:.1f}"/>'
    yield f'<text x="{x:.1f}" y="{y - 5.0:.1f}" text-anchor="end">{words.distance(length_m)}</text>'
    yield '<path class="frame" fill="none" d="M 20 48 V 16 M 15 24 L 20 14 L 25 24"/><text x="29" y="26">N</text>'


def _round_below(value: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in _STEPS if step * power <= value * (1.0 + 1e-9))
