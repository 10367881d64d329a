"""The marks of a window at any instant: reports received by its end, carried forward, or between two of them.

An epoch holds every mark carried forward from its newest report. Where two epochs show the same report, their
difference is the velocity with which it was carried, whatever the motion model; so the reports themselves are
regained, and between two of them the mark is interpolated.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from navfix.association.scene import ComplexArray
from navfix.association.window.tracks import epoch_time
from navfix.catalog import WindowModel
from navfix.geodesy import cloud_to_plane
from navfix.types import Epoch, FloatArray, Mark, Position

SAME_REPORT_S = 0.5


@dataclass(frozen=True, eq=False)
class MarkPaths:
    """Marks (n,) at knots (K,): places ``z`` [m, complex] and velocities ``v`` [m/s, complex], each (n, K).

    ``constant_m`` (n,) 1 sigma per axis of what stays (antenna, hull); ``aged_m`` (n, K) of what grows with age.
    ``marks`` the newest record of each; ``newest`` (n,) its index in the last epoch, -1 where it is not there.
    """

    marks: tuple[Mark, ...]
    z: ComplexArray
    v: ComplexArray
    constant_m: FloatArray
    aged_m: FloatArray
    newest: tuple[int, ...]


_Seen = tuple[float, Mark]


_Report = tuple[float, complex, complex]  # time [POSIX s], place [m], velocity [m/s]


def paths_of(epochs: Sequence[Epoch], origin: Position, knot_s: FloatArray, model: WindowModel) -> MarkPaths:
    """Return where every mark of the window was at the knots [POSIX s]."""
    histories = _histories(epochs, origin)
    index = {mark.label: i for i, mark in enumerate(epochs[-1].marks)}
    z, v, age_s, apart_m = _between([reports for reports, _, _ in histories.values()], knot_s)
    return MarkPaths(
        tuple(newest for _, newest, _ in histories.values()),
        z,
        v,
        np.array([sigma_m for _, _, sigma_m in histories.values()]),
        np.hypot(_aged_m(v, age_s, model), apart_m),
        tuple(index.get(name, -1) for name in histories),
    )


def _histories(epochs: Sequence[Epoch], origin: Position) -> dict[str, tuple[list[_Report], Mark, float]]:
    """Return by label: reports in time order, the newest record, and the least sigma that the mark had [m]."""
    groups: dict[str, list[list[_Seen]]] = {}
    for epoch in epochs:
        at_s = epoch_time(epoch)
        for mark in epoch.marks:
            known = groups.setdefault(mark.label, [])
            if known and _same_report(known[-1][0][1], mark):
                known[-1][1:] = [(at_s, mark)]  # of one report only its first and its newest place are needed
            else:
                known.append([(at_s, mark)])
    seen = [mark for known in groups.values() for group in known for _, mark in group]
    plane = cloud_to_plane(origin, [m.position.lat_deg for m in seen], [m.position.lon_deg for m in seen])
    places = iter((plane[:, 0] + 1j * plane[:, 1]).tolist())
    found = {}
    for label, known in groups.items():
        reports = [_report([(at_s, next(places), mark) for at_s, mark in group]) for group in known]
        least = min(mark.sigma_m for group in known for _, mark in group)
        found[label] = (reports, known[-1][-1][1], least)
    return found


def _same_report(one: Mark, other: Mark) -> bool:
    if one.time_utc is None or other.time_utc is None:
        return one.time_utc is other.time_utc
    return one.time_utc == other.time_utc or abs((other.time_utc - one.time_utc).total_seconds()) < SAME_REPORT_S


def _report(group: list[tuple[float, complex, Mark]]) -> _Report:
    """Return the report behind the places of one group: carried back to its own time."""
    at_s, place, mark = group[0]
    if len(group) > 1 and group[-1][0] > at_s:
        velocity = (group[-1][1] - place) / (group[-1][0] - at_s)
    else:
        velocity = _reported_velocity(mark)
    time_s = at_s if mark.time_utc is None else mark.time_utc.timestamp()
    return time_s, place - velocity * (at_s - time_s), velocity


def _reported_velocity(mark: Mark) -> complex:
    if mark.kind != "ship" or mark.speed_mps is None or mark.course_deg is None or mark.speed_mps <= 0.5:
        return 0j
    return cmath.rect(mark.speed_mps, math.radians(mark.course_deg))


def _between(
    histories: Sequence[Sequence[_Report]], knot_s: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray, FloatArray]:
    """Return place, velocity, time to the nearest report and doubt [m], each (n, K): a blend of the two reports around.

    The doubt is how far the two disagree, where both count.
    """
    length = np.array([len(reports) for reports in histories], dtype=np.int64)
    first = (np.cumsum(length) - length)[:, None]
    time_s, place, velocity = (np.array(part) for part in zip(*chain.from_iterable(histories), strict=True))
    earlier = np.add.reduceat(time_s[:, None] < knot_s, first[:, 0], dtype=np.int64)
    after = first + np.minimum(earlier, length[:, None] - 1)
    before = np.maximum(after - (time_s[after] > knot_s), first)
    forward_s, backward_s = knot_s - time_s[before], knot_s - time_s[after]
    span_s = time_s[after] - time_s[before]
    weight = np.where(span_s > 0.0, forward_s / np.where(span_s > 0.0, span_s, 1.0), 0.0)
    forward, backward = place[before] + velocity[before] * forward_s, place[after] + velocity[after] * backward_s
    z = (1.0 - weight) * forward + weight * backward
    v = (1.0 - weight) * velocity[before] + weight * velocity[after]
    apart_m = 2.0 * weight * (1.0 - weight) * np.abs(forward - backward)
    return z, v, np.minimum(np.abs(forward_s), np.abs(backward_s)), apart_m


def _aged_m(velocity: ComplexArray, age_s: FloatArray, model: WindowModel) -> FloatArray:
    moving = np.hypot(model.mark_drift_mps * age_s, 0.5 * model.mark_acceleration_mps2 * age_s**2)
    still = np.minimum(model.still_drift_mps * age_s, model.still_most_m)
    return np.where(np.abs(velocity) > 0.0, moving, still)
