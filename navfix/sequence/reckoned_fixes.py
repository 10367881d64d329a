"""Dead reckoning takes a fix in: how much of it is new, and when it contradicts."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime

import numpy as np

from navfix.catalog import OwnMotionModel
from navfix.sequence.reckoned import Reckoned, centred, heading_of, stated_of
from navfix.types import Epoch, Fix, Position

_FLOOR_M2 = 1e-4


def updated(track: Reckoned, epoch: Epoch, fix: Fix, at: datetime, motion: OwnMotionModel) -> Reckoned | None:
    """Return the track after a fix of the same instant, None where the fix contradicts it; eq. (10.13)."""
    assert isinstance(fix.position, Position)
    measured = track.plane.to_plane(fix.position)
    whole = fix.covariance[:2, :2]
    elapsed_s = max((at - track.since).total_seconds(), 0.1)
    memory = 1.0 + 2.0 * motion.memory_s / max(elapsed_s, 1.0)
    noise = (1.0 - motion.steady_share) * whole * memory + _FLOOR_M2 * np.eye(2)
    innovation = measured - track.state[:2]
    expected = track.covariance[:2, :2] + track.steady + whole
    if float(innovation @ np.linalg.solve(expected, innovation)) > motion.contradicts_sq:
        return None
    gain = track.covariance[:, :2] @ np.linalg.inv(track.covariance[:2, :2] + noise)
    reduce = np.eye(len(track.state))
    reduce[:, :2] -= gain
    covariance = reduce @ track.covariance @ reduce.T + gain @ noise @ gain.T
    heading_deg, heading_var = heading_of(epoch, fix)
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
        probability_wrong=stated_of(fix),
    )
    return centred(moved)
