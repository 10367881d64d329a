"""Step 3: own motion over the window as knots, and what is known of it beforehand.

Unknowns are (north, east, heading) at each knot, three a knot, and one offset of the radar's clock against AIS. A
priori: an unknown acceleration, a walk of the heading, a speed, a clock offset - and the pose of one knot, unknown
(the gauge) or given by an earlier fix. All priors are Gaussian and none depends on where north is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.association.scene import BoolArray, ComplexArray
from navfix.catalog import WindowModel
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi

LOOSE_M, LOOSE_RAD = 3000.0, 0.5  # how far a motion without any mark may wander from where it started


@dataclass(frozen=True, eq=False)
class Knots:
    """Own motion, k of them: places ``p`` [m, complex] and ``heading_rad`` (k, K), ``clock_s`` (k,).

    ``barred`` (k, m) tells which tracks are taken for clutter under each of them; None: any may be a mark.
    """

    p: ComplexArray
    heading_rad: FloatArray
    clock_s: FloatArray
    barred: BoolArray | None = None

    def __len__(self) -> int:
        return len(self.p)

    def take(self, rows: IntArray | FloatArray) -> Knots:
        """Return the motions of ``rows``."""
        barred = None if self.barred is None else self.barred[rows]
        return Knots(self.p[rows], self.heading_rad[rows], self.clock_s[rows], barred)

    def moved(self, step: FloatArray) -> Knots:
        """Return the motions after a step (k, 3 K + 1) of the unknowns; one motion after k steps is k motions."""
        by_knot = step[:, :-1].reshape(len(step), -1, 3)
        return Knots(
            self.p + by_knot[:, :, 0] + 1j * by_knot[:, :, 1],
            self.heading_rad + by_knot[:, :, 2],
            self.clock_s + step[:, -1],
            self.barred,
        )

    def vector(self) -> FloatArray:
        """Return the unknowns (k, 3 K + 1)."""
        by_knot = np.stack([self.p.real, self.p.imag, self.heading_rad], axis=-1).reshape(len(self), -1)
        return np.concatenate([by_knot, self.clock_s[:, None]], axis=1)

    @classmethod
    def join(cls, *parts: Knots) -> Knots:
        """Return several batches as one."""
        return cls(
            np.concatenate([q.p for q in parts]),
            np.concatenate([q.heading_rad for q in parts]),
            np.concatenate([q.clock_s for q in parts]),
        )


def placed(shape: Knots, p: ComplexArray, heading_rad: FloatArray, gauge: int) -> Knots:
    """Lay one shape of motion (its gauge knot at 0, heading 0) at k poses."""
    turn = np.exp(1j * heading_rad)[:, None]
    return Knots(
        p[:, None] + turn * (shape.p - shape.p[:, gauge, None]),
        heading_rad[:, None] + (shape.heading_rad - shape.heading_rad[:, gauge, None]),
        np.broadcast_to(shape.clock_s, len(p)).copy(),
    )


def shape_of(knots: Knots, gauge: int) -> Knots:
    """Return motions seen from their own gauge knot."""
    turn = np.exp(-1j * knots.heading_rad[:, gauge, None])
    return Knots(
        turn * (knots.p - knots.p[:, gauge, None]),
        knots.heading_rad - knots.heading_rad[:, gauge, None],
        np.zeros(len(knots)),
    )


@dataclass(frozen=True, eq=False)
class PosePrior:
    """Poses known beforehand at one knot, one for each of k motions (or one for all).

    ``p`` (k,) [m, complex], ``heading_rad`` (k,), ``covariance`` (k, 3, 3) in (north m, east m, heading rad).
    """

    knot: int
    p: ComplexArray
    heading_rad: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class MotionPrior:
    """Gaussian prior of the unknowns: ``information`` (d, d) of shape and clock; ``pose`` what is known besides.

    ``log_area`` is ln of the searched area [m^2], for a pose of which nothing is known.
    """

    information: FloatArray
    gauge: int
    log_area: float
    pose: PosePrior | None = None

    def given(self, pose: PosePrior | None) -> MotionPrior:
        """Return the same prior with a pose known beforehand."""
        return replace(self, pose=pose)

    @property
    def full_information(self) -> FloatArray:
        """Information (k or 1, d, d) with that of the pose; of an unknown one a trace, so that a motion stays."""
        known = self.pose
        at = 3 * (self.gauge if known is None else known.knot)
        loose: FloatArray = np.diag(1.0 / np.array([LOOSE_M, LOOSE_M, LOOSE_RAD]) ** 2)[None]
        pose = loose if known is None else np.asarray(np.linalg.inv(known.covariance), dtype=np.float64)
        full = np.repeat(self.information[None], len(pose), axis=0)
        full[:, at : at + 3, at : at + 3] += pose
        return full

    def gradient(self, knots: Knots) -> FloatArray:
        """Return -d/dx of half the misfit to the prior (k, d)."""
        pull = -knots.vector() @ self.information
        if self.pose is not None:
            at = 3 * self.pose.knot
            offset = self._pose_offset(self.pose, knots)
            pull[:, at : at + 3] -= np.linalg.solve(self.pose.covariance, offset[:, :, None])[:, :, 0]
        return pull

    def log_shape(self, knots: Knots) -> FloatArray:
        """Return -1/2 x' Lambda x (k,): how likely the motion itself is, wherever it begins."""
        x = knots.vector()
        misfit: FloatArray = -0.5 * np.einsum("kd,de,ke->k", x, self.information, x)
        return misfit

    def log_density(self, knots: Knots) -> FloatArray:
        """Return ln of the prior density (k,), up to the factors of 2 pi that a Gaussian integral over all cancels."""
        total = self.log_shape(knots)
        if self.pose is None:
            anywhere = -self.log_area - math.log(2.0 * math.pi) + 1.5 * math.log(2.0 * math.pi)
            return total + 0.5 * self._log_det_shape() + anywhere
        total -= 0.5 * self.pose_misfit_sq(knots)
        density: FloatArray = total + 0.5 * np.linalg.slogdet(self.full_information)[1]
        return density

    def pose_misfit_sq(self, knots: Knots) -> FloatArray:
        """Return the squared Mahalanobis distance (k,) of the motions to the pose that was known beforehand."""
        if self.pose is None:
            return np.zeros(len(knots))
        offset = self._pose_offset(self.pose, knots)
        square: FloatArray = (offset * np.linalg.solve(self.pose.covariance, offset[:, :, None])[:, :, 0]).sum(axis=1)
        return square

    def without_pose(self) -> FloatArray:
        """Return the information of the shape alone (d - 4, d - 4): no pose, no clock."""
        keep = self.shape_rows()
        return self.information[np.ix_(keep, keep)]

    def shape_rows(self) -> IntArray:
        """Return which unknowns are the shape of the motion: neither the gauge knot's pose nor the clock."""
        return np.concatenate([np.arange(3 * self.gauge), np.arange(3 * self.gauge + 3, len(self.information) - 1)])

    def _log_det_shape(self) -> float:
        keep = np.append(self.shape_rows(), len(self.information) - 1)
        return float(np.linalg.slogdet(self.information[np.ix_(keep, keep)])[1])

    @staticmethod
    def _pose_offset(pose: PosePrior, knots: Knots) -> FloatArray:
        place = knots.p[:, pose.knot] - pose.p
        turn = wrap_pi(knots.heading_rad[:, pose.knot] - pose.heading_rad)
        return np.stack([place.real, place.imag, turn], axis=1)


