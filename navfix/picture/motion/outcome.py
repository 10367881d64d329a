"""What a motion model answers: the step from the newest report with its sigma, or that it would rather not."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Carried:
    """A step (north, east) [m] from the newest reported position and the sigma per axis [m] that the step adds."""

    north_m: float
    east_m: float
    sigma_m: float


@dataclass(frozen=True, slots=True)
class Declined:
    """The model would rather not: ``reason`` says what it lacks."""

    reason: str
