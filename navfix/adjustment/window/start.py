"""Where the descent begins: one pose, then the poses of all epochs by medians over the marks that agree with it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navfix.adjustment.epoch import adjust
from navfix.adjustment.window.problem import Sighting, WindowNetwork, gyro_steps
from navfix.adjustment.window.state import Layout
from navfix.catalog import RadarModel
from navfix.errors import NoFix, TooFewPairs
from navfix.geodesy import LocalPlane
from navfix.kernels import Kernel
from navfix.types import Association, Epoch, FloatArray, Position
from navfix.units import wrap_pi

Pose = tuple[Position, float | None]
_AGREES_M, _AGREES_SHARE = 250.0, 0.06
_ROUNDS = 4
_TRIED = 3  # epochs that are solved alone before the window is given up


def first_pose(
    epochs: Sequence[Epoch], sightings: Sequence[Sighting], radar: RadarModel, kernel: Kernel
) -> tuple[int, Pose]:
    """Return an epoch and its pose from that epoch alone: the newest with three pairs or more, else the fullest.

    Raises
    ------
    NoFix : what `adjust` raised for the first of the epochs tried
    """
    of_epoch: dict[int, list[Sighting]] = {}
    for s in sightings:
        of_epoch.setdefault(s.epoch, []).append(s)
    order = sorted(of_epoch, key=lambda e: (min(len(of_epoch[e]), 3), e), reverse=True)
    first: NoFix | None = None
    for number in order[:_TRIED]:
        pairs = [(s.target.label, s.mark.label) for s in of_epoch[number]]
        if len(pairs) < 2:
            break
        try:
            fix = adjust(epochs[number], Association.from_pairs(epochs[number], pairs), radar=radar, kernel=kernel)
        except NoFix as error:
            first = first or error
            continue
        assert isinstance(fix.position, Position)
        return number, (fix.position, fix.heading_deg)
    raise first or TooFewPairs(
        "no epoch of the window holds two of the pairs: give a start", observations=2, unknowns=3
    )


def poses_from(window: WindowNetwork, anchor: int, pose: FloatArray) -> FloatArray:
    """Return (E, 3) poses: that of the ``anchor`` epoch carried to its neighbours, scan by scan, both ways."""
    poses = np.tile(np.asarray(pose, np.float64), (window.epochs, 1))
    sure = _agreeing(window, anchor, poses[anchor])
    turned = np.nan_to_num(gyro_steps(window))
    for order in (range(anchor + 1, window.epochs), range(anchor - 1, -1, -1)):
        step = 1 if order.step > 0 else -1
        for e in order:
            before = e - step
            guess = poses[before].copy()
            guess[2] += step * turned[min(e, before)]
            guess[:2] += _run(poses, before, step, window.time_s, e)
            poses[e] = _from_marks(window, e, guess, sure)
    return poses


def initial_state(window: WindowNetwork, layout: Layout, poses: FloatArray) -> FloatArray:
    """Return the state with these poses and everything else zero."""
    state = np.zeros(layout.size)
    layout.poses(state)[:] = poses
    if not window.any_relative:
        told = np.isfinite(window.own.gyro_rad)
        layout.poses(state)[:, 2] = np.where(told, window.own.gyro_rad, poses[:, 2])
    return state


def _run(poses: FloatArray, before: int, step: int, time_s: FloatArray, e: int) -> FloatArray:
    """Return the displacement if the ship went on as between the two epochs solved last; none without two."""
    earlier = before - step
    if not 0 <= earlier < len(poses) or abs(e - before) != 1:
        return np.zeros(2)
    elapsed_s = time_s[before] - time_s[earlier]
    velocity = (poses[before, :2] - poses[earlier, :2]) / elapsed_s
    fast = float(np.hypot(*velocity))
    return np.asarray(velocity * (time_s[e] - time_s[before]) * min(1.0, 25.0 / max(fast, 1e-9)))


def _agreeing(window: WindowNetwork, anchor: int, pose: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Tell which marks (M,) fit the pose at the anchor; all that were not seen there are trusted for a start."""
    seen = window.seen
    here = seen.epoch == anchor
    turn = np.where(seen.is_true, 0.0, pose[2])
    direction = seen.value[:, 1] + turn
    echo = pose[:2] + seen.value[:, :1] * np.column_stack([np.cos(direction), np.sin(direction)])
    off_m = np.hypot(*(echo - seen.place_ne_m).T)
    bad = here & (off_m > _AGREES_M + _AGREES_SHARE * seen.value[:, 0])
    sure = np.ones(len(window.mark_labels), bool)
    sure[seen.mark[bad]] = False
    return sure


def _from_marks(
    window: WindowNetwork, e: int, guess: FloatArray, sure: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
) -> FloatArray:
    """Return the pose of one epoch: medians of the marks' own positions and of the turn, in alternation."""
    seen = window.seen
    here = np.flatnonzero(seen.epoch == e)
    here = here[sure[seen.mark[here]]] if np.count_nonzero(sure[seen.mark[here]]) >= 2 else here
    if not len(here):
        return guess
    pose, relative = guess.copy(), ~seen.is_true[here]
    place, value = seen.place_ne_m[here], seen.value[here]
    for _ in range(_ROUNDS):
        sight = place - pose[:2]
        if np.any(relative) and len(here) >= 2:
            off = wrap_pi(np.arctan2(sight[:, 1], sight[:, 0]) - value[:, 1] - pose[2])
            pose[2] += float(_median(off[relative]))
        direction = value[:, 1] + np.where(relative, pose[2], 0.0)
        own = place - value[:, :1] * np.column_stack([np.cos(direction), np.sin(direction)])
        pose[:2] = _median(own)
    return pose


def _median(values: FloatArray) -> FloatArray:
    """Return the median along the first axis; numpy's own takes ten times as long for so few."""
    ordered, count = np.sort(values, axis=0), len(values)
    return np.asarray(0.5 * (ordered[(count - 1) // 2] + ordered[count // 2]))


def plane_pose(plane: LocalPlane, pose: Pose) -> FloatArray:
    """Return (north m, east m, heading rad) of a place on earth and its heading (None: 0)."""
    position, heading_deg = pose
    north_m, east_m = plane.to_plane(position).tolist()
    turn_deg = 0.0 if heading_deg is None else heading_deg - plane.convergence_deg(position)
    return np.array([north_m, east_m, math.radians(turn_deg)])
