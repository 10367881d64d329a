"""Step 4: the null hypothesis - every echo is clutter - with own motion fitted as well as the winner's.

Still echoes are an odometer: among echoes that stand, all relative velocities are own velocity reversed. The null's
own motion is the shape on which the votes are laid, and its evidence is what every answer must beat. A null that is
fitted worse than the answer would lend the answer evidence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.association.window.field import WindowField
from navfix.association.window.fit import as_clutter, paths_over_ground
from navfix.association.window.knots import Knots, MotionPrior
from navfix.association.window.normal import clutter_equations
from navfix.types import FloatArray


@dataclass(frozen=True, eq=False)
class Null:
    """The best own motion without any mark (one motion, its gauge knot at 0), and its log evidence."""

    shape: Knots
    log_evidence: float


def fit_null(field: WindowField, prior: MotionPrior) -> Null:
    """Fit own motion to the tracks as clutter, from several velocities, and weigh it."""
    if field.scene.knots == 1:
        zero = Knots(np.zeros((1, 1), complex), np.zeros((1, 1)), np.zeros(1))
        return Null(zero, float(as_clutter(field, paths_over_ground(field, zero)[0]).log_density.sum()))
    model = field.model
    half = model.null_rounds // 2
    knots, log_density = _descended(field, prior, _starts(field), half)
    return fit_from(field, prior, knots.take(np.argsort(-log_density, kind="stable")[: model.null_finalists]), half)


def fit_from(field: WindowField, prior: MotionPrior, knots: Knots, rounds: int) -> Null:
    """Fit own motion to the tracks as clutter from each of k motions; return the best."""
    knots, _ = _descended(field, prior, knots, rounds)
    keep = prior.shape_rows()
    shape_prior = prior.without_pose()
    x = knots.vector()[:, keep]
    _, information, log_density = _step(field, knots, prior)
    evidence = log_density - 0.5 * np.einsum("kd,de,ke->k", x, shape_prior, x)
    evidence += 0.5 * np.linalg.slogdet(shape_prior)[1] - 0.5 * np.linalg.slogdet(information)[1]
    best = int(np.argmax(evidence))
    return Null(knots.take(np.array([best])), float(evidence[best]))


def _descended(field: WindowField, prior: MotionPrior, knots: Knots, rounds: int) -> tuple[Knots, FloatArray]:
    """Return motions after so many steps, and ln density (k,) before the last of them."""
    log_density = np.zeros(len(knots))
    for _ in range(rounds):
        knots, _, log_density = _step(field, knots, prior)
    return knots, log_density


def _starts(field: WindowField) -> Knots:
    """Return straight motions with the velocities that would make one or another echo stand, and none."""
    scene = field.scene
    rest = Knots(np.zeros((1, scene.knots), complex), np.zeros((1, scene.knots)), np.zeros(1))
    line = in_ship_velocity(field)
    candidates = np.append(-line[field.has_line], 0.0)
    knots = Knots(
        candidates[:, None] * (scene.knot_s - scene.knot_s[scene.gauge])[None, :],
        np.zeros((len(candidates), scene.knots)),
        np.zeros(len(candidates)),
    )
    score = as_clutter(field, paths_over_ground(field, knots)[0]).log_density.sum(axis=1)
    best = np.argsort(-score, kind="stable")[: field.model.null_starts]
    return Knots.join(rest, knots.take(best))


def in_ship_velocity(field: WindowField) -> np.ndarray:
    """Return every track's velocity [m/s, complex] in the de-rotated ship's frame, 0 where it has but one bin."""
    scene = field.scene
    if scene.knots == 1:
        return np.zeros(len(scene.bins), complex)
    line = np.einsum("mb,mb->m", scene.basis[:, 1, :], scene.rho)
    return np.where(field.has_line, line / np.sqrt(np.maximum(scene.spread_s2, 1e-9)), 0.0)


def _step(field: WindowField, knots: Knots, prior: MotionPrior) -> tuple[Knots, FloatArray, FloatArray]:
    """One step of the EM without marks: moved motions, information of the shape, ln density before the step."""
    path, axis = paths_over_ground(field, knots)
    clutter = as_clutter(field, path)
    information, gradient = clutter_equations(field, knots, axis, path, clutter)
    information += prior.information[None]
    gradient += prior.given(None).gradient(knots)
    keep = prior.shape_rows()
    inner = information[:, keep][:, :, keep]
    step = np.zeros_like(gradient)
    step[:, keep] = np.linalg.solve(inner, gradient[:, keep, None])[:, :, 0]
    return knots.moved(step), inner, clutter.log_density.sum(axis=1)
