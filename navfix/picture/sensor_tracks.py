"""Tracks of each sensor alone, by Kalman filters: radar in range and bearing, AIS in north and east."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime

from navfix.catalog import TrackModel, track_model
from navfix.geodesy import LocalPlane
from navfix.nmea.records import Record
from navfix.picture.kalman import Filtered, predict, start, update
from navfix.picture.picture import AT_TOLERANCE_S, Picture, scans
from navfix.types import Epoch, Mark, RadarTarget
from navfix.units import wrap_180, wrap_360

_RATE_SIGMA_MPS, _RATE_SIGMA_DPS = 20.0, 3.0  # of a track's first echo


@dataclass(slots=True)
class _RadarTrack:
    range: Filtered
    bearing: Filtered
    reference: str


@dataclass(slots=True)
class _AisTrack:
    plane: LocalPlane
    north: Filtered
    east: Filtered
    report: datetime | None


class SensorTracks:
    """Filters every target and every mark over the epochs that are fed, each by its own sensor's reports alone."""

    def __init__(self, model: TrackModel | str = "polar") -> None:
        self._model = track_model(model)
        self._radar: dict[str, _RadarTrack] = {}
        self._ais: dict[str, _AisTrack] = {}

    def feed(self, epoch: Epoch) -> Epoch:
        """Take an epoch in and return it with filtered targets and marks; one without a time is returned as it is."""
        if epoch.time_utc is None:
            return epoch
        at_s = epoch.time_utc.timestamp()
        targets = tuple(self._target(target, at_s) for target in epoch.targets)
        return replace(epoch, targets=targets, marks=tuple(self._mark(mark, at_s) for mark in epoch.marks))

    def _target(self, target: RadarTarget, epoch_s: float) -> RadarTarget:
        model, time_s = self._model, _time_s(target, epoch_s)
        if target.range_sigma_m is None or target.bearing_sigma_deg is None:
            return target
        fresh = 1.0 - model.steady_share
        range_m2, bearing_deg2 = fresh * target.range_sigma_m**2, fresh * target.bearing_sigma_deg**2
        track = self._radar.get(target.label)
        if track is None or self._other_ship(track, target, time_s):
            track = _RadarTrack(
                start(time_s, target.range_m, range_m2, rate_variance=_RATE_SIGMA_MPS**2),
                start(time_s, target.bearing_deg, bearing_deg2, rate_variance=_RATE_SIGMA_DPS**2),
                target.bearing_reference,
            )
        else:
            turn = model.true_turn_deg_per_s2 if track.reference == "true" else model.relative_turn_deg_per_s2
            track.range = update(predict(track.range, time_s, model.acceleration_mps2), target.range_m, range_m2)
            ahead = predict(track.bearing, time_s, turn)
            unwrapped = ahead.value + wrap_180(target.bearing_deg - ahead.value)
            track.bearing = update(ahead, unwrapped, bearing_deg2)
        self._radar[target.label] = track
        steady_m2, steady_deg2 = target.range_sigma_m**2 - range_m2, target.bearing_sigma_deg**2 - bearing_deg2
        return replace(
            target,
            range_m=max(track.range.value, 0.1),
            bearing_deg=wrap_360(track.bearing.value),
            range_sigma_m=math.sqrt(steady_m2 + float(track.range.covariance[0, 0])),
            bearing_sigma_deg=math.sqrt(steady_deg2 + float(track.bearing.covariance[0, 0])),
        )

    def _other_ship(self, track: _RadarTrack, target: RadarTarget, time_s: float) -> bool:
        """Tell whether a number has been given to another ship: a gap, a jump, another reference, time going back."""
        gap_s = time_s - track.range.time_s
        if not 0.0 <= gap_s <= self._model.longest_gap_s or track.reference != target.bearing_reference:
            return True
        ahead = track.range.value + gap_s * track.range.rate
        turned_rad = math.radians(wrap_180(target.bearing_deg - track.bearing.value - gap_s * track.bearing.rate))
        across_m = 2.0 * target.range_m * math.sin(turned_rad / 2.0)
        return math.hypot(target.range_m - ahead, across_m) > self._model.longest_jump_m

    def _mark(self, mark: Mark, at_s: float) -> Mark:
        """Filter a mark: each report counts once, when it is new; between reports the track is carried on."""
        if mark.kind != "ship" or mark.sigma_m <= 0.0:
            return mark
        steady_m2 = mark.hull_sigma_m**2 + self._model.steady_share * (mark.sigma_m**2 - mark.hull_sigma_m**2)
        fresh_m2 = max(mark.sigma_m**2 - steady_m2, 1e-6)
        track = self._carried(mark, at_s)
        if track is None:
            track = _new_ais_track(mark, at_s, fresh_m2)
        elif track.report != mark.time_utc:
            north_m, east_m = track.plane.to_plane(mark.position).tolist()
            track.north, track.east = update(track.north, north_m, fresh_m2), update(track.east, east_m, fresh_m2)
            track.report = mark.time_utc
        self._ais[mark.label] = track
        position = track.plane.to_position(track.north.value, track.east.value)
        variance_m2 = steady_m2 + float(track.north.covariance[0, 0] + track.east.covariance[0, 0]) / 2.0
        return replace(mark, position=position, sigma_m=math.sqrt(min(variance_m2, mark.sigma_m**2)))

    def _carried(self, mark: Mark, at_s: float) -> _AisTrack | None:
        """Return the track of a station at an instant, None where there is none or the mark has jumped off it."""
        track = self._ais.get(mark.label)
        if track is None or at_s < track.north.time_s:
            return None
        acceleration = self._model.acceleration_mps2
        north, east = predict(track.north, at_s, acceleration), predict(track.east, at_s, acceleration)
        north_m, east_m = track.plane.to_plane(mark.position).tolist()
        if math.hypot(north_m - north.value, east_m - east.value) > self._model.longest_jump_m:
            return None
        return _AisTrack(track.plane, north, east, track.report)


def recent_epochs(
    records: Iterable[Record], picture: Picture, *, until_s: float, seconds: float = 120.0
) -> Iterator[Epoch]:
    """Yield the epochs of the radar scans of the last ``seconds`` up to and with ``until_s`` [POSIX s]."""
    for scan in scans(picture, records):
        if scan.time_s > until_s + AT_TOLERANCE_S:
            return
        if scan.time_s >= until_s - seconds:
            yield picture.epoch(scan)


def _new_ais_track(mark: Mark, at_s: float, fresh_m2: float) -> _AisTrack:
    plane = LocalPlane(mark.position)
    course_rad = math.radians(mark.course_deg or 0.0)
    speed_mps = mark.speed_mps or 0.0
    known = mark.speed_mps is not None and (mark.course_deg is not None or mark.speed_mps == 0.0)
    variance = 1.0 if known else _RATE_SIGMA_MPS**2
    north = start(at_s, 0.0, fresh_m2, rate=speed_mps * math.cos(course_rad), rate_variance=variance)
    east = start(at_s, 0.0, fresh_m2, rate=speed_mps * math.sin(course_rad), rate_variance=variance)
    return _AisTrack(plane, north, east, mark.time_utc)


def _time_s(target: RadarTarget, epoch_s: float) -> float:
    return epoch_s if target.time_utc is None else target.time_utc.timestamp()
