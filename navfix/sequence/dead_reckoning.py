"""Dead reckoning between fixes: by log and gyro where there are any, by the last velocity otherwise."""

from __future__ import annotations

import math

from navfix.catalog import OwnMotionModel, own_motion_model
from navfix.sequence.reckoned import Reckoned, begun, over_ground
from navfix.sequence.reckoned_fixes import updated
from navfix.sequence.reckoned_motion import carried, log_found
from navfix.types import DeadReckoning, Epoch, Fix, Position, ReckoningSource


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
        self._track: Reckoned | None = None
        self._doubted = False

    def feed(self, epoch: Epoch, fix: Fix | None = None) -> DeadReckoning | None:
        """Go on to an epoch; return the position there **before** its fix counts, None without an earlier fix."""
        reckoned = self.carry(epoch)
        if fix is not None:
            self.take(epoch, fix)
        return reckoned

    def carry(self, epoch: Epoch) -> DeadReckoning | None:
        """Go on to an epoch and return the position there, None without an earlier fix or too long after it."""
        at = epoch.time_utc
        if self._track is None or at is None:
            return None
        if at < self._track.at:
            self._track = None  # the clock was set back: nothing joins the two passages
            return None
        self._track = carried(self._track, epoch, at, self._motion)
        reckoned = self._answer(self._track)
        if reckoned is None:
            self._track = None
        return reckoned

    @property
    def velocity_mps(self) -> complex | None:
        """Velocity over ground (north, east) [m/s], None without a fix that carries it."""
        return None if self._track is None else over_ground(self._track)

    def forget(self) -> None:
        """Forget every fix: they are in doubt, and nothing is reckoned before the next one."""
        self._track, self._doubted = None, False

    def expect_another(self) -> None:
        """Let the next fix begin a new track at once where it contradicts: it comes from another place than before."""
        self._doubted = True

    def take(self, epoch: Epoch, fix: Fix, velocity_mps: complex | None = None) -> None:
        """Take the fix of an epoch that was carried to.

        A track that begins with it begins with its ``velocity_mps`` over ground (north, east), where that is told. A
        fix that contradicts the track is left out once; the next one that does begins a new track.
        """
        at = epoch.time_utc
        if at is None or not isinstance(fix.position, Position):
            return
        if self._track is None:
            self._track = begun(epoch, at, fix, self._motion, velocity_mps)
        else:
            after = updated(self._track, epoch, fix, at, self._motion)
            if after is None and not self._doubted:
                self._doubted = True
                return
            if after is None:
                self._track = begun(epoch, at, fix, self._motion, velocity_mps)
            else:
                self._track = log_found(after, epoch, self._motion)
        self._doubted = False

    def _answer(self, track: Reckoned) -> DeadReckoning | None:
        age_s = (track.at - track.since).total_seconds()
        if age_s > self._motion.longest_s:
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
            age_s=age_s,
            probability_wrong=track.probability_wrong,
        )
