"""Step 8: the best answer settled - every pair held against its echo being clutter, then pose and covariance.

The EM climbs to the nearest optimum. An echo far away that lies beside a ship by accident turns the heading until it
fits; the ships near by follow within the errors that stay with them, and the climb does not see what that costs. So
each matched track is taken for clutter in turn, everything else fitted anew, and the evidence of both is compared: a
pair without which there is more of it is no pair. What it would have been, had it been one, stays in the covariance
with its probability; eq. (6.21a) of the theory.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.association.window import evidence, jackknife
from navfix.association.window.evidence import Answers
from navfix.association.window.jackknife import PoseAtEnd
from navfix.association.window.joint import Joint, Window
from navfix.association.window.knots import Knots, MotionPrior
from navfix.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Settled:
    """The best answer of a window with the tracks that are no pairs barred; its ``marks`` and its pose at the end."""

    knots: Knots
    marks: int
    pose: PoseAtEnd


def settle(found: Joint, prior: MotionPrior, *, fewest_marks: int) -> Settled:
    """Bar the tracks of the best answer that the evidence is against, as long as ``fewest_marks`` are matched."""
    window, field = found.window, found.window.field
    knots, information = found.answers.knots.take(np.array([0])), found.answers.information[:1]
    left = jackknife.left_out(field, knots, prior)
    refused: list[tuple[FloatArray, float]] = []  # pose with a pair that was taken back, and the probability of that
    for _ in range(field.model.most_barred):
        judged, ahead = _against_clutter(window, knots, information, left, prior)
        if ahead <= 0.0 or judged.marks[0] < fewest_marks:
            break
        refused.append((jackknife.end_vector(field, knots)[0], 1.0 / (1.0 + math.exp(min(ahead, 50.0)))))
        knots, information = judged.knots, judged.information
        left = jackknife.left_out(field, knots, prior)
    here = jackknife.end_vector(field, knots)[0]
    others = sum((p * np.outer(there - here, there - here) for there, p in refused), np.zeros((3, 3)))
    marks = int(evidence.matched(field, knots)[0])
    return Settled(knots, marks, jackknife.pose_at_end(field, knots, information, left, others))


def _against_clutter(
    window: Window, knots: Knots, information: FloatArray, left: Knots, prior: MotionPrior
) -> tuple[Answers, float]:
    """Return the best answer with one more track barred, and by how many nats it is ahead of the one without that."""
    decides = _with_leverage(window, knots, information, left)
    log_null = window.null.log_evidence
    as_it_is = evidence.judge(window.field, knots, information, prior, log_null)
    if not len(decides):
        return as_it_is, -math.inf
    one_less, informed = jackknife.refit(window.field, left.take(decides), prior)
    judged = evidence.judge(window.field, one_less, informed, prior, log_null).take(np.array([0]))
    return judged, float(judged.evidence[0] - as_it_is.evidence[0])


def _with_leverage(window: Window, knots: Knots, information: FloatArray, left: Knots) -> IntArray:
    """Return which of the tracks left out move the pose at the end by a sigma or so: only these can mislead it."""
    step = jackknife.end_vector(window.field, left) - jackknife.end_vector(window.field, knots)
    formal = jackknife.formal_at_end(window.field, information)[0]
    square = (step * np.linalg.solve(formal, step.T).T).sum(axis=1)
    return np.flatnonzero(square > window.field.model.leverage_sq)
