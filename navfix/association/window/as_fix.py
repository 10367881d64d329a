"""A window's answer as a fix: pose and covariance at its end, the matched tracks as adjusted observations."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from navfix.association.scene import position_of
from navfix.association.window import pairs
from navfix.association.window.jackknife import PoseAtEnd
from navfix.association.window.joint import Joint, Window
from navfix.types import AdjustedObservation, Association, Epoch, Fix, FloatArray
from navfix.units import wrap_180, wrap_360


def as_fix(found: Joint, row: int, pose: PoseAtEnd, association: Association, epoch: Epoch) -> Fix:
    """Return the fix of one answer at the newest epoch; residuals are the means of the tracks over the window."""
    window = found.window
    answers = found.answers.take(np.array([row]))
    matched = pairs.one_to_one(window.field, answers.knots)
    observations: list[AdjustedObservation] = []
    scene = window.field.scene
    for (track, mark), misfit_m in zip(matched.index.tolist(), matched.misfit_m, strict=True):
        if scene.tracks[track].newest < 0 or scene.paths.newest[mark] < 0:
            continue  # it took part, but the newest epoch does not show it
        observations += _observations(window, track, mark, misfit_m, pose)
    turned_deg = math.degrees(pose.heading_rad)
    true = scene.flat.reference == "true"  # then the turn of the picture is the compass error, and no heading
    covariance = pose.covariance[:2, :2] if true else pose.covariance
    notes = (f"From {len(matched.index)} tracks over {window.field.scene.knots * window.field.model.bin_s:.0f} s.",)
    return Fix(
        position=position_of(window.field.scene.flat, pose.p),
        heading_deg=None if true else turned_deg % 360.0,
        covariance=covariance,
        sigma0=1.0,
        redundancy=max(0, len(observations) - 3),
        observations=tuple(observations),
        association=association,
        epoch=epoch,
        cofactor_matrix=covariance,
        covariance_scaling="a_priori",
        dof=math.inf,
        kernel="window",
        start="window",
        compass_error_deg=float(wrap_180(turned_deg)) if true else None,
        compass_error_sigma_deg=math.degrees(math.sqrt(pose.covariance[2, 2])) if true else None,
        notes=notes,
    )


def _observations(
    window: Window, track: int, mark: int, misfit_m: FloatArray, pose: PoseAtEnd
) -> list[AdjustedObservation]:
    scene = window.field.scene
    range_m = float(scene.flat.range_m[track])
    bearing_deg = math.degrees(float(scene.flat.bearing_rad[track]))
    mark_m2 = float(scene.paths.constant_m[mark] ** 2)
    kind: Literal["relative_bearing", "true_bearing"] = (
        "true_bearing" if scene.flat.reference == "true" else "relative_bearing"
    )
    azimuth = math.radians(bearing_deg) + pose.heading_rad - scene.yaw_at_end
    made = []
    for axis, name in enumerate(("range", kind)):
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
        residual_m, observed = float(misfit_m[axis]), range_m if axis == 0 else wrap_360(bearing_deg)
        made.append(
            AdjustedObservation(
                target=scene.tracks[track].label,
                mark=scene.paths.marks[mark].label,
                kind=name,  # type: ignore[arg-type]
                observed=observed,
                adjusted=observed + residual_m * unit,
                residual=residual_m * unit,
                sigma=sigma_m * unit,
                standardized=residual_m / (sigma_m * math.sqrt(redundancy)) if redundancy > 0.01 else None,
                redundancy_number=redundancy,
                weight=1.0,
                mdb=sigma_m * unit * 4.1321 / math.sqrt(redundancy) if redundancy > 0.01 else None,
            )
        )
    return made
