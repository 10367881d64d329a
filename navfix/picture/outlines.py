"""Echo outlines beside a log: reading them, and the centre of the hull that each of them shows."""

from __future__ import annotations

import json
import logging
import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Any, Literal

import numpy as np

from navfix.catalog import OutlineModel, outline_model
from navfix.errors import InputError
from navfix.picture.ellipse import FEWEST_POINTS, FittedEllipse, distances_m, fit_ellipse, fitted_centres
from navfix.types import BearingReference, Epoch, FloatArray, RadarTarget
from navfix.units import wrap_180, wrap_360

_logger = logging.getLogger(__name__)

FEWEST_FOR_EXTENT = 3
OUTLINE_AGE_S = 3.0  # an antenna turn
LONGEST_HULL_M = 500.0
SLENDEREST, BLUNTEST = 0.05, 0.6  # beam over length of hulls
BESIDE_M = 500.0  # an outline farther from its target than this belongs to another one of the same number


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Boundary points of one echo: (n, 2) range [m] and bearing [deg], seen at ``time_s`` [POSIX s]."""

    time_s: float
    target: str
    points: FloatArray
    bearing_reference: BearingReference = "relative"


@dataclass(frozen=True, slots=True)
class HullCentre:
    """The centre of a hull by its outline, with 1 sigma of what the points contribute; ``ellipse`` None: the extent."""

    range_m: float
    bearing_deg: float
    range_sigma_m: float
    bearing_sigma_deg: float
    method: Literal["ellipse", "extent"]
    ellipse: FittedEllipse | None = None


@dataclass(frozen=True, slots=True)
class Outlines:
    """The outlines of a recording by target, and how many lines could not be used, by reason."""

    by_target: Mapping[str, tuple[Outline, ...]]
    problems: Mapping[str, int] = field(default_factory=dict)

    def nearest(self, target: str, time_s: float) -> Outline | None:
        """Return the outline of a target within an antenna turn of a time, None where there is none."""
        there = self.by_target.get(_label(target), ())
        best = min(there, key=lambda outline: abs(outline.time_s - time_s), default=None)
        return best if best is not None and abs(best.time_s - time_s) <= OUTLINE_AGE_S else None


def read_outlines(lines: Iterable[str], *, source: str = "outlines") -> Outlines:
    """Read JSON lines ``{"time_utc","target","points":[[range_m,bearing_deg],...],"bearing_reference"}``.

    A line that cannot be used is counted by its reason, and all of them are reported once.

    Raises
    ------
    InputError : not one usable line
    """
    found: defaultdict[str, list[Outline]] = defaultdict(list)
    problems: Counter[str] = Counter()
    for line in lines:
        if not line.strip():
            continue
        try:
            outline = _outline(json.loads(line))
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            problems[_reason(error)] += 1
            continue
        found[outline.target].append(outline)
    told = ", ".join(f"{count} x {reason}" for reason, count in problems.most_common())
    if not found:
        raise InputError(f"{source}: no echo outline, expected JSON lines{f'; {told}' if told else ''}", source=source)
    if problems:
        _logger.warning("%s: %d lines were not used: %s", source, sum(problems.values()), told)
    return Outlines({target: tuple(outlines) for target, outlines in found.items()}, dict(problems))


def with_outlines(epoch: Epoch, outlines: Outlines, *, model: OutlineModel | str = "digitised") -> Epoch:
    """Return the epoch with the centre of the hull in place of the echo for each target that has an outline."""
    if epoch.time_utc is None:
        return epoch
    time_s, points = epoch.time_utc.timestamp(), outline_model(model)
    targets = tuple(
        _centred(target, outlines.nearest(target.label, _time_of(target, time_s)), points) for target in epoch.targets
    )
    return replace(epoch, targets=targets)


def hull_centre(outline: Outline, model: OutlineModel | str = "digitised") -> HullCentre | None:
    """Return the centre of the hull that an outline shows, None for fewer than three points.

    The ellipse where five points or more hold one and its centre is the surer one; else the middle of the extent in
    range and bearing, whose sigma is that of a place anywhere within it.
    """
    points = outline_model(model)
    if len(outline.points) < FEWEST_FOR_EXTENT:
        return None
    extent, by_ellipse = _by_extent(outline, points), _by_ellipse(outline, points)
    return by_ellipse if by_ellipse is not None and _spread_m(by_ellipse) <= _spread_m(extent) else extent


# ------------------------------------------------------------------------------------------------------------ centres


def _centred(target: RadarTarget, outline: Outline | None, model: OutlineModel) -> RadarTarget:
    if outline is None or outline.bearing_reference != target.bearing_reference:
        return target
    centre = hull_centre(outline, model)
    if centre is None or _apart_m(centre, target) > BESIDE_M:
        return target
    return replace(
        target,
        range_m=centre.range_m,
        bearing_deg=centre.bearing_deg,
        range_sigma_m=math.hypot(target.range_sigma_m or 0.0, centre.range_sigma_m),
        bearing_sigma_deg=math.hypot(target.bearing_sigma_deg or 0.0, centre.bearing_sigma_deg),
        point="hull_centre",
    )


def _by_extent(outline: Outline, model: OutlineModel) -> HullCentre:
    range_m, bearing_deg = outline.points.T
    first_deg = float(bearing_deg[0])
    turned_deg = wrap_180(bearing_deg - first_deg)
    spread_m, spread_deg = float(np.ptp(range_m)), float(np.ptp(turned_deg))
    return HullCentre(
        range_m=float(range_m.min() + range_m.max()) / 2.0,
        bearing_deg=wrap_360(first_deg + float(turned_deg.min() + turned_deg.max()) / 2.0),
        range_sigma_m=math.hypot(spread_m / math.sqrt(12.0), model.range_sigma_m),
        bearing_sigma_deg=math.hypot(spread_deg / math.sqrt(12.0), model.bearing_sigma_deg),
        method="extent",
    )


def _by_ellipse(outline: Outline, model: OutlineModel) -> HullCentre | None:
    """Return the centre of the fitted ellipse; sigmas by moving every point by its own sigma in range and bearing."""
    plane = _plane(outline.points)
    fitted = fit_ellipse(plane)
    if fitted is None or not _is_hull(fitted):
        return None
    centre = np.array([fitted.north_m, fitted.east_m])
    count = len(outline.points)
    moved = np.repeat(outline.points[None], 2 * count, axis=0)
    moved[np.arange(count), np.arange(count), 0] += model.range_sigma_m
    moved[np.arange(count) + count, np.arange(count), 1] += model.bearing_sigma_deg
    moves = fitted_centres(_plane(moved)) - centre
    if not np.all(
        np.isfinite(moves)
    ):  # a point within its own sigma decides whether there is an ellipse: there is none
        return None
    range_m, bearing_rad = float(np.hypot(*centre)), math.atan2(centre[1], centre[0])
    along = np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
    across = np.array([-along[1], along[0]])
    steps = moves * max(1.0, _misfit(plane, fitted, model))
    return HullCentre(
        range_m=range_m,
        bearing_deg=wrap_360(math.degrees(bearing_rad)),
        range_sigma_m=float(np.linalg.norm(steps @ along)),
        bearing_sigma_deg=math.degrees(float(np.linalg.norm(steps @ across)) / range_m),
        method="ellipse",
        ellipse=fitted,
    )


def _is_hull(ellipse: FittedEllipse) -> bool:
    return ellipse.length_m <= LONGEST_HULL_M and SLENDEREST <= ellipse.beam_m / ellipse.length_m <= BLUNTEST


def _misfit(plane: FloatArray, ellipse: FittedEllipse, model: OutlineModel) -> float:
    """Return how far the points lie from the ellipse in units of their sigma (the larger of range and bearing)."""
    across_m = np.linalg.norm(plane, axis=1) * math.radians(model.bearing_sigma_deg)
    ratio = distances_m(plane, ellipse) / np.maximum(across_m, model.range_sigma_m)
    return math.sqrt(float(np.sum(ratio**2)) / max(len(plane) - FEWEST_POINTS, 1))


def _plane(points: FloatArray) -> FloatArray:
    """Return (..., 2) north, east [m] (forward, starboard for relative bearings) of ranges and bearings: eq. (8.9)."""
    bearing_rad = np.radians(points[..., 1])
    return np.asarray(points[..., :1] * np.stack([np.cos(bearing_rad), np.sin(bearing_rad)], axis=-1))


def _spread_m(centre: HullCentre) -> float:
    return math.hypot(centre.range_sigma_m, centre.range_m * math.radians(centre.bearing_sigma_deg))


def _apart_m(centre: HullCentre, target: RadarTarget) -> float:
    turn_rad = math.radians(wrap_180(centre.bearing_deg - target.bearing_deg))
    return math.hypot(centre.range_m - target.range_m, 2.0 * target.range_m * math.sin(turn_rad / 2.0))


def _time_of(target: RadarTarget, epoch_s: float) -> float:
    return epoch_s if target.time_utc is None else target.time_utc.timestamp()


# ------------------------------------------------------------------------------------------------------------ reading


def _outline(content: Any) -> Outline:
    if not isinstance(content, dict):
        raise ValueError("not an object")
    time = datetime.fromisoformat(content["time_utc"])
    reference = content.get("bearing_reference", "relative")
    if reference not in ("relative", "true"):
        raise ValueError("bearing_reference is neither relative nor true")
    points = np.array(content["points"], dtype=np.float64).reshape(-1, 2)
    usable = np.all(np.isfinite(points), axis=1) & (points[:, 0] > 0.0)
    if not usable.any():
        raise ValueError("no usable point")
    aware = time.replace(tzinfo=UTC) if time.tzinfo is None else time
    return Outline(aware.timestamp(), _label(str(content["target"])), points[usable], reference)


def _label(target: str) -> str:
    """Return a target's number as the log's targets are labelled: two digits."""
    return f"{int(target):02d}" if target.strip().isdecimal() else target.strip()


def _reason(error: Exception) -> str:
    match error:
        case json.JSONDecodeError():
            return "not JSON"
        case KeyError():
            return f"without {error.args[0]}"
        case TypeError():
            return "a value of the wrong kind"
        case _ if "reshape" in str(error) or "inhomogeneous" in str(error):
            return "points that are not pairs"
        case _:
            return str(error).split(":")[0]
