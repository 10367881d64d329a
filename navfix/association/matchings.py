"""The sum over all ways to match echoes with marks, averaged over clutter share and detection: of a scan or a window.

Echoes are clutter of density c lambda_i; each mark gives at most one echo, each echo is at most one mark. With w_ij the
likelihood ratio of echo i on mark j against clutter, eq. (6.7) of the theory:

    ln Z = M (1 - c) + M ln c + sum_j ln(1 - Pd_j) + ln sum over matchings of prod w_ij / c.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from navfix.types import FloatArray, IntArray


def log_mean_evidence(
    levels: Iterable[tuple[FloatArray, FloatArray]], mark: IntArray, share: FloatArray, marks: int
) -> FloatArray:
    """Return ln Z (k,) averaged over detection levels and clutter shares.

    Parameters
    ----------
    levels : for each detection level the ratios w (k, m, q) and sum of ln(1 - Pd_j) (k,)
    mark : (k, m, q) which of the ``marks`` each ratio belongs to
    share : clutter shares (s,)
    """
    targets = mark.shape[1]
    terms = []
    for ratio, missed in levels:
        by_target, by_mark = matching_bounds(ratio, mark, share, marks)
        matchings = np.minimum(by_target, by_mark)
        terms.append(matchings + missed[:, None] + targets * (1.0 - share + np.log(share))[None, :])
    stacked = np.concatenate(terms, axis=1)
    top = stacked.max(axis=1)
    mean: FloatArray = top + np.log(np.mean(np.exp(stacked - top[:, None]), axis=1))
    return mean


def matching_bounds(ratio: FloatArray, mark: IntArray, share: FloatArray, marks: int) -> tuple[FloatArray, FloatArray]:
    """Return two upper bounds (k, s) of ln sum over matchings of prod w_ij / c, for every clutter share (s,).

    One lets a mark serve two echoes, the other lets an echo serve two marks.
    """
    poses = len(ratio)
    by_target = np.log1p(ratio.sum(axis=2)[:, :, None] / share).sum(axis=1)
    flat = (np.arange(poses)[:, None, None] * marks + mark).ravel()
    claimed = np.bincount(flat, weights=ratio.ravel(), minlength=poses * marks).reshape(poses, marks)
    by_mark = np.stack([np.log1p(claimed / s).sum(axis=1) for s in share], axis=1)
    return by_target, by_mark
