"""What is known of the pose beforehand: nothing, or hints that are checked and never simply believed.

Without hints a position is anywhere in the union of the radar discs about the marks, a heading anywhere. A hint is
right with probability 1 - q and worthless with q, so the prior is a mixture; the data decide which. A gyro that is
90 degrees off costs ln(1/q) and no more, and is told by the share of the worthless component.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from navfix.association.em import Field
from navfix.association.scene import Scene
from navfix.association.seeds import Poses
from navfix.catalog import AssociationModel
from navfix.geodesy import cloud_to_plane, convergence
from navfix.types import Epoch, FloatArray, HeadingHint, IntArray, Position, PositionHint
from navfix.units import wrap_pi

CELLS_IN_RANGE = 6  # of the raster that the searched area is counted in
MOST_CELLS = 1_000_000


@dataclass(frozen=True, slots=True)
class Prior:
    """``log_area`` ln of the searched area [m^2]; a hint's place [m, complex] or heading [rad] with sigma, or None.

    The heading counts from true north where own ship is, if the plane's ``origin`` is given; else from the plane's.
    """

    log_area: float
    wrong_share: float
    place: complex | None = None
    place_sigma_m: float = math.inf
    heading_rad: float | None = None
    heading_sigma_rad: float = math.inf
    origin: Position | None = None

    @property
    def has_hint(self) -> bool:
        """Whether anything is known beforehand."""
        return self.place is not None or self.heading_rad is not None

    def true_heading(self, poses: Poses) -> FloatArray:
        """Return the headings (k,) [rad] of poses, counted as the hint's is."""
        return poses.heading_rad if self.origin is None else poses.heading_rad + convergence(self.origin, poses.p)

    def log_mass(self, poses: Poses, information: FloatArray) -> FloatArray:
        """Return ln of prior x likelihood, integrated over each pose's Gaussian peak of height 1 (k,): eq. (6.8).

        The peak is exp(-1/2 d' H d) with H = ``information`` (k, 3, 3); a Gaussian hint integrates to the density of
        the pose under the sum of both covariances.
        """
        volume = 1.5 * math.log(2.0 * math.pi) - 0.5 * np.linalg.slogdet(information)[1]
        total: FloatArray = volume + np.logaddexp.reduce(self._components(poses, information), axis=0)
        return total

    def log_gain(self, poses: Poses, information: FloatArray) -> FloatArray:
        """Return ln of how much likelier the hints make poses (k,) than knowing nothing does: the rest of eq. (6.8)."""
        nothing = -self.log_area - math.log(2.0 * math.pi)
        gain: FloatArray = np.logaddexp.reduce(self._components(poses, information), axis=0) - nothing
        return gain

    def hint_holds(self, poses: Poses, information: FloatArray) -> FloatArray:
        """Return the probability (k, 2) that the position hint and the heading hint are right, given each pose."""
        weight = self._components(poses, information)
        weight = np.exp(weight - np.logaddexp.reduce(weight, axis=0))
        trusted: FloatArray = weight.T @ np.array(self._choices(), dtype=np.float64)
        return trusted

    def plausible(self, poses: Poses) -> NDArray[np.bool_]:
        """Tell which poses (k,) are within four sigma (and a cell) of every hint."""
        near = np.ones(len(poses), dtype=bool)
        if self.place is not None:
            near &= np.abs(poses.p - self.place) <= 4.0 * self.place_sigma_m + 1000.0
        if self.heading_rad is not None:
            near &= np.abs(wrap_pi(self.true_heading(poses) - self.heading_rad)) <= 4.0 * self.heading_sigma_rad + 0.05
        return near

    def _choices(self) -> list[tuple[bool, bool]]:
        """Return every combination of (position hint trusted, heading hint trusted) that there is."""
        places = (False,) if self.place is None else (False, True)
        headings = (False,) if self.heading_rad is None else (False, True)
        return list(product(places, headings))

    def _components(self, poses: Poses, information: FloatArray) -> FloatArray:
        """Return ln of weight x density (c, k) for each combination of trusted hints."""
        if not self.has_hint:
            return np.full((1, len(poses)), -self.log_area - math.log(2.0 * math.pi))
        sigmas = np.array([self.place_sigma_m, self.place_sigma_m, self.heading_sigma_rad])
        spread = np.asarray(np.linalg.inv(information), dtype=np.float64)
        spread += np.diag(np.where(np.isfinite(sigmas), sigmas, 0.0) ** 2)
        place = poses.p - (self.place or 0.0)
        turn = wrap_pi(self.true_heading(poses) - (self.heading_rad or 0.0))
        offset = np.column_stack([place.real, place.imag, turn])
        rows = []
        for trust_place, trust_heading in self._choices():
            axes = slice(0 if trust_place else 2, 3 if trust_heading else 2)
            log_density = _log_normal(offset[:, axes], spread[:, axes, axes])
            log_density -= (0.0 if trust_place else self.log_area) + (0.0 if trust_heading else math.log(2.0 * math.pi))
            rows.append(log_density + self._log_weight(trust_place, trust_heading))
        return np.stack(rows)

    def _log_weight(self, trust_place: bool, trust_heading: bool) -> float:
        weight = 0.0
        for present, trusted in ((self.place is not None, trust_place), (self.heading_rad is not None, trust_heading)):
            if present:
                weight += math.log(1.0 - self.wrong_share if trusted else self.wrong_share)
        return weight


