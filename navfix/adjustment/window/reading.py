"""Epochs and their pairs read into a window: its times, which sighting is of which track, everything on one plane."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from navfix.adjustment.window.prior import KnownPose, on_plane
from navfix.adjustment.window.problem import OwnSensors, Sighting, Sightings, Tracks, WindowNetwork
from navfix.catalog import AdjustmentModel, RadarModel
from navfix.errors import InputError, TooFewPairs
from navfix.geodesy import LocalPlane
from navfix.types import Association, Epoch, FloatArray, IntArray

Pairs = Mapping[str, str] | Association | Sequence[Mapping[str, str] | Association]
_SAME_INSTANT_S = 0.05


def times_of(epochs: Sequence[Epoch]) -> FloatArray:
    """Return the times of epochs [POSIX s]; scans of one instant follow each other by a twentieth of a second.

    Raises
    ------
    InputError : no epoch, an epoch without a time, times that go back
    """
    if not epochs:
        raise InputError("a window needs at least one epoch, got none")
    times: list[float] = []
    for number, epoch in enumerate(epochs):
        if epoch.time_utc is None:
            raise InputError(f"epoch {number} of the window has no time: give time_utc")
        now_s = epoch.time_utc.timestamp()
        if times and now_s < times[-1] - _SAME_INSTANT_S * number:
            raise InputError(f"epoch {number} is earlier than the one before it: sort the window by time")
        times.append(max(now_s, times[-1] + _SAME_INSTANT_S) if times else now_s)
    return np.array(times)


def sightings_of(epochs: Sequence[Epoch], pairs: Pairs) -> list[Sighting]:
    """Return every target of every epoch that the pairs name and whose mark the epoch holds, in order.

    Raises
    ------
    InputError : as many sets of pairs as epochs are wanted where they come as a sequence
    TooFewPairs : none of the pairs is in any epoch
    """
    found = []
    for number, (epoch, named) in enumerate(zip(epochs, _by_epoch(epochs, pairs), strict=True)):
        if not named:
            continue
        marks = {mark.label: mark for mark in epoch.marks}
        taken: set[str] = set()
        for target in epoch.targets:
            mark = marks.get(named.get(target.label, ""))
            if mark is not None and mark.label not in taken:
                taken.add(mark.label)
                found.append(Sighting(number, target, mark))
    if not found:
        raise TooFewPairs("none of the pairs is in any epoch of the window", observations=0, unknowns=3)
    return found


def _by_epoch(epochs: Sequence[Epoch], pairs: Pairs) -> list[Mapping[str, str]]:
    if isinstance(pairs, Association | Mapping):
        return [_labels(epochs[-1], pairs)] * len(epochs)
    if len(pairs) != len(epochs):
        raise InputError(f"{len(epochs)} epochs need as many sets of pairs, got {len(pairs)}")
    return [_labels(epoch, one) for epoch, one in zip(epochs, pairs, strict=True)]


def _labels(epoch: Epoch, pairs: Mapping[str, str] | Association) -> Mapping[str, str]:
    if isinstance(pairs, Mapping):
        return pairs
    return {epoch.targets[t].label: epoch.marks[m].label for t, m in pairs.pairs}


def window_of(
    epochs: Sequence[Epoch],
    sightings: Sequence[Sighting],
    plane: LocalPlane,
    *,
    radar: RadarModel,
    model: AdjustmentModel,
    compass_sigma_deg: float,
    prior: KnownPose | None = None,
) -> WindowNetwork:
    """Bring a window onto a plane; sigmas are split into what stays and what is new in every scan."""
    time_s = times_of(epochs)
    track, labels, track_mark_label = _tracks(sightings, time_s, model.split_gap_s)
    mark_labels = tuple(dict.fromkeys(s.mark.label for s in sightings))
    mark_index = {label: index for index, label in enumerate(mark_labels)}
    mark = np.array([mark_index[s.mark.label] for s in sightings])
    sigma = _radar_sigmas(sightings, radar)
    total = np.array([s.mark.sigma_m for s in sightings])
    least = np.full(len(mark_labels), np.inf)
    np.minimum.at(least, mark, total)
    steady = np.array([sigma[track == t].mean(axis=0) for t in range(len(labels))])
    seen = Sightings(
        epoch=np.array([s.epoch for s in sightings]),
        track=track,
        mark=mark,
        value=np.array([(s.target.range_m, math.radians(s.target.bearing_deg)) for s in sightings]),
        sigma=sigma * math.sqrt(1.0 - model.steady_share),
        place_ne_m=plane.all_to_plane(
            [s.mark.position.lat_deg for s in sightings], [s.mark.position.lon_deg for s in sightings]
        ),
        velocity_ne_mps=_velocities(sightings),
        is_true=np.array([s.target.bearing_reference == "true" for s in sightings]),
        fresh_m=np.sqrt(total**2 - least[mark] ** 2),
    )
    tracks = Tracks(labels, np.array([mark_index[m] for m in track_mark_label]), steady * math.sqrt(model.steady_share))
    return WindowNetwork(
        plane, time_s, seen, tracks, mark_labels, least, _own_sensors(epochs), model, math.radians(compass_sigma_deg),
        on_plane(prior, plane, not bool(np.all(seen.is_true))),
    )  # fmt: skip


def replaced(
    window: WindowNetwork, epochs: Sequence[Epoch], sightings: Sequence[Sighting], plane: LocalPlane
) -> WindowNetwork:
    """Return the same window on another plane."""
    places = [s.mark.position for s in sightings]
    ne_m = plane.all_to_plane([p.lat_deg for p in places], [p.lon_deg for p in places])
    prior = None if window.prior is None else on_plane(window.prior.known, plane, window.any_relative)
    return replace(
        window, plane=plane, seen=replace(window.seen, place_ne_m=ne_m), own=_own_sensors(epochs), prior=prior
    )


def _tracks(
    sightings: Sequence[Sighting], time_s: FloatArray, gap_s: float
) -> tuple[IntArray, tuple[str, ...], list[str]]:
    """Return the track of each sighting (k,), the label of each track, and its mark's label."""
    last: dict[tuple[str, str], tuple[int, float]] = {}
    index: list[int] = []
    labels: list[str] = []
    marks: list[str] = []
    for s in sightings:
        key, now_s = (s.target.label, s.mark.label), float(time_s[s.epoch])
        known = last.get(key)
        if known is None or now_s - known[1] > gap_s:
            number = len(labels)
            labels.append(s.target.label)
            marks.append(s.mark.label)
        else:
            number = known[0]
        last[key] = (number, now_s)
        index.append(number)
    return np.array(index), tuple(labels), marks


