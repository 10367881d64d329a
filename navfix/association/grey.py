"""Grey relational association of radar tracks with AIS tracks about a known pose (source 001), whole and as printed.

What is mended: the reach counts the bearing error, bearings are unwrapped and lifted before the class-ratio test, all
differences zero (0/0) is degree 1, a constant series takes the limit of its model.

References
----------
[1] Dong, AARFS system level design (2008), eq. 1.1 to 1.28.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.catalog import RadarModel, TrackAssociationModel, radar_model, track_association_model
from navfix.picture.motion.grey_model import closed_form, longest_admissible
from navfix.types import FloatArray
from navfix.units import KNOT_MPS, wrap_180

_INTERVALS_S = ((0.2 * KNOT_MPS, 180.0), (14.0 * KNOT_MPS, 10.0), (23.0 * KNOT_MPS, 6.0))
_FASTEST_INTERVAL_S = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class PolarTrack:
    """A track as seen from own ship: times [POSIX s] rising, range [m], true bearing [deg], ground speed [m/s] (n,)."""

    label: str
    time_s: FloatArray
    range_m: FloatArray
    bearing_deg: FloatArray
    speed_mps: FloatArray

    def __len__(self) -> int:
        return len(self.time_s)

    def part(self, start: int, stop: int) -> PolarTrack:
        """Return the points start .. stop - 1."""
        cut = slice(start, stop)
        return PolarTrack(self.label, self.time_s[cut], self.range_m[cut], self.bearing_deg[cut], self.speed_mps[cut])


@dataclass(frozen=True, slots=True)
class GreyMatch:
    """A radar track and the AIS track that it is taken for; ``degree`` 0 .. 3 as [1] eq. (1.27), of the next best too.

    ``ais`` None: no AIS track came within reach in any section.
    """

    radar: str
    ais: str | None
    degree: float
    next_best: float
    sections: int


def match_track(
    track: PolarTrack,
    candidates: Sequence[PolarTrack],
    *,
    radar: RadarModel | str = "imo",
    model: TrackAssociationModel | str = "grey",
) -> GreyMatch:
    """Find the AIS track of one radar track: TRACK_MATCH of the source.

    Section by section the degrees of [1] eq. (1.25) are summed with the sections' lengths as weights, and the largest
    sum wins, [1] eq. (1.27) and (1.28).
    """
    measures, constants = radar_model(radar), track_association_model(model)
    totals = np.zeros(len(candidates))
    start = sections = 0
    while len(track) - start >= constants.least_points:
        rest = track.part(start, len(track))
        length = section_length(_lifted(rest, constants), constants.least_points)
        section = rest.part(0, length)
        totals += length / len(track) * _section_degrees(section, candidates, measures, constants)
        start, sections = start + length, sections + 1
    order = np.argsort(totals)[::-1]
    best = float(totals[order[0]]) if len(order) else 0.0
    second = float(totals[order[1]]) if len(order) > 1 else 0.0
    return GreyMatch(track.label, candidates[int(order[0])].label if best > 0.0 else None, best, second, sections)


def match_tracks(
    tracks: Sequence[PolarTrack],
    candidates: Sequence[PolarTrack],
    *,
    radar: RadarModel | str = "imo",
    model: TrackAssociationModel | str = "grey",
) -> tuple[GreyMatch, ...]:
    """Match every radar track alone, as the source does: two of them may be taken for one AIS track."""
    return tuple(match_track(track, candidates, radar=radar, model=model) for track in tracks)


def section_length(series: Sequence[FloatArray], least: int) -> int:
    """Return how many of the first points one grey model holds for, [1] eq. (1.17) for all series together.

    Never below ``least`` where there are so many points: shorter series have no model.
    """
    return longest_admissible(series, least=least) or min(least, *(len(values) for values in series))


def candidate_radius_m(speed_mps: float, range_m: float, radar: RadarModel, model: TrackAssociationModel) -> float:
    """Return the reach about the start of a section, [1] eq. (1.1), with the bearing error added.

    As printed it lacks the bearing's error, by far the largest one of a distant target.
    """
    across_m = range_m * np.radians(radar.bearing_sigma_deg)
    radar_m = float(np.hypot(radar.sigma_of_range_m(range_m), across_m))
    return speed_mps * report_interval_s(speed_mps) + model.reach_sigma * (radar_m + model.ais_sigma_m)


def report_interval_s(speed_mps: float) -> float:
    """Return how often a class A ship of this speed reports [s] (ITU-R M.1371-5, without course changes)."""
    return next((interval for below, interval in _INTERVALS_S if speed_mps <= below), _FASTEST_INTERVAL_S)


def relational_degrees(differences: Sequence[FloatArray], resolution: float) -> FloatArray:
    """Return the grey relational degree of each candidate, [1] eq. (1.18) and (1.19).

    Parameters
    ----------
    differences : for each candidate the absolute differences to the reference, of any length each
    resolution : rho, 0 < rho < 1

    All differences zero is degree 1: the printed 0/0 in its limit.
    """
    if not len(differences):
        return np.zeros(0)
    least = min(float(d.min()) for d in differences)
    most = max(float(d.max()) for d in differences)
    if resolution * most == 0.0:  # also what underflows
        return np.ones(len(differences))
    return np.array([float(np.mean((least + resolution * most) / (d + resolution * most))) for d in differences])


def lagrange_weights(degrees: FloatArray) -> tuple[FloatArray, float]:
    """Return the weights u (3,) that make sum u^2 / degree least with sum u = 1, and that least sum.

    u_i = degree_i / sum, and the least is 1 / sum: nearest is where the sum of the degrees is largest, [1] eq. (1.21)
    to (1.26).
    """
    total = float(np.sum(degrees))
    return degrees / total, 1.0 / total


def _section_degrees(
    section: PolarTrack, candidates: Sequence[PolarTrack], radar: RadarModel, model: TrackAssociationModel
) -> FloatArray:
    """Return [1] eq. (1.25) of each candidate in one section, 0 for those that are not within reach."""
    reach_m = candidate_radius_m(float(section.speed_mps[0]), float(section.range_m[0]), radar, model)
    found: list[int] = []
    differences: list[list[FloatArray]] = []
    for index, candidate in enumerate(candidates):
        if _start_gap_m(section, candidate) <= reach_m:
            apart = _differences(section, candidate, model)
            if apart is not None:
                found.append(index)
                differences.append(apart)
    degrees = np.zeros(len(candidates))
    for quantity in range(3):
        degrees[found] += relational_degrees([apart[quantity] for apart in differences], model.resolution)
    return degrees


def _start_gap_m(section: PolarTrack, candidate: PolarTrack) -> float:
    """Return how far a candidate is from the section's first point at its time [m], [1] eq. (1.2), after alignment."""
    at_s = section.time_s[0]
    if not candidate.time_s[0] - 15.0 <= at_s <= candidate.time_s[-1] + 15.0:
        return float("inf")
    place = _places(candidate)
    here = complex(np.interp(at_s, candidate.time_s, place.real), np.interp(at_s, candidate.time_s, place.imag))
    return float(abs(here - _places(section)[0]))


