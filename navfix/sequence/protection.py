"""Protection over time: do new windows surprise the track, and does a solve that knows nothing of it agree?

Two tests, and a level. Innovation: the squared distance of a window's pose to the prior from older data, chi-square
with three degrees of freedom while all is well. Separation: how far the newest blind solve of the same data lies from
the track. Level: no error beyond separation + K sigma goes unnoticed while the blind solve is right: eq. (14.2).
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from navfix.catalog import NavigatorModel
from navfix.sequence.places import Place


class TrackProtection:
    """Remembers innovations and separations of one track."""

    def __init__(self, model: NavigatorModel) -> None:
        self._model = model
        self._innovations: deque[float] = deque(maxlen=model.surprises)
        self._separation_m: float | None = None
        self._separated_s = -math.inf
        self._blind_sigma_m = math.inf

    def note_innovation(self, misfit_sq: float) -> None:
        """Take the squared Mahalanobis distance of a window's pose to its prior."""
        self._innovations.append(misfit_sq)

    def note_blind(self, blind: Place, track: Place) -> None:
        """Take a blind solve and the track at the same instant."""
        self._separation_m = blind.distance_m(track)
        self._separated_s, self._blind_sigma_m = blind.time_s, blind.sigma_m

    @property
    def surprised(self) -> bool:
        """Whether the last windows all lay farther from their priors than one in a thousand does."""
        full = len(self._innovations) == self._model.surprises
        return full and min(self._innovations) > self._model.surprise_sq

    @property
    def startled(self) -> bool:
        """Whether the newest window lay farther from its prior than one in a thousand does."""
        return bool(self._innovations) and self._innovations[-1] > self._model.surprise_sq

    @property
    def innovation(self) -> float | None:
        """The newest squared distance, None before there is one."""
        return self._innovations[-1] if self._innovations else None

    def level_m(self, place: Place) -> float | None:
        """Return the protection level [m] of a place, None where no blind solve of the last minute stands beside it."""
        if self._separation_m is None or place.time_s - self._separated_s > self._model.beside_s:
            return None
        sigma_m = float(np.hypot(place.sigma_m, self._blind_sigma_m))
        return self._separation_m + self._model.missed_factor * sigma_m
