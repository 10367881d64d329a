"""Step 1 from call to call: the index of mark pairs is kept while the picture changes little.

A distance between two marks changes by no more than both have moved. So the sorted pairs serve on while every mark is
within a tolerance of where it was indexed: the look-up is widened by that much and each pair found is measured again.
Marks that moved farther, and new ones, get pairs of their own; those that have gone are passed over. When too many
have changed the index is built anew.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from navfix.association.pair_index import PairIndex
from navfix.association.scene import ComplexArray, Scene
from navfix.geodesy import cloud_to_plane
from navfix.types import FloatArray, IntArray, Mark, Position

TOLERANCE_M = 60.0
MOST_CHANGED = 0.1  # of the marks, beyond which the index is built anew
SPARE_RANGE = 1.1  # pairs are indexed a little farther than this scan needs: the radar range is that of its targets


class KeptIndex:
    """The index of mark pairs, kept by the caller from one `navfix.associate` to the next.

    ``built`` and ``kept`` count how often it was built anew and how often it could be kept.
    """

    def __init__(self, tolerance_m: float = TOLERANCE_M) -> None:
        self.tolerance_m = tolerance_m
        self.built = self.kept = 0
        self._index: PairIndex | None = None
        self._longest_m = 0.0
        self._origin: Position | None = None
        self._slot: dict[Hashable, int] = {}
        self._z: ComplexArray = np.empty(0, dtype=np.complex128)

    def of(self, scene: Scene, marks: Sequence[Mark]) -> PairIndex:
        """Return the index for the marks of a scene, given with their labels in the same order."""
        longest_m = 2.0 * scene.radar_range_m
        lat_deg, lon_deg = (np.array([getattr(m.position, name) for m in marks]) for name in ("lat_deg", "lon_deg"))
        origin = self._origin or scene.origin
        plane = cloud_to_plane(origin, lat_deg, lon_deg)
        z = np.asarray(plane[:, 0] + 1j * plane[:, 1], dtype=np.complex128)
        names = [_name(mark) for mark in marks]
        slot = np.array([self._slot.get(name, -1) for name in names], dtype=np.int64)
        moved_m = np.where(slot >= 0, np.abs(z - self._z[slot]), np.inf) if len(self._z) else np.full(len(z), np.inf)
        loose = ~(moved_m <= self.tolerance_m)
        if self._index is None or longest_m > self._longest_m or loose.sum() > MOST_CHANGED * len(z):
            return self._build(scene, names, SPARE_RANGE * longest_m)
        self.kept += 1
        return self._with_changes(self._index, z, slot, moved_m, loose)

    def _build(self, scene: Scene, names: Sequence[Hashable], longest_m: float) -> PairIndex:
        self.built += 1
        self._index, self._longest_m, self._origin = PairIndex.of(scene.z, longest_m), longest_m, scene.origin
        self._z, self._slot = scene.z, {name: place for place, name in enumerate(names)}
        return self._index

    def _with_changes(
        self, index: PairIndex, z: ComplexArray, slot: IntArray, moved_m: FloatArray, loose: NDArray[np.bool_]
    ) -> PairIndex:
        """Return the index with today's rows, and with pairs of its own for every mark that changed."""
        count = len(self._z)
        row = np.full(count + len(z), -1, dtype=np.int64)
        row[slot[~loose]] = np.flatnonzero(~loose)
        row[count:] = np.arange(len(z))
        slack_m = 2.0 * float(moved_m[~loose].max(initial=0.0))
        if not loose.any():
            return PairIndex(index.distance_m, index.first, index.second, slack_m, row)
        changed = np.flatnonzero(loose)
        apart_m = np.abs(z[changed][:, None] - z[None, :])
        wanted = (apart_m > 0.0) & (apart_m <= self._longest_m)
        wanted &= ~loose[None, :] | (np.arange(len(z))[None, :] > changed[:, None])  # two changed ones: once
        one, other = np.nonzero(wanted)
        distance_m = apart_m[one, other].astype(np.float32)
        order = np.argsort(distance_m, kind="stable")
        at = np.searchsorted(index.distance_m, distance_m[order])
        return PairIndex(
            np.insert(index.distance_m, at, distance_m[order]),
            np.insert(index.first, at, (count + changed[one[order]]).astype(np.int32)),
            np.insert(index.second, at, (count + other[order]).astype(np.int32)),
            slack_m,
            row,
        )


def _name(mark: Mark) -> Hashable:
    return (mark.kind, mark.mmsi, mark.label)
