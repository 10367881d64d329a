"""Where the radar is on the ship: from its antenna and zero mark to the reference point and the bow, and back."""

from __future__ import annotations

import math
from dataclasses import dataclass

from navfix.adjustment.lever_arm import Alignment, Offset, aligned, checked_offset, moved_covariance, swung
from navfix.catalog import RadarModel
from navfix.geodesy import LocalPlane
from navfix.types import FloatArray, Position
from navfix.units import wrap_360


@dataclass(frozen=True, slots=True)
class Mounting:
    """Where the radar's antenna is, (forward, starboard) [m], and how its zero mark is aligned (None: not known)."""

    offset_m: Offset
    alignment: Alignment | None

    @classmethod
    def of(
        cls, radar: RadarModel, offset_m: Offset | None, alignment: Alignment | tuple[float, float] | None
    ) -> Mounting:
        """Return what the options say, else what the model of the radar says."""
        if offset_m is None:
            offset_m = (radar.antenna_forward_m, radar.antenna_starboard_m)
        if alignment is None and radar.alignment_deg is not None:
            alignment = (radar.alignment_deg, radar.alignment_sigma_deg)
        given = Alignment(*alignment) if isinstance(alignment, tuple) else alignment
        return cls(checked_offset(offset_m, "radar_antenna_m"), given)

    @property
    def plain(self) -> bool:
        return self.alignment is None and not any(self.offset_m)

    @property
    def turn_deg(self) -> float:
        return 0.0 if self.alignment is None else self.alignment.offset_deg

    def antenna_and_zero_mark(self, own: Position, heading_deg: float | None) -> tuple[Position, float | None]:
        """Return the place of the antenna and the heading of the zero mark of a ship's place and heading."""
        if heading_deg is None or self.plain:
            return own, heading_deg
        north_m, east_m = swung(self.offset_m, math.radians(heading_deg))[0].tolist()
        return LocalPlane(own).to_position(north_m, east_m), heading_deg + self.turn_deg

    def ship_of(self, antenna: Position, zero_mark_deg: float | None) -> tuple[Position, float | None]:
        """Return the place of the reference point and the bow's heading; the inverse of `antenna_and_zero_mark`."""
        if zero_mark_deg is None or self.plain:
            return antenna, zero_mark_deg
        heading_deg = zero_mark_deg - self.turn_deg
        north_m, east_m = (-swung(self.offset_m, math.radians(heading_deg))[0]).tolist()
        return LocalPlane(antenna).to_position(north_m, east_m), wrap_360(heading_deg)

    def covariance_of_ship(self, covariance: FloatArray, heading_deg: float) -> FloatArray:
        """Return the covariance (3, 3) of reference point and bow from that of antenna and zero mark."""
        if self.alignment is not None:
            covariance = aligned(covariance, self.alignment)
        return moved_covariance(covariance, swung(self.offset_m, math.radians(heading_deg))[1], -1.0)
