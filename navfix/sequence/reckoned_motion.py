"""Dead reckoning from epoch to epoch: by log and current, or by the velocity over ground, turned by the gyro."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import datetime

import numpy as np

from navfix.catalog import OwnMotionModel
from navfix.sequence.reckoned import Reckoned
from navfix.types import Epoch, FloatArray
from navfix.units import wrap_180, wrap_360


def carried(track: Reckoned, epoch: Epoch, at: datetime, motion: OwnMotionModel) -> Reckoned:
    """Return the track at an epoch: turned by the gyro, moved by log and current or by its velocity; eq. (10.12)."""
    step_s = (at - track.at).total_seconds()
    if step_s <= 0.0:
        return track
    track = _log_lost(track, motion) if track.by_log and epoch.speed_hint is None else track
    turned_deg, heading_var, gyro_deg, lost = _turn(track, epoch, step_s, motion)
    heading_deg = None if track.heading_deg is None else wrap_360(track.heading_deg + turned_deg)
    walk = (
        motion.current_walk_mps**2 / motion.current_walk_s
        if track.by_log
        else motion.velocity_walk_mps**2 / motion.velocity_walk_s
    )
    transition, log = np.eye(6), epoch.speed_hint
    transition[0, 2] = transition[1, 3] = step_s
    noise = _wandering(walk, step_s)
    run = np.zeros(2)
    if track.by_log and log is not None and track.log_mps is not None and track.heading_deg is not None:
        run = _through_water((track.log_mps, log.speed_mps), track.heading_deg, turned_deg, step_s)
        across = np.array([-run[1], run[0]])
        transition[:2, 4], transition[:2, 5] = run, across  # the share of it that log and heading miss
        grown = math.radians(math.sqrt(max(heading_var - track.heading_var, 0.0)))
        noise[:2, :2] += grown**2 * np.outer(across, across) + (log.sigma_mps * step_s) ** 2 * np.eye(2)
    state = track.state.copy()
    with_ship = not track.by_log and not lost  # the way over ground turns with the ship: half before she goes on
    if with_ship:
        state[2:4] = _turned(state[2:4], 0.5 * turned_deg)
    state = transition @ state
    state[:2] += run
    if with_ship:
        state[2:4] = _turned(state[2:4], 0.5 * turned_deg)
    covariance = transition @ track.covariance @ transition.T + noise
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


def _turned(velocity: FloatArray, turned_deg: float) -> FloatArray:
    c, s = math.cos(math.radians(turned_deg)), math.sin(math.radians(turned_deg))
    return np.array([c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]])


def _turn(
    track: Reckoned, epoch: Epoch, step_s: float, motion: OwnMotionModel
) -> tuple[float, float, float | None, bool]:
    """Return the turn [deg], the heading's variance [deg^2], the gyro's heading, and whether the gyro is not heard."""
    hint = epoch.heading_hint
    if hint is None or track.gyro_deg is None:
        grown = motion.heading_walk_deg**2 * step_s / motion.heading_walk_s
        return 0.0, track.heading_var + grown, None if hint is None else hint.heading_deg, True
    drift_deg = motion.gyro_drift_deg_per_h * step_s / 3600.0
    sigma_deg = math.sqrt(track.heading_var) + drift_deg
    return float(wrap_180(hint.heading_deg - track.gyro_deg)), sigma_deg**2, hint.heading_deg, track.gyro_lost


def _log_lost(track: Reckoned, motion: OwnMotionModel) -> Reckoned:
    """Return the track without a log: its velocity is now that over ground, log along the heading and current."""
    if track.heading_deg is None or track.log_mps is None:
        return replace(track, by_log=False)
    heading_rad = math.radians(track.heading_deg)
    state, covariance = track.state.copy(), track.covariance.copy()
    state[2:4] += track.log_mps * np.array([math.cos(heading_rad), math.sin(heading_rad)])
    covariance[2:4, 2:4] += _log_m2s2(track.log_mps, track.log_sigma_mps, motion) * np.eye(2)
    return replace(track, by_log=False, state=state, covariance=covariance, log_mps=None)


def log_found(track: Reckoned, epoch: Epoch, motion: OwnMotionModel) -> Reckoned:
    """Return the track with the log that is heard from now on: what is left of its velocity is the current."""
    log = epoch.speed_hint
    if track.by_log or log is None or track.heading_deg is None:
        return track
    heading_rad = math.radians(track.heading_deg)
    state, covariance = track.state.copy(), track.covariance.copy()
    state[2:4] -= log.speed_mps * np.array([math.cos(heading_rad), math.sin(heading_rad)])
    covariance[2:4, 2:4] += _log_m2s2(log.speed_mps, log.sigma_mps, motion) * np.eye(2)
    return replace(
        track, by_log=True, state=state, covariance=covariance, log_mps=log.speed_mps, log_sigma_mps=log.sigma_mps
    )


def _log_m2s2(log_mps: float, sigma_mps: float, motion: OwnMotionModel) -> float:
    """Return the variance of each component of the velocity through the water that log and heading tell [m^2/s^2]."""
    return sigma_mps**2 + (motion.log_velocity_share * log_mps) ** 2


def _through_water(log_mps: tuple[float, float], heading_deg: float, turned_deg: float, step_s: float) -> FloatArray:
    """Return the way (north, east) [m] by the log at both ends of a step, along the heading in its middle."""
    middle_rad = math.radians(heading_deg + 0.5 * turned_deg)
    return 0.5 * sum(log_mps) * step_s * np.array([math.cos(middle_rad), math.sin(middle_rad)])


def _wandering(walk: float, step_s: float) -> FloatArray:
    """Return the covariance (6, 6) that a wandering velocity adds in a step; ``walk`` in (m/s)^2 per s: eq. (10.12)."""
    axis = walk * np.array([[step_s**3 / 3.0, step_s**2 / 2.0], [step_s**2 / 2.0, step_s]])
    covariance = np.zeros((6, 6))
    covariance[:4, :4] = np.kron(axis, np.eye(2))
    return covariance
