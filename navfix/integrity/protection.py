"""The protection level of a fix: what its error does not pass unnoticed, or in words why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.adjustment.network import Network
from navfix.adjustment.whitening import whitened
from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.integrity.levels import separation_levels, slope_level
from navfix.integrity.separation import Blocks, Separation, separate
from navfix.integrity.several import suspicious, without_several
from navfix.kernels import Damping
from navfix.types import Fix, FloatArray, Integrity, Mark, Position

PROBABILITY_OF_FALSE_ALARM = 1e-3
PROBABILITY_OF_MISSED_DETECTION = 1e-4
_NOTHING = 1e-3  # of an information: below it there is no compass error and no prior
_LINEAR_SHARE = 0.5  # of the median distance to the marks: beyond it the linear picture says nothing


@dataclass(frozen=True, slots=True)
class Protection:
    """Protection level [m] by solution separation and by slopes; None with the ``reason`` where there is none."""

    level_m: float | None
    slope_m: float | None
    reason: str


def with_integrity(
    fix: Fix,
    *,
    probability_of_false_alarm: float = PROBABILITY_OF_FALSE_ALARM,
    probability_of_missed_detection: float = PROBABILITY_OF_MISSED_DETECTION,
) -> Fix:
    """Return the fix with its protection level in ``integrity``.

    The level holds against one wrong mark among those that the kernel has left in, whichever it is (against two and
    three where the residuals are larger than chance explains), and against noise: without an alarm the error passes it
    with ``probability_of_missed_detection``. It is None, with the reason in words, where leaving a mark out leaves the
    fix undetermined, or where an alarm stands.

    Raises
    ------
    InputError : a probability outside 0 .. 1
    """
    _check(probability_of_false_alarm, probability_of_missed_detection)
    integrity = fix.integrity or Integrity(r95_m=math.nan)
    if fix.epoch is None or not isinstance(fix.position, Position):
        return replace(fix, integrity=replace(integrity, reason="the fix does not carry its marks"))
    found = protection(
        blocks_of_fix(fix),
        sigma0=fix.sigma0 if fix.covariance_scaling == "a_posteriori" else 1.0,
        dof=fix.dof,
        reach_m=_median_distance(fix),
        probability_of_false_alarm=probability_of_false_alarm,
        probability_of_missed_detection=probability_of_missed_detection,
    )
    return replace(
        fix,
        integrity=replace(
            integrity,
            protection_level_m=found.level_m,
            probability_of_false_alarm=probability_of_false_alarm,
            probability_of_missed_detection=probability_of_missed_detection,
            slope_level_m=found.slope_m,
            reason=found.reason,
        ),
    )


def protection(
    blocks: Blocks,
    *,
    sigma0: float,
    dof: float,
    reach_m: float,
    probability_of_false_alarm: float = PROBABILITY_OF_FALSE_ALARM,
    probability_of_missed_detection: float = PROBABILITY_OF_MISSED_DETECTION,
) -> Protection:
    """Return the protection level of a linearised adjustment whose marks are ``reach_m`` away (the median).

    Every sigma is multiplied by ``sigma0`` where that is above 1, never made smaller by it: that residuals happen to
    be small is no promise. Where the residuals are larger than chance explains, the level holds against two and three
    wrong marks at once too.
    """
    used = blocks.taking_part()
    separation = separate(used)
    if reason := _undetermined(used, separation):
        return Protection(None, None, reason)
    scale = max(1.0, sigma0)
    levels = separation_levels(
        separation,
        scale=scale,
        probability_of_false_alarm=probability_of_false_alarm,
        probability_of_missed_detection=probability_of_missed_detection,
    )
    slope_m = slope_level(
        used,
        separation.cofactor,
        scale=scale,
        dof=dof,
        probability_of_false_alarm=probability_of_false_alarm,
        probability_of_missed_detection=probability_of_missed_detection,
    )
    slope = slope_m if slope_m <= _LINEAR_SHARE * reach_m else None
    if levels.alarms:
        return Protection(None, slope, _alarm(used, separation, levels.alarms, levels.ratio))
    if suspicious(sigma0, dof):
        several = separation_levels(
            without_several(used),
            scale=scale,
            probability_of_false_alarm=probability_of_false_alarm,
            probability_of_missed_detection=probability_of_missed_detection,
        )
        if several.protection_m > _LINEAR_SHARE * reach_m:
            return Protection(None, slope, _several(several.protection_m))
        levels = replace(levels, protection_m=max(levels.protection_m, several.protection_m))
    if levels.protection_m > _LINEAR_SHARE * reach_m:
        worst = used.labels[levels.worst] if levels.worst >= 0 else "no mark in particular"
        why = f"{levels.protection_m:.0f} m (most for {worst}) is too much beside the distance to the marks"
        return Protection(None, slope, why)
    return Protection(levels.protection_m, slope, "")


def _undetermined(blocks: Blocks, separation: Separation) -> str:
    if not len(blocks.labels):
        return "no mark takes part"
    if separation.determined.all():
        return ""
    held = [label for label, fine in zip(blocks.labels, separation.determined, strict=True) if not fine]
    others = f" (and {len(held) - 1} more)" if len(held) > 1 else ""
    return f"without {held[0]}{others} nothing would determine the fix: no redundancy checks it"


def _several(level_m: float) -> str:
    return (
        f"the residuals are larger than chance explains: several marks may be wrong alike, and {level_m:.0f} m "
        "is too much beside the distance to the marks"
    )


def _alarm(blocks: Blocks, separation: Separation, alarms: tuple[int, ...], ratio: FloatArray) -> str:
    worst = max(alarms, key=lambda index: float(ratio[index]))
    moved_m = float(np.hypot(*separation.shift[worst, :2]))
    return f"alarm: without {blocks.labels[worst]} the fix would lie {moved_m:.0f} m away, more than chance explains"


# --------------------------------------------------------------------------------------- linearised, target by target


def blocks_of_network(network: Network, pose: FloatArray, weights: FloatArray, damping: Damping = "joint") -> Blocks:
    """Linearise a solved network at ``pose`` (3,) with ``weights`` (m,); labels are the numbers of the marks."""
    u = network.unknowns
    v_white, a_white = whitened(network, pose, damping)
    root = np.sqrt(weights)
    taken = network.blocks >= 0
    rows = np.where(taken[..., None], (a_white[:, :u] * root[:, None])[network.blocks], 0.0)
    residual = np.where(taken, (v_white * root)[network.blocks], 0.0)
    prior = np.zeros((u, u))
    if network.prior_counts and network.heading_prior_rad is not None:
        prior[2, 2] = 1.0 / network.heading_prior_rad[1] ** 2
    labels = tuple(str(mark) for mark in network.mark[network.blocks[:, 0]])
    return Blocks(rows, residual, prior, labels)


def blocks_of_fix(fix: Fix) -> Blocks:
    """Linearise a fix on the globe from its own record: observations, weights, marks; eq. (2.2).

    Unknowns are north, east, the heading where there are relative bearings, and the compass error that all true
    bearings share. The information that no observation explains, a prior of heading or compass, is what is left of the
    inverse cofactor matrix.

    Raises
    ------
    InputError : the fix does not carry its marks
    """
    marks = marks_of(fix)
    labels = tuple(dict.fromkeys(o.mark for o in fix.observations))
    place = {label: row for row, label in enumerate(labels)}
    north_east = _sight(fix, [marks[label] for label in labels])
    distance = np.maximum(np.hypot(*north_east.T), 1e-6)
    cos, sin = north_east.T / distance
    rows, residual = np.zeros((len(labels), _widest(fix), 4)), np.zeros((len(labels), _widest(fix)))
    filled = [0] * len(labels)
    for o in fix.observations:
        k = place[o.mark]
        unit = 1.0 if o.kind == "range" else math.radians(1.0)
        root = math.sqrt(o.weight) / (o.sigma * unit)
        across = (sin[k] / distance[k], -cos[k] / distance[k])
        turned = (-1.0, 0.0) if o.kind == "relative_bearing" else (0.0, -1.0)
        a = (-cos[k], -sin[k], 0.0, 0.0) if o.kind == "range" else (*across, *turned)
        rows[k, filled[k]] = root * np.array(a)
        residual[k, filled[k]] = root * o.residual * unit
        filled[k] += 1
    information = np.asarray(np.linalg.inv(fix.cofactor_matrix), np.float64)
    return _with_priors(rows, residual, labels, information)


def _with_priors(rows: FloatArray, residual: FloatArray, labels: tuple[str, ...], information: FloatArray) -> Blocks:
    """Drop the unknowns that are none, and add the priors that ``information`` (of the reported unknowns) speaks of.

    With the compass error eliminated from the normal matrix N, the information of position is N_pp - N_pc N_cp / (N_cc
    + its prior), and that of the heading exceeds what the bearings give by the heading's own prior.
    """
    u = len(information)
    flat = rows.reshape(-1, 4)
    normal = flat.T @ flat
    lost = float(np.trace(normal[:2, :2] - information[:2, :2]))
    borne = float(normal[:2, 3] @ normal[:2, 3])
    compass = lost > _NOTHING * float(np.trace(normal[:2, :2])) and borne > 0.0
    unknowns = [*range(u), 3] if compass else [*range(u)]
    prior = np.zeros((4, 4))
    if compass:
        prior[3, 3] = max(borne / lost - normal[3, 3], 0.0)
        normal = normal - np.outer(normal[:, 3], normal[3, :]) / (normal[3, 3] + prior[3, 3])
    if u == 3:
        rest = float(information[2, 2] - normal[2, 2])
        prior[2, 2] = rest if rest > _NOTHING * information[2, 2] else 0.0
    return Blocks(rows[:, :, unknowns], residual, prior[np.ix_(unknowns, unknowns)], labels)


def marks_of(fix: Fix) -> dict[str, Mark]:
    """Return the marks of a fix's observations by label.

    Raises
    ------
    InputError : the fix does not carry its marks
    """
    marks = {} if fix.epoch is None else {mark.label: mark for mark in fix.epoch.marks}
    if fix.epoch is not None and fix.association is not None:
        marks |= {fix.epoch.marks[m].label: fix.epoch.marks[m] for _, m in fix.association.pairs}
    missing = {o.mark for o in fix.observations} - marks.keys()
    if missing or not isinstance(fix.position, Position):
        raise InputError(f"the fix does not carry its marks on earth: {', '.join(sorted(missing)) or 'a plane frame'}")
    return marks


def _sight(fix: Fix, marks: list[Mark]) -> FloatArray:
    assert isinstance(fix.position, Position)
    plane = LocalPlane(fix.position)
    return plane.all_to_plane([m.position.lat_deg for m in marks], [m.position.lon_deg for m in marks])


def _widest(fix: Fix) -> int:
    counts: dict[str, int] = {}
    for o in fix.observations:
        counts[o.mark] = counts.get(o.mark, 0) + 1
    return max(counts.values(), default=1)


def _median_distance(fix: Fix) -> float:
    marks = marks_of(fix)
    used = [marks[label] for label in {o.mark for o in fix.observations if o.weight > 0.0}]
    return float(np.median(np.hypot(*_sight(fix, used).T))) if used else 1.0


def _check(false_alarm: float, missed: float) -> None:
    for name, value in (("probability_of_false_alarm", false_alarm), ("probability_of_missed_detection", missed)):
        if not 0.0 < value < 1.0:
            raise InputError(f"{name} must be within 0 .. 1, got {value!r}")
