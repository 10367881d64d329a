"""From the AIS antenna to the echo: the centre of the hull, and the step to the side of it that own ship sees."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from navfix.catalog import HullModel, echo_model, hull_model_of
from navfix.geodesy import direct, inverse
from navfix.types import Epoch, Hull, IntArray, Mark, Position

ANTENNA_ANYWHERE = 1.0 / math.sqrt(12.0)  # sigma of a place that may be anywhere along a hull, as a share of the length
_ASPECTS_RAD = tuple(math.radians(2.5 + 5.0 * k) for k in range(18))  # a hull looks the same from all four quarters


@dataclass(frozen=True, slots=True)
class Size:
    """A hull as far as it is known: size, the step (forward, starboard) from antenna to centre, 1 sigma of each [m].

    A length of 0 is a point: an aid to navigation.
    """

    length_m: float
    beam_m: float
    forward_m: float = 0.0
    starboard_m: float = 0.0
    length_sigma_m: float = 0.0
    forward_sigma_m: float = 0.0


@dataclass(frozen=True, slots=True)
class HullShift:
    """A step (north, east) [m] from antenna to hull centre and the sigma per axis [m] of the echo about it."""

    north_m: float
    east_m: float
    sigma_m: float


@dataclass(frozen=True, slots=True)
class Echo:
    """Where an echo lies: ``depth_m`` from the hull's centre towards own ship; 1 sigma along and across that line."""

    depth_m: float
    along_sigma_m: float
    across_sigma_m: float


def size_of(
    hull: Hull | None, *, aid: bool = False, ais_class: str | None = None, ship_type: int | None = None
) -> Size:
    """Return the size that AIS tells, or the one to expect of a ship of this class and type.

    AIS gives zero for both bow and port distance when only the size is known and not where the antenna stands
    (ITU-R M.1371-5, 3.3.2): then the antenna is taken as the middle, with a larger sigma.
    """
    if hull is not None and hull.length_m > 0.0:
        if hull.bow_m == 0.0 and hull.port_m == 0.0:
            return Size(hull.length_m, hull.beam_m, forward_sigma_m=ANTENNA_ANYWHERE * hull.length_m)
        return Size(hull.length_m, hull.beam_m, hull.centre_forward_m, hull.centre_starboard_m)
    return Size(0.0, 0.0) if aid else _expected(hull_model_of(ais_class, ship_type))


def hull_shift(size: Size, heading_deg: float | None) -> HullShift:
    """Return the step from the AIS antenna to the middle of the hull; the sigma holds for a view from anywhere."""
    variance = _mean_square_m2(size) + _antenna_variance_m2(size, heading_deg)
    if heading_deg is None:
        return HullShift(0.0, 0.0, math.sqrt(variance))
    heading_rad = math.radians(heading_deg)
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    return HullShift(
        size.forward_m * cos - size.starboard_m * sin,
        size.forward_m * sin + size.starboard_m * cos,
        math.sqrt(variance),
    )


@lru_cache(maxsize=4096)
def echo(size: Size, aspect_rad: float | None) -> Echo:
    """Return where the echo of a hull lies, seen from ``aspect_rad`` off its bow; None: from anywhere, the mean.

    The visible side of a convex hull has the mean depth area / (2 width) over its width across the line of sight,
    eq. (8.1), for a box; how far the nearest edge (8.2) lies before it enters the sigma.
    """
    if size.length_m <= 0.0:
        return Echo(0.0, 0.0, 0.0)
    if aspect_rad is None:
        return _from_anywhere(size)
    model = echo_model()
    half_length_m, half_beam_m = size.length_m / 2.0, max(size.beam_m / 2.0, 0.5)
    cos, sin = abs(math.cos(aspect_rad)), abs(math.sin(aspect_rad))
    half_width_m = half_length_m * sin + half_beam_m * cos
    depth_m = half_length_m * half_beam_m / half_width_m  # eq. (8.1)
    nearest_m = half_length_m * cos + half_beam_m * sin  # eq. (8.2)
    along_m = math.hypot(
        model.depth_sigma_share * depth_m, model.edge_sigma_share * (nearest_m - depth_m), depth_m * _doubt(size)
    )  # eq. (8.3)
    across_m = model.across_sigma_share * 2.0 * half_width_m * math.hypot(1.0, _doubt(size))
    return Echo(depth_m, along_m, across_m)


