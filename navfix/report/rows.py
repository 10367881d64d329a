"""Range and bearing of one pair side by side: what the residual tables and the pictures show."""

from __future__ import annotations

import math
from dataclasses import dataclass

from navfix.types import AdjustedObservation, Fix, Mark

SUSPECT = (
    3.29  # 1 in 1000 of normal residuals: without a kernel nothing is damped, so large residuals are named by this
)


@dataclass(frozen=True, slots=True)
class PairRow:
    """One pair of a fix: its range, its bearing (None where it was not observed) and what they say together.

    ``offset_m`` along ``offset_azimuth_deg`` (true) leads from the place where the radar sees the target to the
    position that the mark is said to have; None where only one of range and bearing was observed.
    ``mark`` is the record, None for a fix without an epoch.
    """

    target: str
    mark_label: str
    mark: Mark | None
    range: AdjustedObservation | None
    bearing: AdjustedObservation | None
    outlier: bool
    offset_m: float | None
    offset_azimuth_deg: float | None

    @property
    def name(self) -> str:
        """The mark's name, else its label."""
        return (self.mark.name if self.mark is not None else None) or self.mark_label

    @property
    def stands_off(self) -> bool:
        """Whether a residual is larger than its sigma: the mean of a window's sightings may fit where they do not."""
        return any(abs(o.residual) > o.sigma for o in (self.range, self.bearing) if o is not None)


def pair_rows(fix: Fix) -> list[PairRow]:
    """Return one row for every pair, in the order of the observations."""
    marks = {mark.label: mark for mark in fix.epoch.marks} if fix.epoch is not None else {}
    grouped: list[dict[str, AdjustedObservation]] = []
    open_group: dict[tuple[str, str], dict[str, AdjustedObservation]] = {}
    for observation in fix.observations:
        slot = "range" if observation.kind == "range" else "bearing"
        group = open_group.get((observation.target, observation.mark))
        if group is None or slot in group:
            group = open_group[observation.target, observation.mark] = {}
            grouped.append(group)
        group[slot] = observation
    return [_row(fix, marks, group.get("range"), group.get("bearing")) for group in grouped]


def _row(
    fix: Fix, marks: dict[str, Mark], range_: AdjustedObservation | None, bearing: AdjustedObservation | None
) -> PairRow:
    any_one = range_ or bearing
    assert any_one is not None  # a group is opened by its first observation
    offset_m, azimuth_deg = _offset(fix, range_, bearing)
    return PairRow(
        target=any_one.target,
        mark_label=any_one.mark,
        mark=marks.get(any_one.mark),
        range=range_,
        bearing=bearing,
        outlier=any(is_outlier(fix, observation) for observation in (range_, bearing) if observation is not None),
        offset_m=offset_m,
        offset_azimuth_deg=azimuth_deg,
    )


def is_outlier(fix: Fix, observation: AdjustedObservation) -> bool:
    """Tell whether the kernel damped the observation below half; without a kernel, whether it is beyond `SUSPECT`."""
    if fix.kernel == "none":
        return observation.standardized is not None and abs(observation.standardized) > SUSPECT
    return observation.weight < 0.5


def _offset(
    fix: Fix, range_: AdjustedObservation | None, bearing: AdjustedObservation | None
) -> tuple[float | None, float | None]:
    if range_ is None or bearing is None:
        return None, None
    turn_deg = 0.0 if bearing.kind == "true_bearing" else (fix.heading_deg or 0.0)
    said_rad, seen_rad = math.radians(bearing.adjusted + turn_deg), math.radians(bearing.observed + turn_deg)
    north_m = range_.adjusted * math.cos(said_rad) - range_.observed * math.cos(seen_rad)
    east_m = range_.adjusted * math.sin(said_rad) - range_.observed * math.sin(seen_rad)
    return math.hypot(north_m, east_m), math.degrees(math.atan2(east_m, north_m)) % 360.0


def unmatched_indices(fix: Fix) -> list[int]:
    """Return the indices of the targets that no mark belongs to; none where the fix carries no association."""
    if fix.epoch is None or fix.association is None:
        return []
    matched = {int(index) for index in fix.association.pairs[:, 0]}
    return [index for index in range(len(fix.epoch.targets)) if index not in matched]
