"""Has a descent over a window led to a solution? GTSAM and Levenberg-Marquardt do not say so by themselves."""

from __future__ import annotations

import math

import numpy as np

from navfix.adjustment.window.descent import Damper, Descended
from navfix.adjustment.window.problem import WindowNetwork
from navfix.errors import NoAgreement, TooFewPairs, Unobservable
from navfix.types import FloatArray

_HOPELESS_SHARE = 0.5
_HOPELESS_RAD = 0.5


def check(damper: Damper, descended: Descended) -> None:
    """Raise where a descent has not led to a solution.

    Raises
    ------
    TooFewPairs : fewer than two marks were seen
    NoAgreement : fewer than two marks are left with half of their weight
    """
    window, layout = damper.plan.window, damper.plan.layout
    if layout.marks < 2:
        raise TooFewPairs("one mark over a window determines no heading and no position", observations=2, unknowns=3)
    weights = descended.weights
    share = mark_weights(window, weights.sighting[:, 0], weights.static)
    left = int(np.count_nonzero(share >= 0.5))
    if left < 2:
        raise NoAgreement(
            f"the tracks contradict each other: {left} of {layout.marks} marks keep half of their weight",
            evidence=-descended.loss,
        )


def mark_weights(window: WindowNetwork, sighting: FloatArray, static: FloatArray) -> FloatArray:
    """Return the weight of each mark (M,): mean weight of its sightings times that of its constant errors."""
    count = np.bincount(window.seen.mark, minlength=len(static))
    return np.asarray(np.bincount(window.seen.mark, sighting, len(static)) / np.maximum(count, 1) * static)


def check_rank(window: WindowNetwork, pose: FloatArray, cofactor: FloatArray) -> None:
    """Raise Unobservable where the newest pose is free to half the distance of the marks, or to 29 deg."""
    distance_m = float(np.median(np.hypot(*(window.seen.place_ne_m - pose[:2]).T)))
    values, vectors = np.linalg.eigh(cofactor[:2, :2])
    if math.sqrt(values[1]) > _HOPELESS_SHARE * distance_m:
        azimuth_deg = math.degrees(math.atan2(vectors[1, 1], vectors[0, 1])) % 180.0
        direction = (float(vectors[0, 1]), float(vectors[1, 1]), 0.0)
        raise Unobservable(f"the window leaves the position along {azimuth_deg:.0f}° free", direction=direction)
    if window.any_relative and math.sqrt(cofactor[2, 2]) > _HOPELESS_RAD:
        raise Unobservable("the window leaves the heading free", direction=(0.0, 0.0, 1.0))
