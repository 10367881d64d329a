"""What charted marks tell about a shift that all AIS positions share, the one error that fits perfectly."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.integrity.noncentral import noncentrality
from navfix.integrity.protection import blocks_of_fix, marks_of
from navfix.integrity.separation import separate
from navfix.types import Fix

_WAYS_OUT = "only charted marks, dead reckoning or another sensor would show it"


@dataclass(frozen=True, slots=True)
class AreaShift:
    """The check of charted marks against AIS: what it says in words, and the doubt that it raises (empty: none)."""

    said: str
    doubt: str = ""


def area_shift(fix: Fix, *, probability_of_false_alarm: float, probability_of_missed_detection: float) -> AreaShift:
    """Compare the place that the charted marks give alone with the one that the AIS marks give alone, eq. (7.8).

    The two share no observation, so the covariance of their difference is the sum of both. Where one of the groups
    does not determine a place by itself, nothing is checked and that is said.
    """
    kinds = {} if fix.epoch is None else {mark.label: mark.kind for mark in fix.epoch.marks}
    labels = {o.mark for o in fix.observations}
    charted = {label for label in labels if kinds.get(label) == "charted"}
    held = {o.mark for o in fix.observations if o.weight >= 0.5}
    if not charted:
        return AreaShift(
            "not checked: an area-wide shift of all AIS positions alike moves the fix with it, and own GNSS too where "
            f"all are deceived: it cannot be seen from AIS alone; no mark comes from a chart, and {_WAYS_OUT}"
        )
    if len(charted - held) > len(charted & held):
        share = f"{len(charted - held)} of {len(charted)} charted marks"
        return AreaShift(
            f"checked: {share} do not fit the AIS positions",
            f"doubt: {share} were given up as outliers; all AIS positions may be shifted alike",
        )
    if len(charted & held) < 2:
        return _not_enough(len(charted & held), len(labels & held))
    return _compare(fix, charted, probability_of_false_alarm, probability_of_missed_detection)


def _not_enough(charted: int, marks: int) -> AreaShift:
    return AreaShift(
        f"not checked: an area-wide shift of all AIS positions alike, beyond what the {charted} charted of {marks} "
        f"marks hold; {_WAYS_OUT}"
    )


def _compare(fix: Fix, charted: set[str], false_alarm: float, missed: float) -> AreaShift:
    marks_of(fix)
    blocks = blocks_of_fix(fix).taking_part()
    from_chart = np.array([label in charted for label in blocks.labels])
    separation = separate(blocks, np.array([~from_chart, from_chart]))
    if not separation.determined.all():
        return _not_enough(int(from_chart.sum()), len(from_chart))
    north_m, east_m = separation.shift[0, :2] - separation.shift[1, :2]
    scale = max(1.0, fix.sigma0) if fix.covariance_scaling == "a_posteriori" else 1.0
    covariance = scale**2 * separation.without[:, :2, :2].sum(axis=0)
    squared = float(np.array([north_m, east_m]) @ np.linalg.solve(covariance, [north_m, east_m]))
    threshold = -2.0 * math.log(false_alarm)
    sigma_m = math.sqrt(float(np.linalg.eigvalsh(covariance)[1]))
    smallest_m = math.sqrt(noncentrality(threshold, None, missed)) * sigma_m
    apart_m, azimuth_deg = math.hypot(north_m, east_m), math.degrees(math.atan2(east_m, north_m)) % 360.0
    said = (
        f"checked: the {int(from_chart.sum())} charted marks alone lie {apart_m:.0f} m towards {azimuth_deg:03.0f}° "
        f"from what AIS alone gives; an area-wide shift of {smallest_m:.0f} m would have been noticed"
    )
    if squared <= threshold:
        return AreaShift(said)
    return AreaShift(said, "doubt: charted marks and AIS do not agree; all AIS positions may be shifted alike")
