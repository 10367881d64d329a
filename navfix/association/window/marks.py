"""The marks of a window at any instant: reports received by its end, carried forward, or between two of them.

An epoch holds every mark carried forward from its newest report. Where two epochs show the same report, their
difference is the velocity with which it was carried, whatever the motion model; so the reports themselves are
regained, and between two of them the mark is interpolated.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import chain

import numpy as np

from navfix.association.scene import ComplexArray
from navfix.association.window.tracks import epoch_time
from navfix.catalog import WindowModel
from navfix.geodesy import cloud_to_plane
from navfix.types import Epoch, FloatArray, IntArray, Mark, Position

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


@dataclass(frozen=True, eq=False)
class _Reports:
    """Reports (r,) of all marks, those of one mark together and in the order of time.

    ``first`` (n,) where those of each mark begin; ``time_s`` [POSIX s], ``place`` [m, complex], ``velocity`` [m/s].
    """

    first: IntArray
    time_s: FloatArray
    place: ComplexArray
    velocity: ComplexArray


@dataclass(slots=True)
class _Shown:
    """The first and the newest of the records that show one report, each with the time of its epoch [POSIX s].

    ``time_utc`` is that of the report, as the first record has it.
    """

    time_utc: datetime | None
    first_s: float
    first: Mark
    newest_s: float
    newest: Mark


def paths_of(epochs: Sequence[Epoch], origin: Position, knot_s: FloatArray, model: WindowModel) -> MarkPaths:
    """Return where every mark of the window was at the knots [POSIX s]."""
    histories = _histories(epochs)
    reports = _reports(histories, origin)
    index = {mark.label: i for i, mark in enumerate(epochs[-1].marks)}
    sigma_m = np.array([min(s.first.sigma_m, s.newest.sigma_m) for shown in histories.values() for s in shown])
    z, v, age_s, apart_m = _between(reports, knot_s)
    return MarkPaths(
        tuple(shown[-1].newest for shown in histories.values()),
        z,
        v,
        np.minimum.reduceat(sigma_m, reports.first),
        np.hypot(_aged_m(v, age_s, model), apart_m),
        tuple(index.get(name, -1) for name in histories),
    )


def _histories(epochs: Sequence[Epoch]) -> dict[str, list[_Shown]]:
    """Return the reports of every mark by its label, in the order of time."""
    histories: dict[str, list[_Shown]] = {}
    newest: dict[str, _Shown] = {}
    for epoch in epochs:
        at_s = epoch_time(epoch)
        for mark in epoch.marks:
            label, time_utc = mark.label, mark.time_utc
            shown = newest.get(label)
            if shown is not None and (shown.time_utc is time_utc or _same_instant(shown.time_utc, time_utc)):
                shown.newest_s, shown.newest = at_s, mark
            else:
                newest[label] = _Shown(time_utc, at_s, mark, at_s, mark)
                histories.setdefault(label, []).append(newest[label])
    return histories


def _same_instant(one: datetime | None, other: datetime | None) -> bool:
    if one is None or other is None:
        return one is other
    return one == other or abs((other - one).total_seconds()) < SAME_REPORT_S


def _reports(histories: Mapping[str, Sequence[_Shown]], origin: Position) -> _Reports:
    """Return the reports behind the records that show them, each carried back to its own time."""
    shown = list(chain.from_iterable(histories.values()))
    first = _places([s.first.position for s in shown], origin)
    newest = _places([s.newest.position for s in shown], origin)
    at_s, newest_s = np.array([s.first_s for s in shown]), np.array([s.newest_s for s in shown])
    velocity = np.zeros(len(shown), np.complex128)
    carried = newest_s > at_s
    velocity[carried] = (newest[carried] - first[carried]) / (newest_s - at_s)[carried]
    for alone in np.flatnonzero(~carried).tolist():
        velocity[alone] = _reported_velocity(shown[alone].first)
    time_s = np.array([s.first_s if s.time_utc is None else s.time_utc.timestamp() for s in shown])
    length = np.array([len(known) for known in histories.values()], dtype=np.int64)
    return _Reports(np.cumsum(length) - length, time_s, first - velocity * (at_s - time_s), velocity)


def _places(positions: Sequence[Position], origin: Position) -> ComplexArray:
    plane = cloud_to_plane(origin, [p.lat_deg for p in positions], [p.lon_deg for p in positions])
    return np.asarray(plane[:, 0] + 1j * plane[:, 1], np.complex128)


def _reported_velocity(mark: Mark) -> complex:
    if mark.kind != "ship" or mark.speed_mps is None or mark.course_deg is None or mark.speed_mps <= 0.5:
        return 0j
    return cmath.rect(mark.speed_mps, math.radians(mark.course_deg))


def _between(reports: _Reports, knot_s: FloatArray) -> tuple[ComplexArray, ComplexArray, FloatArray, FloatArray]:
    """Return place, velocity, time to the nearest report and doubt [m], each (n, K): a blend of the two reports around.

    The doubt is how far the two disagree, where both count.
    """
    time_s, place, velocity, first = reports.time_s, reports.place, reports.velocity, reports.first[:, None]
    last = np.append(reports.first[1:], len(time_s))[:, None] - 1
    earlier = np.add.reduceat(time_s[:, None] < knot_s, reports.first, dtype=np.int64)
    after = np.minimum(first + earlier, last)
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
