"""The joint cold start over a window of scans, as a list of named steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.association.prior import log_area
from navfix.association.seeds import Plausible
from navfix.association.window import em, evidence, null, rigid, scene, votes
from navfix.association.window.evidence import Answers
from navfix.association.window.field import WindowField
from navfix.association.window.knots import Knots, MotionPrior, PosePrior, motion_prior, placed, shape_of
from navfix.association.window.null import Null
from navfix.catalog import AssociationModel, RadarModel, WindowModel, association_model, radar_model, window_model
from navfix.types import Epoch


@dataclass(frozen=True, eq=False)
class Window:
    """A window made ready: its field, the prior of own motion, the null hypothesis, and the epochs it was made of."""

    field: WindowField
    prior: MotionPrior
    null: Null
    epochs: tuple[Epoch, ...]


@dataclass(frozen=True, eq=False)
class Joint:
    """What was found in a window: distinct answers, best first (empty where there is nothing to associate)."""

    window: Window
    answers: Answers


def prepare(
    epochs: Sequence[Epoch],
    model: WindowModel | None = None,
    shared: AssociationModel | None = None,
    *,
    radar: RadarModel | str = "imo",
) -> Window:
    """Make tracks, mark paths, priors and the null hypothesis of a window of epochs."""
    model, shared = model or window_model(), shared or association_model()
    field = WindowField(scene.build(epochs, model, shared, radar_model(radar)), model, shared)
    knots, gauge = field.scene.knot_s, field.scene.gauge
    prior = motion_prior(knots, gauge, log_area(field.flat), model)
    return Window(field, prior, null.fit_null(field, prior), tuple(epochs))


def cold(window: Window, plausible: Plausible | None = None) -> Joint:
    """Find every own motion that explains the window; the search begins also where a hint makes it ``plausible``."""
    found = votes.starts(window.field, window.null.shape, plausible)
    return solve(window, found)


def warm(window: Window, pose: PosePrior) -> Joint:
    """Find the own motion near each pose that was known beforehand: one answer a pose, in the order of the poses."""
    field, prior = window.field, window.prior.given(pose)
    before = shape_of(window.null.shape, pose.knot)
    gauge = field.scene.gauge
    p = pose.p + np.exp(1j * pose.heading_rad) * before.p[0, gauge]
    knots = placed(window.null.shape, p, pose.heading_rad + before.heading_rad[0, gauge], gauge)
    for widening in field.model.annealing:
        knots, information = em.knot_step(field, knots, widening, prior)
    return Joint(window, evidence.judge(field, knots, information, prior, window.null.log_evidence, sort=False))


def solve(window: Window, knots: Knots) -> Joint:
    """Run the annealed EM from every start and judge what is reached, with nothing known beforehand."""
    field, prior, model = window.field, window.prior, window.field.model
    d = len(prior.information)
    if not len(knots):
        return Joint(window, Answers(knots, np.zeros((0, d, d)), np.zeros(0), np.zeros(0)))
    gain = np.zeros(len(knots))
    for number, widening in enumerate(model.annealing_rigid):
        knots, gain = rigid.rigid_step(field, knots, widening)
        if number == 1:
            knots = _finalists(field, knots, gain, 3 * model.finalists)
    knots = _finalists(field, knots, gain[: len(knots)], model.finalists)
    information = np.zeros((len(knots), d, d))
    for widening in model.annealing:
        knots, information = em.knot_step(field, knots, widening, prior)
    found = evidence.judge(field, knots, information, prior, window.null.log_evidence)
    if field.scene.knots > 1:
        found = _against_better_null(window, found)
    return Joint(window, evidence.distinct(found, field))


def _against_better_null(window: Window, found: Answers) -> Answers:
    """Fit the null from the winner's own motion too: it must not be worse for want of a start."""
    field = window.field
    winner = shape_of(found.knots.take(np.arange(1)), field.scene.gauge)
    again = null.fit_from(field, window.prior, winner, field.model.null_rounds)
    gained = max(0.0, again.log_evidence - window.null.log_evidence)
    return Answers(found.knots, found.information, found.evidence - gained, found.marks)


def _finalists(field: WindowField, knots: Knots, gain: np.ndarray, most: int) -> Knots:
    """Return the best motions, one of each group that is on its way to the same optimum."""
    shared = field.shared
    return knots.take(field.at_gauge(knots).leaders(gain, most, 0.5 * shared.distinct_m, shared.distinct_deg))
