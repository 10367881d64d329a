"""Step 5: pairs of tracks vote for poses through pairs of marks at the same distance - that also move alike.

As for one scan, with one gate more: the difference of the velocities of two tracks, turned by the heading of the vote,
must be that of the two marks. Own velocity cancels in it, so it needs to be known as little as own heading.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from navfix.association.pair_index import PairIndex
from navfix.association.scene import ComplexArray, Scene
from navfix.association.seeds import Plausible, Poses, candidates, radar_pairs
from navfix.association.window.field import WindowField
from navfix.association.window.knots import Knots, placed
from navfix.association.window.null import in_ship_velocity
from navfix.types import FloatArray, IntArray

BUCKET_BITS = 18  # at most: counts of more buckets do not stay in the cache
BUCKETS_A_CELL = 4  # full buckets that are looked into first, for each cell wanted: some hold several cells


def starts(field: WindowField, shape: Knots, plausible: Plausible | None = None) -> Knots:
    """Return the own motions that most pairs vote for: the null's shape laid at the poses of the fullest cells.

    With a hint, as many again from the votes that are ``plausible``: few common ships are lost among all votes.
    """
    scene, model = field.scene, field.model
    votes = [_votes_at(field, shape, knot) for knot in sorted({int(part * scene.knots) for part in model.voting_bins})]
    p, heading = np.concatenate([v[0] for v in votes]), np.concatenate([v[1] for v in votes])
    found = [_fullest(p, heading, field, shift) for shift in (0.0, 0.5)]
    if plausible is not None and len(p):
        near = np.flatnonzero(plausible(Poses(p, heading)))
        found += [_fullest(p[near], heading[near], field, shift) for shift in (0.0, 0.5)]
    poses = Poses.join(*found)
    return placed(shape, poses.p, poses.heading_rad, scene.gauge)


def _votes_at(field: WindowField, shape: Knots, knot: int) -> tuple[ComplexArray, FloatArray]:
    """Return position and heading of the gauge knot of every vote of the tracks that live at a knot."""
    scene, model = field.scene, field.model
    live = np.flatnonzero(scene.alive[:, knot])
    if len(live) < 2 or len(scene.paths.marks) < 2:
        return np.zeros(0, complex), np.zeros(0)
    flat = _at_knot(scene.flat, live, scene.rho[live, knot], scene.paths.z[:, knot])
    index = PairIndex.of(flat.z, 2.0 * flat.radar_range_m)
    pairs = radar_pairs(flat, index, field.shared).take(slice(0, model.pairs))
    seen = shape.p[0, knot] + np.exp(1j * shape.heading_rad[0, knot]) * flat.rho  # in the gauge knot's frame
    pair, entry = candidates(index, pairs, field.shared.pair_gate_sigma, model.votes_at_most)
    if len(pair) == 0:
        return np.zeros(0, complex), np.zeros(0)
    i, j = pairs.first[pair], pairs.second[pair]
    a, b = index.first[entry].astype(np.int64), index.second[entry].astype(np.int64)
    turn = (flat.z[b] - flat.z[a]) * np.conj(seen[j] - seen[i])
    turn /= np.abs(turn)
    fits = _moves_alike(field, live, shape, knot, (i, j, a, b), turn)
    turn, i, j, a, b = turn[fits], i[fits], j[fits], a[fits], b[fits]
    middle, lever = 0.5 * (flat.z[a] + flat.z[b]), turn * 0.5 * (seen[i] + seen[j])
    p = np.concatenate([middle - lever, middle + lever])  # either target may be either mark
    return p, np.angle(np.concatenate([turn, -turn]))


def _at_knot(flat: Scene, live: IntArray, rho: ComplexArray, z: ComplexArray) -> Scene:
    kept = flat.keeping(live, np.arange(len(z)))
    return replace(kept, rho=rho, range_m=np.abs(rho), bearing_rad=np.angle(rho), z=z)


def _moves_alike(
    field: WindowField, live: IntArray, shape: Knots, knot: int, who: tuple[IntArray, ...], turn: ComplexArray
) -> np.ndarray:
    """Tell which votes (v,) pass the gate of the difference velocity: it is the same with the marks exchanged."""
    scene, model = field.scene, field.model
    i, j, a, b = who
    if scene.knots == 1:
        return np.ones(len(i), dtype=bool)
    velocity = in_ship_velocity(field)[live]
    variance = (scene.white_m2.sum(axis=1) / np.maximum(scene.spread_s2, 1e-9) + 2.0 * model.slope_mps**2)[live]
    both = field.has_line[live][i] & field.has_line[live][j]
    v = scene.paths.v[:, knot]
    misfit = (v[b] - v[a]) - turn * (velocity[j] - velocity[i])
    limit = model.velocity_gate_sigma**2 * (variance[i] + variance[j])
    passed: np.ndarray = ~both | (np.abs(misfit) ** 2 <= limit)
    return passed


def _fullest(p: ComplexArray, heading_rad: FloatArray, field: WindowField, shift: float) -> Poses:
    """Return the mean pose of the fullest cells of one grid, shifted by a part of a cell; of equal ones the first.

    One scan hashes its cells, which is quicker, and takes equal ones in another order: hence not the same code.
    """
    if len(p) == 0:
        return Poses(p, heading_rad)
    headings = round(360.0 / field.shared.cell_deg)
    north, east = (_cells(axis / field.shared.cell_m + shift) for axis in (p.real, p.imag))
    turn = _cells(heading_rad * (headings / (2.0 * np.pi)) + shift)
    turn += np.where(turn < 0, headings, 0)
    north, east = north - north.min(), east - east.min()
    number = (turn * (int(east.max()) + 1) + east) * (int(north.max()) + 1) + north
    votes, size = _in_fullest(number, field.model.seeds)
    first = np.cumsum(size) - size
    mean_p = np.asarray(np.add.reduceat(p[votes], first) / size, dtype=np.complex128)
    return Poses(mean_p, np.angle(np.add.reduceat(np.exp(1j * heading_rad[votes]), first)))


def _in_fullest(cell: IntArray, most: int) -> tuple[IntArray, IntArray]:
    """Return the votes of the fullest cells, cell by cell, and how many each holds: fullest first, then in their order.

    Most cells hold a vote or two. Votes are counted in buckets by the last bits of their cell's number first: a cell
    holds no more than its bucket, so only the votes of full buckets are sorted.
    """
    bucket = cell & ((1 << min(len(cell).bit_length(), BUCKET_BITS)) - 1)
    in_bucket = np.bincount(bucket)
    of_vote = in_bucket[bucket]
    as_full = np.cumsum(np.bincount(in_bucket)[::-1])[::-1]  # how many buckets hold so many votes or more
    least = int(np.count_nonzero(as_full >= BUCKETS_A_CELL * most))
    while True:  # twice at most: what is reached is no more than the fullest cells of all reach
        votes, begins, size = _sorted_by_cell(cell, np.flatnonzero(of_vote >= least))
        top = _largest(size, most)
        reached = int(size[top[-1]]) if len(top) == most else 1
        if least <= reached:
            return np.concatenate([votes[begins[t] : begins[t] + size[t]] for t in top]), size[top]
        least = reached


def _sorted_by_cell(cell: IntArray, votes: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return votes in the order of their cells, where each cell begins, and how many votes it holds."""
    bits = len(cell).bit_length()
    ordered = np.sort((cell[votes] << bits) | votes)  # cell and vote as one number: quicker than argsort
    begins = np.flatnonzero(np.diff(ordered >> bits, prepend=-1))
    return ordered & ((1 << bits) - 1), begins, np.diff(begins, append=len(votes))


def _cells(value: FloatArray) -> IntArray:
    return np.floor(value, out=value).astype(np.int64)


def _largest(size: IntArray, most: int) -> IntArray:
    """Return where the largest sizes stand, at most so many, largest first and equal ones in their order."""
    least = np.partition(size, -most)[-most] if len(size) > most else 0
    enough = np.flatnonzero(size >= least)
    return enough[np.argsort(-size[enough], kind="stable")[:most]]
