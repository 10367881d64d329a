"""Units and angles: the only place where knots, nautical miles and the wrapping of angles are written down."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

NM_M = 1852.0
KNOT_MPS = NM_M / 3600.0
KMH_MPS = 1.0 / 3.6
STATUTE_MILE_M = 1609.344
MPH_MPS = STATUTE_MILE_M / 3600.0

Angle = TypeVar("Angle", float, NDArray[np.float64])


def wrap_360(angle_deg: Angle) -> Angle:
    """Return the angle [deg] in 0 <= angle < 360."""
    wrapped = angle_deg % 360.0
    # A tiny negative angle rounds up to 360.0 itself: bring it back to 0.
    if isinstance(wrapped, np.ndarray):
        return np.where(wrapped >= 360.0, 0.0, wrapped)
    return 0.0 if wrapped >= 360.0 else wrapped


def wrap_180(angle_deg: Angle) -> Angle:
    """Return the angle [deg] in -180 <= angle < 180."""
    return wrap_360(angle_deg + 180.0) - 180.0


def wrap_pi(angle_rad: Angle) -> Angle:
    """Return the angle [rad] in -pi <= angle < pi."""
    return (angle_rad + np.pi) % (2.0 * np.pi) - np.pi
