"""Seeded Coherent Point Drift: association from nothing but one scan and the AIS picture, as a list of named steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.association import ambiguity, em, evidence, prior, seeds
from navfix.association.evidence import Judged
from navfix.association.pair_index import PairIndex
from navfix.association.prior import Prior
from navfix.association.scene import Scene
from navfix.association.seeds import Poses
from navfix.catalog import AssociationModel
from navfix.types import Epoch


@dataclass(frozen=True, eq=False)
class Search:
    """What a search found: distinct answers, best first, and the field that they were judged in."""

    field: em.Field
    prior: Prior
    answers: Judged
    pairs_tried: int
    index: PairIndex


def search(
    scene: Scene, model: AssociationModel, *, epoch: Epoch | None = None, index: PairIndex | None = None
) -> Search:
    """Find every pose that explains the scene, best first.

    The hints of the ``epoch``, where it has any, are weighed in the evidence; ``index`` is that of the scene's marks.
    """
    index = index or PairIndex.of(scene.z, 2.0 * scene.radar_range_m)
    field = em.Field(scene, model)
    return search_field(field, prior.of(epoch, scene, field, model), index)


def search_field(field: em.Field, known: Prior, index: PairIndex) -> Search:
    """Search as `search` does, with field, prior and index at hand.

    Radar pairs vote in growing stages until one answer stands far ahead; the EM starts from the fullest cells, from
    many more of them after the first stage.
    """
    scene, model = field.scene, field.model
    pairs = seeds.radar_pairs(scene, index, model)
    found: Judged | None = None
    tried = 0
    plausible = known.plausible if known.has_hint else None
    for number, stage in enumerate(model.pairs_per_stage):
        most = model.seeds if number == 0 else deep_seeds(scene, model)
        voting = pairs.take(slice(0, stage))
        starts = seeds.seeds(scene, index, voting, model, most, plausible)
        if found is not None:
            starts = Poses.join(found.poses.take(np.arange(min(5, len(found.poses)))), starts)
        if len(starts) == 0:
            break
        most_final = model.first_finalists if number == 0 else max(model.finalists, most // 3)
        poses, information = em.refine(field, starts, most_final, quickly=number == 0)
        found = ambiguity.distinct(evidence.judge(field, poses, information, known), model)
        tried = len(voting.first)
        certain = found.evidence[0] > model.stop_evidence and ambiguity.margin(found) > model.stop_margin
        if certain or (number > 0 and tried >= len(pairs.first)):
            break
    if found is None:
        found = _nothing(field, known)
    return Search(field, known, found, tried, index)


def deep_seeds(scene: Scene, model: AssociationModel) -> int:
    """Return how many seeds the later stages try: with few targets the right cell has few votes, a try is cheap."""
    return int(np.clip(model.deep_seed_points / len(scene.rho), model.seeds, model.most_seeds))


def _nothing(field: em.Field, known: Prior) -> Judged:
    """Return one pose on the middle of the marks, judged: no two targets are as far apart as any two marks."""
    poses = Poses(np.array([np.mean(field.scene.z)]), np.zeros(1))
    poses, information = em.refine(field, poses)
    return evidence.judge(field, poses, information, known)
