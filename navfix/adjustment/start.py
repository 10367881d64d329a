"""Robust start: trial fixes from one or two marks, consensus over all targets, and every minimum they lead to.

Kernels that forget gross errors have many minima; where the descent begins decides which one it finds. So trial fixes
are made from as few observations as a fix needs (one mark when the heading is known, two when it is not, two circles
or two lines when ranges or bearings are missing), all of them are judged by all targets, and the best places, the
Huber estimate, the least-squares estimate and any given pose are all followed down with the wanted kernel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from navfix import catalog
from navfix.adjustment import gnc
from navfix.adjustment.damped import observation_weights
from navfix.adjustment.dense import Descent, minimise, saddle_exits
from navfix.adjustment.exchange import exchanges
from navfix.adjustment.landscape import norms_of_targets
from navfix.adjustment.network import Network
from navfix.adjustment.sights import sight
from navfix.adjustment.trials import trial_fixes
from navfix.adjustment.whitening import normal_matrix, whitened
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray
from navfix.units import wrap_pi

DISTINCT_M = 50.0
DISTINCT_RAD = math.radians(5.0)
_TRUNCATED_AT = 5.0  # sigma: beyond it a target says only that it does not agree
_AGREES = 3.0  # sigma: nearer than this a target agrees with a trial fix
_GIVES_UP = 0.1  # weight of a target that agrees so, below which a kernel gives it up
_CONSENSUS_STARTS, _FEWEST_STARTS, _EXCHANGES = 5, 3, 3
_ON_A_MARK_M = 1e-3
_EXACT = 1e-6  # of a loss: all residuals are zero
_ROUGH, _COARSE, _FINE = 0.1, 1e-2, 1e-9  # sigma
_ROUGH_STEPS, _COARSE_STEPS, _FINE_STEPS = 3, 10, 60


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
    if kernel.family == gnc.FAMILY:
        near = trials[[int(np.argmin(score))]]
        least_squares = gnc.start_pose(network, catalog.kernel("none"), damping, near)
        return _minima(network, kernel, damping, gnc.graduated(network, kernel, damping, least_squares), [gnc.START])
    agreed = trials[_distinct(trials, score, *apart, limit=_CONSENSUS_STARTS)]
    names, poses = _starts(
        network, kernel, damping, given, agreed, smooth=not _decided(network, kernel, damping, agreed)
    )
    coarse = minimise(network, kernel, damping, poses, tolerance=_COARSE, iterations=_COARSE_STEPS)
    chosen = _distinct(coarse.pose, coarse.loss, *apart)
    fine, names = _without_saddles(network, kernel, damping, coarse.pose[chosen], [names[i] for i in chosen])
    kept = _distinct(fine.pose, fine.loss, *apart)
    minima = _minima(network, kernel, damping, fine.take(kept), [names[i] for i in kept])
    return [_lowered(network, kernel, damping, minima[0]), *(m for m in minima[1:] if m.targets > 0)]


def _lowered(network: Network, kernel: Kernel, damping: Damping, best: Minimum) -> Minimum:
    """Exchange single targets while that lowers the loss, with a kernel that gives up targets that nearly agree.

    Such a kernel (IGG-III) has several minima within a few sigma, nearer to each other than two places are.
    """
    if float(kernel.weight(_AGREES, damping)) > _GIVES_UP:
        return best
    for _ in range(_EXCHANGES):
        tried = exchanges(network, kernel, damping, best.pose)
        if not len(tried):
            break
        found = minimise(network, kernel, damping, tried, tolerance=_FINE, iterations=_FINE_STEPS)
        index = int(np.argmin(found.loss))
        if not found.loss[index] < best.loss - _EXACT:
            break
        best = _minima(network, kernel, damping, found.take([index]), [best.start])[0]
    return best


def _without_saddles(
    network: Network, kernel: Kernel, damping: Damping, poses: FloatArray, names: list[str]
) -> tuple[Descent, list[str]]:
    """Follow all poses to the end; what ends in a saddle goes on to both its sides."""
    fine = minimise(network, kernel, damping, poses, tolerance=_FINE, iterations=_FINE_STEPS)
    saddles, exits = saddle_exits(network, fine)
    if not np.any(saddles):
        return fine, names
    poses = np.concatenate([fine.pose[~saddles], exits])
    names = [name for name, saddle in zip(names, saddles, strict=True) if not saddle] + ["consensus"] * len(exits)
    return minimise(network, kernel, damping, poses, tolerance=_FINE, iterations=_FINE_STEPS), names


def follow(network: Network, kernel: Kernel, damping: Damping, start: FloatArray, name: str) -> Minimum:
    """Return the minimum that is reached from one start (3,)."""
    return _minima(network, kernel, damping, minimise(network, kernel, damping, start[None, :]), [name])[0]


def follow_given(
    network: Network, kernel: Kernel, damping: Damping, start: FloatArray, minima: Sequence[Minimum] = ()
) -> Minimum:
    """Return the minimum on the side of a start that somebody gave, (3,).

    A kernel that forgets outliers stays at a start that is far off, where everything looks like one. So the way over
    the Huber estimate (least squares, where nothing is redundant) is tried too, where the straight way keeps no more
    than half of the targets, and taken where it keeps more. Where nothing is redundant, every solution is exact: if
    the ways end elsewhere, the nearest exact one of the ``minima`` is meant. On a mark nothing has a direction: from
    there too the nearest of the ``minima`` is meant.
    """
    if minima and on_a_mark(network, start):
        return replace(_nearest(minima, start), start="given")
    straight = follow(network, kernel, damping, start, "given")
    if 2 * straight.targets > len(network.blocks) and (network.redundancy > 0 or straight.loss < _EXACT):
        return straight
    smoother = catalog.kernel("huber" if network.redundancy > 0 else "none")
    smooth = follow(network, smoother, damping, start, "given")
    led = follow(network, kernel, damping, smooth.pose, "given")
    best = led if led.targets > straight.targets or led.loss < _EXACT else straight
    exact = [m for m in minima if m.loss < _EXACT] if network.redundancy == 0 and best.loss >= _EXACT else []
    return replace(_nearest(exact, start) if exact else best, start="given")


def _nearest(minima: Sequence[Minimum], start: FloatArray) -> Minimum:
    return min(minima, key=lambda m: math.hypot(*(m.pose[:2] - start[:2])))


def on_a_mark(network: Network, pose: FloatArray) -> bool:
    """Tell whether a pose (3,) is the place of a mark whose bearing takes part: it has no direction from there."""
    bearings = network.mask & ~network.is_range
    return bool(np.any(sight(network, pose).distance[bearings] < _ON_A_MARK_M))


def _minima(network: Network, kernel: Kernel, damping: Damping, found: Descent, names: Sequence[str]) -> list[Minimum]:
    weights = observation_weights(network, kernel, damping, found.pose)
    targets = np.count_nonzero(weights[:, network.blocks[:, 0]] > 0.5, axis=1)
    ends = zip(found.pose, found.loss.tolist(), names, targets.tolist(), strict=True)
    return [Minimum(pose, loss, name, count) for pose, loss, name, count in ends]


def separation(network: Network, pose: FloatArray) -> tuple[float, float]:
    """Return how far apart [m], [rad] two minima must be to be two places: 50 m, less where five sigma are less."""
    _, a = whitened(network, pose)
    u = network.unknowns
    spread = np.linalg.pinv(normal_matrix(network, a, network.mask.astype(np.float64))[:u, :u], hermitian=True)
    five_sigma_m = 5.0 * math.sqrt(max(float(np.trace(spread[:2, :2])), 0.0))
    return (min(DISTINCT_M, five_sigma_m) if five_sigma_m > 0.0 else DISTINCT_M), DISTINCT_RAD


def _decided(network: Network, kernel: Kernel, damping: Damping, agreed: FloatArray) -> bool:
    """Tell whether so many targets agree on the best place that no other can have a lower loss: two in three or more.

    At least three starts must be there already, and the kernel must forget outliers.
    """
    if len(agreed) < _FEWEST_STARTS or not math.isfinite(kernel.bound(damping)):
        return False
    z = norms_of_targets(network, agreed[:1])[0] / np.sqrt(np.maximum(network.block_sizes, 1))
    return 3 * int(np.count_nonzero(z < _AGREES)) >= 2 * len(z)


def _starts(
    network: Network,
    kernel: Kernel,
    damping: Damping,
    given: tuple[tuple[str, FloatArray], ...],
    agreed: FloatArray,
    *,
    smooth: bool,
) -> tuple[list[str], FloatArray]:
    """Return names and poses: the given ones, those of the consensus (c, 3), and from its best Huber and least squares.

    The last two (``smooth``) are not followed to the end: as starts they need not be. A kernel that never lets go has
    its minimum about theirs, and they are followed farther.
    """
    names = [name for name, _ in given] + ["consensus"] * len(agreed)
    poses = [np.asarray(pose, np.float64) for _, pose in given] + list(agreed)
    steps = _ROUGH_STEPS if math.isfinite(kernel.bound(damping)) else _COARSE_STEPS
    for name, smoother in (("huber", "huber"), ("least squares", "none")) if smooth else ():
        damper = catalog.kernel(smoother)
        found = minimise(network, damper, damping, agreed[:1], tolerance=_ROUGH, iterations=steps)
        names.append(name)
        poses.append(found.pose[0])
    return names, np.array(poses)


def consensus(network: Network, poses: FloatArray) -> FloatArray:
    """Return the sum of the targets' truncated z^2 at each pose (t, 3): the lower, the more targets agree."""
    sizes = np.maximum(network.block_sizes, 1)
    z = norms_of_targets(network, poses)
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
