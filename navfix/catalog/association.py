"""Which target is which mark: one epoch, and tracks about a known pose."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.catalog.loading import load, table


@dataclass(frozen=True, slots=True)
class AssociationModel:
    """Constants of the association: how it searches, what it averages over, when it answers."""

    name: str
    title: str
    source: str
    pairs_per_stage: list[int]
    pair_gate_sigma: float
    seeds: int
    deep_seed_points: int
    most_seeds: int
    cell_m: float
    cell_deg: float
    votes_at_most: int
    annealing: list[float]
    finalists: int
    screen_targets: int
    screen_neighbours: int
    first_finalists: int
    neighbours: int
    clutter_share: list[float]
    detection_level: list[float]
    clutter_kernels_m: list[float]
    clutter_neighbours: int
    clutter_floor_m: float
    use_speed: bool
    use_length: bool
    use_missed: bool
    use_local_clutter: bool
    speed_shares: list[float]
    speed_sigmas_mps: list[float]
    length_shortening: float
    length_shares: list[float]
    length_sigmas: list[float]
    most_told: float
    far_detection: float
    conspicuity_long: float
    conspicuity_unknown: float
    conspicuity_medium: float
    conspicuity_small: float
    conspicuity_aton: float
    long_m: float
    medium_m: float
    distinct_m: float
    distinct_deg: float
    distinct_sigma: float
    widest_pose_m: float
    widest_pose_deg: float
    hint_wrong_share: float
    compass_sigma_deg: float
    alignment_sigma_deg: float
    warm_m: float
    warm_deg: float
    second_group_pairs: int
    second_group_evidence: float
    second_group_m: float
    stop_evidence: float
    stop_margin: float
    accept_probability: float
    least_margin: float
    margin_with_hint: float
    mirror_share: float
    mirror_below: float
    accidents: float
    rivals: float
    least_probability: float


@dataclass(frozen=True, slots=True)
class CpdModel:
    """Constants of the plain rigid CPD (see models/association/cpd.toml)."""

    name: str
    title: str
    source: str
    outlier_share: float
    starts: int
    least_probability: float


@dataclass(frozen=True, slots=True)
class TrackAssociationModel:
    """Constants of the grey relational association of tracks: resolution, reach of the candidates, sections.

    ``bearing_lift_deg`` and ``speed_lift_mps`` are added before the class-ratio test, which fails near zero.
    """

    name: str
    title: str
    source: str
    resolution: float
    reach_sigma: float
    least_points: int
    bearing_lift_deg: float
    speed_lift_mps: float
    ais_sigma_m: float


def association_model(name: str | AssociationModel = "seeded") -> AssociationModel:
    """Return the constants of the seeded association by name in models/association, or the record itself."""
    return load("association", name, AssociationModel)


def association_method(name: str | AssociationModel | CpdModel) -> AssociationModel | CpdModel:
    """Return the constants of any association method by name in models/association, or the record itself."""
    if not isinstance(name, str):
        return name
    if "outlier_share" in table("association", name):
        return load("association", name, CpdModel)
    return association_model(name)


def track_association_model(name: str | TrackAssociationModel = "grey") -> TrackAssociationModel:
    """Return the constants of a track association by name in models/track_association, or the record itself."""
    return load("track_association", name, TrackAssociationModel)