def motion_prior(knot_s: FloatArray, gauge: int, log_area: float, model: WindowModel) -> MotionPrior:
    """Return the prior of own motion over knots (K,) [s]: eq. (6.19) of the theory."""
    count = len(knot_s)
    rows: list[FloatArray] = []
    if count > 1:
        step_s = float(knot_s[1] - knot_s[0])
        heading = np.radians(model.heading_walk_deg) * math.sqrt(step_s / 10.0)
        for axis, order, sigma in (
            (0, 2, model.acceleration_mps2 * step_s**2),
            (1, 2, model.acceleration_mps2 * step_s**2),
            (2, 1, heading),
        ):
            difference = np.diff(np.eye(count), n=order, axis=0) / sigma
            rows += [_at_axis(row, axis) for row in difference]
        span = (np.eye(count)[-1] - np.eye(count)[0]) / (float(knot_s[-1] - knot_s[0]) * model.speed_mps)
        rows += [_at_axis(span, axis) for axis in (0, 1)]
    clock = np.zeros(3 * count + 1)
    clock[-1] = 1.0 / model.clock_s
    A = np.array([*rows, clock])
    return MotionPrior(A.T @ A, gauge, log_area)


def _at_axis(row: FloatArray, axis: int) -> FloatArray:
    full = np.zeros(3 * len(row) + 1)
    full[axis:-1:3] = row
    return full
