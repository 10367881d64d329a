"""The association of one epoch: search, judge, pair, and refuse where the data do not say."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navfix.association import acceptance, ambiguity, pairs, proof, second_group, seeded, source_method, warm_start
from navfix.association import scene as scenes
from navfix.association.acceptance import FEWEST, FEWEST_WITH_HINT, Acceptance
from navfix.association.evidence import Judged
from navfix.association.kept_index import KeptIndex
from navfix.association.polish import polish
from navfix.association.scene import Scene, heading_of, position_of
from navfix.association.seeded import Search
from navfix.catalog import (
    AssociationModel,
    CpdModel,
    RadarModel,
    association_method,
    association_model,
    radar_model,
)
from navfix.errors import Ambiguous, InputError, NoAgreement, TooFewPairs
from navfix.types import Alternative, Association, Epoch, IntArray, SecondGroup
from navfix.types.found import LARGEST_MARGIN
from navfix.units import NM_M, wrap_pi


def associate(
    epoch: Epoch | Sequence[Epoch],
    *,
    method: str | AssociationModel | CpdModel = "seeded",
    radar: RadarModel | str = "imo",
    prove: bool = False,
    index: KeptIndex | None = None,
    warm: bool = False,
) -> Association:
    """Find which target is which mark, and with it own position and heading, from any start.

    Parameters
    ----------
    epoch : targets and marks at one instant; at least three of each. Or a sequence of epochs in the order of time: a
        window, whose tracks are associated together; the pairs are those of its newest epoch
    method : a name in models/association: "seeded", or "cpd" for the plain Coherent Point Drift of [2], which always
        answers
    radar : sigma of range [m] and bearing [deg] where the targets bring none of their own
    index : the caller's index of mark pairs, kept from call to call and brought up to date here
    warm : with a position and a heading hint (to some 500 m and 3 deg), start from them alone; the answer is given
        where its evidence stands without the hints, else everything is searched. AIS shifted alike is not looked for
    prove : search everywhere for other answers (seconds to a minute) before one is accepted; the notes say the result

    Returns
    -------
    Association - one-to-one pairs with probabilities, pose, covariance (3, 3), evidence, margin, alternatives

    Raises
    ------
    TooFewPairs : fewer than three targets or marks
    NoAgreement : no pose explains the echoes better than chance
    Ambiguous : another place explains them nearly as well; it lists all of them

    References
    ----------
    [1] Myronenko & Song (2010), Point set registration: Coherent Point Drift.  [2] Knopp, thesis, 2.2 and 4.2.
    """
    if not isinstance(epoch, Epoch):
        return _of_window(epoch, method, radar, prove)
    _require_enough(epoch)
    model = association_method(method)
    if isinstance(model, CpdModel):
        return _by_source_method(epoch, model, radar_model(radar))
    scene = scenes.build(epoch, radar_model(radar), model)
    labels = tuple(target.label for target in epoch.targets)
    if warm and not prove:
        near = warm_start.search(scene, model, epoch)
        if near is not None:
            return _association(near.found, scene, model, near.decision, labels, (near.note,), look_further=False)
    pairs_of_marks = index.of(scene, epoch.marks) if index is not None else None
    found = seeded.search(scene, model, epoch=epoch, index=pairs_of_marks)
    decision = _require_agreement(found, scene, model)
    notes = _prove(found, scene, model) if prove else ()
    return _association(found, scene, model, decision, labels, notes)


def _of_window(
    epochs: Sequence[Epoch], method: str | AssociationModel | CpdModel, radar: RadarModel | str, prove: bool
) -> Association:
    from navfix.association.window.associate import associate_window

    shared = association_method(method)
    if isinstance(shared, CpdModel) or prove:
        raise InputError("a window of epochs is associated jointly: neither method cpd nor prove applies to it")
    return associate_window(tuple(epochs), shared=shared, radar=radar)


def _require_enough(epoch: Epoch) -> None:
    needed = FEWEST_WITH_HINT if epoch.heading_hint or epoch.position_hint else FEWEST
    for word, count in (("radar targets", len(epoch.targets)), ("marks of known position", len(epoch.marks))):
        if count < needed:
            raise TooFewPairs(
                f"{count} {word}: position and heading need at least {needed}", observations=2 * count, unknowns=3
            )


def _require_agreement(found: Search, scene: Scene, model: AssociationModel) -> Acceptance:
    """Return the decision to answer, or raise with what speaks against it."""
    decision = acceptance.decide(found, model)
    enough = model.margin_with_hint if found.prior.has_hint else model.least_margin
    if decision.reason == "accident":
        raise NoAgreement(
            f"no place explains the echoes better than chance does: the best one matches "
            f"{int(found.answers.ships[0])} marks, its evidence is {decision.evidence:.1f}",
            evidence=decision.evidence,
            alternatives=_alternatives(found, scene, enough),
        )
    if decision.reason == "mirror":
        raise NoAgreement(
            acceptance.mirror_words(decision),
            evidence=decision.evidence,
            alternatives=_alternatives(found, scene, enough),
        )
    if decision.reason == "rival":
        raise _ambiguous(found.answers, scene, max(enough, math.log(model.rivals / model.accept_probability)))
    return decision


def _prove(found: Search, scene: Scene, model: AssociationModel) -> tuple[str, ...]:
    """Search everywhere; raise where that finds another answer within the margin, else say what was settled."""
    proved = proof.prove(found, model)
    within = math.log(model.rivals / model.accept_probability)
    if len(proved.answers.evidence) > 1:
        raise _ambiguous(proved.answers, scene, within)
    cells = f"{proved.cells / 1e6:.0f} million cells of position and heading"
    if not proved.complete:
        return (f"Not proved: the data are too weak to settle all of {cells}.",)
    return (f"Proved: a search of {cells} found no other place within {within:.1f} nats of this one.",)


def _ambiguous(answers: Judged, scene: Scene, within: float) -> Ambiguous:
    """Return the refusal that names every answer ``within`` so many nats of the best, and the step between them."""
    rows = ambiguity.contenders(answers, max(within, ambiguity.margin(answers) + 1e-9))
    step = ambiguity.lattice(answers, rows)
    ahead = f"the best is ahead by {ambiguity.margin(answers):.1f} only"
    message = f"{len(rows)} places explain the echoes nearly alike: {ahead}"
    if step is not None:
        azimuth_deg = math.degrees(math.atan2(step.imag, step.real)) % 180.0
        message = f"{len(rows)} places fit, {abs(step) / NM_M:.2f} NM apart along {azimuth_deg:03.0f}°: {ahead}"
    return Ambiguous(message, alternatives=_as_alternatives(answers, scene, rows))


def _alternatives(found: Search, scene: Scene, within: float) -> tuple[Alternative, ...]:
    """Return every distinct answer ``within`` so many nats of the best, at least two where there are."""

    answers = found.answers
    rows = ambiguity.contenders(answers, max(within, ambiguity.margin(answers) + 1e-9))
    return _as_alternatives(answers, scene, rows)


def _as_alternatives(answers: Judged, scene: Scene, rows: IntArray) -> tuple[Alternative, ...]:
    return tuple(
        Alternative(
            position_of(scene, complex(answers.poses.p[row])),
            heading_of(scene, complex(answers.poses.p[row]), float(answers.poses.heading_rad[row])),
            float(answers.evidence[row]),
            int(answers.ships[row]),
        )
        for row in rows
    )


def _association(
    found: Search,
    scene: Scene,
    model: AssociationModel,
    decision: Acceptance,
    labels: tuple[str, ...],
    notes: tuple[str, ...],
    look_further: bool = True,
) -> Association:
    answers = found.answers
    pose, covariance = polish(found.field, answers.poses.take(np.array([0])))
    index_pairs, probability = pairs.one_to_one(found.field, pose)
    return Association(
        pairs=np.column_stack([scene.target_index[index_pairs[:, 0]], scene.mark_index[index_pairs[:, 1]]]),
        probability=probability,
        position=position_of(scene, complex(pose.p[0])),
        heading_deg=heading_of(scene, complex(pose.p[0]), float(pose.heading_rad[0])),
        covariance=covariance,
        evidence=decision.evidence,
        margin=min(decision.margin, LARGEST_MARGIN),
        probability_wrong=decision.probability_wrong,
        alternatives=_alternatives(found, scene, model.least_margin)[1:],
        second_group=_second_group(found, scene, model, index_pairs, labels) if look_further else None,
        notes=(*_notes(found), *notes),
        method=model.name,
    )


def _notes(found: Search) -> tuple[str, ...]:
    """Return what the data say of the hints."""

    prior, best = found.prior, found.answers.take(np.zeros(1, dtype=np.int64))
    position_holds, heading_holds = prior.hint_holds(best.poses, best.information)[0]
    notes = []
    if prior.place is not None and position_holds < 0.5:
        off_nm = abs(best.poses.p[0] - prior.place) / NM_M
        notes.append(f"The position hint is refuted: it lies {off_nm:.1f} NM from the place that the echoes show.")
    if prior.heading_rad is not None and heading_holds < 0.5:
        off_deg = math.degrees(wrap_pi(prior.heading_rad - float(prior.true_heading(best.poses)[0])))
        source = "heading hint" if found.field.scene.reference == "relative" else "compass in the true bearings"
        notes.append(f"The {source} is refuted: it is {off_deg:+.1f}° off.")
    return tuple(notes)


def _second_group(
    found: Search, scene: Scene, model: AssociationModel, matched: IntArray, labels: tuple[str, ...]
) -> SecondGroup | None:
    group = second_group.find(found, model, matched)
    if group is None:
        return None
    shift, targets = group
    azimuth_deg = math.degrees(math.atan2(shift.imag, shift.real)) % 360.0
    return SecondGroup(abs(shift), azimuth_deg, tuple(labels[scene.target_index[i]] for i in targets))


def _by_source_method(epoch: Epoch, method: CpdModel, radar: RadarModel) -> Association:
    """Associate as the thesis does; nothing is refused, the evidence is told."""
    model = association_model()
    scene = scenes.build(epoch, radar, model)
    found = source_method.register_scene(scene, method, epoch.heading_hint)
    index_pairs, probability = source_method.pairs_of(found, method.least_probability)
    judged, _ = source_method.judge(found, scene, model, epoch)
    return Association(
        pairs=np.column_stack([scene.target_index[index_pairs[:, 0]], scene.mark_index[index_pairs[:, 1]]]),
        probability=probability,
        position=position_of(scene, found.translation),
        heading_deg=heading_of(scene, found.translation, float(np.angle(found.rotation))),
        covariance=np.linalg.inv(judged.information[0]),
        evidence=float(judged.evidence[0]),
        method=method.name,
        notes=("Plain CPD always answers: nothing here tells whether the place is right.",),
    )
