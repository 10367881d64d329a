"""Step 6: is the best answer good enough to be given? Three ways in which it can be wrong, and their probabilities.

Chance may have made the agreement (accident), another place may explain the echoes as well (rival), and the echoes may
be the mirror image of what the radar saw: bearings counted the wrong way round. That is a fault of the installation
and not of the method, but it is a trap: where a and b lie alike on both sides of a line, mirrored a falls on b *and*
mirrored b on a, so that one coincidence counts twice and chance agreement is far likelier than among other marks. The
mirrored echoes are therefore searched as well: they explain the marks by far better only if they are the right ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.association import ambiguity, em, seeded
from navfix.association.scene import Scene
from navfix.association.seeded import Search
from navfix.catalog import AssociationModel

FEWEST, FEWEST_WITH_HINT = 3, 2
PLAINLY = 7.0  # nats: a thousand to one


@dataclass(frozen=True, slots=True)
class Acceptance:
    """Why the best answer of a search is given or not.

    ``margin`` to the next distinct answer and ``mirrored``, the evidence of the mirrored echoes [nats] (minus infinity
    where it was not needed); ``reason`` None, "accident", "rival" or "mirror".
    """

    evidence: float
    margin: float
    mirrored: float
    probability_wrong: float
    reason: str | None


def decide(found: Search, model: AssociationModel) -> Acceptance:
    """Weigh the three ways to be wrong; the mirrored echoes are searched only where everything else speaks for yes."""
    evidence, ahead = float(found.answers.evidence[0]), ambiguity.margin(found.answers)
    wrong = ambiguity.probability_wrong(evidence, ahead, model)
    hint = found.prior.has_hint
    fewest, enough = (FEWEST_WITH_HINT, model.margin_with_hint) if hint else (FEWEST, model.least_margin)
    mirrored, reason = -math.inf, None
    if found.answers.ships[0] < fewest or ambiguity.probability_of_accident(evidence, model) > model.accept_probability:
        reason = "accident"
    elif ahead < enough or wrong > model.accept_probability:
        reason = "rival"
    elif evidence < model.mirror_below:
        mirrored = evidence_of_mirror(found, model)
        wrong = min(1.0, wrong + ambiguity.probability_of_mirror(evidence, mirrored, model))
        reason = "mirror" if wrong > model.accept_probability else None
    return Acceptance(evidence, ahead, mirrored, wrong, reason)


def mirror_words(decision: Acceptance) -> str:
    """Say how well the mirrored echoes fit, for a refusal by reason "mirror"."""
    told = f"(evidence {decision.mirrored:.1f} against {decision.evidence:.1f})"
    if decision.mirrored - decision.evidence > PLAINLY:
        return f"mirrored, the echoes fit the marks far better {told}: are bearings counted anticlockwise?"
    return f"mirrored, the echoes fit the marks as well {told}: all in one line, or an agreement by chance"


def evidence_of_mirror(found: Search, model: AssociationModel) -> float:
    """Return the evidence of the best pose of the mirrored echoes, searched as far as the echoes themselves were."""
    first = model.pairs_per_stage[0]
    stages = [stage for stage in model.pairs_per_stage if stage <= max(found.pairs_tried, first)]
    field = em.Field(mirrored(found.field.scene), replace(model, pairs_per_stage=stages))
    mirror = seeded.search_field(field, found.prior, found.index)
    return float(mirror.answers.evidence[0])


def mirrored(scene: Scene) -> Scene:
    """Return the scene with its bearings counted the other way round."""
    return replace(scene, rho=np.conj(scene.rho), bearing_rad=-scene.bearing_rad)
