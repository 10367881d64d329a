"""Step 4: Coherent Point Drift's EM for many poses at once, in the noise that a radar has.

E-step: responsibilities of the nearest marks for every target, as in Myronenko & Song (2010) eq. 6, with two changes:
each target has its own polar covariance, and the outlier term is the local clutter density.
M-step: one Gauss-Newton step on (p, h) in place of their closed form (Fig. 2), which needs equal, round covariances.
The sigmas are annealed from wide to true.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from navfix.association.clutter import clutter_density
from navfix.association.lengths import log_length_ratio
from navfix.association.scene import ComplexArray, Scene
from navfix.association.seeds import Poses
from navfix.association.speeds import log_speed_ratio
from navfix.catalog import AssociationModel
from navfix.types import FloatArray, IntArray

NOMINAL_SHARE = 0.4  # of clutter among the echoes, while the pose is sought; the evidence averages over it
REACH_SIGMA = 7.0  # beyond it a mark is no match
GATE = 11.8  # of a pair: chi-square, 2 degrees of freedom, 99.73 %
NOWHERE = 1e9 + 1e9j  # [m] where no target falls
NOMINAL_LEVEL = 0.6  # of detection, likewise
FREE_M, FREE_RAD = 3000.0, 0.5  # a pose without any match may move so far in a step


class Field:
    """What every pose of one scene is tried against: the marks' tree, detection and clutter at nominal shares."""

    def __init__(self, scene: Scene, model: AssociationModel) -> None:
        self.scene = scene
        self.model = model
        self.neighbours = min(model.neighbours, len(scene.z))
        self.clutter_per_m2 = clutter_density(scene, model)
        self.log_speed_ratio = (
            log_speed_ratio(scene.target_speed_mps, scene.mark_speed_mps, model) if model.use_speed else None
        )
        self.log_pair_ratio = self._log_pair_ratio()
        self.range_m2 = scene.range_sigma_m**2
        self.across_m2 = (scene.range_m * scene.bearing_sigma_rad) ** 2
        self.z = np.append(scene.z, NOWHERE)  # and one more, for targets without a mark within reach
        self.mark_m2 = np.append(scene.mark_sigma_m, 0.0) ** 2
        self.conspicuity = np.append(scene.conspicuity, 0.0)
        self.widest_m = float(np.sqrt(max(self.range_m2.max(), self.across_m2.max()) + self.mark_m2.max()))
        self.seen = self.detection(scene.range_m, np.ones(len(scene.rho)))

    @cached_property
    def tree(self) -> cKDTree:
        return cKDTree(self.scene.mark_xy)

    def thinned(self, targets: int, neighbours: int) -> Field:
        """Return the field with at most so many targets, evenly over the ranges, and so many nearest marks to each."""
        by_range = np.argsort(self.scene.range_m, kind="stable")
        rows = np.sort(by_range[np.linspace(0, len(by_range) - 1, min(targets, len(by_range))).astype(np.int64)])
        _ = self.tree  # one for both
        few = copy.copy(self)
        few.scene = self.scene.keeping(rows, slice(None))
        few.neighbours = min(self.neighbours, neighbours)
        for name in ("clutter_per_m2", "range_m2", "across_m2", "seen"):
            setattr(few, name, getattr(self, name)[rows])
        if self.log_pair_ratio is not None:
            few.log_pair_ratio = self.log_pair_ratio[rows]
        return few

    def detection(self, distance_m: FloatArray, conspicuity: FloatArray) -> FloatArray:
        """Return the detection probability at level 1: conspicuity, full to half the radar's range, then falling."""
        beyond_half = np.clip(2.0 * distance_m / self.scene.radar_range_m - 1.0, 0.0, 1.0)
        fall: FloatArray = conspicuity * (1.0 - (1.0 - self.model.far_detection) * beyond_half)
        return fall

    def _log_pair_ratio(self) -> FloatArray | None:
        """Return what speed and length say of each target and mark (m, n + 1), None where they say nothing."""
        told = (
            np.zeros((len(self.scene.rho), len(self.scene.z))) if self.log_speed_ratio is None else self.log_speed_ratio
        )
        if self.model.use_length and np.isfinite(self.scene.target_length_m).any():
            told = told + log_length_ratio(self.scene.target_length_m, self.scene.mark_length_m, self.model)
        return np.pad(told, ((0, 0), (0, 1))) if told.any() else None

    def nearest(self, world: ComplexArray, reach_m: float = np.inf) -> IntArray:
        """Return the nearest marks (..., q) of places (...); where fewer are within reach, the number of marks."""
        places = np.ascontiguousarray(world).view(np.float64).reshape(-1, 2)
        _, mark = self.tree.query(places, k=self.neighbours, distance_upper_bound=reach_m)
        nearest: IntArray = mark.reshape(*world.shape, self.neighbours)
        return nearest


