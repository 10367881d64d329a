"""The marks of a window at any instant: reports received by its end, carried forward, or between two of them.

An epoch holds every mark carried forward from its newest report. Where two epochs show the same report, their
difference is the velocity with which it was carried, whatever the motion model; so the reports themselves are
regained, and between two of them the mark is interpolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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


@dataclass(slots=True)
class _Report:
    time_s: float
    place: complex
    velocity: complex


def paths_of(epochs: Sequence[Epoch], origin: Position, knot_s: FloatArray, model: WindowModel) -> MarkPaths:
    """Return where every mark of the window was at the knots [POSIX s]."""
    histories = _histories(epochs, origin)
    index = {mark.label: i for i, mark in enumerate(epochs[-1].marks)}
    names = list(histories)
    z, v, aged = np.zeros((len(names), len(knot_s)), complex), np.zeros((len(names), len(knot_s)), complex), []
    for row, name in enumerate(names):
        z[row], v[row], age_s, apart_m = _between(histories[name][0], knot_s)
        aged.append(np.hypot(_aged_m(v[row], age_s, model), apart_m))
    return MarkPaths(
        tuple(histories[name][1] for name in names),
        z,
        v,
        np.array([histories[name][2] for name in names]),
        np.array(aged).reshape(len(names), len(knot_s)),
        tuple(index.get(name, -1) for name in names),
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
    return abs((other.time_utc - one.time_utc).total_seconds()) < SAME_REPORT_S


def _report(group: list[tuple[float, complex, Mark]]) -> _Report:
    """Return the report behind the places of one group: carried back to its own time."""
    at_s, place, mark = group[0]
    velocity = _reported_velocity(mark)
    if len(group) > 1 and group[-1][0] > at_s:
        velocity = (group[-1][1] - place) / (group[-1][0] - at_s)
    time_s = at_s if mark.time_utc is None else mark.time_utc.timestamp()
    return _Report(time_s, place - velocity * (at_s - time_s), velocity)


def _reported_velocity(mark: Mark) -> complex:
    if mark.kind != "ship" or mark.speed_mps is None or mark.course_deg is None or mark.speed_mps <= 0.5:
        return 0j
    return complex(mark.speed_mps * np.exp(1j * np.radians(mark.course_deg)))


def _between(reports: list[_Report], knot_s: FloatArray) -> tuple[ComplexArray, ComplexArray, FloatArray, FloatArray]:
    """Return place, velocity, time to the nearest report and doubt [m] (K,): a blend of the reports before and after.

    The doubt is how far the two disagree, where both count.
    """
    time_s = np.array([r.time_s for r in reports])
    place, velocity = np.array([r.place for r in reports]), np.array([r.velocity for r in reports])
    after = np.clip(np.searchsorted(time_s, knot_s), 0, len(reports) - 1)
    before = np.clip(after - (time_s[after] > knot_s), 0, len(reports) - 1)
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
