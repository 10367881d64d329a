"""A window of scans solved together: its association and its adjustment."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.catalog.loading import load


@dataclass(frozen=True, slots=True)
class WindowModel:
    """Constants of the joint association of a window of scans (see models/window/joint.toml)."""

    name: str
    title: str
    source: str
    bin_s: float
    gap_s: float
    jump_m: float
    number_mps: float
    number_m: float
    silence_s: float
    silent_turns: float
    yaw_kept_s: float
    fewest_reports: int
    acceleration_mps2: float
    heading_walk_deg: float
    speed_mps: float
    clock_s: float
    constant_m: float
    constant_deg: float
    white_m: float
    white_deg: float
    slope_mps: float
    mark_drift_mps: float
    mark_acceleration_mps2: float
    still_drift_mps: float
    still_most_m: float
    scatter_dof: float
    still_share: float
    still_mps: float
    moving_mps: float
    jumping_share: float
    jumping_mps: float
    voting_bins: list[float]
    velocity_gate_sigma: float
    pairs: int
    votes_at_most: int
    seeds: int
    finalists: int
    neighbours: int
    annealing_rigid: list[float]
    annealing: list[float]
    null_starts: int
    null_finalists: int
    null_rounds: int
    matched_posterior: float
    leverage_sq: float
    most_barred: int
    left_out_rounds: int
    left_out_most_m: float
    least_evidence: float
    enough_marks: int
    least_evidence_few: float
    fewest_marks: int
    least_margin: float
    least_probability_wrong: float
    accident_nats: float


@dataclass(frozen=True, slots=True)
class AdjustmentModel:
    """Constants of the adjustment of a window of scans, 1 sigma where they are sigmas.

    ``steady_share`` of the radar's error variance stays with a track, ``least_steady_share`` of it or of what is
    found to be new at least. ``velocity_walk_mps`` and ``heading_walk_deg`` are how far own velocity and heading
    wander within ``walk_time_s`` where no log and no gyro tells. A pause of more than ``split_gap_s`` ends a track,
    one of more than ``longest_step_s`` the connection of two epochs. Variance components count ``prior_dof`` degrees
    of freedom at what is expected and stay between the smallest and the largest. A mark whose constant error keeps
    less than ``least_static_weight`` is left out. The adjusted fix stands within ``agrees_sq`` of the association's,
    as a squared distance in its sigmas.
    """

    name: str
    title: str
    source: str
    steady_share: float
    least_steady_share: float
    split_gap_s: float
    clock_sigma_s: float
    range_bias_sigma_m: float
    current_sigma_mps: float
    ground_log_sigma_mps: float
    own_speed_sigma_mps: float
    velocity_walk_mps: float
    heading_walk_deg: float
    walk_time_s: float
    gyro_step_sigma_deg: float
    longest_step_s: float
    prior_dof: float
    component_rounds: int
    smallest_component: float
    largest_component: float
    least_static_weight: float
    agrees_sq: float


def window_model(name: str | WindowModel = "joint") -> WindowModel:
    """Return the constants of the joint association by name in models/window, or the record itself."""
    return load("window", name, WindowModel)


def adjustment_model(name: str | AdjustmentModel = "window") -> AdjustmentModel:
    """Return the constants of the adjustment of a window by name in models/adjustment, or the record itself."""
    return load("adjustment", name, AdjustmentModel)
