"""Epochs with known own poses -> radar and AIS tracks as own ship sees them: the input of the grey association."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.association.grey import PolarTrack
from navfix.geodesy import inverse
from navfix.types import Epoch, FloatArray, Position
from navfix.units import wrap_360

_SPEED_SPAN_S = 20.0  # a radar that tells no ground speed: from where it was so long before


@dataclass(frozen=True, slots=True)
class SeenFrom:
    """Where own ship was at an epoch, and where the radar's zero mark pointed [deg]: known, or fixed before."""

    position: Position
    heading_deg: float


def polar_tracks(
    epochs: Sequence[Epoch], poses: Sequence[SeenFrom]
) -> tuple[tuple[PolarTrack, ...], tuple[PolarTrack, ...]]:
    """Return the tracks of the targets and those of the marks, by label, in the order of time.

    Targets keep their labels: `navfix.picture.stitching.stitch` makes these stable first. A ground speed that the
    radar does not tell is taken from the track itself, own motion added.
    """
    targets: dict[str, list[tuple[float, float, float, float]]] = defaultdict(list)
    marks: dict[str, list[tuple[float, float, float, float]]] = defaultdict(list)
    own = _own_plane(poses)
    own_at: dict[float, FloatArray] = {}
    for index, (epoch, pose) in enumerate(zip(epochs, poses, strict=True)):
        if epoch.time_utc is None:
            continue
        now_s = epoch.time_utc.timestamp()
        own_at[now_s] = own[index]
        for target in epoch.targets:
            turn_deg = pose.heading_deg if target.bearing_reference == "relative" else 0.0
            speed = math.nan if target.speed_mps is None else target.speed_mps
            targets[target.label].append((now_s, target.range_m, wrap_360(target.bearing_deg + turn_deg), speed))
        for mark in epoch.marks:
            range_m, bearing_deg = inverse(pose.position, mark.position)
            marks[mark.label].append((now_s, range_m, bearing_deg, mark.speed_mps or 0.0))
    seen = tuple(_track(label, rows, own_at) for label, rows in targets.items())
    return seen, tuple(_track(label, rows, own_at) for label, rows in marks.items())


def _own_plane(poses: Sequence[SeenFrom]) -> FloatArray:
    """Return own places (n, 2) [m] about the first one."""
    rows = [inverse(poses[0].position, pose.position) for pose in poses]
    return np.array([(d * math.cos(math.radians(a)), d * math.sin(math.radians(a))) for d, a in rows]).reshape(-1, 2)


def _track(label: str, rows: list[tuple[float, float, float, float]], own_at: dict[float, FloatArray]) -> PolarTrack:
    time_s, range_m, bearing_deg, speed_mps = np.array(rows).T
    if np.isnan(speed_mps).any():
        angle = np.radians(bearing_deg)
        place = range_m[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        place = place + np.array([own_at[t] for t in time_s])
        before = np.minimum(np.searchsorted(time_s, time_s - _SPEED_SPAN_S), np.maximum(np.arange(len(time_s)) - 1, 0))
        before[0] = min(len(time_s) - 1, int(np.searchsorted(time_s, time_s[0] + _SPEED_SPAN_S)))
        span_s = np.maximum(np.abs(time_s - time_s[before]), 1.0)
        derived = np.hypot(*(place - place[before]).T) / span_s
        speed_mps = np.where(np.isnan(speed_mps), derived, speed_mps)
    return PolarTrack(label, time_s, range_m, bearing_deg, speed_mps)
