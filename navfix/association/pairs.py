"""Step 7: one-to-one pairs at the chosen pose, with a posterior probability for each."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from navfix.association.em import GATE, NOMINAL_LEVEL, Field, lay_over, likelihood_ratio
from navfix.association.seeds import Poses
from navfix.types import FloatArray, IntArray


def one_to_one(field: Field, pose: Poses) -> tuple[IntArray, FloatArray]:
    """Return pairs (k, 2) of target and mark index at one pose (the likeliest assignment), and their posteriors (k,).

    A target may stay without a mark: that costs the clutter's likelihood. The posterior of a pair is its share among
    clutter and all marks near the target, and among all targets near the mark.
    """
    fit = lay_over(field, pose)
    level, share = NOMINAL_LEVEL, _clutter_share(field, pose)
    ratio = np.where(fit.distance_sq <= GATE, likelihood_ratio(field, fit, level), 0.0)[0] / share
    return likeliest(ratio, fit.mark[0], len(field.scene.z))


def likeliest(ratio: FloatArray, mark: IntArray, marks: int) -> tuple[IntArray, FloatArray]:
    """Return the likeliest pairs (k, 2) and their posteriors (k,), each target and mark at most once.

    Parameters
    ----------
    ratio, mark : (m, q) likelihood ratio of each target on ``marks`` near it against clutter, and which they are
    """
    dense = np.zeros((len(ratio), marks))
    np.put_along_axis(dense, mark, ratio, axis=1)
    near = np.flatnonzero(dense.any(axis=0))
    dense = dense[:, near]
    target, column = linear_sum_assignment(np.log1p(dense), maximize=True)
    chosen = dense[target, column] > 1.0
    target, column = target[chosen], column[chosen]
    return np.column_stack([target, near[column]]), association_marginals(dense)[target, column]


def association_marginals(ratio: FloatArray, sweeps: int = 30) -> FloatArray:
    """Return P(target i is mark j) (m, n) from likelihood ratios against clutter (m, n), by belief propagation.

    Each echo at most one mark and each mark at most one echo: Williams & Lau (2014), eq. 27-29; it always converges.
    """
    from_mark = np.ones_like(ratio)
    for _ in range(sweeps):
        claimed = ratio * from_mark
        from_target = ratio / (1.0 + claimed.sum(axis=1, keepdims=True) - claimed)
        from_mark = 1.0 / (1.0 + from_target.sum(axis=0, keepdims=True) - from_target)
    claimed = ratio * from_mark
    marginals: FloatArray = claimed / (1.0 + claimed.sum(axis=1, keepdims=True))
    return marginals


def _clutter_share(field: Field, pose: Poses, sweeps: int = 10) -> float:
    """Return the share of echoes that are clutter at this pose, by EM from one half."""
    ratio = likelihood_ratio(field, lay_over(field, pose), NOMINAL_LEVEL).sum(axis=2)[0]
    share = 0.5
    for _ in range(sweeps):
        share = float(np.clip(np.mean(share / (share + ratio)), 0.05, 0.95))
    return share
