"""Cells of position and heading, cut ever smaller, with an upper bound of the evidence that falls as they shrink.

A target can be displaced by at most half the cell's diagonal and its range times half the heading interval, anywhere in
a cell. A mark at distance d from where the cell's middle puts the target is then at least d less that away, and its
likelihood ratio no larger than the peak times exp(-1/2 (that / s)^2), s the larger sigma of the two: eq. (6.16).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.association.em import Field
from navfix.types import FloatArray

NEAREST = 6  # marks that are measured; if there may be more within reach, all are taken to be as near as the last
GATE_SIGMA = 4.0
BATCH = 4096


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of one size: middles ``p`` (k,) [m, complex] and ``heading_rad`` (k,), side and heading interval."""

    p: NDArray[np.complex128]
    heading_rad: FloatArray
    side_m: float
    turn_rad: float

    def __len__(self) -> int:
        return len(self.p)

    def take(self, rows: NDArray[np.bool_] | slice) -> Cells:
        """Return some of the cells."""
        return Cells(self.p[rows], self.heading_rad[rows], self.side_m, self.turn_rad)

    def split(self) -> Cells:
        """Return the eight parts of every cell."""
        quarter_m, quarter_rad = self.side_m / 4.0, self.turn_rad / 4.0
        north, east, turn = (axis.ravel() for axis in np.meshgrid([-1, 1], [-1, 1], [-1, 1], indexing="ij"))
        p = self.p[:, None] + quarter_m * (north + 1j * east)
        heading_rad = self.heading_rad[:, None] + quarter_rad * turn
        return Cells(p.ravel(), heading_rad.ravel(), self.side_m / 2.0, self.turn_rad / 2.0)


def settle(field: Field, cells: Cells, peaks: FloatArray, floor: float, smallest_m: float, most: int) -> Cells:
    """Return the cells, cut down to ``smallest_m``, whose bound is above ``floor``; early where more than ``most``.

    Parameters
    ----------
    peaks : (m,) likelihood ratio of a match without misfit at detection odds of one
    """
    while True:
        parts = [cells.take(slice(begin, begin + BATCH)) for begin in range(0, len(cells), BATCH)]
        above = [bound(field, part, peaks) > floor for part in parts]
        cells = cells.take(np.concatenate(above)) if parts else cells
        if len(cells) == 0 or len(cells) > most or cells.side_m <= smallest_m:
            return cells
        cells = cells.split()


def bound(field: Field, cells: Cells, peaks: FloatArray) -> FloatArray:
    """Return an upper bound (k,) of the log likelihood ratio of every pose in each cell: eq. (6.16)."""
    scene, model = field.scene, field.model
    half_m = cells.side_m / np.sqrt(2.0)
    world = cells.p[:, None] + np.exp(1j * cells.heading_rad)[:, None] * scene.rho[None, :]
    sigma_m = np.sqrt(np.maximum(field.range_m2, field.across_m2) + field.mark_m2.max())
    reach_m = half_m + scene.range_m * cells.turn_rad / 2.0
    near = min(NEAREST, len(scene.z))
    places = world.view(np.float64).reshape(-1, 2)
    farthest_m = float((reach_m + GATE_SIGMA * sigma_m).max())
    distance_m, _ = field.tree.query(places, k=near, distance_upper_bound=farthest_m)
    distance_m = distance_m.reshape(len(cells), len(scene.rho), near)
    least = np.maximum(distance_m - reach_m[None, :, None], 0.0) / sigma_m[None, :, None]
    weight = np.where(least <= GATE_SIGMA, np.exp(-0.5 * least**2), 0.0)
    weight[:, :, -1] *= max(1, len(scene.z) - near + 1)  # there may be more of them
    ratio = weight.sum(axis=2) * peaks[None, :]
    share = np.array(model.clutter_share)
    missed = least_missed(field, cells.p, cells.side_m)
    best = np.full(len(cells), -np.inf)
    for row, level in enumerate(model.detection_level):
        odds = level / (1.0 - level)
        for c in share:
            value = len(scene.rho) * (1.0 - c + np.log(c)) + np.log1p(ratio * (odds / c)).sum(axis=1)
            best = np.maximum(best, value + missed[row])
    return best


def least_missed(field: Field, centres: NDArray[np.complex128], cell_m: float) -> FloatArray:
    """Return (levels, g): the largest sum of ln(1 - Pd) over the marks that every pose in a cell has in range."""
    scene, half_m = field.scene, cell_m / np.sqrt(2.0)
    levels = np.array(field.model.detection_level)
    missed = np.zeros((len(levels), len(centres)))
    for begin in range(0, len(centres) if field.model.use_missed else 0, BATCH):
        distance_m = np.abs(scene.z[None, :] - centres[begin : begin + BATCH, None])
        surely = distance_m + half_m <= scene.radar_range_m
        pd = field.detection(distance_m + half_m, scene.conspicuity[None, :])
        for row, level in enumerate(levels):
            missed[row, begin : begin + BATCH] = np.where(surely, np.log1p(-level * pd), 0.0).sum(axis=1)
    return missed