@dataclass(frozen=True, eq=False)
class Fit:
    """Targets laid over marks at k poses: for each pose, target and neighbour.

    ``mark`` (k, m, q) mark indices; ``radial_m`` and ``tangential_m`` (k, m, q) misfits in the target's own axes;
    ``radial_m2``, ``tangential_m2`` (k, m, q) their variances (radar and mark together).
    """

    mark: IntArray
    radial_m: FloatArray
    tangential_m: FloatArray
    radial_m2: FloatArray
    tangential_m2: FloatArray

    @cached_property
    def distance_sq(self) -> FloatArray:
        """Squared Mahalanobis distance (k, m, q)."""
        return self.radial_m**2 / self.radial_m2 + self.tangential_m**2 / self.tangential_m2

    def log_density(self, widening: float = 1.0) -> FloatArray:
        """Return the logarithm of the normal density per m^2 (k, m, q), sigmas multiplied by ``widening``."""
        log_det = np.log(self.radial_m2 * self.tangential_m2) + 4.0 * np.log(widening)
        log_density: FloatArray = -0.5 * (self.distance_sq / widening**2 + log_det) - np.log(2.0 * np.pi)
        return log_density

    def density(self, widening: float = 1.0) -> FloatArray:
        """Return the normal density per m^2 (k, m, q), sigmas multiplied by ``widening``."""
        density: FloatArray = np.exp((-0.5 / widening**2) * self.distance_sq)
        density /= np.sqrt(self.radial_m2 * self.tangential_m2) * (2.0 * np.pi * widening**2)
        return density


def lay_over(field: Field, poses: Poses, mark: IntArray | None = None, *, reach_m: float = np.inf) -> Fit:
    """Place the targets at every pose and measure their misfit to the nearest marks, or to those given (k, m, q)."""
    scene = field.scene
    turn = np.exp(1j * poses.heading_rad)[:, None]
    world = poses.p[:, None] + turn * scene.rho[None, :]
    if mark is None:
        mark = field.nearest(world, reach_m)
    axis = turn * scene.ray[None, :]
    misfit = (field.z[mark] - world[:, :, None]) * np.conj(axis)[:, :, None]
    mark_m2 = field.mark_m2[mark]
    return Fit(
        mark,
        misfit.real,
        misfit.imag,
        field.range_m2[None, :, None] + mark_m2,
        field.across_m2[None, :, None] + mark_m2,
    )


