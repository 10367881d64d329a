"""The fix of a window: newest pose, covariance, one pair of rows for each track, and what was estimated beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from navfix.adjustment.reliability import DELTA0, global_test, radius_of_probability
from navfix.adjustment.window.components import Judged, reference_deviation
from navfix.adjustment.window.motion import logged
from navfix.adjustment.window.problem import Sighting, Window, gyro_steps
from navfix.adjustment.window.rows import (
    MOVE,
    NEW_BEARING,
    NEW_RANGE,
    OFFSET,
    STEADY_BEARING,
    STEADY_RANGE,
    TURN,
    radar_rows,
    radar_sigma,
)
from navfix.adjustment.window.state import CLOCK, COMPASS, CURRENT_EAST, CURRENT_NORTH, RANGE_BIAS
from navfix.kernels import Kernel
from navfix.types import AdjustedObservation, Association, Epoch, Fix, FloatArray, GlobalTest, Integrity
from navfix.units import wrap_360

_LISTED = 6  # marks whose offsets are told one by one
_STANDS_OFF = 3.0  # sigma
_UNSTEADY = 4.0  # variance component of own sensors from which on the notes say so
_LEAST_REDUNDANCY = 1e-9


def fix_of(
    epochs: Sequence[Epoch],
    sightings: Sequence[Sighting],
    window: Window,
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
    observations = _observations(sightings, window, found, None if whole else at)
    if whole:
        epoch = _epoch_with_marks(epoch, sightings)
    used = sum(o.weight > 0.0 for o in observations)
    compass_deg = _compass_error_deg(window, found) if np.any(window.seen.is_true) else (None, None)
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
        notes=_notes(window, found, solver, at),
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


# -------------------------------------------------------------------------------------------------- residual report


def _observations(
    sightings: Sequence[Sighting], window: Window, found: Judged, at: int | None
) -> tuple[AdjustedObservation, ...]:
    """Return range and bearing of each track: mean residual over the window against the mark as given; eq. (10.10).

    With ``at`` only the tracks of that epoch, as observed there.
    """
    plan, state = found.damper.plan, found.descended.state
    bare = state.copy()
    bare[plan.layout.shared + 5 :] = 0.0
    v, a = radar_rows(window, plan.layout, bare)
    sigma = radar_sigma(window)
    v, a = v.reshape(-1, 2) * sigma, a.reshape(-1, 2, a.shape[1]) * sigma[:, :, None]
    columns = plan.columns[plan.radar].reshape(-1, 2, a.shape[2])
    _, weights = found.damper.judge(found.damper.rows(state).residual)
    rows = []
    for track, label in enumerate(window.tracks.label):
        members = np.flatnonzero(window.seen.track == track)
        here = members if at is None else members[window.seen.epoch[members] == at]
        if not len(here):
            continue
        mark = int(window.tracks.mark[track])
        static = float(weights.static[mark]) * float(found.damper.taking_part[mark])
        for part in (0, 1):
            w = weights.sighting[members, part]
            share = w / w.sum() if w.sum() > 0.0 else np.full(len(members), 1.0 / len(members))
            last = here[-1]
            kept = [0, 1, 2, 6, 7]  # pose and globals: what stays with the mark is the residual's own business
            row, entry = a[last, part, kept], columns[last, part, kept]
            spread = _spread(window, found, track, part, members, share)
            explained = float(row @ found.cofactor[entry[:, None], entry] @ row)
            rows.append(
                _row(
                    sightings[last], label, part, float(share @ v[members, part]), spread, explained,
                    static * float(np.mean(w)),
                )
            )  # fmt: skip
    return tuple(rows)


def _spread(window: Window, found: Judged, track: int, part: int, members: np.ndarray, share: FloatArray) -> float:
    """Return 1 sigma of a track's mean: what stays with track and mark, and what is new, the memory counted."""
    components, mark = found.damper.components, int(window.tracks.mark[track])
    across = 1.0 if part == 0 else 1.0 / max(float(window.seen.value[members[-1], 0]), 1.0)
    offset = window.mark_sigma_m[mark] * across
    steady = window.tracks.sigma[track, part]
    new = radar_sigma(window)[members, part]
    variance = components[OFFSET] * offset**2 + components[(STEADY_RANGE, STEADY_BEARING)[part]] * steady**2
    variance += components[(NEW_RANGE, NEW_BEARING)[part]] * float(share**2 @ new**2)
    return math.sqrt(float(variance))


def _row(
    last: Sighting, label: str, part: int, residual: float, sigma: float, explained: float, weight: float
) -> AdjustedObservation:
    unit = 1.0 if part == 0 else math.degrees(1.0)
    observed = last.target.range_m if part == 0 else last.target.bearing_deg
    redundancy = min(max(1.0 - weight * explained / sigma**2, 0.0), 1.0)
    testable = redundancy > _LEAST_REDUNDANCY
    adjusted = observed + residual * unit
    kind = "true_bearing" if last.target.bearing_reference == "true" else "relative_bearing"
    return AdjustedObservation(
        target=label,
        mark=last.mark.label,
        kind="range" if part == 0 else kind,  # type: ignore[arg-type]
        observed=observed,
        adjusted=adjusted if part == 0 else wrap_360(adjusted),
        residual=residual * unit,
        sigma=sigma * unit,
        standardized=residual / (sigma * math.sqrt(redundancy)) if testable else None,
        redundancy_number=redundancy,
        weight=weight,
        mdb=DELTA0 * sigma * unit / math.sqrt(redundancy) if testable else None,
    )


