"""Step 5: the evidence of a pose against "every echo is clutter"; the tracks of a window are summed over likewise.

Echoes are a Poisson clutter of local density c lambda and, for each mark in range, at most one echo with probability
Pd_j. The likelihood of all ways to match them against the same for clutter alone is summed in `matchings`, for clutter
share c and detection level d; both are averaged over (a fixed share over-trusts few matches).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from navfix.association.em import GATE, NOMINAL_LEVEL, NOMINAL_SHARE, REACH_SIGMA, Field, Fit, lay_over, odds_free_ratio
from navfix.association.matchings import NEGLIGIBLE, Pairings, log_mean, log_terms
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


@dataclass(frozen=True, eq=False)
class Matches:
    """The likelihood ratios of many poses that are not negligible (e of them), in the order of poses and targets.

    ``pose``, ``target``, ``mark`` (e,) indices; ``ratio`` (e,) N_ij / lambda_i; ``seen`` (e,) the detection
    probability at level 1; ``distance_sq`` (e,) squared Mahalanobis distances; ``log_told`` (e,) what speed and length
    have added to ln ``ratio``, None where they say nothing.
    """

    pose: IntArray
    target: IntArray
    mark: IntArray
    ratio: FloatArray
    seen: FloatArray
    distance_sq: FloatArray
    log_told: FloatArray | None = None

    @classmethod
    def of(cls, field: Field, fit: Fit) -> Matches:
        """Collect them from targets laid over marks."""
        found = cls.among(field, fit.mark, *odds_free_ratio(field, fit), fit.distance_sq)
        if field.log_pair_ratio is None:
            return found
        return replace(found, log_told=field.log_pair_ratio[found.target, found.mark])

    @classmethod
    def among(
        cls, field: Field, mark: IntArray, ratio: FloatArray, seen: FloatArray, distance_sq: FloatArray
    ) -> Matches:
        """Collect them from the ratios, detection probabilities and distances of targets on marks, each (k, m, q)."""
        most = max(field.model.detection_level)
        at = np.nonzero(ratio > NEGLIGIBLE * (1.0 - most) / most)
        return cls(at[0], at[1], mark[at], ratio[at], seen[at], distance_sq[at])

    def at_levels(self, levels: FloatArray) -> FloatArray:
        """Return w_ij (levels, e) of eq. (6.4)."""
        pd = levels[:, None] * self.seen
        ratios: FloatArray = pd / (1.0 - pd) * self.ratio
        return ratios

    def at_levels_told_or_not(self, levels: FloatArray) -> FloatArray:
        """Return w_ij (levels, e), and once more (2 x levels, e) as if speeds and lengths had not been told."""
        told = self.at_levels(levels)
        return told if self.log_told is None else np.concatenate([told, told * np.exp(-self.log_told)])


def judge(field: Field, poses: Poses, information: FloatArray, prior: Prior) -> Judged:
    """Weigh poses (k,) and sort them, best first."""
    fit = lay_over(field, poses, reach_m=REACH_SIGMA * field.widest_m)
    matches = Matches.of(field, fit)
    log_ratio = log_mean_ratio(field, poses, matches)
    evidence = log_ratio + prior.log_mass(poses, information)
    found = Judged(poses, information, log_ratio, evidence, marks_matched(field, len(poses), matches))
    return found.take(np.argsort(-evidence, kind="stable"))


def log_likelihood_ratio(field: Field, poses: Poses, fit: Fit) -> FloatArray:
    """Return ln of the likelihood ratio (k,), averaged over clutter share and detection level: eq. (6.7)."""
    return log_mean_ratio(field, poses, Matches.of(field, fit))


def log_mean_ratio(field: Field, poses: Poses, matches: Matches) -> FloatArray:
    """Return eq. (6.7) (k,) from the matches of poses (k,), averaged over clutter share and detection level."""
    return log_mean(_log_terms(field, poses, matches))


def share_and_level(field: Field, pose: Poses) -> tuple[float, float]:
    """Return the mean clutter share and detection level at one pose, given its echoes."""
    terms = _log_terms(field, pose, Matches.of(field, lay_over(field, pose, reach_m=REACH_SIGMA * field.widest_m)))
    weight = np.exp(terms[:, 0, :] - terms[:, 0, :].max()).reshape(-1, len(field.model.detection_level), terms.shape[2])
    weight = weight.sum(axis=0) / weight.sum()
    share, level = np.array(field.model.clutter_share), np.array(field.model.detection_level)
    return float(weight.sum(axis=0) @ share), float(weight.sum(axis=1) @ level)


def _log_terms(field: Field, poses: Poses, matches: Matches) -> FloatArray:
    """Return eq. (6.7) for every detection level, pose and clutter share (levels, k, s).

    Where speeds or lengths are told the levels come twice, with them and without: a young tracker gives moored ships a
    knot or two, and whether this radar's are worth anything is averaged over like the shares.
    """
    model, scene = field.model, field.scene
    levels = np.array(model.detection_level)
    pairings = Pairings(matches.pose, matches.target, matches.mark, len(poses), len(scene.rho), len(scene.z))
    weights = matches.at_levels_told_or_not(levels)
    missed = np.tile(_log_missed(field, poses, levels), (len(weights) // len(levels), 1))
    return log_terms(weights, pairings, missed, np.array(model.clutter_share))


def _log_missed(field: Field, poses: Poses, levels: FloatArray) -> FloatArray:
    """Return sum of ln(1 - Pd_j) (levels, k) over the marks in radar range: one without an echo speaks against it."""
    scene = field.scene
    missed = np.zeros((len(levels), len(poses)))
    if not field.model.use_missed:
        return missed
    distance_m = np.abs(scene.z[None, :] - poses.p[:, None])
    pose, mark = np.nonzero(distance_m <= scene.radar_range_m)
    if len(pose):
        pd = field.detection(distance_m[pose, mark], scene.conspicuity[mark])
        begin = np.flatnonzero(np.concatenate([[True], pose[1:] != pose[:-1]]))
        missed[:, pose[begin]] = np.add.reduceat(np.log1p(-levels[:, None] * pd), begin, axis=1)
    return missed


def marks_matched(field: Field, poses: int, matches: Matches) -> FloatArray:
    """Return how many distinct marks (k,) some target is more likely to be than clutter."""
    ratio = matches.at_levels(np.array([NOMINAL_LEVEL]))[0]
    by_target = matches.pose * len(field.scene.rho) + matches.target
    total = NOMINAL_SHARE + np.bincount(by_target, weights=ratio, minlength=1)[by_target]
    taken = (ratio > 0.5 * total) & (matches.distance_sq < GATE)
    distinct = np.unique(matches.pose[taken] * len(field.scene.z) + matches.mark[taken])
    return np.bincount(distinct // len(field.scene.z), minlength=poses).astype(np.float64)
