"""Step 7: the evidence of an own motion with its marks, against every echo being clutter.

The sum over matchings, the detection and the clutter share are those of one scan; a track counts once, however many
scans it was seen in. Own motion is integrated over by Laplace's method, under the marks and under the null alike, so
what own motion merely explains better than the null costs the freedom that it took: eq. (6.21) of the theory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.association.em import GATE, NOMINAL_LEVEL
from navfix.association.matchings import log_mean_evidence
from navfix.association.window.em import density_ratio, expect
from navfix.association.window.field import WindowField
from navfix.association.window.fit import Fit, as_clutter, lay_over
from navfix.association.window.knots import Knots, MotionPrior
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi


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
    evidence = log_likelihood(field, knots, fit) + prior.log_density(knots)
    evidence = evidence - 0.5 * np.linalg.slogdet(information)[1] - log_null
    found = Answers(knots, information, evidence, _matched(field, fit))
    return found.take(np.argsort(-evidence, kind="stable")) if sort else found


def log_likelihood(field: WindowField, knots: Knots, fit: Fit) -> FloatArray:
    """Return ln of the likelihood (k,) of the tracks, clutter's place density taken out."""
    clutter = as_clutter(field, fit.path)
    density, _ = density_ratio(field, fit, clutter)
    levels = (
        (field.odds(fit.mark, level) * density, _log_missed(field, knots, level))
        for level in field.shared.detection_level
    )
    share = np.array(field.shared.clutter_share)
    log_mean = log_mean_evidence(levels, fit.mark, share, len(field.scene.paths.marks))
    total: FloatArray = log_mean + clutter.log_density.sum(axis=1)
    return total


def distinct(found: Answers, field: WindowField) -> Answers:
    """Keep the best of every group of motions that are the same answer: near at the gauge knot."""
    model, gauge = field.shared, field.scene.gauge
    p, heading = found.knots.p[:, gauge], found.knots.heading_rad[:, gauge]
    left, kept = np.ones(len(found), dtype=bool), []
    for row in range(len(found)):
        if left[row]:
            kept.append(row)
            turn = np.abs(wrap_pi(heading - heading[row]))
            left &= ~((np.abs(p - p[row]) <= model.distinct_m) & (turn <= np.radians(2.0 * model.distinct_deg)))
            left[row] = False
    return found.take(np.array(kept, dtype=np.int64))


def _log_missed(field: WindowField, knots: Knots, level: float) -> FloatArray:
    """Return sum of ln(1 - Pd_j) (k,) over the marks in radar range of the gauge knot."""
    scene = field.scene
    if not field.shared.use_missed:
        return np.zeros(len(knots))
    distance_m = np.abs(scene.paths.z[None, :, scene.gauge] - knots.p[:, scene.gauge, None])
    pd = level * field.flat.detection(distance_m, scene.flat.conspicuity[None, :])
    missed: FloatArray = np.where(distance_m <= scene.flat.radar_range_m, np.log1p(-pd), 0.0).sum(axis=1)
    return missed


def matched(field: WindowField, knots: Knots) -> FloatArray:
    """Return how many distinct marks (k,) some track is more likely to be than clutter, at each own motion."""
    return _matched(field, lay_over(field, knots))


def _matched(field: WindowField, fit: Fit) -> FloatArray:
    """Return how many distinct marks (k,) some track is more likely to be than clutter."""
    motion, track, neighbour = np.nonzero(posterior(field, fit) > 0.5)
    taken = np.zeros((len(fit.mark), len(field.scene.paths.marks)), dtype=bool)
    taken[motion, fit.mark[motion, track, neighbour]] = True
    return np.asarray(taken.sum(axis=1), dtype=np.float64)


def posterior(field: WindowField, fit: Fit) -> FloatArray:
    """Return the responsibilities (k, m, q) of marks within the gate of a track's mean."""
    square = (fit.misfit[..., 0, :] ** 2 / fit.variance_m2[..., 0, :]).sum(axis=-1)
    return np.where(square <= GATE, expect(field, fit).on_mark, 0.0)


__all__ = ["NOMINAL_LEVEL", "Answers", "distinct", "judge", "log_likelihood", "matched", "posterior"]
