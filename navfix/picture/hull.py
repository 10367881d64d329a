"""From the AIS antenna to the echo: the hull's centre where its dimensions are known, a larger sigma where not."""

from __future__ import annotations

import math
from dataclasses import dataclass

from navfix.types import Hull

ALIGNED_SHARE = 0.2  # sigma of the echo's place about the hull's centre, as a share of the length, heading known
UNALIGNED_SHARE = 0.35  # ... and where neither heading nor antenna place is known


@dataclass(frozen=True, slots=True)
class HullShift:
    """A step (north, east) [m] from antenna to hull centre and the sigma per axis [m] of the echo about it."""

    north_m: float
    east_m: float
    sigma_m: float


def hull_shift(hull: Hull | None, heading_deg: float | None, unknown_sigma_m: float) -> HullShift:
    """Return the step from the AIS antenna to the middle of the hull.

    A hull of length 0 is unknown. AIS gives zero for both bow and port distance when only the size is known and not
    where the antenna stands (ITU-R M.1371-5, 3.3.2): then the antenna is taken as the middle, with a larger sigma.
    """
    if hull is None or hull.length_m <= 0.0:
        return HullShift(0.0, 0.0, unknown_sigma_m)
    antenna_known = not (hull.bow_m == 0.0 and hull.port_m == 0.0)
    if heading_deg is None or not antenna_known:
        return HullShift(0.0, 0.0, UNALIGNED_SHARE * hull.length_m)
    heading_rad = math.radians(heading_deg)
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    forward_m, starboard_m = hull.centre_forward_m, hull.centre_starboard_m
    return HullShift(
        forward_m * cos - starboard_m * sin,
        forward_m * sin + starboard_m * cos,
        ALIGNED_SHARE * hull.length_m,
    )
