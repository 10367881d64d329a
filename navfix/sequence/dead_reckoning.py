"""Dead reckoning between fixes: by log and gyro where there are any, by the last velocity otherwise."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from navfix.catalog import OwnMotionModel, own_motion_model
from navfix.geodesy import WGS84_A_M, LocalPlane
from navfix.types import DeadReckoning, Epoch, Fix, FloatArray, Position, ReckoningSource
from navfix.units import wrap_180, wrap_360

_CONTRADICTS = 30.0  # squared innovation in units of its covariance: not the same track, or a wrong fix
_FLOOR_M2 = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class _Track:
    """Position and velocity (north, east, each per second) about ``plane``, and what does not average out.

    ``velocity`` is the current (or drift of the log) where a log is heard, else that over ground. ``steady`` (2, 2) is
    the part of the last fix's covariance that successive fixes share. ``sensors`` is the epoch they were read at.
    """

    plane: LocalPlane
    at: datetime
    state: FloatArray
    covariance: FloatArray
    steady: FloatArray
    by_log: bool
    heading_deg: float | None
    heading_var: float
    gyro_deg: float | None
    log_mps: float | None
    log_sigma_mps: float
    since: datetime
    gyro_lost: bool = False


class DeadReckoner:
    """Carries own position from fix to fix; reads no clock: times come with the epochs.

    A filter of position and velocity. Its prediction is the error growth law, per axis,

        sigma^2(t) = sigma_p^2 + 2 t cov(p, v) + t^2 sigma_v^2 + q t^3 / 3,

    v being the current and q its wandering where a log is heard, velocity over ground and its wandering where not.

    References
    ----------
    Theory 10, eq. (10.12) and (10.13).
    """

    def __init__(self, motion: OwnMotionModel | str = "own_ship") -> None:
        self._motion = own_motion_model(motion)
        self._track: _Track | None = None
        self._doubted = False

    def feed(self, epoch: Epoch, fix: Fix | None = None) -> DeadReckoning | None:
        """Go on to an epoch; return the position there **before** its fix counts, None without an earlier fix.

        A fix that contradicts the track is left out once; the next one that does begins a new track.
        """
        if epoch.time_utc is None:
            return None
        if self._track is not None and epoch.time_utc < self._track.at:
            self._track = None  # the clock was set back: nothing joins the two passages
        reckoned = None
        if self._track is not None:
            self._track = _carried(self._track, epoch, epoch.time_utc, self._motion)
            reckoned = self._answer(epoch.time_utc)
            if reckoned is None:
                self._track = None
        if fix is not None and isinstance(fix.position, Position):
            self._take(epoch, epoch.time_utc, fix)
        return reckoned

    def _answer(self, at: datetime) -> DeadReckoning | None:
        track = self._track
        if track is None or (at - track.since).total_seconds() > self._motion.longest_s:
            return None
        source: ReckoningSource = "last_velocity"
        if track.by_log:
            source = "log" if track.gyro_lost or track.gyro_deg is None else "log_and_gyro"
        return DeadReckoning(
            position=track.plane.to_position(float(track.state[0]), float(track.state[1])),
            covariance=track.covariance[:2, :2] + track.steady,
            heading_deg=track.heading_deg,
            since_utc=track.since,
            source=source,
            heading_sigma_deg=None if track.heading_deg is None else math.sqrt(track.heading_var),
            age_s=(at - track.since).total_seconds(),
        )

    def _take(self, epoch: Epoch, at: datetime, fix: Fix) -> None:
        track = self._track
        if track is not None:
            updated = _updated(track, epoch, fix, at, self._motion)
            if updated is None and not self._doubted:
                self._doubted = True
                return
            self._track = _begun(epoch, at, fix, self._motion) if updated is None else _log_found(updated, epoch)
        else:
            self._track = _begun(epoch, at, fix, self._motion)
        self._doubted = False


def _begun(epoch: Epoch, at: datetime, fix: Fix, motion: OwnMotionModel) -> _Track:
    """Return the track that begins with a fix: velocity or current unknown."""
    assert isinstance(fix.position, Position)
    log = epoch.speed_hint
    heading_deg, heading_var = _heading(epoch, fix)
    by_log = log is not None and heading_deg is not None
    sigma_mps = motion.unknown_current_mps if by_log else motion.unknown_speed_mps
    covariance = np.zeros((4, 4))
    covariance[:2, :2] = (1.0 - motion.steady_share) * fix.covariance[:2, :2]
    covariance[2, 2] = covariance[3, 3] = sigma_mps**2
    return _Track(
        plane=LocalPlane(fix.position),
        at=at,
        state=np.zeros(4),
        covariance=covariance,
        steady=motion.steady_share * fix.covariance[:2, :2],
        by_log=by_log,
        heading_deg=heading_deg,
        heading_var=heading_var,
        gyro_deg=None if epoch.heading_hint is None else epoch.heading_hint.heading_deg,
        log_mps=None if log is None else log.speed_mps,
        log_sigma_mps=0.0 if log is None else log.sigma_mps,
        since=at,
    )


def _heading(epoch: Epoch, fix: Fix) -> tuple[float | None, float]:
    """Return the heading of a fix and its variance [deg^2]; where bearings are true that of the gyro."""
    if fix.heading_deg is not None:
        return fix.heading_deg, math.degrees(math.sqrt(fix.covariance[2, 2])) ** 2
    hint = epoch.heading_hint
    return (None, 0.0) if hint is None else (hint.heading_deg, hint.sigma_deg**2)


def _carried(track: _Track, epoch: Epoch, at: datetime, motion: OwnMotionModel) -> _Track:
    """Return the track at an epoch: turned by the gyro, moved by log and current or by its velocity; eq. (10.12)."""
    step_s = (at - track.at).total_seconds()
    if step_s <= 0.0:
        return track
    track = _log_lost(track, motion) if track.by_log and epoch.speed_hint is None else track
    turned, heading_var, gyro_deg, lost = _turn(track, epoch, step_s, motion)
    heading_deg = None if track.heading_deg is None else wrap_360(track.heading_deg + turned)
    walk = (
        motion.current_walk_mps**2 / motion.current_walk_s
        if track.by_log
        else motion.velocity_walk_mps**2 / motion.velocity_walk_s
    )
    transition = np.eye(4)
    transition[0, 2] = transition[1, 3] = step_s
    covariance = transition @ track.covariance @ transition.T + _wandering(walk, step_s)
    state = transition @ track.state
    log = epoch.speed_hint
    if not track.by_log and not lost:
        state[2:] = _turned(state[2:], turned)  # the way over ground turns with the ship
    if track.by_log and log is not None and track.log_mps is not None and track.heading_deg is not None:
        middle = math.radians(track.heading_deg + 0.5 * turned)
        run_m = 0.5 * (track.log_mps + log.speed_mps) * step_s
        ahead, across = np.array([math.cos(middle), math.sin(middle)]), np.array([-math.sin(middle), math.cos(middle)])
        state[:2] += run_m * ahead
        grown = math.radians(math.sqrt(max(heading_var - track.heading_var, 0.0))) * run_m
        covariance[:2, :2] += grown**2 * np.outer(across, across) + (log.sigma_mps * step_s) ** 2 * np.eye(2)
    return replace(
        track,
        at=at,
        state=state,
        covariance=covariance,
        heading_deg=heading_deg,
        heading_var=heading_var,
        gyro_deg=gyro_deg,
        gyro_lost=lost,
        log_mps=track.log_mps if log is None else log.speed_mps,
    )


def _turned(velocity: FloatArray, turn_deg: float) -> FloatArray:
    c, s = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    return np.array([c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]])


def _turn(
    track: _Track, epoch: Epoch, step_s: float, motion: OwnMotionModel
) -> tuple[float, float, float | None, bool]:
    """Return the turn [deg], the heading's variance [deg^2], the gyro's heading, and whether the gyro is not heard."""
    hint = epoch.heading_hint
    if hint is None or track.gyro_deg is None:
        grown = motion.heading_walk_deg**2 * step_s / motion.heading_walk_s
        return 0.0, track.heading_var + grown, None if hint is None else hint.heading_deg, True
    drift_deg = motion.gyro_drift_deg_per_h * step_s / 3600.0
    sigma_deg = math.sqrt(track.heading_var) + drift_deg
    return float(wrap_180(hint.heading_deg - track.gyro_deg)), sigma_deg**2, hint.heading_deg, track.gyro_lost


def _log_lost(track: _Track, motion: OwnMotionModel) -> _Track:
    """Return the track without a log: its velocity is now that over ground, log along the heading and current."""
    if track.heading_deg is None or track.log_mps is None:
        return replace(track, by_log=False)
    heading_rad = math.radians(track.heading_deg)
    state, covariance = track.state.copy(), track.covariance.copy()
    state[2:] += track.log_mps * np.array([math.cos(heading_rad), math.sin(heading_rad)])
    covariance[2:, 2:] += (track.log_sigma_mps**2 + (0.05 * track.log_mps) ** 2) * np.eye(2)
    return replace(track, by_log=False, state=state, covariance=covariance, log_mps=None)


def _log_found(track: _Track, epoch: Epoch) -> _Track:
    """Return the track with the log that is heard from now on: what is left of its velocity is the current."""
    log = epoch.speed_hint
    if track.by_log or log is None or track.heading_deg is None:
        return track
    heading_rad = math.radians(track.heading_deg)
    state, covariance = track.state.copy(), track.covariance.copy()
    state[2:] -= log.speed_mps * np.array([math.cos(heading_rad), math.sin(heading_rad)])
    covariance[2:, 2:] += (log.sigma_mps**2 + (0.05 * log.speed_mps) ** 2) * np.eye(2)
    return replace(
        track, by_log=True, state=state, covariance=covariance, log_mps=log.speed_mps, log_sigma_mps=log.sigma_mps
    )


def _updated(track: _Track, epoch: Epoch, fix: Fix, at: datetime, motion: OwnMotionModel) -> _Track | None:
    """Return the track after a fix of the same instant, None where the fix contradicts it; eq. (10.13)."""
    assert isinstance(fix.position, Position)
    measured = track.plane.to_plane(fix.position)
    whole = fix.covariance[:2, :2]
    elapsed_s = max((at - track.since).total_seconds(), 0.1)
    memory = 1.0 + 2.0 * motion.memory_s / max(elapsed_s, 1.0)
    noise = (1.0 - motion.steady_share) * whole * memory + _FLOOR_M2 * np.eye(2)
    innovation = measured - track.state[:2]
    expected = track.covariance[:2, :2] + track.steady + whole
    if float(innovation @ np.linalg.solve(expected, innovation)) > _CONTRADICTS:
        return None
    gain = track.covariance[:, :2] @ np.linalg.inv(track.covariance[:2, :2] + noise)
    reduce = np.eye(4)
    reduce[:, :2] -= gain
    covariance = reduce @ track.covariance @ reduce.T + gain @ noise @ gain.T
    heading_deg, heading_var = _heading(epoch, fix)
    known = heading_deg is not None
    moved = replace(
        track,
        state=track.state + gain @ innovation,
        covariance=covariance,
        steady=motion.steady_share * whole,
        heading_deg=heading_deg if known else track.heading_deg,
        heading_var=heading_var if known else track.heading_var,
        since=at,
        gyro_lost=False,
    )
    return _centred(moved)


def _centred(track: _Track) -> _Track:
    """Return the track on a plane about its own position."""
    place = track.plane.to_position(float(track.state[0]), float(track.state[1]))
    turn = float(track.state[1]) * math.tan(math.radians(place.lat_deg)) / WGS84_A_M  # meridians converge
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.kron(np.eye(2), np.array([[c, -s], [s, c]]))
    state = rotation @ track.state
    state[:2] = 0.0
    return replace(track, plane=LocalPlane(place), state=state, covariance=rotation @ track.covariance @ rotation.T)


def _wandering(walk: float, step_s: float) -> FloatArray:
    """Return the covariance (4, 4) that a wandering velocity adds in a step; ``walk`` in (m/s)^2 per s."""
    axis = walk * np.array([[step_s**3 / 3.0, step_s**2 / 2.0], [step_s**2 / 2.0, step_s]])
    return np.asarray(np.kron(axis, np.eye(2)), np.float64)
