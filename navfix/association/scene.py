"""An epoch as arrays: radar targets and marks as complex numbers in one plane.

A point (north, east) is the complex number north + 1j * east, so that its argument is the azimuth, clockwise from
north. A target at range r and bearing b is rho = r exp(1j b); own ship at p with heading h sees it at
world = p + exp(1j h) rho. Mirror images cannot be expressed, so no reflection can be found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from navfix.catalog import AssociationModel, RadarModel
from navfix.geodesy import LocalPlane, cloud_to_plane, convergence, ecef
from navfix.types import Epoch, FloatArray, IntArray, Mark, Position, RadarTarget

ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]


BY_TARGET = (
    "rho",
    "range_m",
    "bearing_rad",
    "range_sigma_m",
    "bearing_sigma_rad",
    "target_speed_mps",
    "target_length_m",
    "target_index",
)
BY_MARK = ("z", "mark_sigma_m", "conspicuity", "mark_speed_mps", "mark_length_m", "mark_index")


@dataclass(frozen=True, eq=False)
class Scene:
    """Targets (m of them) and marks (n of them) as arrays.

    Attributes
    ----------
    origin : of the plane
    rho (m,) : complex targets [m]; ``range_m``, ``bearing_rad``, ``range_sigma_m``, ``bearing_sigma_rad`` (m,)
    z (n,) : complex marks [m]; ``mark_sigma_m`` (n,) per axis; ``conspicuity`` (n,) 0 .. 1
    target_speed_mps (m,), mark_speed_mps (n,) : over ground, NaN where not known
    target_length_m (m,), mark_length_m (n,) : of echo and ship, NaN where not known
    reference : "relative" or "true": what the bearings count from
    target_index (m,), mark_index (n,) : places in the epoch's tuples
    """

    origin: Position
    rho: ComplexArray
    range_m: FloatArray
    bearing_rad: FloatArray
    range_sigma_m: FloatArray
    bearing_sigma_rad: FloatArray
    z: ComplexArray
    mark_sigma_m: FloatArray
    conspicuity: FloatArray
    target_speed_mps: FloatArray
    mark_speed_mps: FloatArray
    target_length_m: FloatArray
    mark_length_m: FloatArray
    reference: str
    target_index: IntArray
    mark_index: IntArray

    @cached_property
    def radar_range_m(self) -> float:
        """Radius of the area that the radar watched: a little beyond its farthest target."""
        return float(self.range_m.max()) * 1.02

    @cached_property
    def ray(self) -> ComplexArray:
        """The targets' directions (m,) as unit vectors."""
        ray: ComplexArray = np.exp(1j * self.bearing_rad)
        return ray

    @cached_property
    def mark_xy(self) -> FloatArray:
        """Marks as (n, 2) for the KD-tree."""
        return np.column_stack([self.z.real, self.z.imag])

    def keeping(self, targets: IntArray | slice, marks: IntArray | slice) -> Scene:
        """Return the scene with only these ``targets`` and ``marks`` (indices of this scene)."""
        return replace(
            self,
            **{name: getattr(self, name)[targets] for name in BY_TARGET},
            **{name: getattr(self, name)[marks] for name in BY_MARK},
        )


def build(epoch: Epoch, radar: RadarModel, model: AssociationModel) -> Scene:
    """Turn an epoch into arrays about the middle of its marks.

    Where relative and true bearings are mixed, the larger group is associated.
    """
    reference = _prevailing_reference(epoch.targets)
    chosen = [i for i, target in enumerate(epoch.targets) if target.bearing_reference == reference]
    targets = [epoch.targets[i] for i in chosen]
    range_m = np.array([t.range_m for t in targets], dtype=np.float64)
    bearing_rad = np.radians([t.bearing_deg for t in targets])
    model_sigma_m = radar.sigma_of_range_m(range_m)
    range_sigma_m = np.array([t.range_sigma_m or s for t, s in zip(targets, model_sigma_m, strict=True)])
    bearing_sigma_rad = np.radians([t.bearing_sigma_deg or radar.bearing_sigma_deg for t in targets])
    lat_deg = np.array([m.position.lat_deg for m in epoch.marks])
    lon_deg = np.array([m.position.lon_deg for m in epoch.marks])
    origin = middle(lat_deg, lon_deg)
    plane = cloud_to_plane(origin, lat_deg, lon_deg)
    return Scene(
        origin=origin,
        rho=np.asarray(range_m * np.exp(1j * bearing_rad), dtype=np.complex128),
        range_m=range_m,
        bearing_rad=bearing_rad,
        range_sigma_m=range_sigma_m,
        bearing_sigma_rad=bearing_sigma_rad,
        z=plane[:, 0] + 1j * plane[:, 1],
        mark_sigma_m=np.array([m.sigma_m for m in epoch.marks]),
        conspicuity=np.array([conspicuity(m, model) for m in epoch.marks]),
        target_speed_mps=np.array([_target_speed(t) for t in targets]),
        mark_speed_mps=np.array([_mark_speed(m) for m in epoch.marks]),
        target_length_m=np.array([t.length_m or np.nan for t in targets]),
        mark_length_m=np.array([m.hull.length_m or np.nan if m.hull else np.nan for m in epoch.marks]),
        reference=reference,
        target_index=np.array(chosen, dtype=np.int64),
        mark_index=np.arange(len(epoch.marks)),
    )


def conspicuity(mark: Mark, model: AssociationModel) -> float:
    """Return how likely a radar in range sees this mark, against the best target there is (1)."""
    if mark.kind != "ship":
        return model.conspicuity_aton
    length_m = mark.hull.length_m if mark.hull is not None else None
    if length_m is None or length_m <= 0.0:
        return model.conspicuity_small if mark.ais_class == "B" else model.conspicuity_unknown
    if length_m > model.long_m:
        return model.conspicuity_long
    return model.conspicuity_medium if length_m > model.medium_m else model.conspicuity_small


def position_of(scene: Scene, p: complex) -> Position:
    """Return the place of a complex number of the scene's plane."""
    return LocalPlane(scene.origin).to_position(p.real, p.imag)


def convergence_of(scene: Scene, p: ComplexArray) -> FloatArray:
    """Return what is to be added [rad] (k,) to a direction of the plane to have it from true north at ``p`` (k,)."""
    return convergence(scene.origin, p)


def heading_of(scene: Scene, p: complex, heading_rad: float) -> float:
    """Return the heading [deg, 0 .. 360] from true north at ``p`` of one that counts from the plane's north."""
    return math.degrees(heading_rad + float(convergence_of(scene, np.array([p]))[0])) % 360.0


def _target_speed(target: RadarTarget) -> float:
    """Return the speed over ground [m/s], NaN where it is not known; a track that is still being acquired has none."""
    return np.nan if target.speed_mps is None or target.status == "Q" else target.speed_mps


def _mark_speed(mark: Mark) -> float:
    """Return the speed over ground [m/s], NaN where it is not known; an aid to navigation lies still."""
    if mark.kind != "ship":
        return 0.0
    return np.nan if mark.speed_mps is None else mark.speed_mps


def _prevailing_reference(targets: tuple[RadarTarget, ...]) -> str:
    true = sum(t.bearing_reference == "true" for t in targets)
    return "true" if true > len(targets) - true else "relative"


def middle(lat_deg: FloatArray, lon_deg: FloatArray) -> Position:
    """Return the component-wise median place: a few positions from the other side of the world do not move it far."""
    x, y, z = np.median(ecef(lat_deg, lon_deg), axis=0)
    return Position(float(np.degrees(np.arctan2(z, np.hypot(x, y)))), float(np.degrees(np.arctan2(y, x))))
