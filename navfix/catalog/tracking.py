"""Following the numbers and the plots of one radar: filters, tracker, stitching."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.catalog.loading import load


@dataclass(frozen=True, slots=True)
class TrackModel:
    """Constants of the filters of one sensor: accelerations, what of an error stays, when a number is another ship."""

    name: str
    title: str
    source: str
    acceleration_mps2: float
    relative_turn_deg_per_s2: float
    true_turn_deg_per_s2: float
    steady_share: float
    radar_speed_sigma_mps: float
    longest_gap_s: float
    longest_jump_m: float


@dataclass(frozen=True, slots=True)
class TrackingModel:
    """Constants of the tracker for raw plots: gate, motion, life cycle, pieces of one hull, local clutter.

    Speeds and accelerations are relative to own ship. Times of the life cycle count in antenna turns; ``confirm_score``
    is the log likelihood ratio "a ship" against "clutter" from which a track is reported.
    """

    name: str
    title: str
    source: str
    gate_chi2: float
    detection: float
    relative_speed_mps: float
    relative_acceleration_mps2: float
    fastest_mps: float
    least_hits: int
    confirm_score: float
    tentative_turns: float
    lost_turns: float
    coast_turns: float
    settle_hits: int
    piece_m: float
    twin_turns: int
    clutter_radius_m: float
    clutter_turns: int
    clutter_floor_per_km2: float
    widest_turn_deg: float


@dataclass(frozen=True, slots=True)
class StitchingModel:
    """Constants for the stitching of target numbers: when a number is cut, when two are joined, when two have changed.

    ``join_log_odds`` is the least log odds "the same echo" against "another one that appears there by chance",
    ``join_lead`` and ``swap_lead`` how far the answer must be ahead of the next one.
    """

    name: str
    title: str
    source: str
    gap_s: float
    jump_m: float
    jump_chi2: float
    relative_speed_mps: float
    relative_acceleration_mps2: float
    longest_join_s: float
    join_chi2: float
    join_log_odds: float
    join_lead: float
    least_sightings: int
    clutter_speed_mps: float
    swap_chi2: float
    swap_lead: float
    swap_guard: int
    unseen_turn_deg: float


def track_model(name: str | TrackModel = "polar") -> TrackModel:
    """Return the constants of the filters of one sensor by name in models/track, or the record itself."""
    return load("track", name, TrackModel)


def tracking_model(name: str | TrackingModel = "plots") -> TrackingModel:
    """Return the constants of a tracker by name in models/tracking, or the record itself."""
    return load("tracking", name, TrackingModel)


def stitching_model(name: str | StitchingModel = "numbers") -> StitchingModel:
    """Return the constants of the stitching by name in models/stitching, or the record itself."""
    return load("stitching", name, StitchingModel)
