"""Independent proof: an exhaustive search of every place and heading, by branch and bound.

The whole space is cut into cells of position and heading. For each cell an upper bound of the evidence of any pose in
it is computed; cells that cannot hold a rival are pruned, the others are cut into eight and bounded again, down to the
radar's sigma, and from every one that is left the EM is run. What the fast search
missed is then named; if nothing is, its answers are certified complete within the margin. Where too many cells stay
open (weak data), nothing is certified.

The bound, eq. (6.12) of the theory: a target can match only if some mark is within reach of the cell (cell, turn of the
heading interval, four sigma of target and mark together), and then not better than with no misfit at all; a mark that
is in range from everywhere in the cell and may be unmatched costs at least what a missed detection costs. A match
farther off than four sigma counts as none.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.association import ambiguity, em, evidence
from navfix.association.em import Field
from navfix.association.evidence import Judged
from navfix.association.prior import Prior
from navfix.association.proof_cells import Cells, least_missed, settle
from navfix.association.seeded import Search
from navfix.association.seeds import Poses
from navfix.catalog import AssociationModel
from navfix.types import FloatArray, IntArray

CELLS_IN_RANGE = 35  # the side of a cell as a part of the radar range, within the two limits
SMALLEST_CELL_M, LARGEST_CELL_M = 100.0, 500.0
CELL_DEG = 1.0
GATE_SIGMA = 4.0
BATCH = 512
MOST_OPEN = 300_000


@dataclass(frozen=True, eq=False)
class Proof:
    """What the exhaustive search found.

    ``cells`` cells in all, ``open_cells`` parts of them not pruned, ``complete`` whether all of these were tried (at
    most ``MOST_OPEN``); ``answers`` everything distinct within ``margin`` nats of the best, best first; ``missed``
    rows of ``answers`` that the fast search did not have.
    """

    cells: int
    open_cells: int
    complete: bool
    answers: Judged
    missed: IntArray

    @property
    def certified(self) -> bool:
        """Whether every cell was settled and the fast search had every answer."""
        return self.complete and len(self.missed) == 0


def prove(found: Search, model: AssociationModel, margin: float | None = None) -> Proof:
    """Search everywhere for poses whose evidence is within ``margin`` nats of the best that ``found`` has.

    Parameters
    ----------
    margin : default the logarithm that the acceptance of ``model`` asks for
    """
    field, known = found.field, found.prior
    within = margin if margin is not None else float(np.log(model.rivals / model.accept_probability))
    floor = float(found.answers.evidence[0]) - within
    grid = _Grid.of(field)
    starts = [found.answers.poses]
    open_cells, needed = 0, floor - _largest_mass(known, field)
    peaks, smallest_m = grid.peaks(), max(SMALLEST_CELL_M, 0.3 * field.widest_m)
    for heading_rad in np.radians(np.arange(0.0, 360.0, CELL_DEG)):
        rows = np.flatnonzero(grid.bound(heading_rad) > needed)
        cells = Cells(grid.centres[rows], np.full(len(rows), heading_rad), grid.cell_m, np.radians(CELL_DEG))
        cells = settle(field, cells, peaks, needed, smallest_m, MOST_OPEN)
        open_cells += len(cells)
        if open_cells > MOST_OPEN:
            break
        starts.append(Poses(cells.p, cells.heading_rad))
    complete = open_cells <= MOST_OPEN
    answers = _solve(field, known, starts if complete else starts[:1], model)
    answers = answers.take(np.flatnonzero(answers.evidence >= answers.evidence[0] - within))
    total = len(grid.centres) * round(360.0 / CELL_DEG)
    return Proof(total, open_cells, complete, answers, _not_among(answers, found.answers, model))


@dataclass(frozen=True, eq=False)
class _Grid:
    """Cells of position: ``centres`` (g,) complex [m]; ``missed`` (levels, g) what marks surely in range cost."""

    field: Field
    cell_m: float
    north: int
    east: int
    corner: complex
    centres: NDArray[np.complex128]
    missed: FloatArray

    @classmethod
    def of(cls, field: Field) -> _Grid:
        scene = field.scene
        cell_m = float(np.clip(scene.radar_range_m / CELLS_IN_RANGE, SMALLEST_CELL_M, LARGEST_CELL_M))
        reach_m = scene.radar_range_m + cell_m
        corner = complex(scene.z.real.min() - reach_m, scene.z.imag.min() - reach_m)
        span = complex(scene.z.real.max() + reach_m, scene.z.imag.max() + reach_m) - corner
        north, east = int(np.ceil(span.real / cell_m)), int(np.ceil(span.imag / cell_m))
        rows, columns = np.divmod(np.arange(north * east), east)
        centres = np.asarray(corner + cell_m * ((rows + 0.5) + 1j * (columns + 0.5)), dtype=np.complex128)
        return cls(field, cell_m, north, east, corner, centres, least_missed(field, centres, cell_m))

    def bound(self, heading_rad: float) -> FloatArray:
        """Return an upper bound (g,) of the log likelihood ratio of every pose in a cell and heading interval."""
        scene, model = self.field.scene, self.field.model
        matches, gains = np.zeros(len(self.centres)), np.zeros(len(self.centres))
        for target, peak in enumerate(self.peaks()):
            places = scene.z - np.exp(1j * heading_rad) * scene.rho[target]
            cells, marks = self._within_reach(places, target)
            matches[cells] += 1.0
            gains[cells] += np.log(marks * peak + 1.0)
        share = np.array(model.clutter_share)[:, None]
        best = np.full(len(self.centres), -np.inf)
        unmatched = len(scene.rho) - matches[None, :]
        for row, level in enumerate(model.detection_level):
            odds = level / (1.0 - level)
            value = len(scene.rho) * (1.0 - share) + unmatched * np.log(share) + matches * np.log(max(odds, 1.0))
            best = np.maximum(best, value.max(axis=0) + self.missed[row])
        return best + gains

    def peaks(self) -> FloatArray:
        """Return the likelihood ratio (m,) of a match without misfit, at detection odds of one."""
        scene = self.field.scene
        sigma_m = float(scene.mark_sigma_m.min())
        area = np.hypot(scene.range_sigma_m, sigma_m) * np.hypot(scene.range_m * scene.bearing_sigma_rad, sigma_m)
        told = 0.0 if self.field.log_pair_ratio is None else self.field.log_pair_ratio.max(axis=1)
        peaks: FloatArray = np.exp(told) / (2.0 * np.pi * area * self.field.clutter_per_m2)
        return peaks

    def _within_reach(self, places: NDArray[np.complex128], target: int) -> tuple[IntArray, FloatArray]:
        """Return the cells from which a target can lie on a mark, and on how many marks."""
        scene = self.field.scene
        sigma_m = max(scene.range_sigma_m[target], scene.range_m[target] * scene.bearing_sigma_rad[target])
        turned_m = scene.range_m[target] * np.radians(CELL_DEG / 2.0)
        reach_m = GATE_SIGMA * np.hypot(sigma_m, scene.mark_sigma_m) + turned_m + self.cell_m / np.sqrt(2.0)
        count = np.zeros(len(self.centres))
        width = np.ceil(reach_m / self.cell_m).astype(np.int64)
        for cells_wide in np.unique(width):
            same = width == cells_wide
            count += self._count_about(places[same], reach_m[same], int(cells_wide))
        cells = np.flatnonzero(count)
        return cells, count[cells]

    def _count_about(self, places: NDArray[np.complex128], reach_m: FloatArray, width: int) -> FloatArray:
        """Return how many of the places (k,) are within their reach (k,) of each cell (g,), ``width`` cells at most."""
        offset = np.arange(-width, width + 1)
        nearest_m = np.maximum(np.abs(offset) - 1, 0) * self.cell_m  # that such a cell can be
        disc = np.hypot(nearest_m[:, None], nearest_m[None, :])[None] <= reach_m[:, None, None]
        row = np.floor((places - self.corner).real / self.cell_m).astype(np.int64)
        column = np.floor((places - self.corner).imag / self.cell_m).astype(np.int64)
        rows, columns = row[:, None, None] + offset[:, None], column[:, None, None] + offset
        valid = disc & (rows >= 0) & (rows < self.north) & (columns >= 0) & (columns < self.east)
        return np.bincount((rows * self.east + columns)[valid], minlength=len(self.centres)).astype(np.float64)


def _largest_mass(known: Prior, field: Field) -> float:
    """Return ln of the largest prior mass that a pose with at least three matches can have."""
    widest = field.model.widest_pose_m**2 * np.radians(field.model.widest_pose_deg) * (2.0 * np.pi) ** 1.5
    density = -known.log_area - np.log(2.0 * np.pi)
    if known.has_hint:
        density = 0.0 - np.log(widest)  # a hint can make any one place as likely as certain
    return float(np.log(widest) + density)


def _solve(field: Field, known: Prior, starts: list[Poses], model: AssociationModel) -> Judged:
    """Run the EM from every start, in batches, and keep the distinct answers."""
    parts = [ambiguity.distinct(part, model) for part in _judged(field, known, Poses.join(*starts))]
    joined = Judged(
        Poses.join(*(part.poses for part in parts)),
        np.concatenate([part.information for part in parts]),
        np.concatenate([part.log_ratio for part in parts]),
        np.concatenate([part.evidence for part in parts]),
        np.concatenate([part.ships for part in parts]),
    )
    return ambiguity.distinct(joined.take(np.argsort(-joined.evidence, kind="stable")), model)


def _judged(field: Field, known: Prior, poses: Poses) -> Iterator[Judged]:
    for begin in range(0, len(poses), BATCH):
        refined, information = em.refine(field, poses.take(np.arange(begin, min(begin + BATCH, len(poses)))))
        yield evidence.judge(field, refined, information, known)


def _not_among(answers: Judged, others: Judged, model: AssociationModel) -> IntArray:
    """Return the rows of ``answers`` that are none of the ``others``."""
    rows = [row for row in range(len(answers.evidence)) if not ambiguity.same_as(answers, row, others, model).any()]
    return np.array(rows, dtype=np.int64)