def facing(epoch: Epoch, own: Position, pairs: IntArray | None = None) -> Epoch:
    """Move marks from the centre of their hulls to the side that own ship sees, and replace their sigmas.

    Parameters
    ----------
    own : where own ship is, to some hundred metres
    pairs : (k, 2) target and mark: only these marks are moved, and where the target is the centre of a hull (by its
        outline) the mark stays there, with what is not known of the antenna's place; None: all marks

    Marks with ``hull_sigma_m`` 0 stay: they are where their echo is expected. Doing it twice changes nothing.
    """
    marks = list(epoch.marks)
    if pairs is None:
        return replace(epoch, marks=tuple(_seen_from(mark, own) for mark in marks))
    for target, index in pairs.tolist():
        centre = epoch.targets[target].point == "hull_centre"
        marks[index] = at_centre(marks[index]) if centre else _seen_from(marks[index], own)
    return replace(epoch, marks=tuple(marks))


def at_centre(mark: Mark) -> Mark:
    """Return a mark for a target whose hull centre was measured: what stays of the hull is the antenna's place."""
    if mark.hull_sigma_m <= 0.0:
        return mark
    return _with_hull_variance(mark, mark.position, _antenna_variance_m2(_size_of_mark(mark), mark.heading_deg))


def _seen_from(mark: Mark, own: Position) -> Mark:
    if mark.hull_sigma_m <= 0.0:
        return mark
    size = _size_of_mark(mark)
    range_m, towards_own_deg = inverse(mark.position, own)
    aspect_rad = None if mark.heading_deg is None else math.radians(towards_own_deg - mark.heading_deg)
    seen = echo(size, aspect_rad)
    place = direct(mark.position, towards_own_deg, min(seen.depth_m, range_m / 2.0))
    variance = (seen.along_sigma_m**2 + seen.across_sigma_m**2) / 2.0
    return _with_hull_variance(mark, place, variance + _antenna_variance_m2(size, mark.heading_deg))


def _with_hull_variance(mark: Mark, place: Position, variance_m2: float) -> Mark:
    rest_m2 = mark.sigma_m**2 - mark.hull_sigma_m**2
    return replace(mark, position=place, sigma_m=math.sqrt(max(rest_m2, 0.0) + variance_m2), hull_sigma_m=0.0)


def _size_of_mark(mark: Mark) -> Size:
    return size_of(mark.hull, aid=mark.kind != "ship", ais_class=mark.ais_class, ship_type=mark.ship_type)


def _expected(model: HullModel) -> Size:
    return Size(
        length_m=model.length_m,
        beam_m=model.beam_m,
        forward_m=model.centre_forward_share * model.length_m,
        length_sigma_m=model.length_sigma_m,
        forward_sigma_m=model.centre_forward_sigma_share * math.hypot(model.length_m, model.length_sigma_m),
    )


def _doubt(size: Size) -> float:
    """Return the relative sigma of the size."""
    return size.length_sigma_m / size.length_m


def _antenna_variance_m2(size: Size, heading_deg: float | None) -> float:
    """Return the variance per axis [m2] of the hull's centre: place of the antenna, and an unknown heading."""
    variance = size.forward_sigma_m**2 / 2.0
    return variance if heading_deg is not None else variance + (size.forward_m**2 + size.starboard_m**2) / 2.0


@lru_cache(maxsize=4096)
def _mean_square_m2(size: Size) -> float:
    """Return the mean square per axis [m2] of the step from centre to echo, over views from all around."""
    seen = [echo(size, aspect_rad) for aspect_rad in _ASPECTS_RAD]
    return sum(e.depth_m**2 + e.along_sigma_m**2 + e.across_sigma_m**2 for e in seen) / (2.0 * len(seen))


def _from_anywhere(size: Size) -> Echo:
    """Return the mean over all aspects; what the depth varies with the aspect is in the sigma."""
    seen = [echo(size, aspect_rad) for aspect_rad in _ASPECTS_RAD]
    depth_m = sum(e.depth_m for e in seen) / len(seen)
    along_m2 = sum((e.depth_m - depth_m) ** 2 + e.along_sigma_m**2 for e in seen) / len(seen)
    across_m2 = sum(e.across_sigma_m**2 for e in seen) / len(seen)
    return Echo(depth_m, math.sqrt(along_m2), math.sqrt(across_m2))
