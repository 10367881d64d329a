"""Dead reckoning beside the navigator: from the fixes that it gave out, and withheld where they are in doubt."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from navfix.sequence.dead_reckoning import DeadReckoner
from navfix.sequence.places import Place
from navfix.sequence.track import Track
from navfix.types import DeadReckoning, Epoch, Fix

_LAPSED = "the tracks since hardly speak for that fix"


class BetweenFixes:
    """Carries the last fix of the navigator on. What ends a place for doubt ends its dead reckoning too."""

    def __init__(self) -> None:
        self._reckoner = DeadReckoner()
        self._track: Track | None = None
        self._now: DeadReckoning | None = None
        self._true_bearings = False

    def carry(self, epoch: Epoch) -> None:
        """Go on to an epoch, whose gyro and log have been checked."""
        self._now = self._reckoner.carry(epoch)

    def drifted(self, before: Place) -> Place | None:
        """Return the dead reckoning of now as a place, ``before`` carried on; None where no fix carries it.

        True bearings tell no heading: that of the place, which is how they are turned, stays.
        """
        now, velocity = self._now, self._reckoner.velocity_mps
        if now is None or velocity is None:
            return None
        covariance = before.covariance.copy()
        covariance[:2, :] = covariance[:, :2] = 0.0
        covariance[:2, :2] = now.covariance
        heading_deg = before.heading_deg
        if now.heading_deg is not None and now.heading_sigma_deg is not None and not self._true_bearings:
            heading_deg, covariance[2, 2] = now.heading_deg, math.radians(now.heading_sigma_deg) ** 2
        at_s = now.since_utc.timestamp() + now.age_s
        return replace(
            before,
            time_s=at_s,
            position=now.position,
            heading_deg=heading_deg,
            velocity_mps=velocity,
            covariance=np.asarray(covariance, np.float64),
        )

    def answer(self, track: Track | None, now_s: float, *, conflict: bool, seen: bool) -> DeadReckoning | None:
        """Return the dead reckoning of now, before a fix of now counts; None where no fix carries it.

        Parameters
        ----------
        track : the place that is held now
        conflict : whether two places are believed, or a former one speaks against the new
        seen : whether echoes and marks speak now: a place that ends unseen has not been contradicted
        """
        ended, self._track = self._track, track
        if conflict or (ended is not None and ended is not track and seen and not ended.lost):
            self._reckoner.forget()
            self._now = None
        elif track is not ended:
            self._reckoner.expect_another()
        if self._now is None or (track is not None and track.standing.outdone):
            return None
        if track is None or not seen:
            return self._now
        return replace(self._now, doubt=_LAPSED if track.lapsed else track.standing.why_silent(now_s))

    def take(self, epoch: Epoch, fix: Fix, velocity_mps: complex | None = None, *, blind: bool = False) -> None:
        """Take a fix that the navigator gives out, with the velocity of its window over ground (north, east) [m/s].

        A fix that was only carried forward says nothing new: it is not taken. Where a ``blind`` one contradicts dead
        reckoning, own ship has turned or stopped unseen, and dead reckoning goes on from the fix.
        """
        if blind:
            self._reckoner.expect_another()
        self._true_bearings = fix.heading_deg is None
        self._reckoner.take(epoch, fix, velocity_mps)
