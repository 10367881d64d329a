"""Radar targets and AIS ships of one instant in one list: each sensor filtered alone, joined by the pairs of a fix."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from navfix.association.grey_pairs import grey_association, poses_between
from navfix.association.grey_tracks import SeenFrom
from navfix.catalog import RadarModel
from navfix.errors import InputError
from navfix.picture.fusion import OwnPose, fused_list, lists_apart
from navfix.picture.sensor_tracks import SensorTracks
from navfix.report.answer import Answer
from navfix.types import Association, Epoch, Fix, Pairing, Position, TargetList

GREY_STEP_S = 10.0

Solve = Callable[[Epoch], Answer]


def listed(
    history: Iterable[Epoch], solve: Solve, *, radar: RadarModel | str = "imo", pairing: Pairing = "fix"
) -> TargetList:
    """Return the list at the last of some epochs, with own places by ``solve``: see `navfix.pipeline.targets`.

    Raises
    ------
    InputError : no epoch
    """
    tracks, filtered, seen = SensorTracks(), None, list[Epoch]()
    for newest in history:
        filtered = tracks.feed(newest)
        seen.append(newest)
    if filtered is None:
        raise InputError("a list of targets needs at least one epoch, got none")
    solved = solve(seen[-1])
    if solved.fix is None:
        return lists_apart(filtered, reason=getattr(solved.error, "reason", ""), message=str(solved.error), radar=radar)
    pairs = solved.fix.association or Association(pairs=np.zeros((0, 2), np.int64), probability=np.zeros(0))
    if pairing == "grey":
        fixes = {len(seen) - 1: solved.fix, **_fixed_every(seen[:-1], solve)}
        known = {_time_s(seen[k]): _seen_from(found) for k, found in fixes.items()}
        pairs = grey_association(seen, poses_between(seen, known), radar=radar)
    return replace(fused_list(filtered, _own_pose(solved.fix), pairs, radar=radar), pairing=pairing)


def _fixed_every(seen: Sequence[Epoch], solve: Solve) -> dict[int, Fix]:
    """Return fixes of some of the epochs by their number, one in ten seconds at most, where there is one."""
    found: dict[int, Fix] = {}
    due_s = -math.inf
    for number, epoch in enumerate(seen):
        if _time_s(epoch) >= due_s:
            solved = solve(epoch)
            if solved.fix is not None:
                found[number], due_s = solved.fix, _time_s(epoch) + GREY_STEP_S
    return found


def _seen_from(found: Fix) -> SeenFrom:
    assert isinstance(found.position, Position)
    return SeenFrom(found.position, found.heading_deg or 0.0)  # true bearings need none


def _time_s(epoch: Epoch) -> float:
    return -math.inf if epoch.time_utc is None else epoch.time_utc.timestamp()


def _own_pose(found: Fix) -> OwnPose:
    assert isinstance(found.position, Position)
    sigma_deg = found.compass_error_sigma_deg or 0.0
    return OwnPose(found.position, found.heading_deg, found.covariance, found.compass_error_deg, sigma_deg**2)
