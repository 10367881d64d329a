"""Step 8: do the targets that the answer leaves unexplained agree with each other on another place?

AIS positions that are shifted alike (a spoofed area, a wrong datum, a stale feed) explain a part of the echoes from a
place that is off by the same vector, with the same heading. Nothing in the margin shows it: both places are right for
their own marks, and the larger group wins.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from navfix.association import em, evidence, prior
from navfix.association.pair_index import PairIndex
from navfix.association.pairs import one_to_one
from navfix.association.prior import Prior
from navfix.association.scene import Scene
from navfix.association.seeded import Search
from navfix.association.seeds import Poses, radar_pairs, seeds
from navfix.catalog import AssociationModel
from navfix.types import IntArray


def find(found: Search, model: AssociationModel, matched: IntArray) -> tuple[complex, IntArray] | None:
    """Return the shift of own position [m, complex] and the targets of the second group, None where there is none.

    Parameters
    ----------
    found : the search whose best answer stands
    matched : its pairs (k, 2) of target and mark (indices of the scene): neither may serve again
    """
    scene = found.field.scene
    targets = np.setdiff1d(np.arange(len(scene.rho)), matched[:, 0])
    marks = np.setdiff1d(np.arange(len(scene.z)), matched[:, 1])
    if min(len(targets), len(marks)) < model.second_group_pairs:
        return None
    rest = scene.keeping(targets, marks)
    index = PairIndex.of(rest.z, 2.0 * rest.radar_range_m)
    field = em.Field(rest, model)
    best = found.answers.take(np.zeros(1, dtype=np.int64))
    heading_sigma_rad = np.sqrt(np.linalg.inv(best.information[0])[2, 2]) + np.radians(0.5)
    same_heading = Prior(
        prior.log_area(field),
        model.hint_wrong_share,
        heading_rad=float(best.poses.heading_rad[0]),
        heading_sigma_rad=float(heading_sigma_rad),
    )
    voting = radar_pairs(rest, index, model).take(slice(0, model.pairs_per_stage[2]))
    starts = seeds(rest, index, voting, model, model.seeds, same_heading.plausible)
    starts = Poses.join(starts.take(same_heading.plausible(starts)), _by_shift(rest, best.poses, model))
    if len(starts) == 0:
        return None
    nearby = replace(same_heading, place=complex(best.poses.p[0]), place_sigma_m=model.second_group_m)
    second = evidence.judge(field, *em.refine(field, starts), nearby)
    shift = complex(second.poses.p[0] - best.poses.p[0])
    agrees = second.evidence[0] >= model.second_group_evidence and second.ships[0] >= model.second_group_pairs
    if not agrees or abs(shift) < model.distinct_m:
        return None
    pairs, _ = one_to_one(field, second.poses.take(np.zeros(1, dtype=np.int64)))
    return shift, targets[pairs[:, 0]]


def _by_shift(scene: Scene, pose: Poses, model: AssociationModel) -> Poses:
    """Return the poses that differ from the one at hand by a shift on which most targets and marks agree."""
    heading_rad = float(pose.heading_rad[0])
    world = pose.p[0] + np.exp(1j * heading_rad) * scene.rho
    shift = (scene.z[None, :] - world[:, None]).ravel()
    shift = shift[np.abs(shift) <= 4.0 * model.second_group_m]
    near = np.abs(shift[:, None] - shift[None, :]) <= model.cell_m
    fullest = np.argsort(-near.sum(axis=1), kind="stable")[: model.seeds]
    middle = (near[fullest] @ shift) / near[fullest].sum(axis=1)
    return Poses(pose.p[0] + middle, np.full(len(middle), heading_rad))
