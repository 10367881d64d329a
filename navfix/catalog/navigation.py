"""Own ship over minutes: the navigator, how she moves between fixes, and what is wrong with her radar meanwhile."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.catalog.loading import load


@dataclass(frozen=True, slots=True)
class NavigatorModel:
    """Constants of the navigator over minutes (see models/navigator/default.toml)."""

    name: str
    title: str
    source: str
    kept_s: float
    window_s: float
    shortest_window_s: float
    unseen_s: float
    drift_m: float
    cold_every_s: float
    bank_every_s: float
    birth_windows_s: list[float]
    places: int
    least_detection: float
    births: int
    birth_deficit: float
    merge_m: float
    merge_deg: float
    drop_behind: float
    memory_s: float
    steady_sq: float
    same_m: float
    plain_evidence: float
    plain_margin: float
    plain_marks: int
    sure_evidence: float
    sure_margin: float
    sure_marks: int
    again_evidence: float
    again_margin: float
    again_marks: int
    again_ahead: float
    least_score: float
    least_ahead: float
    give_up_behind: float
    conflict_hold_s: float
    prior_factor: float
    prior_m: float
    prior_deg: float
    gap_mps: float
    gap_degps: float
    fewest_marks: int
    lost_m: float
    apart_m: float
    apart_deg: float
    lapse_evidence: float
    lapse_memory_s: float
    back_evidence: float
    drop_after_s: float
    surprise_sq: float
    surprises: int
    beside_s: float
    missed_factor: float
    gyro_refuted_s: float
    gyro_judged_s: float
    gyro_differs_deg: float
    ais_jump_sigmas: float
    ais_jump_memory_s: float
    ais_jump_ships: int
    doubt_accepted: float
    doubt_per_nat: float
    doubt_reached: float
    doubt_per_hour: float
    most_doubt: float
    former_s: float
    older_s: float


@dataclass(frozen=True, slots=True)
class OwnMotionModel:
    """How own ship moves between fixes, 1 sigma where they are sigmas, and how a log is cut for smoothing.

    Velocity over ground wanders by ``velocity_walk_mps`` within ``velocity_walk_s`` where no log tells, the current by
    ``current_walk_mps`` within ``current_walk_s`` where one does. A window tells its velocity to
    ``window_velocity_mps``; a log that is found or lost tells that through the water to ``log_velocity_share`` of it.
    A log is ``log_share`` of its speed off all the time, the way through the water ``leeway_deg`` off the heading of a
    fix (alignment of the radar, leeway). ``steady_share`` of a fix's variance is the same in successive fixes, the
    rest is forgotten with ``memory_s``; one ``contradicts_sq`` away, as a squared distance in sigmas, is not taken.
    Fixes are one voyage where the fastest ship, with ``chain_sigma`` of both and ``chain_m``, gets from one to the
    next. Dead reckoning ends after ``longest_s``. A log is smoothed in chunks of ``chunk_s`` without their outer
    ``margin_s``; a place farther than ``longest_bridge_s`` from every fix is not given.
    """

    name: str
    title: str
    source: str
    velocity_walk_mps: float
    velocity_walk_s: float
    current_walk_mps: float
    current_walk_s: float
    unknown_speed_mps: float
    unknown_current_mps: float
    window_velocity_mps: float
    log_share: float
    log_velocity_share: float
    leeway_deg: float
    steady_share: float
    memory_s: float
    contradicts_sq: float
    heading_walk_deg: float
    heading_walk_s: float
    gyro_drift_deg_per_h: float
    longest_s: float
    fastest_mps: float
    chain_sigma: float
    chain_m: float
    chunk_s: float
    margin_s: float
    longest_bridge_s: float


@dataclass(frozen=True, slots=True)
class RadarErrorsModel:
    """Constants of the errors of the whole radar over minutes (see models/radar_errors/default.toml)."""

    name: str
    title: str
    source: str
    memory_s: float
    clock_walk: float
    range_walk: float
    clock_sigma_s: float
    range_sigma_m: float
    clock_common_s: float
    range_common_m: float
    least_ships: float
    least_marks: float
    least_clock_share: float
    least_range_share: float
    probability: float
    largest_s: float
    largest_m: float
    clock_slew: float
    own_speed_mps: float


def navigator_model(name: str | NavigatorModel = "default") -> NavigatorModel:
    """Return the constants of the navigator by name in models/navigator, or the record itself."""
    return load("navigator", name, NavigatorModel)


def own_motion_model(name: str | OwnMotionModel = "own_ship") -> OwnMotionModel:
    """Return how own ship moves between fixes, by name in models/own_motion, or the record itself."""
    return load("own_motion", name, OwnMotionModel)


def radar_errors_model(name: str | RadarErrorsModel = "default") -> RadarErrorsModel:
    """Return the constants of the radar's errors over minutes by name in models/radar_errors, or the record itself."""
    return load("radar_errors", name, RadarErrorsModel)
