"""Robust start: trial fixes from one or two marks, consensus over all targets, and every minimum they lead to.

Kernels that forget gross errors have many minima; where the descent begins decides which one it finds. So trial fixes
are made from as few observations as a fix needs (one mark when the heading is known, two when it is not, two circles
or two lines when ranges or bearings are missing), all of them are judged by all targets, and the best places, the
Huber estimate, the least-squares estimate and any given pose are all followed down with the wanted kernel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix import catalog
from navfix.adjustment.dense import Descent, minimise, normal_matrix, observation_weights, saddle_exits
from navfix.adjustment.network import RANGE, RELATIVE_BEARING, Network, predict
from navfix.adjustment.whitening import target_norms, whitened
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi

DISTINCT_M = 50.0
DISTINCT_RAD = math.radians(5.0)
_TRUNCATED_AT = 5.0  # sigma: beyond it a target says only that it does not agree
_CONSENSUS_STARTS = 5
_TRIAL_BUDGET = 5_000  # trials x observations
_GRID_RINGS, _GRID_SPOKES = 14, 36
_ROUGH, _COARSE, _FINE = 0.1, 1e-2, 1e-9  # sigma
_ROUGH_STEPS, _COARSE_STEPS, _FINE_STEPS = 6, 10, 60


@dataclass(frozen=True, slots=True, eq=False)
class Minimum:
    """A place where a descent ended: pose (3,), its loss, where it came from, the targets left with half weight."""

    pose: FloatArray
    loss: float
    start: str
    targets: int


def find_minima(
    network: Network, kernel: Kernel, damping: Damping, *, given: tuple[tuple[str, FloatArray], ...] = ()
) -> list[Minimum]:
    """Return the distinct minima that at least one target supports, the lowest loss first; never empty.

    Minima are distinct when they lie more than 50 m apart (less in a small, precise network: five sigma), or when
    their headings differ by more than 5 deg.
    """
    trials = trial_fixes(network)
    score = consensus(network, trials)
    apart = separation(network, trials[int(np.argmin(score))])
    names, poses = _starts(network, damping, given, trials[_distinct(trials, score, *apart, limit=_CONSENSUS_STARTS)])
    coarse = minimise(network, kernel, damping, poses, tolerance=_COARSE, iterations=_COARSE_STEPS)
    chosen = _distinct(coarse.pose, coarse.loss, *apart)
    fine, names = _without_saddles(network, kernel, damping, coarse.pose[chosen], [names[i] for i in chosen])
    kept = _distinct(fine.pose, fine.loss, *apart)
    minima = [_minimum(network, kernel, damping, fine, i, names[i]) for i in kept]
    return [minima[0], *(m for m in minima[1:] if m.targets > 0)]


def _without_saddles(
    network: Network, kernel: Kernel, damping: Damping, poses: FloatArray, names: list[str]
) -> tuple[Descent, list[str]]:
    """Follow all poses to the end; what ends in a saddle goes on to both its sides."""
    fine = minimise(network, kernel, damping, poses, tolerance=_FINE, iterations=_FINE_STEPS)
    saddles, exits = saddle_exits(network, kernel, damping, fine.pose)
    if not np.any(saddles):
        return fine, names
    poses = np.concatenate([fine.pose[~saddles], exits])
    names = [name for name, saddle in zip(names, saddles, strict=True) if not saddle] + ["consensus"] * len(exits)
    return minimise(network, kernel, damping, poses, tolerance=_FINE, iterations=_FINE_STEPS), names


def follow(network: Network, kernel: Kernel, damping: Damping, start: FloatArray, name: str) -> Minimum:
    """Return the minimum that is reached from one start (3,)."""
    return _minimum(network, kernel, damping, minimise(network, kernel, damping, start[None, :]), 0, name)


def follow_given(network: Network, kernel: Kernel, damping: Damping, start: FloatArray) -> Minimum:
    """Return the minimum on the side of a start that somebody gave, (3,).

    A kernel that forgets outliers stays at a start that is far off, where everything looks like one. So the way over
    the Huber estimate is tried too, where the straight way keeps no more than half of the targets, and taken where it
    keeps more.
    """
    straight = follow(network, kernel, damping, start, "given")
    if 2 * straight.targets > len(network.blocks):
        return straight
    smooth = follow(network, catalog.kernel("huber"), damping, start, "given")
    led = follow(network, kernel, damping, smooth.pose, "given")
    return led if led.targets > straight.targets else straight


def _minimum(network: Network, kernel: Kernel, damping: Damping, found: Descent, index: int, name: str) -> Minimum:
    pose = found.pose[index]
    weights = observation_weights(network, kernel, damping, pose)
    targets = int(np.count_nonzero(weights[network.blocks[:, 0]] > 0.5))
    return Minimum(pose, float(found.loss[index]), name, targets)


def separation(network: Network, pose: FloatArray) -> tuple[float, float]:
    """Return how far apart [m], [rad] two minima must be to be two places: 50 m, less where five sigma are less."""
    _, a = whitened(network, pose)
    u = network.unknowns
    spread = np.linalg.pinv(normal_matrix(network, a, network.mask.astype(np.float64))[:u, :u], hermitian=True)
    five_sigma_m = 5.0 * math.sqrt(max(float(np.trace(spread[:2, :2])), 0.0))
    return (min(DISTINCT_M, five_sigma_m) if five_sigma_m > 0.0 else DISTINCT_M), DISTINCT_RAD


def _starts(
    network: Network, damping: Damping, given: tuple[tuple[str, FloatArray], ...], agreed: FloatArray
) -> tuple[list[str], FloatArray]:
    """Return names and poses: the given ones, those of the consensus (c, 3), and from its best Huber and least squares.

    Huber and least squares are not followed to the end: as starts they need not be.
    """
    names = [name for name, _ in given] + ["consensus"] * len(agreed)
    poses = [np.asarray(pose, np.float64) for _, pose in given] + list(agreed)
    for name, kernel in (("huber", "huber"), ("least squares", "none")):
        damper = catalog.kernel(kernel)
        found = minimise(network, damper, damping, agreed[:1], tolerance=_ROUGH, iterations=_ROUGH_STEPS)
        names.append(name)
        poses.append(found.pose[0])
    return names, np.array(poses)


def consensus(network: Network, poses: FloatArray) -> FloatArray:
    """Return the sum of the targets' truncated z^2 at each pose (t, 3): the lower, the more targets agree."""
    v_white, _ = whitened(network, poses)
    sizes = np.maximum(network.block_sizes, 1)
    z = target_norms(network, v_white)
    return np.asarray(np.minimum(z**2 / sizes, _TRUNCATED_AT**2).sum(axis=-1))


