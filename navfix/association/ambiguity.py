"""Judgement of steps 5 and 6: which poses are distinct answers, and how far the best is ahead of the next."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from navfix.association.evidence import Judged
from navfix.association.seeds import firsts
from navfix.catalog import AssociationModel
from navfix.types import IntArray
from navfix.units import wrap_pi

LATTICE_TURN_DEG = 5.0
LATTICE_FEWEST = 3
LATTICE_SPREAD = 0.2


def distinct(judged: Judged, model: AssociationModel) -> Judged:
    """Keep the best of every group of poses that are the same answer (judged is sorted, best first)."""
    return judged.take(firsts(_same(judged, judged, model)))


def same_as(judged: Judged, row: int, others: Judged, model: AssociationModel) -> NDArray[np.bool_]:
    """Tell which of the ``others`` (k,) are the same optimum as a ``row`` of ``judged``.

    Near in metres and degrees, or within its own sigmas.
    """
    same: NDArray[np.bool_] = _same(judged.take(np.array([row])), others, model)[0]
    return same


def _same(judged: Judged, others: Judged, model: AssociationModel) -> NDArray[np.bool_]:
    """Tell for each pose of ``judged`` which of the ``others`` are the same optimum, (k, l)."""
    offset = others.poses.p[None, :] - judged.poses.p[:, None]
    turn_rad = wrap_pi(others.poses.heading_rad[None, :] - judged.poses.heading_rad[:, None])
    near = judged.poses.near(others.poses, model.distinct_m, model.distinct_deg)
    step = np.stack([offset.real, offset.imag, turn_rad], axis=2)
    mahalanobis_sq = ((step @ judged.information) * step).sum(axis=2)
    same: NDArray[np.bool_] = near | (mahalanobis_sq <= model.distinct_sigma**2)
    return same


def margin(judged: Judged) -> float:
    """Return by how many nats the best distinct answer is ahead of the next (infinite where there is no other)."""
    return float(judged.evidence[0] - judged.evidence[1]) if len(judged.evidence) > 1 else float("inf")


def probability_of_accident(evidence: float, model: AssociationModel) -> float:
    """Return the probability that so much evidence arises where nothing right exists (radar and AIS of two places)."""
    return min(1.0, model.accidents * math.exp(-evidence))


def probability_of_rival(ahead: float, model: AssociationModel) -> float:
    """Return the probability that another place is right although the best is so far ahead."""
    return min(1.0, model.rivals * math.exp(-ahead))


def probability_of_mirror(evidence: float, mirrored: float, model: AssociationModel) -> float:
    """Return the probability that the bearings are counted backwards, given the evidence of the mirrored echoes."""
    return min(1.0, model.mirror_share * math.exp(min(mirrored - evidence, 50.0)))


def probability_wrong(evidence: float, ahead: float, model: AssociationModel) -> float:
    """Return the probability that an answer is wrong, never less than what the calibration can vouch for."""
    total = probability_of_accident(evidence, model) + probability_of_rival(ahead, model)
    return min(1.0, max(total, model.least_probability))


def lattice(answers: Judged, rows: IntArray) -> complex | None:
    """Return the step (north + 1j east) [m] between answers that lie in a regular row, None where they do not.

    A regular row of marks fits at every shift by its spacing: the answers with the best one's heading are then one step
    apart from their neighbours.
    """
    turn_rad = wrap_pi(answers.poses.heading_rad[rows] - answers.poses.heading_rad[rows[0]])
    places = answers.poses.p[rows[np.abs(turn_rad) < np.radians(LATTICE_TURN_DEG)]]
    if len(places) < LATTICE_FEWEST:
        return None
    offset = places[None, :] - places[:, None] + np.where(np.eye(len(places), dtype=bool), np.inf, 0.0)
    steps = offset[np.arange(len(places)), np.argmin(np.abs(offset), axis=1)]
    axis = np.sqrt(np.mean(steps**2 / np.abs(steps) ** 2))  # squared: a step forward and one back are the same
    along = steps * np.conj(axis / np.abs(axis))
    step_m = float(np.median(np.abs(along.real)))
    regular = np.abs(np.abs(along.real) - step_m) < LATTICE_SPREAD * step_m
    regular &= np.abs(along.imag) < LATTICE_SPREAD * step_m
    return complex(step_m * axis / np.abs(axis)) if np.mean(regular) >= 0.6 else None


def contenders(judged: Judged, within: float) -> IntArray:
    """Return the rows of every answer within ``within`` nats of the best, best first."""
    rows: IntArray = np.flatnonzero(judged.evidence >= judged.evidence[0] - within)
    return rows