# ------------------------------------------------------------------------------------------------------------ notes


def _notes(window: Window, found: Judged, solver: str, at: int) -> tuple[str, ...]:
    span_s = window.time_s[-1] - window.time_s[0]
    road = "GTSAM" if solver == "gtsam" else "dense normal equations"
    said = [f"window of {window.epochs} scans over {span_s:.0f} s, {len(window.tracks.label)} tracks; solved by {road}"]
    said += _globals(window, found)
    said += _components(window, found)
    said += _offsets(window, found)
    before = window.seen.epoch[window.seen.epoch <= at]
    silent_s = window.time_s[at] - window.time_s[before.max()] if len(before) else 0.0
    if silent_s > 0.0:
        said.append(f"no track was seen for the last {silent_s:.0f} s: the pose is carried on by own motion")
    return tuple(said)


def _shared_errors(window: Window, found: Judged) -> tuple[FloatArray, FloatArray]:
    """Return what all sightings share (5,) with 1 sigma (5,): clock [s], range bias [m], compass [rad], current."""
    first = found.damper.plan.layout.shared
    at, spread = slice(first, first + 5), window.global_sigma
    value: FloatArray = spread * found.descended.state[at]
    sigma: FloatArray = spread * np.sqrt(np.diagonal(found.cofactor[at, at]))
    return value, sigma


def _compass_error_deg(window: Window, found: Judged) -> tuple[float, float]:
    """Return what must be added to the true bearings, and its 1 sigma [deg]."""
    value, sigma = _shared_errors(window, found)
    return math.degrees(float(value[COMPASS])), math.degrees(float(sigma[COMPASS]))


def _globals(window: Window, found: Judged) -> list[str]:
    value, sigma = _shared_errors(window, found)
    said = [
        f"radar clock offset {value[CLOCK]:+.2f} s +- {sigma[CLOCK]:.2f}, "
        f"range bias {value[RANGE_BIAS]:+.0f} m +- {sigma[RANGE_BIAS]:.0f} (1 sigma)"
    ]
    if np.any(window.seen.is_true):
        error, spread_deg = _compass_error_deg(window, found)
        said.append(f"compass error {error:+.2f} deg +- {spread_deg:.2f} (1 sigma), to be added to the true bearings")
    if np.any(logged(window)):
        word = "current" if np.any(window.own.through_water) else "drift of the log"
        speed = math.hypot(value[CURRENT_NORTH], value[CURRENT_EAST])
        towards = math.degrees(math.atan2(value[CURRENT_EAST], value[CURRENT_NORTH])) % 360.0
        larger = max(sigma[CURRENT_NORTH], sigma[CURRENT_EAST])
        said.append(f"{word} {speed:.2f} m/s towards {towards:03.0f} deg +- {larger:.2f} m/s (1 sigma)")
    return said


def _components(window: Window, found: Judged) -> list[str]:
    root = np.sqrt(found.damper.components)
    said = [
        "errors in units of their models: new in each scan "
        f"{root[NEW_RANGE]:.2f} (range), {root[NEW_BEARING]:.2f} (bearing); staying with a track "
        f"{root[STEADY_RANGE]:.2f}, {root[STEADY_BEARING]:.2f}; of the marks {root[OFFSET]:.2f}"
    ]
    if root[TURN] ** 2 > _UNSTEADY and np.any(np.isfinite(gyro_steps(window))):
        said.append(f"the turns of the gyro do not fit: their sigma was taken {root[TURN]:.1f} times as large")
    if root[MOVE] ** 2 > _UNSTEADY and np.any(logged(window)):
        said.append(f"the log does not fit: its sigma was taken {root[MOVE]:.1f} times as large")
    return said


def _offsets(window: Window, found: Judged) -> list[str]:
    """Name the marks that stand off by more than chance: an estimate beyond `_STANDS_OFF` times its own spread.

    The estimate is drawn towards 0 by the mark's own sigma, so its spread is what the data have taken off that.
    """
    layout, state = found.damper.plan.layout, found.descended.state
    prior = found.damper.components[OFFSET]
    told = []
    for mark, label in enumerate(window.mark_labels):
        at, sigma_m = int(layout.offset(np.array(mark))), float(window.mark_sigma_m[mark])
        spread = np.sqrt(np.maximum(prior - np.diagonal(found.cofactor)[at : at + 2], _LEAST_REDUNDANCY))
        size = float(np.max(np.abs(state[at : at + 2]) / spread))
        if size > _STANDS_OFF and found.damper.taking_part[mark]:
            north, east = sigma_m * state[at : at + 2]
            left = sigma_m * math.sqrt(float(np.diagonal(found.cofactor)[at : at + 2].max()))
            told.append((size, f"{label} {north:+.0f} N {east:+.0f} E +- {left:.0f}"))
    if not told:
        return []
    named = ", ".join(text for _, text in sorted(told, reverse=True)[:_LISTED])
    more = f" and {len(told) - _LISTED} more" if len(told) > _LISTED else ""
    return [f"marks that stand off from where they are said to be [m]: {named}{more}"]