def _differences(section: PolarTrack, candidate: PolarTrack, model: TrackAssociationModel) -> list[FloatArray] | None:
    """Return the absolute differences of range, bearing and speed at the candidate's instants within the section.

    The radar's series are brought to these instants by one grey model each; None where there is no such instant.
    """
    inside = (candidate.time_s >= section.time_s[0]) & (candidate.time_s <= section.time_s[-1])
    if not inside.any():
        return None
    step_s = float(np.median(np.diff(section.time_s)))
    steps = (candidate.time_s[inside] - section.time_s[0]) / step_s
    grid_s = section.time_s[0] + step_s * np.arange(int(np.ptp(section.time_s) / step_s) + 1)
    aligned = [
        closed_form(np.interp(grid_s, section.time_s, values)).value(steps) for values in _lifted(section, model)
    ]
    turned = wrap_180(aligned[1] - model.bearing_lift_deg - candidate.bearing_deg[inside])
    return [
        np.abs(aligned[0] - candidate.range_m[inside]),
        np.abs(turned),
        np.abs(aligned[2] - model.speed_lift_mps - candidate.speed_mps[inside]),
    ]


def _lifted(track: PolarTrack, model: TrackAssociationModel) -> list[FloatArray]:
    """Return range, bearing and speed as the class-ratio test needs them: no jump at 360 deg, no values near zero."""
    bearing_deg = np.degrees(np.unwrap(np.radians(track.bearing_deg)))
    turns_deg = 360.0 * np.ceil(max(0.0, -float(bearing_deg.min())) / 360.0)
    return [
        track.range_m,
        bearing_deg + turns_deg + model.bearing_lift_deg,
        track.speed_mps + model.speed_lift_mps,
    ]


def _places(track: PolarTrack) -> np.ndarray:
    return track.range_m * np.exp(1j * np.radians(track.bearing_deg))
