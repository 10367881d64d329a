"""Dead reckoning: where own ship should be by its last fix and its own motion since."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

import numpy as np

from navfix.types.adjusted import Ellipse
from navfix.types.checks import FloatArray, frozen_array
from navfix.types.places import Position

ReckoningSource = Literal["log_and_gyro", "log", "last_velocity"]


@dataclass(frozen=True, slots=True, eq=False)
class DeadReckoning:
    """A position carried on from the last fix (``since_utc``); ``covariance`` (2, 2) in north, east [m^2] grows.

    ``source``: own speed by log along the heading of a gyro or along the last one, or the last velocity over ground.
    ``heading_deg`` with its 1 sigma is None where no fix told it. ``probability_wrong`` is what was stated of the last
    fix (None where nothing was): if that place was another one, so is this, and the ellipse does not hold it.
    ``doubt`` says in words what speaks against that fix by now, "" where nothing does.
    """

    position: Position
    covariance: FloatArray
    heading_deg: float | None
    since_utc: datetime
    source: ReckoningSource
    heading_sigma_deg: float | None = None
    age_s: float = 0.0
    probability_wrong: float | None = None
    doubt: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "covariance", frozen_array(self.covariance, np.float64))

    def ellipse(self, probability: float = 0.95) -> Ellipse:
        """Return the confidence ellipse at ``probability``; the covariance is known beforehand."""
        return Ellipse.from_covariance(self.covariance, probability)

    def search_radius_m(self, reach_m: float, *, sigmas: float = 3.0) -> float:
        """Return the radius [m] about the position that holds all that radar can see within ``reach_m``: r + 3 sigma.

        Sigma is the one along the longer axis. Three of them hold 99.7 % along that axis and at least 98.9 % in the
        plane (99.7 % where the ellipse is slender).
        """
        return reach_m + sigmas * float(np.sqrt(np.linalg.eigvalsh(self.covariance)[-1]))
