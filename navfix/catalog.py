"""The catalogue: models/*.toml -> validated records. Data live in the files, their meaning here."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from navfix.errors import CatalogError, InputError
from navfix.kernels import FAMILIES, Kernel
from navfix.types import FloatArray

Record = TypeVar("Record")


@dataclass(frozen=True, slots=True)
class RadarModel:
    """What one class of radar measures, 1 sigma; IMO's figures are 95 % and were divided by 1.96.

    The sigma of a range is the larger of ``range_sigma_m`` and ``range_sigma_fraction`` x range. Rounding of the
    sentences comes on top when targets are read. ``compass_sigma_deg`` is that of the error common to all true
    bearings: the compass that turned them and the alignment of the radar.

    How a radar is mounted may be said in its file too: its antenna forward and starboard of the ship's reference point
    [m], and the direction of its zero mark from the bow, clockwise, with its 1 sigma [deg] (None: not known).
    """

    name: str
    title: str
    source: str
    range_sigma_m: float
    range_sigma_fraction: float
    bearing_sigma_deg: float
    maximum_range_m: float
    turn_s: float
    compass_sigma_deg: float = 1.5
    antenna_forward_m: float = 0.0
    antenna_starboard_m: float = 0.0
    alignment_deg: float | None = None
    alignment_sigma_deg: float = 0.0

    def sigma_of_range_m(self, range_m: ArrayLike) -> FloatArray:
        """Return 1 sigma [m] of each range [m]."""
        return np.maximum(self.range_sigma_m, self.range_sigma_fraction * np.asarray(range_m, dtype=np.float64))


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


@dataclass(frozen=True, slots=True)
class HullModel:
    """The hull to expect of a ship that does not say its size: mean and 1 sigma, by AIS class and ship type.

    ``ship_types`` holds the first and the last type of ITU-R M.1371, or nothing: any other. ``centre_forward_share`` is
    how far the hull's centre lies forward of the AIS antenna, as a share of the length.
    """

    name: str
    title: str
    source: str
    ais_class: str
    ship_types: list[int]
    length_m: float
    length_sigma_m: float
    beam_m: float
    centre_forward_share: float
    centre_forward_sigma_share: float


@dataclass(frozen=True, slots=True)
class EchoModel:
    """Where on a hull its echo lies: about the mean depth of the visible side, with 1 sigma.

    Along the line of sight ``depth_sigma_share`` of that depth and ``edge_sigma_share`` of the way from it to the
    nearest edge; across it ``across_sigma_share`` of the width.
    """

    name: str
    title: str
    source: str
    depth_sigma_share: float
    edge_sigma_share: float
    across_sigma_share: float


@dataclass(frozen=True, slots=True)
class OutlineModel:
    """How well one boundary point of an echo is measured against the others, 1 sigma."""

    name: str
    title: str
    source: str
    range_sigma_m: float
    bearing_sigma_deg: float


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
class WindowModel:
    """Constants of the joint association of a window of scans (see models/window/joint.toml)."""

    name: str
    title: str
    source: str
    bin_s: float
    gap_s: float
    jump_m: float
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
    least_evidence: float
    enough_marks: int
    least_evidence_few: float
    fewest_marks: int
    least_margin: float
    least_probability_wrong: float


@dataclass(frozen=True, slots=True)
class NavigatorModel:
    """Constants of the navigator over minutes (see models/navigator/default.toml)."""

    name: str
    title: str
    source: str
    kept_s: float
    window_s: float
    shortest_window_s: float
    cold_every_s: float
    bank_every_s: float
    birth_windows_s: list[float]
    places: int
    births: int
    birth_deficit: float
    merge_m: float
    merge_deg: float
    drop_behind: float
    memory_s: float
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
    lapse_evidence: float
    lapse_memory_s: float
    back_evidence: float
    drop_after_s: float
    least_probability_wrong: float


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
class ChartModel:
    """How well a chart knows where an echo is, and when an AIS aid is a charted one (see models/chart/aids.toml)."""

    name: str
    title: str
    source: str
    fixed_sigma_m: float
    sinker_sigma_m: float
    land_sigma_m: float
    chain_per_depth: float
    tide_m: float
    default_depth_m: float
    largest_depth_m: float
    largest_extent_m: float
    colocated_m: float
    same_object_m: float
    gate_sigma: float
    named_within_m: float
    nameless_within_m: float
    sparse_ais: int
    ais_range_m: float
    most_marks: int


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


@dataclass(frozen=True, slots=True)
class AdjustmentModel:
    """Constants of the adjustment of a window of scans, 1 sigma where they are sigmas.

    ``steady_share`` of the radar's error variance stays with a track. ``velocity_walk_mps`` and ``heading_walk_deg``
    are how far own velocity and heading wander within ``walk_time_s`` where no log and no gyro tells. A pause of more
    than ``split_gap_s`` ends a track, one of more than ``longest_step_s`` the connection of two epochs. Variance
    components count ``prior_dof`` degrees of freedom at 1 and stay between the smallest and the largest. A mark whose
    constant error keeps less than ``least_static_weight`` is left out.
    """

    name: str
    title: str
    source: str
    steady_share: float
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


@dataclass(frozen=True, slots=True)
class OwnMotionModel:
    """How own ship moves between fixes, 1 sigma where they are sigmas, and how a log is cut for smoothing.

    Velocity over ground wanders by ``velocity_walk_mps`` within ``velocity_walk_s`` where no log tells, the current by
    ``current_walk_mps`` within ``current_walk_s`` where one does. ``steady_share`` of a fix's variance is the same in
    successive fixes, the rest is forgotten with ``memory_s``. Dead reckoning ends after ``longest_s``. A log
    is smoothed in chunks of ``chunk_s`` without their outer ``margin_s``; a place farther than ``longest_bridge_s``
    from every fix is not given.
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
    steady_share: float
    memory_s: float
    heading_walk_deg: float
    heading_walk_s: float
    gyro_drift_deg_per_h: float
    longest_s: float
    fastest_mps: float
    chunk_s: float
    margin_s: float
    longest_bridge_s: float


