"""The integrity of a fix from a window of tracks: the radius that holds 95 %, and why there is no protection level."""

from __future__ import annotations

from dataclasses import replace

from navfix.adjustment.reliability import radius_of_probability
from navfix.types import Fix, Integrity

REASON = "a window of tracks: what leaving a track out does is in the covariance (jackknife), no level is made of it"


def with_window_integrity(fix: Fix, level_m: float | None = None) -> Fix:
    """Return the fix of a window with R95 of its covariance, and a protection level where the track gives one."""
    r95_m = radius_of_probability(fix.covariance[:2, :2], 0.95)
    return replace(fix, integrity=Integrity(r95_m, level_m, reason=REASON if level_m is None else ""))
