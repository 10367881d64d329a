"""What comes out: the fix with its adjusted observations, ellipse, tests and integrity, and the plain-mean fix."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from navfix.types.checks import FloatArray, frozen_array, require
from navfix.types.found import Alternative, Association
from navfix.types.observed import Epoch
from navfix.types.places import PlanePosition, Position
from navfix.units import wrap_360

ObservationKind = Literal["range", "relative_bearing", "true_bearing"]
HeadingReference = Literal["radar_zero_mark", "bow"]
CovarianceScaling = Literal["a_priori", "a_posteriori"]
DELTA0 = 4.1321  # Baarda: bias of a standardised residual found with power .80 by a test at alpha .001
LEAST_REDUNDANCY = 1e-9  # below this nothing checks an observation


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

    def holds(self, north_m: float, east_m: float) -> bool:
        """Tell whether the ellipse holds a point so far to north and east of its centre."""
        azimuth = math.radians(self.azimuth_deg)
        along_m = north_m * math.cos(azimuth) + east_m * math.sin(azimuth)
        across_m = east_m * math.cos(azimuth) - north_m * math.sin(azimuth)
        if self.semi_minor_m <= 0.0:
            return across_m == 0.0 and abs(along_m) <= self.semi_major_m
        return math.hypot(along_m / self.semi_major_m, across_m / self.semi_minor_m) <= 1.0


def confidence_radius(probability: float, *, dof: float | None = None) -> float:
    """Return the Mahalanobis radius that holds ``probability`` in two dimensions (2.448 for 95 %, 3.035 for 99 %)."""
    require(0.0 < probability < 1.0, "probability", "must be within 0 .. 1", probability)
    if dof is None or math.isinf(dof):
        return math.sqrt(-2.0 * math.log1p(-probability))
    require(dof > 0.0, "dof", "must be > 0", dof)
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

    @classmethod
    def of_track(
        cls,
        target: str,
        mark: str,
        kind: ObservationKind,
        *,
        observed: float,
        residual: float,
        sigma: float,
        redundancy_number: float,
        weight: float,
    ) -> AdjustedObservation:
        """Make the record of a track over a window: ``observed`` and its mean residual with sigma, in m or deg."""
        adjusted = observed + residual
        root = math.sqrt(redundancy_number) if redundancy_number > LEAST_REDUNDANCY else None
        return cls(
            target=target,
            mark=mark,
            kind=kind,
            observed=observed,
            adjusted=adjusted if kind == "range" else wrap_360(adjusted),
            residual=residual,
            sigma=sigma,
            standardized=None if root is None else residual / (sigma * root),
            redundancy_number=redundancy_number,
            weight=weight,
            mdb=None if root is None else DELTA0 * sigma / root,
        )


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
    ``damping`` ("joint", "separate") and ``standardise`` ("sigma", "gdynia") say how the kernel was applied.
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
    damping: str = "joint"
    standardise: str = "sigma"

    def __post_init__(self) -> None:
        object.__setattr__(self, "covariance", frozen_array(self.covariance, np.float64))
        object.__setattr__(self, "cofactor_matrix", frozen_array(self.cofactor_matrix, np.float64))

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
