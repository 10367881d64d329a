"""The state of dead reckoning: position, velocity or current, heading, and what does not average out of fixes."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from navfix.catalog import OwnMotionModel
from navfix.geodesy import WGS84_A_M, LocalPlane
from navfix.types import Epoch, Fix, FloatArray, Position


@dataclass(frozen=True, slots=True, eq=False)
class Reckoned:
    """State (6,): position and velocity (north, east) about ``plane``, and the share of log and heading that is wrong.

    The velocity is the current (or drift of the log) where a log is heard, else that over ground. The share, ahead and
    to starboard, is that of the way through the water which log and heading miss all the time, as by a log that reads
    low, a bow that is not where radar's zero mark is, or leeway: unlike a current it turns with the ship. ``steady``
    (2, 2) is the part of the last fix's covariance that successive fixes share.
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
    probability_wrong: float | None = None


def begun(
    epoch: Epoch, at: datetime, fix: Fix, motion: OwnMotionModel, velocity_mps: complex | None = None
) -> Reckoned:
    """Return the track that begins with a fix: velocity or current unknown, or as a window tells it [m/s]."""
    assert isinstance(fix.position, Position)
    log = epoch.speed_hint
    heading_deg, heading_var = heading_of(epoch, fix)
    by_log = log is not None and heading_deg is not None
    sigma_mps = motion.unknown_current_mps if by_log else motion.unknown_speed_mps
    state = np.zeros(6)
    if velocity_mps is not None:
        through = _ahead(log.speed_mps, heading_deg) if log is not None and heading_deg is not None else 0j
        state[2:4] = (velocity_mps - through).real, (velocity_mps - through).imag
        sigma_mps = min(sigma_mps, motion.window_velocity_mps)
    covariance = np.zeros((6, 6))
    covariance[:2, :2] = (1.0 - motion.steady_share) * fix.covariance[:2, :2]
    covariance[2, 2] = covariance[3, 3] = sigma_mps**2
    covariance[4, 4], covariance[5, 5] = motion.log_share**2, math.radians(motion.leeway_deg) ** 2
    return Reckoned(
        plane=LocalPlane(fix.position),
        at=at,
        state=state,
        covariance=covariance,
        steady=motion.steady_share * fix.covariance[:2, :2],
        by_log=by_log,
        heading_deg=heading_deg,
        heading_var=heading_var,
        gyro_deg=None if epoch.heading_hint is None else epoch.heading_hint.heading_deg,
        log_mps=None if log is None else log.speed_mps,
        log_sigma_mps=0.0 if log is None else log.sigma_mps,
        since=at,
        probability_wrong=stated_of(fix),
    )


def over_ground(track: Reckoned) -> complex:
    """Return the velocity over ground (north, east) [m/s, complex]: of the state, with the log where it has one."""
    velocity = complex(track.state[2], track.state[3])
    if track.by_log and track.log_mps is not None and track.heading_deg is not None:
        velocity += _ahead(track.log_mps, track.heading_deg) * (1.0 + complex(track.state[4], track.state[5]))
    return velocity


def _ahead(speed_mps: float, heading_deg: float) -> complex:
    return cmath.rect(speed_mps, math.radians(heading_deg))


def stated_of(fix: Fix) -> float | None:
    """Return the probability of being wrong that a fix states, None where it states none."""
    return None if fix.association is None else fix.association.probability_wrong


def heading_of(epoch: Epoch, fix: Fix) -> tuple[float | None, float]:
    """Return the heading of a fix and its variance [deg^2]; where bearings are true that of the gyro."""
    if fix.heading_deg is not None:
        return fix.heading_deg, math.degrees(math.sqrt(fix.covariance[2, 2])) ** 2
    hint = epoch.heading_hint
    return (None, 0.0) if hint is None else (hint.heading_deg, hint.sigma_deg**2)


def centred(track: Reckoned) -> Reckoned:
    """Return the track on a plane about its own position."""
    place = track.plane.to_position(float(track.state[0]), float(track.state[1]))
    turn = float(track.state[1]) * math.tan(math.radians(place.lat_deg)) / WGS84_A_M  # meridians converge
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.eye(6)
    rotation[:4, :4] = np.kron(np.eye(2), np.array([[c, -s], [s, c]]))
    state = rotation @ track.state
    state[:2] = 0.0
    return replace(track, plane=LocalPlane(place), state=state, covariance=rotation @ track.covariance @ rotation.T)