def of(epoch: Epoch | None, scene: Scene, field: Field, model: AssociationModel) -> Prior:
    """Return the prior of an epoch: its hints in the scene's plane.

    True bearings already hold a heading, so a heading hint says nothing about their turn: that is the compass error.
    """
    place, place_sigma_m = _place(epoch.position_hint if epoch else None, scene)
    heading = epoch.heading_hint if epoch else None
    if scene.reference == "true":
        heading = HeadingHint(0.0, model.compass_sigma_deg)
    return Prior(
        log_area(field),
        model.hint_wrong_share,
        place,
        place_sigma_m,
        None if heading is None else math.radians(heading.heading_deg),
        math.inf if heading is None else math.radians(math.hypot(heading.sigma_deg, model.alignment_sigma_deg)),
        scene.origin,
    )


def log_area(field: Field) -> float:
    """Return ln of the searched area [m^2]: the union of the radar discs about the marks, counted in cells."""
    radius_m = field.scene.radar_range_m
    cell_m = radius_m / CELLS_IN_RANGE
    row = np.round(field.scene.z.real / cell_m).astype(np.int64)
    column = np.round(field.scene.z.imag / cell_m).astype(np.int64)
    rows, columns = row - row.min() + CELLS_IN_RANGE, column - column.min() + CELLS_IN_RANGE
    height, width = int(rows.max()) + CELLS_IN_RANGE + 1, int(columns.max()) + CELLS_IN_RANGE + 1
    occupied = np.unique(rows * width + columns)
    north, east = _DISC
    covered = np.add.outer(occupied, north * width + east).ravel()
    if height * width > MOST_CELLS:  # marks at both ends of the world
        return math.log(len(np.unique(covered)) * cell_m**2)
    raster = np.zeros(height * width, dtype=bool)
    raster[covered] = True
    return math.log(int(np.count_nonzero(raster)) * cell_m**2)


def _disc() -> tuple[IntArray, IntArray]:
    """Return rows and columns of the cells within the radar's range of one in the middle."""
    offsets = np.arange(-CELLS_IN_RANGE, CELLS_IN_RANGE + 1)
    north, east = np.meshgrid(offsets, offsets, indexing="ij")
    within = north**2 + east**2 <= CELLS_IN_RANGE**2
    return north[within], east[within]


_DISC = _disc()


def _place(hint: PositionHint | None, scene: Scene) -> tuple[complex | None, float]:
    if hint is None:
        return None, math.inf
    north_m, east_m = cloud_to_plane(scene.origin, [hint.position.lat_deg], [hint.position.lon_deg])[0]
    return complex(north_m, east_m), hint.sigma_m


def _log_normal(offset: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return ln of the normal density (k,) of offsets (k, d) with covariances (k, d, d); 0 for no dimensions."""
    dimensions = offset.shape[1]
    if dimensions == 0:
        return np.zeros(len(offset))
    if dimensions == 1:
        mahalanobis_sq, log_det = offset[:, 0] ** 2 / covariance[:, 0, 0], np.log(covariance[:, 0, 0])
    else:
        mahalanobis_sq = (offset * np.linalg.solve(covariance, offset[:, :, None])[:, :, 0]).sum(axis=1)
        log_det = np.linalg.slogdet(covariance)[1]
    log_density: FloatArray = -0.5 * (mahalanobis_sq + log_det + dimensions * math.log(2.0 * math.pi))
    return log_density
