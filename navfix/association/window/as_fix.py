"""A window's answer as a fix: pose and covariance at its end, the matched tracks as adjusted observations."""

from __future__ import annotations

import math

import numpy as np

from navfix.association.scene import heading_of, position_of
from navfix.association.window.jackknife import PoseAtEnd
from navfix.association.window.joint import Window
from navfix.association.window.pairs import Pairs
from navfix.types import AdjustedObservation, Association, Fix, FloatArray, ObservationKind
from navfix.units import wrap_180, wrap_360


def as_fix(window: Window, pose: PoseAtEnd, matched: Pairs, association: Association) -> Fix:
    """Return the fix of an answer at the newest epoch; residuals are the means of the tracks over the window.

    True bearings say nothing of own heading: what they are turned by is not given out as one.
    """
    observations: list[AdjustedObservation] = []
    scene = window.field.scene
    yaw_rad = scene.yaw_at_end
    for (track, mark), misfit_m in zip(matched.index.tolist(), matched.misfit_m, strict=True):
        if scene.tracks[track].newest < 0 or scene.paths.newest[mark] < 0:
            continue  # it took part, but the newest epoch does not show it
        observations += _observations(window, track, mark, misfit_m, pose, yaw_rad)
    true = scene.flat.reference == "true"  # then the pose's angle is what the compass is off by
    angle_deg, unknowns = heading_of(scene.flat, pose.p, pose.heading_rad), 2 if true else 3
    notes = (f"From {len(matched.index)} tracks over {window.field.scene.knots * window.field.model.bin_s:.0f} s.",)
    return Fix(
        position=position_of(window.field.scene.flat, pose.p),
        heading_deg=None if true else angle_deg,
        covariance=pose.covariance[:unknowns, :unknowns],
        sigma0=1.0,
        redundancy=max(0, len(observations) - 3),
        observations=tuple(observations),
        association=association,
        epoch=window.epochs[-1],
        cofactor_matrix=pose.covariance[:unknowns, :unknowns],
        covariance_scaling="a_priori",
        dof=math.inf,
        kernel="window",
        start="window",
        notes=notes,
        compass_error_deg=wrap_180(angle_deg) if true else None,
        compass_error_sigma_deg=math.degrees(math.sqrt(float(pose.covariance[2, 2]))) if true else None,
    )


def _observations(
    window: Window, track: int, mark: int, misfit_m: FloatArray, pose: PoseAtEnd, yaw_rad: float
) -> list[AdjustedObservation]:
    scene = window.field.scene
    range_m = float(scene.flat.range_m[track])
    bearing_deg = math.degrees(float(scene.flat.bearing_rad[track]))
    mark_m2 = float(scene.paths.constant_m[mark] ** 2)
    kinds: tuple[ObservationKind, ObservationKind] = (
        "range",
        "true_bearing" if scene.flat.reference == "true" else "relative_bearing",
    )
    azimuth = math.radians(bearing_deg) + pose.heading_rad - yaw_rad
    made = []
    for axis, kind in enumerate(kinds):
        unit = 1.0 if axis == 0 else math.degrees(1.0 / range_m)
        sigma_m = math.sqrt(
            float(scene.constant_m2[track, axis] + scene.white_m2[track, axis] / scene.bins[track]) + mark_m2
        )
        along = np.array(
            [math.cos(azimuth), math.sin(azimuth), 0.0]
            if axis == 0
            else [-math.sin(azimuth), math.cos(azimuth), range_m]
        )
        redundancy = float(np.clip(1.0 - along @ pose.formal @ along / sigma_m**2, 0.0, 1.0))
        made.append(
            AdjustedObservation.of_track(
                scene.tracks[track].label,
                scene.paths.marks[mark].label,
                kind,
                observed=range_m if axis == 0 else wrap_360(bearing_deg),
                residual=float(misfit_m[axis]) * unit,
                sigma=sigma_m * unit,
                redundancy_number=redundancy,
                weight=1.0,
            )
        )
    return made