def odds_free_ratio(field: Field, fit: Fit, widening: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return N_ij / lambda_i and the detection probability at level 1, each (k, m, q)."""
    ratio = fit.density(widening) / field.clutter_per_m2[None, :, None]
    if field.log_pair_ratio is not None:
        ratio *= np.exp(field.log_pair_ratio[np.arange(len(field.scene.rho))[None, :, None], fit.mark])
    return ratio, field.seen[None, :, None] * field.conspicuity[fit.mark]


def likelihood_ratio(field: Field, fit: Fit, level: float, widening: float = 1.0) -> FloatArray:
    """Return w_ij = Pd_j / (1 - Pd_j) N_ij / lambda_i (k, m, q) at one detection level: eq. (6.4) of the theory."""
    ratio, seen = odds_free_ratio(field, fit, widening)
    pd = level * seen
    ratio *= pd / (1.0 - pd)
    return ratio


def refine(
    field: Field, poses: Poses, finalists: int | None = None, *, quickly: bool = False
) -> tuple[Poses, FloatArray]:
    """Run the annealed EM from every pose; return the poses and their information matrices (k, 3, 3).

    After the wide steps only the best ``finalists`` (default ``model.finalists``) that differ go on: the others are
    accidents of the vote. ``quickly``: the wide steps look at a part of the targets only.
    """
    model = field.model
    widest, rest = model.annealing[:2], model.annealing[2:]
    screen = field.thinned(model.screen_targets, model.screen_neighbours) if quickly else field
    gain = np.zeros(len(poses))
    for widening in widest:
        fit = lay_over(screen, poses, reach_m=widening * REACH_SIGMA * field.widest_m)
        poses, information, gain = em_step(screen, poses, widening, fit)
    most = finalists or model.finalists
    poses = poses.take(poses.leaders(gain, most, 0.5 * model.distinct_m, 0.5 * model.distinct_deg))
    for number, widening in enumerate(rest):
        near = fit.mark if number % 2 else None  # the nearest marks change little in one step
        fit = lay_over(field, poses, near, reach_m=widening * REACH_SIGMA * field.widest_m)
        poses, information, _ = em_step(field, poses, widening, fit)
    return poses, information


def em_step(
    field: Field,
    poses: Poses,
    widening: float,
    fit: Fit | None = None,
    *,
    share: float = NOMINAL_SHARE,
    level: float = NOMINAL_LEVEL,
) -> tuple[Poses, FloatArray, FloatArray]:
    """One E-step and one M-step at all poses (k); ``fit``, where it is at hand, lays the targets over at these poses.

    Returns
    -------
    the moved poses, the information matrices (k, 3, 3) of (p, h), and the log likelihood ratio (k,) before the step
    """
    scene = field.scene
    fit = fit or lay_over(field, poses)
    ratio = likelihood_ratio(field, fit, level, widening)
    total = share + ratio.sum(axis=2, keepdims=True)
    responsibility = ratio / total  # M&S eq. 6
    weight_radial = responsibility / fit.radial_m2
    weight_tangential = responsibility / fit.tangential_m2
    information, gradient = _normal_equations(scene, poses, fit, weight_radial, weight_tangential, widening)
    step = np.linalg.solve(information, gradient[:, :, None])[:, :, 0]
    moved = Poses(poses.p + step[:, 0] + 1j * step[:, 1], poses.heading_rad + step[:, 2])
    return moved, information, np.log(total).sum(axis=(1, 2))


def _normal_equations(
    scene: Scene, poses: Poses, fit: Fit, weight_radial: FloatArray, weight_tangential: FloatArray, widening: float
) -> tuple[FloatArray, FloatArray]:
    """Return A'WA (k, 3, 3) and A'Wl (k, 3) of the misfits, unknowns (north, east, heading).

    In a target's axes a step of p moves it by the step turned into these axes, a step of h by r along the tangent. As
    complex numbers (north + i east), with u = exp(i azimuth): the block of p is the mean of both weights on its
    diagonal and half their difference times u^2; the column of p and h is i u r; the gradient is the misfit times u.
    A weak prior of ten cells keeps a pose without any match where it is.
    """
    u = np.exp(1j * poses.heading_rad)[:, None] * scene.ray[None, :]
    radial, tangential = weight_radial.sum(axis=2), weight_tangential.sum(axis=2)
    pull = np.empty(u.shape, dtype=np.complex128)
    pull.real = (weight_radial * fit.radial_m).sum(axis=2)
    pull.imag = (weight_tangential * fit.tangential_m).sum(axis=2)
    r = scene.range_m
    both, difference = 0.5 * (radial + tangential).sum(axis=1), 0.5 * ((radial - tangential) * u * u).sum(axis=1)
    column = (u * tangential) @ r
    shift = (pull * u).sum(axis=1)
    free = widening**2 / np.array([FREE_M, FREE_M, FREE_RAD]) ** 2
    information = np.empty((len(poses), 3, 3))
    information[:, 0, 0] = both + difference.real + free[0]
    information[:, 1, 1] = both - difference.real + free[1]
    information[:, 2, 2] = tangential @ (r * r) + free[2]
    information[:, 0, 1] = information[:, 1, 0] = difference.imag
    information[:, 0, 2] = information[:, 2, 0] = -column.imag
    information[:, 1, 2] = information[:, 2, 1] = column.real
    gradient = np.empty((len(poses), 3))
    gradient[:, 0], gradient[:, 1], gradient[:, 2] = shift.real, shift.imag, pull.imag @ r
    return information, gradient