def data_folder(name: str) -> Path:
    """Return the folder ``models`` or ``data``: inside the package when installed, beside it in a checkout."""
    inside = Path(str(files("navfix"))) / name
    return inside if inside.is_dir() else inside.parent.parent / name


def radar_model(name: str | RadarModel) -> RadarModel:
    """Return a radar model by its name in models/radar, or the model itself.

    Raises
    ------
    CatalogError : unknown name, unknown or missing key
    """
    return name if isinstance(name, RadarModel) else _load("radar", name, RadarModel)


def ais_model(name: str | AisModel) -> AisModel:
    """Return an AIS class by name in models/ais ("class_a", "class_b", "aton"), or the record itself."""
    return name if isinstance(name, AisModel) else _load("ais", name, AisModel)


def chart_model(name: str | ChartModel = "aids") -> ChartModel:
    """Return the sigmas and gates of charted marks by name in models/chart, or the record itself."""
    return name if isinstance(name, ChartModel) else _load("chart", name, ChartModel)


def hull_model(name: str | HullModel) -> HullModel:
    """Return the hull to expect of a ship of unknown size by name in models/hull ("tanker"), or the record itself."""
    return name if isinstance(name, HullModel) else _load("hull", name, HullModel)


@cache
def hull_model_of(ais_class: str | None, ship_type: int | None) -> HullModel:
    """Return the hull to expect of a ship of this AIS class and type that does not say its size."""
    if ais_class == "B":
        return hull_model("class_b")
    models = [hull_model(name) for name in names("hull")]
    fits = [m for m in models if m.ship_types and m.ship_types[0] <= (ship_type or 0) <= m.ship_types[-1]]
    return fits[0] if fits else hull_model("class_a")


def echo_model(name: str | EchoModel = "visible_side") -> EchoModel:
    """Return where on a hull its echo lies by name in models/echo, or the record itself."""
    return name if isinstance(name, EchoModel) else _load("echo", name, EchoModel)


