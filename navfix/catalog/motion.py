"""How ships go on after their last report."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.catalog.loading import load, table


@dataclass(frozen=True, slots=True)
class PersistingModel:
    """How the steering of a ship is read from its reports, and how long it goes on (models/motion/persisting.toml).

    Regressions of course and speed over ``*_memory_s``, shrunk by ``*_shrink_s2``; ``reported_turn_share`` is the
    weight of a rate of turn that the ship reports itself. What was found lasts ``*_persist_s``; reported speed and
    course lag behind by ``lag_s``.
    """

    name: str
    title: str
    source: str
    turn_memory_s: float
    turn_shrink_s2: float
    turn_persist_s: float
    reported_turn_share: float
    speed_memory_s: float
    speed_shrink_s2: float
    speed_persist_s: float
    way_persist_s: float
    lag_s: float
    fastest_turn_rad_s: float
    strongest_mps2: float


@dataclass(frozen=True, slots=True)
class FilterModel:
    """Constants of the Kalman filters with a coordinated turn (see models/motion/turn_filter.toml).

    ``alpha``, ``beta``, ``kappa`` of the scaled unscented transform; process noise as standard deviations per square
    root of a second; the rate of turn fades with ``turn_persist_s``; sigmas of what a report measures;
    ``acceleration_walk_mps`` is that of each axis in the linear filter.
    """

    name: str
    title: str
    source: str
    alpha: float
    beta: float
    kappa: float
    position_walk_m: float
    speed_walk_mps: float
    course_walk_rad: float
    turn_walk_rad_s: float
    turn_persist_s: float
    position_sigma_m: float
    speed_sigma_mps: float
    course_sigma_deg: float
    start_turn_sigma_rad_s: float
    acceleration_walk_mps: float


def persisting_model(name: str | PersistingModel = "persisting") -> PersistingModel:
    """Return the constants of the persisting motion by name in models/motion, or the record itself."""
    return load("motion", name, PersistingModel)


def filter_model(name: str | FilterModel = "turn_filter") -> FilterModel:
    """Return the constants of the Kalman filters of motion by name in models/motion, or the record itself."""
    return load("motion", name, FilterModel)


def motion_model(name: str | PersistingModel | FilterModel) -> PersistingModel | FilterModel:
    """Return the constants of any motion model by name in models/motion, or the record itself."""
    if not isinstance(name, str):
        return name
    return filter_model(name) if "alpha" in table("motion", name) else persisting_model(name)