def _distinct(
    poses: FloatArray, scores: FloatArray, apart_m: float, apart_rad: float, *, limit: int | None = None
) -> list[int]:
    """Return indices of poses, lowest score first, each a different place from all before it."""
    order, kept = np.argsort(scores, kind="stable"), list[int]()
    left = np.isfinite(scores[order])
    while np.any(left) and (limit is None or len(kept) < limit):
        index = int(order[np.argmax(left)])
        kept.append(index)
        near = np.hypot(*(poses[order, :2] - poses[index, :2]).T) <= apart_m
        left &= ~(near & (np.abs(wrap_pi(poses[order, 2] - poses[index, 2])) <= apart_rad))
    return kept


# ------------------------------------------------------------------------------------------------------ trial fixes


def trial_fixes(network: Network) -> FloatArray:
    """Return poses (t, 3), t >= 1, each made from as few observations as a pose needs."""
    table = _per_target(network)
    whole = table[(table[:, 0] >= 0) & (table[:, 1] >= 0)]
    poses = [_from_two_marks(network, whole), *_from_known_headings(network, table)]
    if len(whole) < len(table) or not any(len(found) for found in poses):
        poses += [_from_crossings(network, table), _from_grid(network)]
    found = np.concatenate(poses)
    return found[np.all(np.isfinite(found), axis=1)]


def _per_target(network: Network) -> IntArray:
    """Return (g, 3): the first range, relative bearing and true bearing of each target, -1 where it has none."""
    table = np.full((len(network.blocks), 3), -1, np.int64)
    for row, block in enumerate(network.blocks):
        for index in block[block >= 0][::-1]:
            table[row, network.kind[index]] = index
    return table


