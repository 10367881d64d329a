"""The association of a window for its newest epoch: search, judge, pair, and refuse where the data do not say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from navfix.association import ambiguity
from navfix.association.scene import heading_of, position_of
from navfix.association.window import gyro, jackknife, joint, pairs
from navfix.association.window.as_fix import as_fix
from navfix.association.window.evidence import Answers
from navfix.association.window.jackknife import PoseAtEnd
from navfix.association.window.joint import Joint, Window
from navfix.association.window.pairs import Pairs
from navfix.association.window.settle import Settled, settle
from navfix.catalog import AssociationModel, RadarModel, WindowModel, association_model, window_model
from navfix.errors import Ambiguous, InputError, NoAgreement, TooFewPairs
from navfix.types import Alternative, Association, Epoch, Fix, FloatArray
from navfix.types.found import LARGEST_MARGIN


def associate_window(
    epochs: Sequence[Epoch],
    *,
    model: WindowModel | str = "joint",
    shared: AssociationModel | str = "seeded",
    radar: RadarModel | str = "imo",
) -> Association:
    """Find which track is which mark over a window of scans, and with it own position and heading at its end.

    Parameters
    ----------
    epochs : scans in the order of time, each with its time
    model, shared : constants of the window, and those that it shares with the association of one scan
    radar : sigma of range [m] and bearing [deg] where the targets bring none of their own

    Returns
    -------
    Association - pairs of the newest epoch's targets and marks, pose and covariance (3, 3) at its instant

    Raises
    ------
    TooFewPairs : fewer than three tracks or marks in the window
    NoAgreement : no own motion explains the tracks better than chance; Ambiguous : another explains them nearly as well
    InputError : epochs without a time, or not in the order of time
    """
    return solve_jointly(epochs, model=model, shared=shared, radar=radar).association


@dataclass(frozen=True, slots=True, eq=False)
class WindowAnswer:
    """What a window says: the fix at its newest epoch, the association there, and the pairs of every epoch.

    ``labels`` holds {target label: mark label} for each epoch; ``spread`` (3, 3) is what leaving out one track after
    the other adds to the covariance, in north [m], east [m], heading [rad].
    """

    fix: Fix
    association: Association
    labels: tuple[dict[str, str], ...]
    spread: FloatArray


def solve_jointly(
    epochs: Sequence[Epoch],
    *,
    model: WindowModel | str = "joint",
    shared: AssociationModel | str = "seeded",
    radar: RadarModel | str = "imo",
) -> WindowAnswer:
    """Return the fix of a window at its newest epoch, and what is behind it; raises as `associate_window`."""
    require_order(epochs)
    window = joint.prepare(epochs, window_model(model), association_model(shared), radar=radar)
    require_enough(window)
    found = gyro.cold(window)
    require_agreement(found, hinted=gyro.heading_prior(window).has_hint)
    return window_answer(found, settle(found, window.prior, fewest_marks=window.field.model.fewest_marks))


def window_answer(found: Joint, settled: Settled) -> WindowAnswer:
    """Return the best answer of a window, which is settled, as a fix with its pairs."""
    window, pose = found.window, settled.pose
    matched = pairs.one_to_one(window.field, settled.knots)
    said = association(found, pose, matched)
    fix = as_fix(window, pose, matched, said)
    labels = pairs.labels_by_epoch(window, matched.index, window.epochs)
    return WindowAnswer(fix, said, tuple(labels), pose.covariance - pose.formal)


def require_order(epochs: Sequence[Epoch]) -> None:
    """Raise unless every epoch has a time and they are in its order."""
    if not epochs:
        raise InputError("a window needs at least one epoch, got none")
    times = [epoch.time_utc for epoch in epochs]
    if any(time is None for time in times):
        raise InputError("a window of scans needs the time of every epoch; one has none: solve them one by one")
    if any(later < earlier for earlier, later in pairwise(times)):  # type: ignore[operator]
        raise InputError("the epochs of a window must be in the order of time")


def require_enough(window: Window) -> None:
    """Raise unless the window holds as many tracks and marks as an answer needs."""
    scene, fewest = window.field.scene, window.field.model.fewest_marks
    for word, count in (("tracks", len(scene.tracks)), ("marks of known position", len(scene.paths.marks))):
        if count < fewest:
            raise TooFewPairs(
                f"{count} {word} in the window: position and heading need at least {fewest}",
                observations=2 * count,
                unknowns=3,
            )


def require_agreement(found: Joint, *, hinted: bool = False) -> None:
    """Raise unless the best answer has enough marks, enough evidence and enough margin; more of it with a hint."""
    model, answers = found.window.field.model, found.answers
    evidence = float(answers.evidence[0]) if len(answers) else -math.inf
    marks = int(answers.marks[0]) if len(answers) else 0
    needed = model.least_evidence if marks >= model.enough_marks else model.least_evidence_few
    if marks < model.fewest_marks or evidence < needed:
        raise NoAgreement(
            f"no own motion explains the tracks better than chance does: the best one matches {marks} marks, "
            f"its evidence is {evidence:.1f} (at least {needed:g})",
            evidence=evidence,
            alternatives=alternatives(found),
        )
    if answers.margin < (found.window.field.shared.margin_with_hint if hinted else model.least_margin):
        raise Ambiguous(
            f"{len(alternatives(found))} places explain the tracks nearly alike: the best is ahead by "
            f"{answers.margin:.1f} only",
            alternatives=alternatives(found),
        )


def alternatives(found: Joint) -> tuple[Alternative, ...]:
    """Return every distinct answer within the margin of the best, best first, at least two where there are."""
    answers, window = found.answers, found.window
    if not len(answers):
        return ()
    within = max(window.field.model.least_margin, answers.margin + 1e-9)
    rows = np.flatnonzero(answers.evidence >= answers.evidence[0] - within)
    return tuple(_alternative(window, answers, int(row)) for row in rows)


def _alternative(window: Window, answers: Answers, row: int) -> Alternative:
    p, heading, _ = jackknife.at_end(window.field, answers.knots.take(np.array([row])))
    turn = window.field.scene.yaw_at_end
    return Alternative(
        position_of(window.field.scene.flat, complex(p[0])),
        heading_of(window.field.scene.flat, complex(p[0]), float(heading[0]) + turn),
        float(answers.evidence[row]),
        int(answers.marks[row]),
    )


def association(found: Joint, pose: PoseAtEnd, matched: Pairs) -> Association:
    """Return the association of the best answer for the newest epoch of its window, from its pairs over all of it."""
    window, answers = found.window, found.answers.take(np.array([0]))
    evidence = float(answers.evidence[0])
    ahead = min(found.answers.margin, LARGEST_MARGIN)
    index, probability = _newest_pairs(window, matched)
    return Association(
        pairs=index,
        probability=probability,
        position=position_of(window.field.scene.flat, pose.p),
        heading_deg=heading_of(window.field.scene.flat, pose.p, pose.heading_rad),
        covariance=pose.covariance,
        evidence=evidence,
        margin=ahead,
        probability_wrong=probability_wrong(evidence, ahead, window.field.model, window.field.shared),
        alternatives=alternatives(found)[1:],
        method=window.field.model.name,
        notes=gyro.notes(window, pose),
    )


def probability_wrong(evidence: float, ahead: float, model: WindowModel, shared: AssociationModel) -> float:
    """Return the probability that an accepted window is wrong, never below what the negative controls support."""
    accident = model.least_probability_wrong * math.exp(-evidence / model.accident_nats)
    total = ambiguity.probability_of_rival(ahead, shared) + accident
    return min(1.0, max(model.least_probability_wrong, total))


def _newest_pairs(window: Window, matched: Pairs) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs as indices of the newest epoch's targets and marks, with their probability."""
    scene = window.field.scene
    target = np.array([scene.tracks[t].newest for t in matched.index[:, 0]], dtype=np.int64)
    mark = np.array([scene.paths.newest[m] for m in matched.index[:, 1]], dtype=np.int64)
    there = (target >= 0) & (mark >= 0)
    return np.column_stack([target, mark])[there].reshape(-1, 2), matched.probability[there]
