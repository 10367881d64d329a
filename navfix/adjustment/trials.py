"""Trial fixes: poses made from as few observations as a pose needs, for the robust start to choose from."""

from __future__ import annotations

import numpy as np

from navfix.adjustment.minimal import index_pairs, minimal_places
from navfix.adjustment.network import RANGE, RELATIVE_BEARING, Network
from navfix.adjustment.sights import predict
from navfix.types import FloatArray, IntArray
from navfix.units import wrap_pi

_TRIAL_BUDGET = 5_000  # trials x observations
_GRID_RINGS, _GRID_SPOKES = 14, 36


def trial_fixes(network: Network) -> FloatArray:
    """Return poses (t, 3), t >= 1, each made from as few observations as a pose needs."""
    table = _per_target(network)
    whole = table[(table[:, 0] >= 0) & (table[:, 1] >= 0)]
    poses = [_from_two_marks(network, whole), *_from_known_headings(network, table)]
    if len(whole) < len(table) or not any(len(found) for found in poses):
        at_most = max(_TRIAL_BUDGET // (4 * len(network.kind)), 60)
        poses += [with_heading(network, minimal_places(network, at_most)), _from_grid(network)]
    found = np.concatenate(poses)
    return found[np.all(np.isfinite(found), axis=1)]


def _per_target(network: Network) -> IntArray:
    """Return (g, 3): the first range, relative bearing and true bearing of each target, -1 where it has none."""
    table = np.full((len(network.blocks), 3), -1, np.int64)
    for column in network.blocks.T[::-1]:
        rows = np.flatnonzero(column >= 0)
        table[rows, network.kind[column[rows]]] = column[rows]
    return table


def _from_two_marks(network: Network, whole: IntArray) -> FloatArray:
    """Solve two targets with range and relative bearing: the baseline gives the heading, its middle the position."""
    if len(whole) < 2:
        return np.empty((0, 3))
    first, second = index_pairs(len(whole), max(_TRIAL_BUDGET // len(network.kind), 60))
    reach, bearing = network.value[whole[:, 0]], network.value[whole[:, 1]]
    seen = reach * np.exp(1j * bearing)  # north + i east, in the ship's axes
    place = _complex(network.mark_ne_m[network.mark[whole[:, 0]]])
    heading = np.angle(place[second] - place[first]) - np.angle(seen[second] - seen[first])
    own = 0.5 * (place[first] + place[second] - np.exp(1j * heading) * (seen[first] + seen[second]))
    return np.stack([own.real, own.imag, heading], axis=1)


def _from_known_headings(network: Network, table: IntArray) -> list[FloatArray]:
    """Solve single targets: range and true bearing, or range and relative bearing with the heading prior."""
    found = [_backwards(network, table[:, 0], table[:, 2], 0.0)]
    if network.prior_counts and network.heading_prior_rad is not None:
        heading = network.heading_prior_rad[0]
        places = _backwards(network, table[:, 0], table[:, 1], heading)
        found.append(np.column_stack([places, np.full(len(places), heading)]))
    found[0] = with_heading(network, found[0])
    return found


def _backwards(network: Network, ranges: IntArray, bearings: IntArray, heading_rad: float) -> FloatArray:
    both = (ranges >= 0) & (bearings >= 0)
    ranges, bearings = ranges[both], bearings[both]
    place = _complex(network.mark_ne_m[network.mark[ranges]])
    own = place - network.value[ranges] * np.exp(1j * (network.value[bearings] + heading_rad))
    return np.stack([own.real, own.imag], axis=1)


def _from_grid(network: Network) -> FloatArray:
    """Spread places in rings about the marks: for whatever the closed forms do not cover."""
    marks = network.mark_ne_m[np.unique(network.mark[network.mask])]
    centre = marks.mean(axis=0)
    ranges = network.value[(network.kind == RANGE) & network.mask]
    size = max(float(np.hypot(*(marks - centre).T).max()), float(ranges.max(initial=0.0)), 1.0)
    rings = size * np.geomspace(0.05, 4.0, _GRID_RINGS)
    spokes = 2.0 * np.pi * np.arange(_GRID_SPOKES) / _GRID_SPOKES
    own = (rings[:, None] * np.exp(1j * spokes)[None, :]).ravel() + _complex(centre[None, :])
    return with_heading(network, np.stack([own.real, own.imag], axis=1))


def with_heading(network: Network, places: FloatArray) -> FloatArray:
    """Add to each place (t, 2) the heading on which most relative bearings agree there; zero where it is known."""
    poses = np.column_stack([places, np.zeros(len(places))])
    relative = np.flatnonzero((network.kind == RELATIVE_BEARING) & network.mask)
    if not len(relative) or not len(places):
        return poses
    headings = np.asarray(wrap_pi(predict(network, poses)[:, relative] - network.value[relative]))
    candidates = headings[:, np.unique(np.linspace(0, len(relative) - 1, 9).astype(np.int64))]
    misfit = np.abs(wrap_pi(candidates[:, :, None] - headings[:, None, :]))
    best = np.argmin(np.median(misfit, axis=-1), axis=-1)
    poses[:, 2] = candidates[np.arange(len(places)), best]
    return poses


def _complex(north_east: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    return north_east[..., 0] + 1j * north_east[..., 1]
