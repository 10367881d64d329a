"""Places on the globe and in a plane, and hulls."""

from __future__ import annotations

import math
from dataclasses import dataclass

from navfix.types.checks import require
from navfix.units import wrap_180


@dataclass(frozen=True, slots=True)
class Position:
    """A place on WGS 84: latitude -90 .. 90 deg, longitude in deg, wrapped to -180 <= longitude < 180."""

    lat_deg: float
    lon_deg: float

    def __post_init__(self) -> None:
        require(
            math.isfinite(self.lat_deg) and abs(self.lat_deg) <= 90.0,
            "lat_deg",
            "must be within -90 .. 90",
            self.lat_deg,
        )
        require(
            math.isfinite(self.lon_deg) and abs(self.lon_deg) <= 360.0,
            "lon_deg",
            "must be within -360 .. 360",
            self.lon_deg,
        )
        object.__setattr__(self, "lat_deg", float(self.lat_deg))
        object.__setattr__(self, "lon_deg", wrap_180(float(self.lon_deg)))


@dataclass(frozen=True, slots=True)
class PlanePosition:
    """A place in a plane frame of a case file, metres."""

    north_m: float
    east_m: float

    def __post_init__(self) -> None:
        require(
            math.isfinite(self.north_m) and math.isfinite(self.east_m),
            "plane position",
            "must be finite",
            (self.north_m, self.east_m),
        )


@dataclass(frozen=True, slots=True)
class Hull:
    """Distances [m] from the AIS antenna to bow, stern, port and starboard side (the A, B, C, D of AIS)."""

    bow_m: float
    stern_m: float
    port_m: float
    starboard_m: float

    def __post_init__(self) -> None:
        sides = (self.bow_m, self.stern_m, self.port_m, self.starboard_m)
        require(all(math.isfinite(s) and s >= 0.0 for s in sides), "hull", "must be four distances >= 0 m", sides)

    @property
    def length_m(self) -> float:
        return self.bow_m + self.stern_m

    @property
    def beam_m(self) -> float:
        return self.port_m + self.starboard_m

    @property
    def centre_forward_m(self) -> float:
        """From the antenna to the hull's centre, positive towards the bow."""
        return (self.bow_m - self.stern_m) / 2.0

    @property
    def centre_starboard_m(self) -> float:
        """From the antenna to the hull's centre, positive to starboard."""
        return (self.starboard_m - self.port_m) / 2.0
