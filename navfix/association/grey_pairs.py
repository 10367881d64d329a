"""Grey relational pairs of one instant: tracks over the minute before it, about own places that are known or fixed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from navfix.association.grey import GreyMatch, PolarTrack, match_tracks
from navfix.association.grey_tracks import SeenFrom, polar_tracks
from navfix.catalog import RadarModel
from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.picture.stitching import stitch
from navfix.types import Association, Epoch

WHOLE = 3.0  # the degree of a match whose ranges, bearings and speeds do not differ


def grey_association(
    epochs: Sequence[Epoch], poses: Sequence[SeenFrom], *, radar: RadarModel | str = "imo"
) -> Association:
    """Pair the targets and the marks of the last epoch by grey relation of their tracks.

    Every radar track finds its ship alone; of tracks that are taken for one ship the nearest keeps it. The degree is
    relative to the ships at hand and says nothing of a track without AIS: one that is near a ship is taken for it.

    Parameters
    ----------
    epochs : in the order of time, five and more, the newest one last
    poses : own place and the direction of the radar's zero mark at each of them

    Returns
    -------
    Association - ``probability`` is the degree as a share of its largest value, no probability of being right

    Raises
    ------
    InputError : no epoch, or not as many poses
    """
    if not epochs or len(epochs) != len(poses):
        raise InputError(f"grey association: as many own poses as epochs, got {len(poses)} for {len(epochs)}")
    stable = stitch(epochs, radar=radar).epochs
    tracks, ships = polar_tracks(stable, poses)
    targets = {target.label: index for index, target in enumerate(stable[-1].targets)}
    marks = {mark.label: index for index, mark in enumerate(stable[-1].marks)}
    seen = [track for track in tracks if track.label in targets]
    there = [ship for ship in ships if ship.label in marks]
    pairs, degrees = [], []
    for match in _one_to_one(match_tracks(seen, there, radar=radar), seen, there):
        pairs.append((targets[match.radar], marks[str(match.ais)]))
        degrees.append(min(match.degree / WHOLE, 1.0))
    return Association(
        pairs=np.array(pairs, np.int64).reshape(-1, 2), probability=np.array(degrees), method="grey_relational"
    )


def poses_between(epochs: Sequence[Epoch], known: Mapping[float, SeenFrom]) -> tuple[SeenFrom, ...]:
    """Return own pose at every epoch from those that are known at some times [POSIX s], on straight lines between.

    Before the first and after the last known pose it stays where it is.

    Raises
    ------
    InputError : no pose, or an epoch without a time
    """
    times = sorted(known)
    if not times or any(epoch.time_utc is None for epoch in epochs):
        raise InputError("own poses between epochs: one known pose at least, and the time of every epoch")
    plane = LocalPlane(known[times[-1]].position)
    north, east = np.array([plane.to_plane(known[t].position) for t in times]).T
    heading = np.unwrap(np.radians([known[t].heading_deg for t in times]))
    made = []
    for epoch in epochs:
        assert epoch.time_utc is not None
        here = [float(np.interp(epoch.time_utc.timestamp(), times, values)) for values in (north, east, heading)]
        made.append(SeenFrom(plane.to_position(here[0], here[1]), math.degrees(here[2]) % 360.0))
    return tuple(made)


def _one_to_one(
    matches: Sequence[GreyMatch], tracks: Sequence[PolarTrack], ships: Sequence[PolarTrack]
) -> list[GreyMatch]:
    """Return the matches with a ship, each ship once: degrees of two tracks do not compare, the nearer one keeps it."""
    place = {id(match): _newest(track) for match, track in zip(matches, tracks, strict=True)}
    ship = {one.label: _newest(one) for one in ships}
    matched = [match for match in matches if match.ais is not None]
    taken: dict[str, GreyMatch] = {}
    for match in sorted(matched, key=lambda m: abs(place[id(m)] - ship[str(m.ais)])):
        taken.setdefault(str(match.ais), match)
    return list(taken.values())


def _newest(track: PolarTrack) -> complex:
    """Return where a track ends, north + i east [m] from own ship."""
    angle = math.radians(float(track.bearing_deg[-1]))
    return complex(float(track.range_m[-1]) * math.cos(angle), float(track.range_m[-1]) * math.sin(angle))
