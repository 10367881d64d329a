"""More evidence: the speed of a target against the speed of a mark, as a ratio to the speeds that this picture shows.

A third of the ships lie at anchor: 0 kn against 0 kn proves little, 14.2 kn against 14.1 kn a lot. So the likelihood of
a target's speed, given a mark, is divided by the density of such speeds among all other targets and among all marks,
whichever is larger. Only the amount is used: a course is as good as the compass that the radar was given.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from navfix.catalog import AssociationModel, association_model
from navfix.types import FloatArray


def log_speed_ratio(
    target_mps: FloatArray, mark_mps: FloatArray, model: AssociationModel | str = "seeded"
) -> FloatArray:
    """Return ln [f(speed of target i | mark j) / f(speed of target i)] (m, n): eq. (6.11) of the theory.

    Parameters
    ----------
    target_mps, mark_mps : speeds over ground (m,) and (n,), NaN where unknown: such pairs get 0
    """
    m = association_model(model)
    return ratio_to_the_picture(target_mps, mark_mps, m.speed_shares, m.speed_sigmas_mps, m.most_told)


def ratio_to_the_picture(
    target: FloatArray, mark: FloatArray, shares: Sequence[float], sigmas: Sequence[float], most: float
) -> FloatArray:
    """Return ln of the density of target - mark over that of the value among all marks or targets (m, n), 0 for NaN.

    The difference is a mixture of normal distributions about zero, with heavy tails so that no pair is impossible; of
    the densities among the marks and among the other targets the larger counts. No pair gains more than ``most`` nats.
    """
    ratio = np.zeros((len(target), len(mark)))
    told, known = np.isfinite(target), np.isfinite(mark)
    if told.sum() < 2 or known.sum() < 2:
        return ratio
    among_marks = _density(target[told][:, None] - mark[known][None, :], shares, sigmas)
    among_targets = _density(target[told][:, None] - target[told][None, :], shares, sigmas)
    np.fill_diagonal(among_targets, 0.0)
    common = np.maximum(among_marks.mean(axis=1), among_targets.sum(axis=1) / (told.sum() - 1))
    gain = np.minimum(np.log(among_marks) - np.log(common)[:, None], most)
    ratio[np.ix_(told, known)] = gain
    return ratio


def _density(difference: FloatArray, shares: Sequence[float], sigmas: Sequence[float]) -> FloatArray:
    scaled, height = difference[..., None] / np.array(sigmas), np.array(shares) / np.array(sigmas)
    density: FloatArray = (height / np.sqrt(2.0 * np.pi) * np.exp(-0.5 * scaled**2)).sum(axis=-1)
    return density
