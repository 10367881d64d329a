"""Charted objects -> marks: the sigma of a fixed one is tight, that of a floating one its watch circle."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable

from navfix.catalog import ChartModel, chart_model
from navfix.chart.records import ChartObject
from navfix.types import Mark


def marks(objects: Iterable[ChartObject], *, land: bool = False, model: ChartModel | str = "aids") -> tuple[Mark, ...]:
    """Return the marks of charted objects, their labels made unique.

    Parameters
    ----------
    land : conspicuous objects ashore too
    model : sigmas, by name in models/chart or as a record
    """
    chosen = chart_model(model)
    counted: Counter[str] = Counter()
    found = []
    for item in objects:
        if not is_mark(item, land=land):
            continue
        label = _plain_label(item)
        counted[label] += 1
        found.append(
            Mark(
                label=label if counted[label] == 1 else f"{label} #{counted[label]}",
                position=item.position,
                sigma_m=sigma_m(item, chosen),
                kind="charted",
                mmsi=item.mmsi,
                name=item.name,
            )
        )
    return tuple(found)


def is_mark(item: ChartObject, *, land: bool = False) -> bool:
    """Tell whether an object gives an echo of its own that may be matched."""
    role = item.chart_class.role
    return role in ("structure", "equipment") or (role == "land" and land)


def sigma_m(item: ChartObject, model: ChartModel) -> float:
    """Return 1 sigma per axis [m] of where the echo of an object lies about its charted place.

    A sigma of the file stands as it is. A floating mark is anywhere in its watch circle, eq. (C.2); a line or area
    reaches as far as its outline, and its echo lies anywhere on it.
    """
    if item.sigma_m is not None:
        return item.sigma_m
    spread_m = item.extent_m / 2.0
    if item.kind == "floating":
        return math.hypot(model.sinker_sigma_m, watch_circle_m(item.depth_m, model) / 2.0, spread_m)
    base_m = model.land_sigma_m if item.chart_class.role == "land" else model.fixed_sigma_m
    return math.hypot(base_m, spread_m)


def watch_circle_m(depth_m: float | None, model: ChartModel) -> float:
    """Return the radius [m] of the circle in which a mark swings on a taut chain, eq. (C.1)."""
    charted_m = model.default_depth_m if depth_m is None else min(depth_m, model.largest_depth_m)
    water_m = charted_m + model.tide_m
    return water_m * math.sqrt(model.chain_per_depth**2 - 1.0)


def _plain_label(item: ChartObject) -> str:
    """Return the label, told apart from an MMSI, which is the label of an AIS station."""
    return f"chart:{item.label}" if item.label.isdecimal() and len(item.label) == 9 else item.label