def _radar_sigmas(sightings: Sequence[Sighting], radar: RadarModel) -> FloatArray:
    by_model = radar.sigma_of_range_m(np.array([s.target.range_m for s in sightings]))
    return np.array(
        [
            (
                s.target.range_sigma_m or float(by_model[row]),
                math.radians(s.target.bearing_sigma_deg or radar.bearing_sigma_deg),
            )
            for row, s in enumerate(sightings)
        ]
    )


def _velocities(sightings: Sequence[Sighting]) -> FloatArray:
    speed_mps = np.array([s.mark.speed_mps or 0.0 for s in sightings])
    course_deg = np.array([math.nan if s.mark.course_deg is None else s.mark.course_deg for s in sightings])
    known, course_rad = np.isfinite(course_deg), np.radians(course_deg)
    velocity = speed_mps[:, None] * np.column_stack([np.cos(course_rad), np.sin(course_rad)])
    return np.where(known[:, None], velocity, 0.0)


def _own_sensors(epochs: Sequence[Epoch]) -> OwnSensors:
    gyro = [math.nan if e.heading_hint is None else math.radians(e.heading_hint.heading_deg) for e in epochs]
    spread = [math.nan if e.heading_hint is None else math.radians(e.heading_hint.sigma_deg) for e in epochs]
    speed = [math.nan if e.speed_hint is None else e.speed_hint.speed_mps for e in epochs]
    sigma = [math.nan if e.speed_hint is None else e.speed_hint.sigma_mps for e in epochs]
    water = [e.speed_hint is not None and e.speed_hint.reference == "water" for e in epochs]
    return OwnSensors(np.array(gyro), np.array(spread), np.array(speed), np.array(sigma), np.array(water))
