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

    Sigma of the report itself by its accuracy flag; of a moving ship's speed, course and unknown acceleration; of the
    time between the AIS and the radar clock; of a still ship's swing. Reports older than ``oldest_*_s`` are dropped.
    """

    name: str
    title: str
    source: str
    accurate_sigma_m: float
    default_sigma_m: float
    speed_sigma_mps: float
    course_sigma_deg: float
    acceleration_mps2: float
    clock_sigma_s: float
    swing_sigma_m: float
    oldest_moving_s: float
    oldest_still_s: float
    unknown_hull_sigma_m: float


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
    neighbours: int
    clutter_share: list[float]
    detection_level: list[float]
    clutter_kernels_m: list[float]
    clutter_neighbours: int
    clutter_floor_m: float
    use_speed: bool
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
    second_group_pairs: int
    second_group_evidence: float
    stop_evidence: float
    stop_margin: float
    accept_probability: float
    least_margin: float
    margin_with_hint: float
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
