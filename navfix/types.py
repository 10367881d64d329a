"""The frozen records: what goes in (targets, marks, epoch), what is found (association) and what comes out (fix)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from navfix.errors import InputError
from navfix.units import wrap_180, wrap_360

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BearingReference = Literal["relative", "true"]
MarkKind = Literal["ship", "aton", "charted"]
ObservationKind = Literal["range", "relative_bearing", "true_bearing"]
HeadingReference = Literal["radar_zero_mark", "bow"]
CovarianceScaling = Literal["a_priori", "a_posteriori"]
Verdict = Literal["ok", "caution", "unsafe", "not_available"]


def _require(condition: bool, name: str, rule: str, value: object) -> None:
    if not condition:
        raise InputError(f"{name} {rule}, got {value!r}")


def _frozen_array(values: object, dtype: type) -> NDArray[np.generic]:
    array: NDArray[np.generic] = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array


# ---------------------------------------------------------------------------------------------- places and hulls


@dataclass(frozen=True, slots=True)
class Position:
    """A place on WGS 84: latitude -90 .. 90 deg, longitude in deg, wrapped to -180 <= longitude < 180."""

    lat_deg: float
    lon_deg: float

    def __post_init__(self) -> None:
        _require(
            math.isfinite(self.lat_deg) and abs(self.lat_deg) <= 90.0,
            "lat_deg",
            "must be within -90 .. 90",
            self.lat_deg,
        )
        _require(
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
        _require(
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
        _require(all(math.isfinite(s) and s >= 0.0 for s in sides), "hull", "must be four distances >= 0 m", sides)

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


# ----------------------------------------------------------------------------------------------------- what goes in


@dataclass(frozen=True, slots=True)
class RadarTarget:
    """What the radar sees: range [m] and bearing [deg] from own ship.

    ``bearing_reference`` "relative" counts from the radar's zero mark, "true" from north.
    ``speed_mps`` and ``course_deg`` are true and over ground (None where the radar does not say so).
    A sigma given here (1 sigma) overrides the radar model's.
    """

    label: str
    range_m: float
    bearing_deg: float
    bearing_reference: BearingReference = "relative"
    time_utc: datetime | None = None
    speed_mps: float | None = None
    course_deg: float | None = None
    range_sigma_m: float | None = None
    bearing_sigma_deg: float | None = None
    status: str | None = None

    def __post_init__(self) -> None:
        who = f"target {self.label}"
        _require(math.isfinite(self.range_m) and self.range_m > 0.0, f"{who}: range_m", "must be > 0", self.range_m)
        _require(math.isfinite(self.bearing_deg), f"{who}: bearing_deg", "must be finite", self.bearing_deg)
        _require(
            self.bearing_reference in ("relative", "true"),
            f"{who}: bearing_reference",
            "must be 'relative' or 'true'",
            self.bearing_reference,
        )
        for name in ("range_sigma_m", "bearing_sigma_deg"):
            sigma = getattr(self, name)
            _require(sigma is None or (math.isfinite(sigma) and sigma > 0.0), f"{who}: {name}", "must be > 0", sigma)
        object.__setattr__(self, "bearing_deg", wrap_360(float(self.bearing_deg)))


@dataclass(frozen=True, slots=True)
class Mark:
    """What has a known position: an AIS ship, an aid to navigation, a charted object.

    ``sigma_m`` is 1 sigma per axis and complete: age and hull enter when the epoch is built, not later.
    ``age_s`` is the age of the report that the position was carried forward from.
    """

    label: str
    position: Position
    sigma_m: float
    kind: MarkKind = "ship"
    mmsi: int | None = None
    time_utc: datetime | None = None
    speed_mps: float | None = None
    course_deg: float | None = None
    heading_deg: float | None = None
    hull: Hull | None = None
    name: str | None = None
    ais_class: Literal["A", "B"] | None = None
    ship_type: int | None = None
    age_s: float | None = None

    def __post_init__(self) -> None:
        _require(
            math.isfinite(self.sigma_m) and self.sigma_m >= 0.0,
            f"mark {self.label}: sigma_m",
            "must be >= 0",
            self.sigma_m,
        )
        _require(
            self.kind in ("ship", "aton", "charted"),
            f"mark {self.label}: kind",
            "must be 'ship', 'aton' or 'charted'",
            self.kind,
        )


@dataclass(frozen=True, slots=True)
class HeadingHint:
    """A heading [deg] with its sigma [deg] from a gyro or an earlier fix: checked against the data, never believed."""

    heading_deg: float
    sigma_deg: float

    def __post_init__(self) -> None:
        _require(math.isfinite(self.heading_deg), "heading_deg", "must be finite", self.heading_deg)
        _require(math.isfinite(self.sigma_deg) and self.sigma_deg > 0.0, "sigma_deg", "must be > 0", self.sigma_deg)


@dataclass(frozen=True, slots=True)
class PositionHint:
    """A position with its sigma per axis [m] from dead reckoning or an earlier fix: checked, never believed."""

    position: Position
    sigma_m: float

    def __post_init__(self) -> None:
        _require(math.isfinite(self.sigma_m) and self.sigma_m > 0.0, "sigma_m", "must be > 0", self.sigma_m)


@dataclass(frozen=True, slots=True)
class GnssReport:
    """Own GNSS position of the log, carried to the epoch. Never evidence for a fix: only compared with it."""

    position: Position
    sigma_m: float
    time_utc: datetime | None = None


@dataclass(frozen=True, slots=True)
class Epoch:
    """Everything reduced to one instant: targets, marks, and the hints that a log may hold.

    ``left_out`` counts the stations that could not serve as marks, by reason. ``build_ms`` is how long it took to
    reduce everything to the instant [ms].
    """

    time_utc: datetime | None
    targets: tuple[RadarTarget, ...]
    marks: tuple[Mark, ...]
    heading_hint: HeadingHint | None = None
    position_hint: PositionHint | None = None
    gnss: GnssReport | None = None
    left_out: tuple[tuple[str, int], ...] = ()
    build_ms: float | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "targets", tuple(self.targets))
        object.__setattr__(self, "marks", tuple(self.marks))
        if self.time_utc is not None:
            _require(self.time_utc.tzinfo is not None, "time_utc", "must carry a time zone (UTC)", self.time_utc)


# --------------------------------------------------------------------------------------------------- what is found


@dataclass(frozen=True, slots=True)
class Alternative:
    """One place that explains the data; ``score`` is its log evidence, comparable within one epoch."""

    position: Position | PlanePosition
    heading_deg: float | None
    score: float
    pairs: int = 0


@dataclass(frozen=True, slots=True)
class SecondGroup:
    """Targets that agree with each other on another place: the sign of AIS positions shifted alike."""

    offset_m: float
    azimuth_deg: float
    targets: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Association:
    """Which target is which mark.

    ``pairs`` is (k, 2): target index, mark index; ``probability`` (k,) in 0 .. 1. The pose (``position``,
    ``heading_deg``, ``covariance`` (3, 3) in north m, east m, heading rad) is None when the pairs were given by hand.
    ``evidence`` and ``margin`` are natural logarithms; ``probability_wrong`` is that of another place.
    """

    pairs: IntArray
    probability: FloatArray
    position: Position | None = None
    heading_deg: float | None = None
    covariance: FloatArray | None = None
    evidence: float | None = None
    margin: float | None = None
    probability_wrong: float | None = None
    alternatives: tuple[Alternative, ...] = ()
    second_group: SecondGroup | None = None
    method: str = "by_hand"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        pairs = _frozen_array(self.pairs, np.int64).reshape(-1, 2)
        pairs.setflags(write=False)
        object.__setattr__(self, "pairs", pairs)
        object.__setattr__(self, "probability", _frozen_array(self.probability, np.float64))
        _require(
            len(self.pairs) == len(self.probability),
            "probability",
            f"must have {len(self.pairs)} entries",
            len(self.probability),
        )
        for column, word in ((0, "target"), (1, "mark")):
            indices = self.pairs[:, column]
            _require(len(np.unique(indices)) == len(indices), "pairs", f"must name each {word} once", indices.tolist())
        if self.covariance is not None:
            object.__setattr__(self, "covariance", _frozen_array(self.covariance, np.float64))

    @classmethod
    def from_pairs(cls, epoch: Epoch, pairs: Iterable[tuple[int | str, int | str]]) -> Association:
        """Make an association by hand from (target, mark) given as indices or labels.

        Raises
        ------
        InputError : an index out of range, an unknown or doubled label, a target or mark named twice
        """
        resolved = [
            (
                _find(target, [t.label for t in epoch.targets], "target"),
                _find(mark, [m.label for m in epoch.marks], "mark"),
            )
            for target, mark in pairs
        ]
        return cls(pairs=np.array(resolved, dtype=np.int64).reshape(-1, 2), probability=np.ones(len(resolved)))


def _find(key: int | str, labels: Sequence[str], word: str) -> int:
    if isinstance(key, str):
        hits = [index for index, label in enumerate(labels) if label == key]
        if len(hits) != 1:
            why = "unknown" if not hits else "more than one has this label"
            raise InputError(f"{word} {key!r}: {why}; labels are {', '.join(labels[:20])}")
        return hits[0]
    if not 0 <= int(key) < len(labels):
        raise InputError(f"{word} index {key} is out of range: there are {len(labels)} {word}s")
    return int(key)


# ------------------------------------------------------------------------------------------------- what comes out


@dataclass(frozen=True, slots=True)
class Ellipse:
    """Confidence ellipse that holds the truth with ``probability``; azimuth of its major axis, 0 .. 180 deg."""

    semi_major_m: float
    semi_minor_m: float
    azimuth_deg: float
    probability: float

    @classmethod
    def from_covariance(
        cls, covariance_m2: FloatArray, probability: float = 0.95, *, dof: float | None = None
    ) -> Ellipse:
        """Make the ellipse of a (2, 2) covariance in (north, east).

        Without ``dof`` the covariance is known a priori: radius^2 = -2 ln(1 - P), the chi-square quantile.
        With ``dof`` it was scaled by a sigma0 of that many degrees of freedom: radius^2 = 2 F(P; 2, dof).
        """
        radius = confidence_radius(probability, dof=dof)
        eigenvalues, eigenvectors = np.linalg.eigh(np.asarray(covariance_m2, dtype=np.float64))
        minor, major = np.sqrt(np.maximum(eigenvalues, 0.0)) * radius
        azimuth_deg = math.degrees(math.atan2(eigenvectors[1, 1], eigenvectors[0, 1])) % 180.0
        return cls(float(major), float(minor), azimuth_deg, probability)


def confidence_radius(probability: float, *, dof: float | None = None) -> float:
    """Return the Mahalanobis radius that holds ``probability`` in two dimensions (2.448 for 95 %, 3.035 for 99 %)."""
    _require(0.0 < probability < 1.0, "probability", "must be within 0 .. 1", probability)
    if dof is None or math.isinf(dof):
        return math.sqrt(-2.0 * math.log1p(-probability))
    _require(dof > 0.0, "dof", "must be > 0", dof)
    return math.sqrt(dof * ((1.0 - probability) ** (-2.0 / dof) - 1.0))


@dataclass(frozen=True, slots=True)
class AdjustedObservation:
    """One observation after the adjustment; ``unit`` is "m" or "deg", residual = adjusted - observed.

    ``standardized`` is residual / (sigma sqrt(redundancy_number)); None where the redundancy number is zero.
    ``mdb`` is the minimal detectable bias in the same unit; None where nothing could detect it. ``external_m`` is how
    far an error of that size would move the position (external reliability).
    """

    target: str
    mark: str
    kind: ObservationKind
    observed: float
    adjusted: float
    residual: float
    sigma: float
    standardized: float | None
    redundancy_number: float
    weight: float
    mdb: float | None
    external_m: float | None = None

    @property
    def unit(self) -> str:
        return "m" if self.kind == "range" else "deg"


@dataclass(frozen=True, slots=True)
class GlobalTest:
    """Chi-square test of the weighted sum of squared residuals against its a priori expectation."""

    statistic: float
    dof: float
    threshold: float
    passed: bool


@dataclass(frozen=True, slots=True)
class Integrity:
    """What the fix guarantees: radius that holds 95 %, and the protection level where the redundancy carries one.

    ``slope_level_m`` is the protection level by the slope method, for comparison; ``reason`` says in words why there
    is no protection level, and is empty where there is one or none was asked for.
    """

    r95_m: float
    protection_level_m: float | None = None
    probability_of_false_alarm: float | None = None
    probability_of_missed_detection: float | None = None
    slope_level_m: float | None = None
    reason: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Fix:
    """An adjusted position and heading.

    ``covariance`` and ``cofactor_matrix`` are (3, 3) in (north m, east m, heading rad), or (2, 2) where the heading is
    not an unknown; covariance = sigma0^2 cofactor_matrix when ``covariance_scaling`` is "a_posteriori".
    ``redundancy`` counts observations minus unknowns; ``dof`` is the weighted count that belongs to sigma0.
    ``compass_error_deg`` with its 1 sigma is what must be added to the true bearings, where it was an unknown.
    """

    position: Position | PlanePosition
    heading_deg: float | None
    covariance: FloatArray
    sigma0: float
    redundancy: int
    observations: tuple[AdjustedObservation, ...]
    association: Association | None
    epoch: Epoch | None
    cofactor_matrix: FloatArray
    covariance_scaling: CovarianceScaling
    dof: float
    kernel: str
    heading_reference: HeadingReference = "radar_zero_mark"
    global_test: GlobalTest | None = None
    integrity: Integrity | None = None
    alternatives: tuple[Alternative, ...] = ()
    start: str = ""
    notes: tuple[str, ...] = field(default=())
    compass_error_deg: float | None = None
    compass_error_sigma_deg: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "covariance", _frozen_array(self.covariance, np.float64))
        object.__setattr__(self, "cofactor_matrix", _frozen_array(self.cofactor_matrix, np.float64))

    def ellipse(self, probability: float = 0.95) -> Ellipse:
        """Return the confidence ellipse of the position at ``probability``."""
        dof = self.dof if self.covariance_scaling == "a_posteriori" else None
        return Ellipse.from_covariance(self.covariance[:2, :2], probability, dof=dof)

    @property
    def outliers(self) -> tuple[AdjustedObservation, ...]:
        """Observations that the kernel has damped below half weight."""
        return tuple(o for o in self.observations if o.weight < 0.5)


@dataclass(frozen=True, slots=True, eq=False)
class MeanFix:
    """The plain-mean fix of single-mark positions: the baseline.

    ``individual_ne_m`` is (k, 2), each pair's own position about ``position`` in (north, east); ``used`` (k,) tells
    which survived the rejection. ``covariance`` (2, 2) is the spread of the single-mark positions (not of their mean).
    ``heading_deg`` is None where all bearings are true and no heading was told.
    """

    position: Position
    heading_deg: float | None
    individual_ne_m: FloatArray
    used: NDArray[np.bool_]
    covariance: FloatArray | None
    weights: FloatArray

    def ellipse(self, probability: float = 0.95) -> Ellipse | None:
        """Return the ellipse of the spread at ``probability``, None with fewer than three positions."""
        return None if self.covariance is None else Ellipse.from_covariance(self.covariance, probability)


@dataclass(frozen=True, slots=True)
class GnssVerdict:
    """The GNSS of the log against the fix: what was found, how far apart, and what could have been seen at all.

    Where epochs were followed, ``verdict`` is the lasting one and ``instant`` that of this epoch alone; ``alert`` is
    the sentence of a change, once; ``drift_mps`` the rate at which GNSS leaves the fix. None for a single epoch.
    """

    position: Position
    distance_m: float
    verdict: Verdict
    threshold_m: float
    smallest_detectable_m: float
    reasons: tuple[str, ...]
    instant: Verdict | None = None
    alert: str | None = None
    drift_mps: float | None = None


VeracityStatus = Literal["agrees", "disagrees", "no_echo", "elsewhere", "too_little"]


@dataclass(frozen=True, slots=True)
class ShipVeracity:
    """One AIS station against radar, over all epochs that were fed.

    ``offset_m`` and ``azimuth_deg`` say where radar sees it from where its AIS says it is, ``sigma_m`` how well that is
    known along this direction, ``p_value`` how often a true AIS would give as much; None where no echo belongs to it.
    ``seen`` counts the epochs with an echo, ``expected`` those in which one had to be seen, ``missing`` those of them
    without; ``target`` is the echo that lies elsewhere.
    """

    mark: str
    mmsi: int | None
    name: str | None
    status: VeracityStatus
    epochs: int
    seen: int
    expected: int
    missing: int
    offset_m: float | None = None
    azimuth_deg: float | None = None
    sigma_m: float | None = None
    p_value: float | None = None
    target: str | None = None
    note: str = ""
