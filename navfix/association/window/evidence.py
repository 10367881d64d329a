"""Step 7: the evidence of an own motion with its marks, against every echo being clutter.

The sum over matchings, the detection and the clutter share are those of one scan; a track counts once, however many
scans it was seen in. Own motion is integrated over by Laplace's method, under the marks and under the null alike, so
what own motion merely explains better than the null costs the freedom that it took: eq. (6.21) of the theory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.association.em import GATE
from navfix.association.evidence import Matches, log_mean_ratio, marks_matched
from navfix.association.seeds import firsts
from navfix.association.window.em import density_ratio, expect
from navfix.association.window.field import WindowField
from navfix.association.window.fit import Clutter, Fit, as_clutter, lay_over
from navfix.association.window.knots import Knots, MotionPrior
from navfix.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Answers:
    """Own motions (k), best ``evidence`` (k,) first; ``information`` (k, d, d); how many ``marks`` (k,) match."""

    knots: Knots
    information: FloatArray
    evidence: FloatArray
    marks: FloatArray

    def __len__(self) -> int:
        return len(self.evidence)

    def take(self, rows: IntArray) -> Answers:
        """Return the answers of ``rows``, in this order."""
        return Answers(self.knots.take(rows), self.information[rows], self.evidence[rows], self.marks[rows])

    @property
    def margin(self) -> float:
        """By how many nats the best is ahead of the next (infinite where there is none)."""
        return float(self.evidence[0] - self.evidence[1]) if len(self) > 1 else float("inf")


def judge(
    field: WindowField, knots: Knots, information: FloatArray, prior: MotionPrior, log_null: float, *, sort: bool = True
) -> Answers:
    """Weigh own motions (k) and sort them, best first unless told not to."""
    fit = lay_over(field, knots)
    clutter = as_clutter(field, fit.path)
    matches = _matches(field, fit, clutter)
    log_likelihood = log_mean_ratio(field.flat, field.at_gauge(knots), matches) + clutter.log_density.sum(axis=1)
    evidence = log_likelihood + prior.log_density(knots) - 0.5 * np.linalg.slogdet(information)[1] - log_null
    found = Answers(knots, information, evidence, marks_matched(field.flat, len(knots), matches))
    return found.take(np.argsort(-evidence, kind="stable")) if sort else found


def matched(field: WindowField, knots: Knots) -> FloatArray:
    """Return how many distinct marks (k,) some track is more likely to be than clutter, at each own motion."""
    fit = lay_over(field, knots)
    return marks_matched(field.flat, len(knots), _matches(field, fit, as_clutter(field, fit.path)))


def _matches(field: WindowField, fit: Fit, clutter: Clutter) -> Matches:
    """Return which track may be which mark, as of one scan: a track is judged by all of its bins at once."""
    density, _ = density_ratio(field, fit, clutter)
    seen = field.flat.seen[None, :, None] * field.flat.conspicuity[fit.mark]
    return Matches.among(field.flat, fit.mark, density, seen, fit.distance_sq)


def distinct(found: Answers, field: WindowField) -> Answers:
    """Keep the best of every group of motions that are the same answer: near at the gauge knot."""
    poses, model = field.at_gauge(found.knots), field.shared
    return found.take(firsts(poses.near(poses, model.distinct_m, 2.0 * model.distinct_deg)))


def posterior(field: WindowField, fit: Fit) -> FloatArray:
    """Return the responsibilities (k, m, q) of marks within the gate of a track's mean."""
    return np.where(fit.distance_sq <= GATE, expect(field, fit).on_mark, 0.0)
