"""Where things are put: the layouts of a group - uniform, anchorage, lane, buoyed channel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.simulation.settings import TrafficGroup
from navfix.types import FloatArray

_ANCHOR_TRIES = 200


@dataclass(frozen=True, slots=True)
class Placement:
    """Where one member of a group starts, in the plane of the stage; ``anchored`` ones swing about that point."""

    north_m: float
    east_m: float
    course_deg: float
    speed_mps: float
    anchored: bool = False


def place(group: TrafficGroup, rng: np.random.Generator) -> list[Placement]:
    """Return ``group.count`` placements of the group's layout."""
    layouts = {"uniform": _uniform, "anchorage": _anchorage, "lane": _lane, "buoy_channel": _buoy_channel}
    return layouts[group.layout](group, rng)


def _speed(group: TrafficGroup, rng: np.random.Generator) -> float:
    return float(rng.uniform(group.speed_min_mps, group.speed_max_mps))


def _disc_point(group: TrafficGroup, rng: np.random.Generator) -> FloatArray:
    """Return a point (north, east) uniform over the ring between the two radii, about the group's centre."""
    radius_m = math.sqrt(rng.uniform(group.inner_radius_m**2, group.radius_m**2))
    angle_rad = rng.uniform(0.0, 2.0 * math.pi)
    return np.array([group.north_m + radius_m * math.cos(angle_rad), group.east_m + radius_m * math.sin(angle_rad)])


def _along(group: TrafficGroup, along_m: float, starboard_m: float) -> tuple[float, float]:
    """Return (north, east) of a point given along the group's axis and to starboard of it."""
    axis = math.radians(group.axis_deg)
    north = group.north_m + along_m * math.cos(axis) - starboard_m * math.sin(axis)
    return north, group.east_m + along_m * math.sin(axis) + starboard_m * math.cos(axis)


def _uniform(group: TrafficGroup, rng: np.random.Generator) -> list[Placement]:
    points = [_disc_point(group, rng) for _ in range(group.count)]
    return [Placement(float(n), float(e), float(rng.uniform(0.0, 360.0)), _speed(group, rng)) for n, e in points]


def _anchorage(group: TrafficGroup, rng: np.random.Generator) -> list[Placement]:
    """Anchors at least ``spacing_m`` apart as long as the disc has room (200 tries each), heads into the wind."""
    anchors: list[FloatArray] = []
    for _ in range(group.count):
        candidate = _disc_point(group, rng)
        for _ in range(_ANCHOR_TRIES):
            if all(float(np.hypot(*(candidate - other))) >= group.spacing_m for other in anchors):
                break
            candidate = _disc_point(group, rng)
        anchors.append(candidate)
    heads_deg = group.axis_deg + rng.normal(0.0, 12.0, group.count)
    return [
        Placement(float(n), float(e), float(head), 0.0, True) for (n, e), head in zip(anchors, heads_deg, strict=True)
    ]


def _lane(group: TrafficGroup, rng: np.random.Generator) -> list[Placement]:
    """Two-way traffic: each direction on its own half, to starboard of the axis as seen by the ship."""
    placements = []
    for index in range(group.count):
        reverse = index % 2 == 1
        along_m = float(rng.uniform(-group.length_m / 2.0, group.length_m / 2.0))
        starboard_m = float(rng.uniform(0.1, 0.9)) * group.width_m / 2.0
        north, east = _along(group, along_m, -starboard_m if reverse else starboard_m)
        course_deg = group.axis_deg + (180.0 if reverse else 0.0) + float(rng.normal(0.0, 2.0))
        placements.append(Placement(north, east, course_deg, _speed(group, rng)))
    return placements


def _buoy_channel(group: TrafficGroup, rng: np.random.Generator) -> list[Placement]:
    """Pairs of marks along the axis; an odd one out stands alone at the end."""
    pairs = math.ceil(group.count / 2)
    placements = []
    for index in range(group.count):
        jitter_along, jitter_across = rng.normal(0.0, 1.0, 2) * group.irregularity_m
        along_m = (index // 2 - (pairs - 1) / 2.0) * group.spacing_m + float(jitter_along)
        across_m = (1.0 if index % 2 else -1.0) * group.width_m / 2.0 + float(jitter_across)
        placements.append(Placement(*_along(group, along_m, across_m), group.axis_deg, 0.0))
    return placements
