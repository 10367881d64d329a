"""What every own motion in one window is tried against: tracks, marks, their variances, clutter; made once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from navfix.association.em import NOMINAL_LEVEL, Field
from navfix.association.scene import ComplexArray
from navfix.association.seeds import Poses
from navfix.association.window.knots import Knots
from navfix.association.window.scene import WindowScene
from navfix.catalog import AssociationModel, WindowModel
from navfix.types import FloatArray, IntArray

LOG_2PI = float(np.log(2.0 * np.pi))
MEAN, LINE, SCATTER = range(3)


class WindowField:
    """What every own motion in one window is tried against."""

    def __init__(self, scene: WindowScene, model: WindowModel, shared: AssociationModel) -> None:
        self.scene, self.model, self.shared = scene, model, shared
        self.flat = Field(scene.flat, shared)
        self.neighbours = min(model.neighbours, len(scene.paths.marks))
        self.has_line = scene.used[:, 1] if scene.knots > 1 else np.zeros(len(scene.bins), dtype=bool)

    def at_gauge(self, knots: Knots) -> Poses:
        """Return the poses (k,) of own motions at the gauge knot."""
        return Poses(knots.p[:, self.scene.gauge], knots.heading_rad[:, self.scene.gauge])

    @cached_property
    def trees(self) -> list[cKDTree]:
        """A tree of the marks at each knot."""
        z = self.scene.paths.z
        return [cKDTree(np.column_stack([z[:, k].real, z[:, k].imag])) for k in range(self.scene.knots)]

    @cached_property
    def by_coordinate(self) -> tuple[FloatArray, ComplexArray]:
        """What own place, and what own heading, at each knot do to the coordinates of all tracks, each (K, m s)."""
        basis = self.scene.basis
        own = self.scene.rho[:, None, :] * basis
        return basis.reshape(-1, self.scene.knots).T, own.reshape(-1, self.scene.knots).T

    @cached_property
    def middle_rho(self) -> ComplexArray:
        """Every track (m,) at the bin in the middle of its life, in the de-rotated ship's frame [m]."""
        middle: ComplexArray = self.scene.rho[np.arange(len(self.scene.rho)), self.scene.middle_bin]
        return middle

    @property
    def coordinates(self) -> tuple[int, int, int]:
        """How many coordinates a basis over all bins has of each kind: mean, line, scatter."""
        return 1, min(self.scene.knots - 1, 1), max(self.scene.knots - 2, 0)

    @cached_property
    def scatters(self) -> FloatArray:
        """How many coordinates of each track (m,) are scatter, on both axes together."""
        return np.asarray(2.0 * self.scene.used[:, SCATTER:].sum(axis=1))

    def odds(self, mark: IntArray, level: float) -> FloatArray:
        """Return the detection odds Pd_j / (1 - Pd_j) (k, m, q) of tracks as the marks (k, m, q)."""
        flat = self.scene.flat
        pd = level * self.flat.detection(flat.range_m[None, :, None], flat.conspicuity[mark])
        return np.asarray(pd / (1.0 - pd))

    @cached_property
    def means(self) -> Means:
        """Every track beside every mark by their means."""
        scene, to_mean = self.scene, self.scene.basis[:, 0]
        every = np.broadcast_to(np.arange(len(scene.paths.marks)), (1, len(scene.bins), len(scene.paths.marks)))
        log_ratio = np.log(self.odds(every, NOMINAL_LEVEL)[0]) - 0.5 * self.log_det[..., MEAN] - LOG_2PI
        log_ratio += np.log(scene.bins / self.flat.clutter_per_m2)[:, None]
        information = 1.0 / self.variance_m2[..., MEAN, :]
        return Means(to_mean @ scene.paths.z.T, to_mean @ scene.paths.v.T, information, log_ratio)

    @cached_property
    def variance_m2(self) -> FloatArray:
        """Variances (m, n, 3, 2) of every track on every mark [m^2], radial and tangential: eq. (6.18).

        Mean n s_c^2 + s_w^2, line S_tt s_s^2 + s_w^2, scatter s_w^2, those of track and mark together.
        """
        scene, paths = self.scene, self.scene.paths
        aged_m2: FloatArray = (paths.aged_m**2).mean(axis=1)  # of what grows with the age of a mark's reports
        white = scene.white_m2[:, None] + aged_m2[:, None]
        constant = scene.constant_m2[:, None] + (paths.constant_m**2)[:, None]
        mean = white + scene.bins[:, None, None] * constant
        line = white + (scene.spread_s2 * self.model.slope_mps**2)[:, None, None]
        return np.stack([mean, line, white], axis=2)

    @cached_property
    def log_det(self) -> FloatArray:
        """Ln of the product of both axes' variances (m, n, 3) of every track on every mark."""
        log_det: FloatArray = np.log(self.variance_m2[..., 0] * self.variance_m2[..., 1])
        return log_det

    @cached_property
    def line_m2(self) -> FloatArray:
        """Variances (3, m, 2) of the line of clutter: still, moving and jumping [m^2]."""
        speed = np.array([self.model.still_mps, self.model.moving_mps, self.model.jumping_mps])
        moved: FloatArray = self.scene.spread_s2[None, :, None] * speed[:, None, None] ** 2
        return self.scene.white_m2[None] + moved

    @cached_property
    def line_share(self) -> FloatArray:
        """Shares (3,) of clutter that stands, moves and jumps."""
        still, jumping = self.model.still_share, self.model.jumping_share
        return np.array([still, 1.0 - still - jumping, jumping])


@dataclass(frozen=True, eq=False)
class Means:
    """Every track beside every mark (m, n), by its mean over the bins.

    ``z`` and ``v`` the mark's place and velocity; ``information`` (m, n, 2) the inverse variance of the misfit, radial
    and tangential; ``log_ratio`` ln of the ratio of eq. (6.20) without misfit, of the places alone.
    """

    z: ComplexArray
    v: ComplexArray
    information: FloatArray
    log_ratio: FloatArray