def _from_two_marks(network: Network, whole: IntArray) -> FloatArray:
    """Solve two targets with range and relative bearing: the baseline gives the heading, its middle the position."""
    if len(whole) < 2:
        return np.empty((0, 3))
    first, second = _index_pairs(len(whole), max(_TRIAL_BUDGET // len(network.kind), 60))
    reach, bearing = network.value[whole[:, 0]], network.value[whole[:, 1]]
    seen = reach * np.exp(1j * bearing)  # north + i east, in the ship's axes
    place = _complex(network.mark_ne_m[network.mark[whole[:, 0]]])
    heading = np.angle(place[second] - place[first]) - np.angle(seen[second] - seen[first])
    own = 0.5 * (place[first] + place[second] - np.exp(1j * heading) * (seen[first] + seen[second]))
    return np.stack([own.real, own.imag, heading], axis=1)


def _index_pairs(count: int, at_most: int) -> tuple[IntArray, IntArray]:
    """Return index pairs i < j: all, or an even choice in which every index occurs about as often."""
    first, second = np.triu_indices(count, 1)
    if len(first) <= at_most:
        return first, second
    strides = np.unique(np.linspace(1, count // 2, max(at_most // count, 1)).astype(np.int64))
    base = np.arange(count)
    return np.tile(base, len(strides)), np.concatenate([(base + stride) % count for stride in strides])


def _from_known_headings(network: Network, table: IntArray) -> list[FloatArray]:
    """Solve single targets: range and true bearing, or range and relative bearing with the heading prior."""
    found = [_backwards(network, table[:, 0], table[:, 2], 0.0)]
    if network.prior_counts and network.heading_prior_rad is not None:
        heading = network.heading_prior_rad[0]
        places = _backwards(network, table[:, 0], table[:, 1], heading)
        found.append(np.column_stack([places, np.full(len(places), heading)]))
    found[0] = _with_heading(network, found[0])
    return found


def _backwards(network: Network, ranges: IntArray, bearings: IntArray, heading_rad: float) -> FloatArray:
    both = (ranges >= 0) & (bearings >= 0)
    ranges, bearings = ranges[both], bearings[both]
    place = _complex(network.mark_ne_m[network.mark[ranges]])
    own = place - network.value[ranges] * np.exp(1j * (network.value[bearings] + heading_rad))
    return np.stack([own.real, own.imag], axis=1)


def _from_crossings(network: Network, table: IntArray) -> FloatArray:
    """Cross the circles of two ranges and the lines of two true bearings."""
    circles, lines = table[table[:, 0] >= 0, 0], table[table[:, 2] >= 0, 2]
    at_most = max(_TRIAL_BUDGET // (4 * len(network.kind)), 60)
    places = [_circle_crossings(network, circles, at_most), _line_crossings(network, lines, at_most)]
    return _with_heading(network, np.concatenate(places))


def _circle_crossings(network: Network, ranges: IntArray, at_most: int) -> FloatArray:
    if len(ranges) < 2:
        return np.empty((0, 2))
    first, second = (ranges[index] for index in _index_pairs(len(ranges), at_most))
    place, reach = _complex(network.mark_ne_m[network.mark]), network.value
    baseline = place[second] - place[first]
    length = np.abs(baseline)
    apart = length > 0.0
    first, second, baseline, length = first[apart], second[apart], baseline[apart], length[apart]
    along = (reach[first] ** 2 - reach[second] ** 2 + length**2) / (2.0 * length)
    across = np.sqrt(np.maximum(reach[first] ** 2 - along**2, 0.0))
    unit = baseline / length
    own = np.concatenate([place[first] + unit * (along + 1j * side * across) for side in (-1.0, 1.0)])
    return np.stack([own.real, own.imag], axis=1)


def _line_crossings(network: Network, bearings: IntArray, at_most: int) -> FloatArray:
    if len(bearings) < 2:
        return np.empty((0, 2))
    first, second = (bearings[index] for index in _index_pairs(len(bearings), at_most))
    place, direction = _complex(network.mark_ne_m[network.mark]), np.exp(1j * network.value)
    sine = np.imag(np.conj(direction[first]) * direction[second])
    usable = np.abs(sine) > 1e-6
    first, second, sine = first[usable], second[usable], sine[usable]
    # place_1 - t_1 d_1 = place_2 - t_2 d_2, multiplied by conj(d_2): the imaginary part leaves t_1
    reach = -np.imag((place[first] - place[second]) * np.conj(direction[second])) / sine
    own = place[first] - reach * direction[first]
    return np.stack([own.real, own.imag], axis=1)


def _from_grid(network: Network) -> FloatArray:
    """Spread places in rings about the marks: for whatever the closed forms do not cover."""
    marks = network.mark_ne_m[np.unique(network.mark[network.mask])]
    centre = marks.mean(axis=0)
    ranges = network.value[(network.kind == RANGE) & network.mask]
    size = max(float(np.hypot(*(marks - centre).T).max()), float(ranges.max(initial=0.0)), 1.0)
    rings = size * np.geomspace(0.05, 4.0, _GRID_RINGS)
    spokes = 2.0 * np.pi * np.arange(_GRID_SPOKES) / _GRID_SPOKES
    own = (rings[:, None] * np.exp(1j * spokes)[None, :]).ravel() + _complex(centre[None, :])
    return _with_heading(network, np.stack([own.real, own.imag], axis=1))


def _with_heading(network: Network, places: FloatArray) -> FloatArray:
    """Add to each place (t, 2) the heading on which most relative bearings agree there; zero where it is known."""
    poses = np.column_stack([places, np.zeros(len(places))])
    relative = np.flatnonzero((network.kind == RELATIVE_BEARING) & network.mask)
    if not len(relative) or not len(places):
        return poses
    headings = np.asarray(wrap_pi(predict(network, poses)[:, relative] - network.value[relative]))
    candidates = headings[:, np.unique(np.linspace(0, len(relative) - 1, 9).astype(np.int64))]
    misfit = np.abs(wrap_pi(candidates[:, :, None] - headings[:, None, :]))
    best = np.argmin(np.median(misfit, axis=-1), axis=-1)
    poses[:, 2] = candidates[np.arange(len(places)), best]
    return poses


def _complex(north_east: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    return north_east[..., 0] + 1j * north_east[..., 1]
