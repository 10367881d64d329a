"""Where own ship is known to some 500 m and 3 degrees: the same EM from that one start, checked.

Nothing is believed: the place found must lie within the hints, and its evidence must stand *without* them. How far
behind another place is follows from the hints alone: one that fits as well elsewhere needs both to be worthless.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.association import ambiguity, em, evidence, prior
from navfix.association.acceptance import FEWEST, Acceptance
from navfix.association.pair_index import PairIndex
from navfix.association.prior import Prior
from navfix.association.scene import Scene, convergence_of
from navfix.association.seeded import Search
from navfix.association.seeds import Poses
from navfix.catalog import AssociationModel
from navfix.types import Epoch

NOTE = "Warm start: only the place that the hints name was tried; the echoes bear it out without them."


@dataclass(frozen=True, eq=False)
class Warm:
    """The one place that was tried, why it is accepted, and what to say of it."""

    found: Search
    decision: Acceptance
    note: str = NOTE


def search(scene: Scene, model: AssociationModel, epoch: Epoch) -> Warm | None:
    """Return the place near the hints of the epoch; None where they are loose or the echoes do not bear it out."""
    field = em.Field(scene, model)
    known = prior.of(epoch, scene, field, model)
    if not _tight(known, model) or known.place is None or known.heading_rad is None:
        return None
    place = np.array([known.place])
    start = Poses(place, known.heading_rad - convergence_of(scene, place))
    free = Prior(known.log_area, known.wrong_share)
    poses, information = em.refine(field, start)
    found = evidence.judge(field, poses, information, free)
    stands = found.evidence[0] > model.stop_evidence and found.ships[0] >= FEWEST
    if not stands or not known.plausible(found.poses)[0]:
        return None
    told = float(known.log_mass(found.poses, found.information)[0])
    elsewhere = float(found.evidence[0] - found.log_ratio[0]) + 2.0 * math.log(known.wrong_share)
    ahead = told - elsewhere
    wrong = ambiguity.probability_wrong(float(found.evidence[0]), ahead, model)
    if ahead < model.margin_with_hint or wrong > model.accept_probability:
        return None
    with_hints = replace(found, evidence=found.log_ratio + told)
    nothing = PairIndex.of(scene.z[:0], 0.0)
    decision = Acceptance(float(with_hints.evidence[0]), ahead, -math.inf, wrong, None)
    return Warm(Search(field, known, with_hints, 0, nothing), decision)


def _tight(known: Prior, model: AssociationModel) -> bool:
    return known.place_sigma_m <= model.warm_m and known.heading_sigma_rad <= math.radians(model.warm_deg)