def outline_model(name: str | OutlineModel = "digitised") -> OutlineModel:
    """Return how well the boundary points of an echo are measured by name in models/outline, or the record itself."""
    return name if isinstance(name, OutlineModel) else _load("outline", name, OutlineModel)


def track_model(name: str | TrackModel = "polar") -> TrackModel:
    """Return the constants of the filters of one sensor by name in models/track, or the record itself."""
    return name if isinstance(name, TrackModel) else _load("track", name, TrackModel)


def persisting_model(name: str | PersistingModel = "persisting") -> PersistingModel:
    """Return the constants of the persisting motion by name in models/motion, or the record itself."""
    return name if isinstance(name, PersistingModel) else _load("motion", name, PersistingModel)


def filter_model(name: str | FilterModel = "turn_filter") -> FilterModel:
    """Return the constants of the Kalman filters of motion by name in models/motion, or the record itself."""
    return name if isinstance(name, FilterModel) else _load("motion", name, FilterModel)


def motion_model(name: str | PersistingModel | FilterModel) -> PersistingModel | FilterModel:
    """Return the constants of any motion model by name in models/motion, or the record itself."""
    if not isinstance(name, str):
        return name
    return filter_model(name) if "alpha" in table("motion", name) else persisting_model(name)


def association_model(name: str | AssociationModel = "seeded") -> AssociationModel:
    """Return the constants of the seeded association by name in models/association, or the record itself."""
    return name if isinstance(name, AssociationModel) else _load("association", name, AssociationModel)


def window_model(name: str | WindowModel = "joint") -> WindowModel:
    """Return the constants of the joint association by name in models/window, or the record itself."""
    return name if isinstance(name, WindowModel) else _load("window", name, WindowModel)


def navigator_model(name: str | NavigatorModel = "default") -> NavigatorModel:
    """Return the constants of the navigator by name in models/navigator, or the record itself."""
    return name if isinstance(name, NavigatorModel) else _load("navigator", name, NavigatorModel)


def association_method(name: str | AssociationModel | CpdModel) -> AssociationModel | CpdModel:
    """Return the constants of any association method by name in models/association, or the record itself."""
    if not isinstance(name, str):
        return name
    if "outlier_share" in table("association", name):
        plain: CpdModel = _load("association", name, CpdModel)
        return plain
    return association_model(name)


def tracking_model(name: str | TrackingModel = "plots") -> TrackingModel:
    """Return the constants of a tracker by name in models/tracking, or the record itself."""
    return name if isinstance(name, TrackingModel) else _load("tracking", name, TrackingModel)


def stitching_model(name: str | StitchingModel = "numbers") -> StitchingModel:
    """Return the constants of the stitching by name in models/stitching, or the record itself."""
    return name if isinstance(name, StitchingModel) else _load("stitching", name, StitchingModel)


def track_association_model(name: str | TrackAssociationModel = "grey") -> TrackAssociationModel:
    """Return the constants of a track association by name in models/track_association, or the record itself."""
    return name if isinstance(name, TrackAssociationModel) else _load("track_association", name, TrackAssociationModel)


def adjustment_model(name: str | AdjustmentModel = "window") -> AdjustmentModel:
    """Return the constants of the adjustment of a window by name in models/adjustment, or the record itself."""
    return name if isinstance(name, AdjustmentModel) else _load("adjustment", name, AdjustmentModel)


def own_motion_model(name: str | OwnMotionModel = "own_ship") -> OwnMotionModel:
    """Return how own ship moves between fixes, by name in models/own_motion, or the record itself."""
    return name if isinstance(name, OwnMotionModel) else _load("own_motion", name, OwnMotionModel)


def kernel(name: str | Path | Kernel) -> Kernel:
    """Return a kernel by its name in models/kernel, by the path of a TOML file, or the kernel itself.

    Raises
    ------
    CatalogError : unknown name; a file that cannot be read, or with unknown, missing or impossible constants
    """
    if isinstance(name, Kernel):
        return name
    if isinstance(name, Path) or name.endswith(".toml"):
        path = Path(name)
        return _build_kernel(path.stem, read_table(path), where=str(path))
    return _kernel(name)


