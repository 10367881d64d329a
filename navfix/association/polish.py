"""Step 6b: the answer's own pose and covariance, with the clutter share and detection level that its echoes show.

While poses are sought both are nominal; at the answer they are known better, and with them how much a target three
sigma off still counts. The covariance leaves out what is lost by not knowing the pairs for certain.
"""

from __future__ import annotations

import numpy as np

from navfix.association import em, evidence
from navfix.association.em import Field
from navfix.association.seeds import Poses
from navfix.types import FloatArray

STEPS = 3
MOST_MISSING = 0.9  # of the information in any direction: beyond it the pose is no optimum


def polish(field: Field, pose: Poses) -> tuple[Poses, FloatArray]:
    """Return one pose after a few more EM steps, and its covariance (3, 3) in north [m], east [m], heading [rad]."""
    share, level = evidence.share_and_level(field, pose)
    information = np.eye(3)[None]
    for _ in range(STEPS):
        pose, information, _ = em.em_step(field, pose, 1.0, share=share, level=level)
    missing = missing_information(field, pose, share=share, level=level)[0]
    root = np.linalg.cholesky(information[0])
    inverse = np.linalg.inv(root)
    lost, axes = np.linalg.eigh(inverse @ missing @ inverse.T)
    kept = inverse.T @ axes / np.sqrt(1.0 - np.clip(lost, 0.0, MOST_MISSING))
    return pose, np.asarray(kept @ kept.T, dtype=np.float64)


def missing_information(field: Field, poses: Poses, *, share: float, level: float) -> FloatArray:
    """Return the information (k, 3, 3) that not knowing the pairs costs: eq. (6.14) of the theory.

    The normal matrix takes every responsibility as settled. Where a target may be one of two marks, or clutter, its
    contribution to the gradient is uncertain, and the variance of that is lost (Louis 1982, eq. 3.2).
    """
    fit = em.lay_over(field, poses, reach_m=em.REACH_SIGMA * field.widest_m)
    ratio = em.likelihood_ratio(field, fit, level)
    responsibility = (ratio / (share + ratio.sum(axis=2, keepdims=True)))[..., None]
    azimuth = (poses.heading_rad[:, None] + field.scene.bearing_rad[None, :])[:, :, None]
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    radial, tangential = fit.radial_m / fit.radial_m2, fit.tangential_m / fit.tangential_m2
    score = np.stack(
        [
            cos * radial - sin * tangential,
            sin * radial + cos * tangential,
            field.scene.range_m[None, :, None] * tangential,
        ],
        axis=-1,
    )
    mean = (responsibility * score).sum(axis=2)
    second = np.einsum("kmqa,kmqb->kab", responsibility * score, score)
    missing: FloatArray = second - np.einsum("kma,kmb->kab", mean, mean)
    return missing
