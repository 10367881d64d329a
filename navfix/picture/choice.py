"""Which of the data at hand a fix is made from: the decision table of [1], 4.2.1, its filters, and what is done here.

The source asks three things - AIS of ships and aids around? own speed? at least three aids? - and takes one of its
algorithms by the answers, each with some of three filters. Its table is not printed: the one below follows from what
each filter needs. Our own association explains ships and aids, moving and still, by one model and gives every echo the
chance to be clutter, so that a filter only takes information from it; it uses everything (docs/charts.md has figures).

[1] J. Knopp, thesis, 4.2.1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np

from navfix.types import Decision, Epoch, Filter, Mark, MethodChoice, RadarTarget

AIDS_ENOUGH = 3
STRONGEST_CURRENT_MPS = 3.0
SAME_VELOCITY_MPS = 0.8  # two velocities of still targets differ by no more: speed noise of a tracker
FEWEST_STANDING = 3

Item = TypeVar("Item", Mark, RadarTarget)

# (ships, own speed, three aids) -> what the source takes, and its filters
TABLE: dict[tuple[bool, bool, bool], tuple[str, tuple[Filter, ...]]] = {
    (True, True, True): ("aids and targets that stand still", ("aids", "standing")),
    (True, True, False): ("ships and targets, newest reports", ("newest",)),
    (True, False, True): ("ships and aids, newest reports", ("newest",)),
    (True, False, False): ("ships and targets, newest reports", ("newest",)),
    (False, True, True): ("aids and targets that stand still", ("aids", "standing")),
    (False, True, False): ("nothing to compare with", ()),
    (False, False, True): ("aids", ("aids",)),
    (False, False, False): ("nothing to compare with", ()),
}
_WHY_ALL = "together they say more than any part"


def choose(epoch: Epoch) -> MethodChoice:
    """Return the decision for an epoch, and the source's beside it."""
    aids = sum(mark.kind != "ship" for mark in epoch.marks)
    ships = len(epoch.marks) > aids
    return decide(ships=ships, own_speed=epoch.speed_hint is not None, aids=aids)


def decide(*, ships: bool, own_speed: bool, aids: int) -> MethodChoice:
    """Return the decision for what is there: AIS ships, own speed by log, so many aids by AIS or chart."""
    three_aids = aids >= AIDS_ENOUGH
    source, filters = TABLE[ships, own_speed, three_aids]
    decision: Decision = "all" if ships or aids else "none"
    there = [
        "AIS of ships" if ships else "no AIS of ships",
        "own speed" if own_speed else "no own speed",
        "three aids or more" if three_aids else f"fewer than {AIDS_ENOUGH} aids",
    ]
    why = _WHY_ALL if decision == "all" else "neither AIS nor chart shows a mark"
    return MethodChoice(ships, own_speed, three_aids, source, filters, decision, f"{', '.join(there)}: {why}")


def as_the_source_chooses(epoch: Epoch) -> Epoch:
    """Return the epoch with the filters that the source's table names for it."""
    choice = epoch.choice or choose(epoch)
    for name in choice.filters:
        epoch = FILTERS[name](epoch)
    reason = choice.reason.partition(": ")[0]
    return replace(epoch, choice=replace(choice, decision="source", reason=f"{reason}: as asked for"))


def newest(epoch: Epoch) -> Epoch:
    """Keep the newest report of each target and each station (filter 1)."""
    targets = _newest_of(epoch.targets, lambda target: target.label)
    marks = _newest_of(epoch.marks, lambda mark: mark.label if mark.mmsi is None else str(mark.mmsi))
    return replace(epoch, targets=targets, marks=marks)


def aids_only(epoch: Epoch) -> Epoch:
    """Keep the aids to navigation, by AIS or chart (filter 2)."""
    return replace(epoch, marks=tuple(mark for mark in epoch.marks if mark.kind != "ship"))


def standing(epoch: Epoch) -> Epoch:
    """Keep the targets that stand still (filter 3); all of them where too few tell a speed.

    A ground-stabilised radar shows them at rest; a sea-stabilised one shows all of them with the current's opposite.
    So they are the largest group with one velocity that a current can have.
    """
    velocity = np.array([_velocity(target) for target in epoch.targets], dtype=np.complex128)
    slow = np.abs(velocity) <= STRONGEST_CURRENT_MPS  # NaN compares as false
    if slow.sum() < FEWEST_STANDING:
        return epoch
    alike = np.abs(velocity[:, None] - velocity[None, :]) <= SAME_VELOCITY_MPS
    size = np.where(slow, alike.sum(axis=1) - 1e-3 * np.nan_to_num(np.abs(velocity)), 0.0)
    centre = velocity[alike[int(np.argmax(size))]].mean()
    kept = np.flatnonzero(np.abs(velocity - centre) <= SAME_VELOCITY_MPS)
    return replace(epoch, targets=tuple(epoch.targets[int(i)] for i in kept))


FILTERS: dict[Filter, Callable[[Epoch], Epoch]] = {"newest": newest, "aids": aids_only, "standing": standing}


def _velocity(target: RadarTarget) -> complex:
    """Return the velocity (north + 1j east) [m/s], NaN where the radar does not tell it."""
    if target.speed_mps is None or (target.course_deg is None and target.speed_mps > 0.0):
        return complex(float("nan"), float("nan"))
    return complex(target.speed_mps * np.exp(1j * np.radians(target.course_deg or 0.0)))


def _newest_of(items: tuple[Item, ...], key: Callable[[Item], str]) -> tuple[Item, ...]:
    """Return the newest item of each key, in the order of the items; one without a time counts as the oldest."""
    best: dict[str, int] = {}
    for i, item in enumerate(items):
        known = best.get(key(item))
        if known is None or _time_s(item) >= _time_s(items[known]):
            best[key(item)] = i
    return tuple(items[i] for i in sorted(best.values()))


def _time_s(item: Mark | RadarTarget) -> float:
    return float("-inf") if item.time_utc is None else item.time_utc.timestamp()
