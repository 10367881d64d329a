"""Steps 2 and 3: pairs of targets vote for poses through pairs of marks at the same distance.

A radar pair (i, j) and a mark pair (a, b) of equal distance fix a pose: the heading turns rho_j - rho_i onto
z_b - z_a, the position follows. Both orientations vote (i on a, j on b and the other way round); a mirror image cannot.
Poses that many pairs vote for are the seeds of the EM.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.association.pair_index import PairIndex
from navfix.association.scene import BoolArray, ComplexArray, Scene
from navfix.catalog import AssociationModel
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi


@dataclass(frozen=True, eq=False)
class Poses:
    """A batch of poses: ``p`` (k,) complex own positions [m], ``heading_rad`` (k,)."""

    p: ComplexArray
    heading_rad: FloatArray

    def __len__(self) -> int:
        return len(self.p)

    def take(self, rows: IntArray | BoolArray) -> Poses:
        """Return the poses of ``rows``."""
        return Poses(self.p[rows], self.heading_rad[rows])

    @classmethod
    def join(cls, *parts: Poses) -> Poses:
        """Return all poses of several batches as one."""
        return cls(np.concatenate([q.p for q in parts]), np.concatenate([q.heading_rad for q in parts]))

    def near(self, others: Poses, within_m: float, within_deg: float) -> BoolArray:
        """Tell for each pose (k,) which of the ``others`` (l,) are so near in place and heading (k, l)."""
        near: BoolArray = np.abs(others.p[None, :] - self.p[:, None]) <= within_m
        one, other = np.nonzero(near)  # few: only their headings are compared
        near[one, other] = np.abs(wrap_pi(others.heading_rad[other] - self.heading_rad[one])) <= np.radians(within_deg)
        return near

    def leaders(self, gain: FloatArray, most: int, within_m: float, within_deg: float) -> IntArray:
        """Return the rows of the poses of most ``gain`` (k,), best first: none that has a better one so near."""
        order = np.argsort(-gain, kind="stable")
        ranked = self.take(order)
        has_better = np.tril(ranked.near(ranked, within_m, within_deg), -1).any(axis=1)
        return order[~has_better][:most]


def firsts(same: BoolArray) -> IntArray:
    """Return the first row of every group that is the ``same`` (k, k) answer, answers best first."""
    left, kept = np.ones(len(same), dtype=bool), []
    for row in range(len(same)):
        if left[row]:
            kept.append(row)
            left &= ~same[row]
    return np.array(kept, dtype=np.int64)


Plausible = Callable[[Poses], BoolArray]


@dataclass(frozen=True, eq=False)
class RadarPairs:
    """Pairs of targets (k,) in the order in which they vote, with the sigma of their distance and direction."""

    first: IntArray
    second: IntArray
    distance_m: FloatArray
    distance_sigma_m: FloatArray
    direction_sigma_rad: FloatArray

    def take(self, rows: slice) -> RadarPairs:
        """Return a part of the pairs."""
        return RadarPairs(
            self.first[rows], self.second[rows], self.distance_m[rows],
            self.distance_sigma_m[rows], self.direction_sigma_rad[rows],
        )  # fmt: skip


def radar_pairs(scene: Scene, index: PairIndex, model: AssociationModel) -> RadarPairs:
    """Return all pairs of targets, those first that say most: accurate, and of a distance that few mark pairs have."""
    i, j = np.triu_indices(len(scene.rho), 1)
    line = scene.rho[j] - scene.rho[i]
    distance_m = np.abs(line)
    direction = np.where(distance_m > 0.0, line / np.maximum(distance_m, 1e-9), 1.0)
    along_m2 = _variance_along(scene, i, direction) + _variance_along(scene, j, direction)
    across_m2 = _variance_along(scene, i, 1j * direction) + _variance_along(scene, j, 1j * direction)
    mark_m2 = 2.0 * float(np.median(scene.mark_sigma_m)) ** 2
    distance_sigma_m = np.sqrt(along_m2 + mark_m2)
    direction_sigma_rad = np.sqrt(across_m2 + mark_m2) / np.maximum(distance_m, 1.0)
    alike = index.about_how_many(distance_m, model.pair_gate_sigma * distance_sigma_m)
    usable = (distance_m > 0.0) & (direction_sigma_rad < 0.35) & (alike > 0)
    cost = (alike + 1.0) * np.maximum(direction_sigma_rad, 0.25 * np.radians(model.cell_deg))
    order = _spread(
        i, j, np.argsort(np.where(usable, cost, np.inf), kind="stable")[: int(usable.sum())], len(scene.rho)
    )
    return RadarPairs(i[order], j[order], distance_m[order], distance_sigma_m[order], direction_sigma_rad[order])


def seeds(
    scene: Scene,
    index: PairIndex,
    pairs: RadarPairs,
    model: AssociationModel,
    most: int,
    plausible: Plausible | None = None,
) -> Poses:
    """Return the poses that most of the radar pairs vote for, at most ``most`` from each of two grids.

    With hints, as many again from the votes that are ``plausible``: two common targets are lost among all votes.
    """
    voted = Poses(*votes(scene, index, pairs, model))
    found = [_fullest_cells(voted, model, most, shift) for shift in (0.0, 0.5)]
    if plausible is not None:
        near = voted.take(plausible(voted))
        found += [_fullest_cells(near, model, most, shift) for shift in (0.0, 0.5)]
    return Poses.join(*found)


def votes(
    scene: Scene, index: PairIndex, pairs: RadarPairs, model: AssociationModel
) -> tuple[ComplexArray, FloatArray]:
    """Return position (v,) [m, complex] and heading (v,) [rad] of every vote."""
    pair, entry = candidates(index, pairs, model.pair_gate_sigma, model.votes_at_most)
    first, second = index.marks_of(entry)
    z_a, z_b = scene.z[first], scene.z[second]
    if index.row is not None:  # distances as they are today
        gate_m = (model.pair_gate_sigma * pairs.distance_sigma_m)[pair]
        same = (np.abs(np.abs(z_b - z_a) - pairs.distance_m[pair]) <= gate_m) & (first >= 0) & (second >= 0)
        same &= first != second
        pair, z_a, z_b = pair[same], z_a[same], z_b[same]
    rho_i, rho_j = scene.rho[pairs.first], scene.rho[pairs.second]
    turn = (z_b - z_a) * np.conj((rho_j - rho_i) / np.abs(rho_j - rho_i) ** 2)[pair]
    turn /= np.abs(turn)
    middle = 0.5 * (z_a + z_b)
    lever = turn * (0.5 * (rho_i + rho_j))[pair]
    p = np.concatenate([middle - lever, middle + lever])
    return p, np.angle(np.concatenate([turn, -turn]))


def candidates(index: PairIndex, pairs: RadarPairs, gate_sigma: float, most: int) -> tuple[IntArray, IntArray]:
    """Return radar pair (c,) and entry of the index (c,) of equal distance; each votes twice, at most so many votes."""
    low, high = index.window(pairs.distance_m, gate_sigma * pairs.distance_sigma_m)
    count = high - low
    allowed = np.cumsum(2 * count) <= most
    allowed[:1] = True
    low, count = low[allowed], count[allowed]
    pair = np.repeat(np.arange(len(count)), count)
    entry = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count) + np.repeat(low, count)
    return pair, entry


def _variance_along(scene: Scene, target: IntArray, direction: ComplexArray) -> FloatArray:
    """Return the variance [m^2] of targets (k,) along unit vectors (k,): their polar covariance is a thin ellipse."""
    local = direction * np.exp(-1j * scene.bearing_rad[target])
    tangential_m = scene.range_m[target] * scene.bearing_sigma_rad[target]
    variance_m2: FloatArray = (local.real * scene.range_sigma_m[target]) ** 2 + (local.imag * tangential_m) ** 2
    return variance_m2


def _spread(i: IntArray, j: IntArray, order: IntArray, targets: int) -> IntArray:
    """Reorder so that every leading part uses each target about equally often: one wrong target must not fill it."""
    ends = np.stack([i[order], j[order]], axis=1).ravel()
    by_target = np.argsort(ends.astype(np.int16), kind="stable")  # short integers: a radix sort
    first = np.searchsorted(ends[by_target], np.arange(targets))
    taken = np.empty(len(ends), dtype=np.int64)  # how often a target was used before
    taken[by_target] = np.arange(len(ends)) - first[ends[by_target]]
    rounds = taken.reshape(-1, 2).max(axis=1)
    per_round = max(2.0, 2.6 * 50 / max(targets, 1))
    return order[np.argsort((rounds // per_round).astype(np.int16), kind="stable")]


def _fullest_cells(voted: Poses, model: AssociationModel, most: int, shift: float) -> Poses:
    """Return the mean pose of the fullest cells of one grid, shifted by a part of a cell."""
    p, heading_rad = voted.p, voted.heading_rad
    if len(p) == 0:
        return voted
    headings = round(360.0 / model.cell_deg)
    north = _cells(p.real, 1.0 / model.cell_m, shift)
    east = _cells(p.imag, 1.0 / model.cell_m, shift)
    turn = _cells(heading_rad, headings / (2.0 * np.pi), shift)
    turn += np.where(turn < 0, headings, 0).astype(np.int32)
    bits = int(np.clip(np.ceil(np.log2(4 * len(p))), 10, 21))
    key = _unsigned(north) * np.uint32(73856093)
    key ^= _unsigned(east) * np.uint32(19349663)
    key ^= _unsigned(turn) * np.uint32(83492791)
    key ^= key >> np.uint32(bits)
    bucket = (key & np.uint32((1 << bits) - 1)).astype(np.int64)
    count = np.bincount(bucket, minlength=1 << bits)
    best = np.flatnonzero(count >= _count_of_the_fullest(count, most))
    rank = np.full(1 << bits, -1, dtype=np.int32)
    rank[best] = np.arange(len(best))
    member = np.flatnonzero(rank[bucket] >= 0)
    cells = np.stack([north, east, turn])[:, member]
    return _cell_means(p[member], heading_rad[member], rank[bucket[member]], cells, most)


def _cells(value: FloatArray, per_unit: float, shift: float) -> NDArray[np.int32]:
    """Return the number of the cell of each value; float32 is enough for a vote."""
    scaled = value.astype(np.float32)
    scaled *= np.float32(per_unit)
    scaled += np.float32(shift)
    return np.floor(scaled, out=scaled).astype(np.int32)


def _unsigned(cell: NDArray[np.int32]) -> NDArray[np.uint32]:
    return cell.view(np.uint32)


def _count_of_the_fullest(count: IntArray, wanted: int) -> int:
    """Return the least count among the ``wanted`` fullest cells, at least 1."""
    several = count[count > 1]
    return int(np.partition(several, -wanted)[-wanted]) if len(several) >= wanted else 1


def _cell_means(
    p: ComplexArray, heading_rad: FloatArray, bucket: NDArray[np.int32], cell: NDArray[np.int32], most: int
) -> Poses:
    """Return the mean pose of each true cell among the members of the fullest buckets (two cells may share one)."""
    order = np.lexsort((cell[2], cell[1], cell[0], bucket))
    steps = np.any(np.diff(np.vstack([bucket, cell])[:, order], axis=1) != 0, axis=0)
    starts = np.flatnonzero(np.concatenate([[True], steps]))
    size = np.diff(np.concatenate([starts, [len(order)]]))
    top = np.argsort(-size, kind="stable")[:most]
    mean_p = np.asarray(np.add.reduceat(p[order], starts) / size, dtype=np.complex128)
    mean_turn = np.add.reduceat(np.exp(1j * heading_rad[order]), starts)
    return Poses(mean_p[top], np.angle(mean_turn[top]))
