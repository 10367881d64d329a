"""The fix of a window: newest pose, covariance, one pair of rows for each track, and what was estimated beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from navfix.adjustment.reliability import global_test, radius_of_probability
from navfix.adjustment.window.components import Judged, reference_deviation
from navfix.adjustment.window.notes import compass_error_deg, window_notes
from navfix.adjustment.window.problem import Sighting, WindowNetwork
from navfix.adjustment.window.residuals import track_observations
from navfix.adjustment.window.rows import NEW_BEARING, NEW_RANGE, OFFSET, STEADY_BEARING, STEADY_RANGE
from navfix.kernels import Kernel
from navfix.types import Association, Epoch, Fix, FloatArray, GlobalTest, Integrity
from navfix.units import wrap_360


def fix_of(
    epochs: Sequence[Epoch],
    sightings: Sequence[Sighting],
    window: WindowNetwork,
    found: Judged,
    cofactor: FloatArray,
    kernel: Kernel,
    solver: str,
    *,
    at: int | None = None,
) -> Fix:
    """Return the record of a solved window for the epoch ``at``, default the newest; ``cofactor`` (3, 3) of its pose.

    For another epoch than the newest only the tracks that it shows are reported.
    """
    whole, at = at is None, len(epochs) - 1 if at is None else at
    pose = found.damper.plan.layout.poses(found.descended.state)[at]
    position = window.plane.to_position(float(pose[0]), float(pose[1]))
    sigma0, dof = reference_deviation(found)
    unknowns = 3 if window.any_relative else 2
    heading_deg = None
    if window.any_relative:
        heading_deg = wrap_360(math.degrees(float(pose[2])) + window.plane.convergence_deg(position))
    cofactor = cofactor[:unknowns, :unknowns]
    covariance = sigma0**2 * cofactor
    epoch, association = epochs[at], _association(epochs, sightings, at)
    observations = track_observations(sightings, window, found, None if whole else at)
    if whole:
        epoch = _epoch_with_marks(epoch, sightings)
    used = sum(o.weight > 0.0 for o in observations)
    compass_deg = compass_error_deg(window, found) if np.any(window.seen.is_true) else (None, None)
    return Fix(
        position=position,
        heading_deg=heading_deg,
        covariance=covariance,
        sigma0=sigma0,
        redundancy=max(used - unknowns, 0),
        observations=observations,
        association=association,
        epoch=epoch,
        cofactor_matrix=cofactor,
        covariance_scaling="a_posteriori",
        dof=dof,
        kernel=kernel.name,
        global_test=_global_test(found),
        integrity=Integrity(r95_m=radius_of_probability(covariance[:2, :2], 0.95, dof=dof)),
        start="window",
        notes=window_notes(window, found, solver, at),
        compass_error_deg=compass_deg[0],
        compass_error_sigma_deg=compass_deg[1],
    )


def _global_test(found: Judged) -> GlobalTest | None:
    """Test the sigmas as the models give them: components of the radar and of what stays, memory counted off."""
    components = found.damper.components
    judged_ = [NEW_RANGE, NEW_BEARING, STEADY_RANGE, STEADY_BEARING, OFFSET]
    statistic = float(np.sum((components * found.squared / found.memory)[judged_]))
    return global_test(statistic, float(np.sum((found.redundancy / found.memory)[judged_])))


def _epoch_with_marks(epoch: Epoch, sightings: Sequence[Sighting]) -> Epoch:
    """Return the newest epoch with the marks that only earlier ones held: the record must carry all of its marks."""
    held = {mark.label for mark in epoch.marks}
    latest = {s.mark.label: s.mark for s in sightings if s.mark.label not in held}
    return replace(epoch, marks=(*epoch.marks, *latest.values())) if latest else epoch


def _association(epochs: Sequence[Epoch], sightings: Sequence[Sighting], at: int) -> Association:
    epoch = epochs[at]
    targets = {id(target): index for index, target in enumerate(epoch.targets)}
    marks = {mark.label: index for index, mark in enumerate(epoch.marks)}
    pairs = [(targets[id(s.target)], marks[s.mark.label]) for s in sightings if s.epoch == at]
    return Association(pairs=np.array(pairs, np.int64).reshape(-1, 2), probability=np.ones(len(pairs)), method="window")
