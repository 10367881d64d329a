"""The sum over all ways to match echoes with marks, averaged over clutter share and detection: of a scan or a window.

Echoes are clutter of density c lambda_i; each mark gives at most one echo, each echo is at most one mark. With w_ij the
likelihood ratio of echo i on mark j against clutter, eq. (6.7) of the theory:

    ln Z = M (1 - c) + M ln c + sum_j ln(1 - Pd_j) + ln sum over matchings of prod w_ij / c.

The sum over matchings is bounded by letting a mark serve two echoes and by letting an echo serve two marks; the lesser
bound is taken.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from navfix.types import FloatArray, IntArray

NEGLIGIBLE = 1e-8  # a likelihood ratio that changes no sum


@dataclass(frozen=True, eq=False)
class Pairings:
    """Which echo may be which mark, at every pose, in the order of poses and targets.

    ``pose``, ``target``, ``mark`` (e,) indices; ``poses``, ``targets``, ``marks`` how many there are of each.
    """

    pose: IntArray
    target: IntArray
    mark: IntArray
    poses: int
    targets: int
    marks: int


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
    ratios, missed = (np.stack(part) for part in zip(*levels, strict=True))
    pose, target, near = np.nonzero(ratios.max(axis=0) > NEGLIGIBLE)
    pairings = Pairings(pose, target, mark[pose, target, near], len(mark), mark.shape[1], marks)
    return log_mean(log_terms(ratios[:, pose, target, near], pairings, missed, share))


def log_terms(weights: FloatArray, pairings: Pairings, missed: FloatArray, share: FloatArray) -> FloatArray:
    """Return ln Z (levels, k, s) for every detection level, pose and clutter share.

    Parameters
    ----------
    weights : w_ij (levels, e) of the ``pairings``
    missed : sum of ln(1 - Pd_j) (levels, k) over the marks in range
    share : clutter shares (s,)
    """
    by_target = _log_products(weights, pairings, pairings.target, pairings.targets, share)
    by_mark = _log_products(weights, pairings, pairings.mark, pairings.marks, share)
    terms: FloatArray = np.minimum(by_target, by_mark) + missed[:, :, None]
    terms += pairings.targets * (1.0 - share + np.log(share))
    return terms


def log_mean(terms: FloatArray) -> FloatArray:
    """Return the mean (k,) over levels and shares of exp(terms) (levels, k, s), as a logarithm."""
    stacked = np.moveaxis(terms, 1, 0).reshape(terms.shape[1], -1)
    top = stacked.max(axis=1)
    mean: FloatArray = top + np.log(np.mean(np.exp(stacked - top[:, None]), axis=1))
    return mean


def _log_products(
    weights: FloatArray, pairings: Pairings, member: IntArray, members: int, share: FloatArray
) -> FloatArray:
    """Return ln prod over targets, or over marks, of (1 + sum of their w_ij / c) (levels, k, s).

    Both bound the sum over matchings of prod w_ij / c from above, for every clutter share (s,).
    """
    pose = pairings.pose
    product = np.zeros((len(weights), pairings.poses, len(share)))
    if len(pose) == 0:
        return product
    key = pose * members + member
    if np.any(key[1:] < key[:-1]):
        order = np.argsort(key, kind="stable")
        key, pose, weights = key[order], pose[order], weights[:, order]
    first = _beginnings(key)
    claimed = np.add.reduceat(weights, first, axis=1)
    factor = np.log1p(claimed[:, :, None] / share)
    owner = pose[first]
    begin = _beginnings(owner)
    product[:, owner[begin]] = np.add.reduceat(factor, begin, axis=1)
    return product


def _beginnings(key: IntArray) -> IntArray:
    """Return where each run of equal keys begins."""
    return np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
