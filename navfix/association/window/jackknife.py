"""Step 8b: the covariance of the newest instant - the inverse Hessian, and what each track moves when it is left out.

The Hessian trusts the stated errors. Tracks err in ways that nobody stated (a hull seen from one side, a clock), and
few of them carry a fix: so each matched track is left out in turn and the spread of what remains is added.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from navfix.association.window.em import knot_step
from navfix.association.window.evidence import posterior
from navfix.association.window.field import WindowField
from navfix.association.window.fit import lay_over
from navfix.association.window.knots import Knots, MotionPrior
from navfix.types import FloatArray


@dataclass(frozen=True, eq=False)
class PoseAtEnd:
    """Own pose at the end of the window: place [m, complex], heading [rad], covariance (3, 3), formal and full.

    ``velocity`` [m/s, complex] over ground at the end.
    """

    p: complex
    heading_rad: float
    covariance: FloatArray
    formal: FloatArray
    velocity: complex


def spread(field: WindowField, left: Knots) -> FloatArray:
    """Return the covariance (3, 3) of the pose at the end from own motions with one track left out: eq. (6.22)."""
    shift = end_vector(field, left)
    if len(shift) < 2:
        return np.zeros((3, 3))
    away = np.hypot(*(shift[:, :2] - np.median(shift[:, :2], axis=0)).T)
    near = away <= field.model.left_out_most_m
    shift = shift[near] - shift[near].mean(axis=0)
    n = len(shift)
    return (n - 1.0) / n * shift.T @ shift if n > 1 else np.zeros((3, 3))


def left_out(field: WindowField, knots: Knots, prior: MotionPrior) -> Knots:
    """Take one matched track after the other for clutter (n of them) and let the rest move one own motion."""
    likeliest = posterior(field, lay_over(field, knots))[0].max(axis=1, initial=0.0)
    matched = np.flatnonzero(likeliest > field.model.matched_posterior)
    before = np.zeros((1, len(field.scene.bins)), dtype=bool) if knots.barred is None else knots.barred
    barred = np.repeat(before, len(matched), axis=0)
    barred[np.arange(len(matched)), matched] = True
    if not len(matched):
        return knots.take(matched)
    return refit(field, replace(knots, barred=barred), prior)[0]  # one motion at first: what it fits is laid over once


def refit(field: WindowField, knots: Knots, prior: MotionPrior) -> tuple[Knots, FloatArray]:
    """Let own motions settle where the tracks that are not barred have them; return them and their information."""
    knots, information = knot_step(field, knots, 1.0, prior)
    for _ in range(field.model.left_out_rounds - 1):
        knots, information = knot_step(field, knots, 1.0, prior)
    return knots, information


def pose_at_end(
    field: WindowField, knots: Knots, information: FloatArray, left: Knots, others: FloatArray
) -> PoseAtEnd:
    """Return the pose of one own motion at the end of the window, with its covariance.

    Parameters
    ----------
    left : the same motion with one track after the other left out
    others : covariance (3, 3) that other poses of the same place add, each with its probability
    """
    formal = formal_at_end(field, information)[0]
    place, heading, velocity = at_end(field, knots)
    turned = float(heading[0]) + field.scene.yaw_at_end
    covariance = formal + spread(field, left) + others
    return PoseAtEnd(complex(place[0]), turned, covariance, formal, complex(velocity[0]))


def formal_at_end(field: WindowField, information: FloatArray) -> FloatArray:
    """Return the covariance (k, 3, 3) of the pose at the end as the Hessians (k, d, d) have it."""
    carry = carry_to_end(field)
    formal: FloatArray = carry @ np.linalg.inv(information) @ carry.T + _process(field)
    return formal


def at_end(field: WindowField, knots: Knots) -> tuple[np.ndarray, FloatArray, np.ndarray]:
    """Return place, heading (de-rotated) and velocity (k,) of own motions at the end of the window."""
    scene = field.scene
    if scene.knots == 1:
        return knots.p[:, 0], knots.heading_rad[:, 0], np.zeros(len(knots), complex)
    step_s = scene.knot_s[-1] - scene.knot_s[-2]
    velocity = (knots.p[:, -1] - knots.p[:, -2]) / step_s
    return knots.p[:, -1] + velocity * (scene.end_s - scene.knot_s[-1]), knots.heading_rad[:, -1], velocity


def end_vector(field: WindowField, knots: Knots) -> FloatArray:
    """Return the poses (k, 3) at the end of the window: north [m], east [m], heading [rad] (de-rotated)."""
    place, heading, _ = at_end(field, knots)
    return np.stack([place.real, place.imag, heading], axis=1)


def carry_to_end(field: WindowField) -> FloatArray:
    """Return what the unknowns do to the pose at the end: (3, d)."""
    scene = field.scene
    carry = np.zeros((3, 3 * scene.knots + 1))
    ahead = 0.0
    if scene.knots > 1:
        ahead = (scene.end_s - scene.knot_s[-1]) / (scene.knot_s[-1] - scene.knot_s[-2])
        carry[0, -7], carry[1, -6] = -ahead, -ahead
    carry[0, -4], carry[1, -3], carry[2, -2] = 1.0 + ahead, 1.0 + ahead, 1.0
    return carry


def _process(field: WindowField) -> FloatArray:
    """Return the covariance (3, 3) that acceleration and yaw add between the last knot and the end."""
    scene, model = field.scene, field.model
    ahead_s = scene.end_s - float(scene.knot_s[-1])
    place_m = 0.5 * model.acceleration_mps2 * ahead_s * max(model.bin_s, ahead_s)
    return np.diag([place_m**2, place_m**2, np.radians(model.heading_walk_deg) ** 2 * ahead_s / 10.0])