@cache
def _kernel(name: str) -> Kernel:
    return _build_kernel(name, table("kernel", name), where=f"models/kernel/{name}.toml")


def _build_kernel(name: str, content: dict[str, Any], *, where: str) -> Kernel:
    family = FAMILIES.get(str(content.get("family")))
    if family is None:
        seen = content.get("family")
        raise CatalogError(
            f"{where}: family must be one of {', '.join(FAMILIES)}, got {seen!r}", path=where, key="family"
        )
    constants = {key: _constants(content.get(key, {}), family.constants, where, key) for key in ("separate", "joint")}
    try:
        return build(Kernel, {"name": name, **content, **constants}, where=where)
    except InputError as error:
        raise CatalogError(f"{where}: {error}", path=where) from error


def _constants(section: Any, names: tuple[str, ...], where: str, key: str) -> tuple[float, ...]:
    if not isinstance(section, dict) or set(section) != set(names):
        seen = ", ".join(section) if isinstance(section, dict) else repr(section)
        raise CatalogError(
            f"{where}: [{key}] must hold {', '.join(names) or 'nothing'}, got {seen or 'nothing'}", path=where, key=key
        )
    for constant, value in section.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise CatalogError(
                f"{where}: {key}.{constant} must be a number, got {value!r}", path=where, key=f"{key}.{constant}"
            )
    return tuple(float(section[constant]) for constant in names)


def names(kind: str) -> list[str]:
    """Return the names of all models of one kind ("radar", "kernel", ...)."""
    return sorted(path.stem for path in (data_folder("models") / kind).glob("*.toml"))


def kinds() -> list[str]:
    """Return the kinds of models: the folders of models/."""
    return sorted(path.name for path in data_folder("models").iterdir() if path.is_dir())


def table(kind: str, name: str) -> dict[str, Any]:
    """Return the raw table of one model file.

    Raises
    ------
    CatalogError : unknown name; a file that is not TOML or carries no title or source
    """
    path = data_folder("models") / kind / f"{name}.toml"
    if name not in names(kind):
        raise CatalogError(f"no {kind} model named {name!r}; there are {', '.join(names(kind))}", key=name)
    return read_table(path)


def read_table(path: Path) -> dict[str, Any]:
    """Return the table of a model file outside or inside the catalogue; it must carry a title and a source."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise CatalogError(f"{path}: no such file", path=str(path)) from error
    except OSError as error:
        raise CatalogError(f"{path}: cannot be read: {error.strerror}", path=str(path)) from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CatalogError(f"{path.name}: not a readable TOML file: {error}", path=str(path)) from error
    for key in ("title", "source"):
        if not isinstance(content.get(key), str) or not content[key].strip():
            raise CatalogError(f"{path.name}: every model needs a {key}", path=str(path), key=key)
    return content


def every_table() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield (kind, name, table) of the whole catalogue."""
    for kind in kinds():
        for name in names(kind):
            yield kind, name, table(kind, name)


@cache
def _load(kind: str, name: str, record: type[Record]) -> Record:
    return build(record, {"name": name, **table(kind, name)}, where=f"models/{kind}/{name}.toml")


def build(record: type[Record], content: dict[str, Any], *, where: str) -> Record:
    """Make a record of a table: every key known, every required key present, numbers where numbers belong."""
    known = {field.name: field for field in fields(record)}  # type: ignore[arg-type]
    for key in content:
        if key not in known:
            raise CatalogError(f"{where}: unknown key {key!r}; known are {', '.join(known)}", path=where, key=key)
    for key, field in known.items():
        if key not in content and field.default is MISSING and field.default_factory is MISSING:
            raise CatalogError(f"{where}: missing key {key!r}", path=where, key=key)
        wants_number = str(field.type).startswith(("float", "int"))
        if (
            key in content
            and wants_number
            and (isinstance(content[key], bool) or not isinstance(content[key], int | float))
        ):
            raise CatalogError(f"{where}: {key} must be a number, got {content[key]!r}", path=where, key=key)
    return record(**content)
