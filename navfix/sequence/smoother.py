"""A whole log forward and backward: every epoch's pose from all that was seen before and after it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from navfix import catalog
from navfix.adjustment.window import Solved, solve_window
from navfix.adjustment.window.reading import times_of
from navfix.adjustment.window.record import fix_of
from navfix.catalog import AdjustmentModel, OwnMotionModel, RadarModel, own_motion_model, radar_model
from navfix.errors import InputError, NoFix
from navfix.geodesy import LocalPlane
from navfix.kernels import Kernel
from navfix.sequence.chain import consistent
from navfix.types import Epoch, Fix, FloatArray, Position
from navfix.units import wrap_180

Labels = dict[str, str]
_MAJORITY = 0.5  # of the fixes in a chunk that must agree


def smooth(
    epochs: Sequence[Epoch],
    fixes: Sequence[Fix | None],
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    model: AdjustmentModel | str = "window",
    motion: OwnMotionModel | str = "own_ship",
) -> tuple[Fix | None, ...]:
    """Smooth a log: one fix for each epoch from all accepted pairs of the minutes about it.

    The log is cut into overlapping chunks; each is adjusted as one network, and every epoch takes its pose from the
    chunk in which it lies farthest from the ends. A target that two fixes took for the same ship is that ship in the
    scans between them too. Fixes that no ship can have made one after the other are left out beforehand.

    Parameters
    ----------
    epochs : of the whole log; where the clock is set back another passage begins
    fixes : what was accepted at each epoch, None where nothing was; only its pairs, position and covariance count

    Returns
    -------
    a fix for each epoch, None far from every accepted one, or where the fixes of a chunk contradict each other

    Raises
    ------
    InputError : epochs without a time, not as many fixes as epochs

    References
    ----------
    Theory 10, eq. (10.11).
    """
    radar, kernel, motion = radar_model(radar), catalog.kernel(kernel), own_motion_model(motion)
    if len(fixes) != len(epochs):
        raise InputError(f"{len(epochs)} epochs need as many fixes (None where there is none), got {len(fixes)}")
    result: list[Fix | None] = [None] * len(epochs)
    for section in _sections(epochs):
        members, given = epochs[section], fixes[section]
        time_s = times_of(members)
        for chunk, inner in _chunks(time_s, motion):
            part = range(chunk.start, chunk.stop)
            for index, fix in _smoothed(members, given, time_s, part, radar, kernel, model, motion):
                if inner.start <= index < inner.stop:
                    result[section.start + index] = fix
    return tuple(result)


def _sections(epochs: Sequence[Epoch]) -> Iterator[slice]:
    """Cut where the clock was set back, as after a restart."""
    first = 0
    for number in range(1, len(epochs) + 1):
        if number == len(epochs) or _set_back(epochs[number - 1], epochs[number]):
            yield slice(first, number)
            first = number


def _set_back(before: Epoch, after: Epoch) -> bool:
    if before.time_utc is None or after.time_utc is None:
        return False
    return (after.time_utc - before.time_utc).total_seconds() < 0.0


def _chunks(time_s: FloatArray, motion: OwnMotionModel) -> Iterator[tuple[slice, slice]]:
    """Yield (epochs of a chunk, those of them that it answers for): together all epochs, each once."""
    first, count = 0, len(time_s)
    answered = 0
    while answered < count:
        last = int(np.searchsorted(time_s, time_s[first] + motion.chunk_s, side="right"))
        end = last if last >= count else int(np.searchsorted(time_s, time_s[last - 1] - motion.margin_s, side="right"))
        end = max(end, answered + 1)
        yield slice(first, last), slice(answered, end)
        answered = end
        if answered < count:
            first = int(np.searchsorted(time_s, time_s[answered] - motion.margin_s))


def _smoothed(
    epochs: Sequence[Epoch],
    fixes: Sequence[Fix | None],
    time_s: FloatArray,
    part: range,
    radar: RadarModel,
    kernel: Kernel,
    model: AdjustmentModel | str,
    motion: OwnMotionModel,
) -> Iterator[tuple[int, Fix]]:
    """Yield (epoch, its fix) of one chunk; nothing where it cannot be solved."""
    inside = [fixes[i] for i in part]
    chain = consistent(inside, time_s[part.start : part.stop], motion)
    given = sum(fix is not None for fix in inside)
    if not chain or len(chain) <= _MAJORITY * given:
        return
    for stretch in _stretches(chain, time_s[part.start : part.stop], motion.longest_bridge_s):
        pairs = _carried(epochs, fixes, part, stretch)
        lower, upper = _reach(stretch, time_s[part.start : part.stop], motion.longest_bridge_s)
        members = list(epochs[part.start + lower : part.start + upper])
        own = pairs[lower:upper]
        start = _between(members, {i - lower: fixes[part.start + i] for i in stretch})
        try:
            solved = solve_window(members, own, start=start, radar=radar, kernel=kernel, model=model, solver="dense")
        except NoFix:
            continue
        for index, fix in enumerate(_fixes(members, solved, kernel)):
            yield part.start + lower + index, fix


def _stretches(chain: list[int], time_s: FloatArray, gap_s: float) -> list[list[int]]:
    """Cut a chain where more than twice the bridge lies between two fixes: nothing holds the two sides together."""
    cuts = [[chain[0]]]
    for before, after in pairwise(chain):
        if time_s[after] - time_s[before] > 2.0 * gap_s:
            cuts.append([])
        cuts[-1].append(after)
    return cuts


def _reach(stretch: list[int], time_s: FloatArray, bridge_s: float) -> tuple[int, int]:
    """Return the first and the last but one epoch within the bridge of a stretch."""
    lower = int(np.searchsorted(time_s, time_s[stretch[0]] - bridge_s))
    upper = int(np.searchsorted(time_s, time_s[stretch[-1]] + bridge_s, side="right"))
    return lower, upper


def _carried(epochs: Sequence[Epoch], fixes: Sequence[Fix | None], part: range, stretch: list[int]) -> list[Labels]:
    """Return the pairs of each epoch of a chunk; between two fixes that agree on a target it is that ship too."""
    pairs: list[Labels] = [{} for _ in part]
    last: dict[str, tuple[int, str]] = {}
    for i in stretch:
        fix = fixes[part.start + i]
        assert fix is not None
        for target, mark in _labels(fix).items():
            pairs[i][target] = mark
            known = last.get(target)
            if known is not None and known[1] == mark:
                for between in range(known[0] + 1, i):
                    if target in {t.label for t in epochs[part.start + between].targets}:
                        pairs[between].setdefault(target, mark)
            last[target] = (i, mark)
    return pairs


def _labels(fix: Fix) -> Labels:
    if fix.association is None or fix.epoch is None:
        return {}
    return {fix.epoch.targets[t].label: fix.epoch.marks[m].label for t, m in fix.association.pairs}


def _between(epochs: Sequence[Epoch], known: dict[int, Fix | None]) -> list[tuple[Position, float | None]]:
    """Return a start for every epoch: the fixes, and straight lines between them."""
    time_s = times_of(epochs)
    at = np.array(sorted(known))
    fixes = [fix for i in at.tolist() if (fix := known[i]) is not None]
    places = [fix.position for fix in fixes if isinstance(fix.position, Position)]
    plane = LocalPlane(places[-1])
    ne_m = plane.all_to_plane([p.lat_deg for p in places], [p.lon_deg for p in places])
    headings = _headings(epochs, at, fixes)
    turned = np.cumsum([headings[0], *(float(wrap_180(b - a)) for a, b in pairwise(headings))])
    north, east, heading = (np.interp(time_s, time_s[at], column) for column in (ne_m[:, 0], ne_m[:, 1], turned))
    return [(plane.to_position(float(n), float(e)), float(h)) for n, e, h in zip(north, east, heading, strict=True)]


def _headings(epochs: Sequence[Epoch], at: np.ndarray, fixes: Sequence[Fix]) -> list[float]:
    """Return the headings of the fixes [deg]; where bearings are true that of the gyro, or north."""
    found = []
    for i, fix in zip(at.tolist(), fixes, strict=True):
        hint = epochs[i].heading_hint
        told = 0.0 if hint is None else hint.heading_deg
        found.append(told if fix.heading_deg is None else fix.heading_deg)
    return found


def _fixes(epochs: Sequence[Epoch], solved: Solved, kernel: Kernel) -> Iterator[Fix]:
    for index in range(len(epochs)):
        block = slice(3 * index, 3 * index + 3)
        cofactor = solved.found.cofactor[block, block]
        fix = fix_of(epochs, solved.sightings, solved.window, solved.found, cofactor, kernel, solved.solver, at=index)
        yield replace(fix, start="smoother")
