"""Step 5: the evidence of a pose against "every echo is clutter".

Echoes are a Poisson clutter of local density c lambda and, for each mark in range, at most one echo with probability
Pd_j. Summed over all ways to match (each mark at most one echo, each echo at most one mark) and divided by the same for
clutter alone, the log likelihood ratio at clutter share c and detection level d is eq. (6.7) of the theory:

    ln Z = M (1 - c) + M ln c + sum_j ln(1 - Pd_j) + ln sum over matchings of prod w_ij / c.

The sum over matchings is bounded by letting a mark serve two echoes and by letting an echo serve two marks; the lesser
bound is taken. Clutter share and detection level are averaged over (a fixed share over-trusts few matches).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.association.em import NOMINAL_LEVEL, NOMINAL_SHARE, Field, Fit, lay_over, likelihood_ratio
from navfix.association.matchings import log_mean_evidence
from navfix.association.prior import Prior
from navfix.association.seeds import Poses
from navfix.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Judged:
    """Poses with their evidence, best first.

    ``log_ratio`` (k,) log likelihood ratio at the pose; ``evidence`` (k,) with the pose integrated over its prior:
    above 0 more likely than chance.
    ``information`` (k, 3, 3); ``ships`` (k,) how many marks are matched with posterior above one half.
    """

    poses: Poses
    information: FloatArray
    log_ratio: FloatArray
    evidence: FloatArray
    ships: FloatArray

    def take(self, rows: IntArray) -> Judged:
        """Return the poses of ``rows``, in this order."""
        return Judged(
            self.poses.take(rows), self.information[rows], self.log_ratio[rows], self.evidence[rows], self.ships[rows]
        )


def judge(field: Field, poses: Poses, information: FloatArray, prior: Prior) -> Judged:
    """Weigh poses (k,) and sort them, best first."""
    fit = lay_over(field, poses)
    log_ratio = log_likelihood_ratio(field, poses, fit)
    evidence = log_ratio + prior.log_mass(poses, information)
    found = Judged(poses, information, log_ratio, evidence, _matched(field, fit))
    return found.take(np.argsort(-evidence, kind="stable"))


def log_likelihood_ratio(field: Field, poses: Poses, fit: Fit) -> FloatArray:
    """Return ln of the likelihood ratio (k,), averaged over clutter share and detection level: eq. (6.7)."""
    levels = (
        (likelihood_ratio(field, fit, level), _log_missed(field, poses, level)) for level in field.model.detection_level
    )
    return log_mean_evidence(levels, fit.mark, np.array(field.model.clutter_share), len(field.scene.z))


def _log_missed(field: Field, poses: Poses, level: float) -> FloatArray:
    """Return sum of ln(1 - Pd_j) (k,) over the marks in radar range: one without an echo speaks against a pose."""
    if not field.model.use_missed:
        return np.zeros(len(poses))
    scene = field.scene
    distance_m = np.abs(scene.z[None, :] - poses.p[:, None])
    pd = level * field.detection(distance_m, scene.conspicuity[None, :])
    missed: FloatArray = np.where(distance_m <= scene.radar_range_m, np.log1p(-pd), 0.0).sum(axis=1)
    return missed


def _matched(field: Field, fit: Fit) -> FloatArray:
    """Return how many distinct marks (k,) some target is more likely to be than clutter."""
    ratio = likelihood_ratio(field, fit, NOMINAL_LEVEL)
    posterior = ratio / (NOMINAL_SHARE + ratio.sum(axis=2, keepdims=True))
    taken = (posterior > 0.5) & (fit.distance_sq < 11.8)
    return np.array([len(np.unique(mark[row])) for mark, row in zip(fit.mark, taken, strict=True)], dtype=np.float64)
