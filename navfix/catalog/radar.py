"""What a radar measures, and how well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from navfix.catalog.loading import load
from navfix.types import FloatArray


@dataclass(frozen=True, slots=True)
class RadarModel:
    """What one class of radar measures, 1 sigma; IMO's figures are 95 % and were divided by 1.96.

    The sigma of a range is the larger of ``range_sigma_m`` and ``range_sigma_fraction`` x range. Rounding of the
    sentences comes on top when targets are read. ``compass_sigma_deg`` is that of the error common to all true
    bearings: the compass that turned them and the alignment of the radar.

    How a radar is mounted may be said in its file too: its antenna forward and starboard of the ship's reference point
    [m], and the direction of its zero mark from the bow, clockwise, with its 1 sigma [deg] (None: not known).
    """

    name: str
    title: str
    source: str
    range_sigma_m: float
    range_sigma_fraction: float
    bearing_sigma_deg: float
    maximum_range_m: float
    turn_s: float
    compass_sigma_deg: float = 1.5
    antenna_forward_m: float = 0.0
    antenna_starboard_m: float = 0.0
    alignment_deg: float | None = None
    alignment_sigma_deg: float = 0.0

    def sigma_of_range_m(self, range_m: ArrayLike) -> FloatArray:
        """Return 1 sigma [m] of each range [m]."""
        return np.maximum(self.range_sigma_m, self.range_sigma_fraction * np.asarray(range_m, dtype=np.float64))


def radar_model(name: str | RadarModel) -> RadarModel:
    """Return a radar model by its name in models/radar, or the model itself.

    Raises
    ------
    CatalogError : unknown name, unknown or missing key
    """
    return load("radar", name, RadarModel)
