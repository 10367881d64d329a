"""How far a report of an AIS station can be trusted."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.catalog.loading import load


@dataclass(frozen=True, slots=True)
class AisModel:
    """How far a report of one AIS class can be trusted, 1 sigma per axis, and how that grows with its age.

    Sigma of the report itself by its accuracy flag; of the time of the report (``clock_sigma_s``) and of the speed of a
    moving ship; how its path spreads (theory, eq. 13.5): as a share of the way in general, by its turning, by the
    unsteadiness of its course, each a share without unit; how a still ship drifts, at most to its swing. Reports older
    than ``oldest_*_s`` are dropped.
    """

    name: str
    title: str
    source: str
    accurate_sigma_m: float
    default_sigma_m: float
    clock_sigma_s: float
    speed_sigma_mps: float
    path_share: float
    path_floor_mps: float
    path_time_s: float
    turn_share: float
    unsteady_share: float
    typical_unsteadiness_rad: float
    still_sigma_mps: float
    swing_sigma_m: float
    oldest_moving_s: float
    oldest_still_s: float


def ais_model(name: str | AisModel) -> AisModel:
    """Return an AIS class by name in models/ais ("class_a", "class_b", "aton"), or the record itself."""
    return load("ais", name, AisModel)
