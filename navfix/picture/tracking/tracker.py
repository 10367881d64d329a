"""The tracker: plots of one antenna turn in, reports of the confirmed targets out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from navfix.catalog import RadarModel, TrackingModel, radar_model, tracking_model
from navfix.nmea.plots import RadarPlot
from navfix.nmea.records import TargetReport
from navfix.picture.tracking import filter as cv
from navfix.picture.tracking.assignment import assign
from navfix.picture.tracking.clutter import ClutterMap
from navfix.picture.tracking.gating import distances
from navfix.picture.tracking.pieces import beside, clusters, joined
from navfix.picture.tracking.rotation import LEAST_TRACKS, Yaw, common_change_deg, orbit_rate_rad_s
from navfix.picture.tracking.tracks import Track, is_over, proves_a_ship, score_hit, score_miss
from navfix.types import BearingReference, FloatArray
from navfix.units import wrap_360

_ANOTHER_LOOK = 0.5  # of a turn between two plots of one track
_SAME_LOOK = 0.3  # of a turn between the pieces of one hull
_RANGE_GATE_SIGMA = 3.5
_LATE = 0.3  # of a turn that a plot may come late: own ship turns with the beam
_ORBIT_GAIN = 0.1  # in each turn


class PlotTracker:
    """Follows echoes from turn to turn.

    Parameters
    ----------
    turn_s : time of one antenna turn [s]
    reference : what the bearings of the plots count from; relative ones turn with own ship, which is estimated
    radar : sigma of one range [m] and one bearing [deg]
    model : constants of the tracker

    Notes
    -----
    Works in a plane about own ship that does not turn with her, section 11 of the theory.
    """

    def __init__(
        self,
        turn_s: float,
        *,
        reference: BearingReference = "relative",
        radar: RadarModel | str = "imo",
        model: TrackingModel | str = "plots",
    ) -> None:
        self._turn_s, self._reference = turn_s, reference
        self._radar, self._model = radar_model(radar), tracking_model(model)
        self._clutter = ClutterMap(self._model)
        self._yaw = Yaw()
        self._tracks: list[Track] = []
        self._numbers = 0

    def feed(self, plots: Sequence[RadarPlot]) -> list[TargetReport]:
        """Take the plots of one turn in the order of time; return a report of each confirmed target that it shows."""
        if not plots:
            return []
        self._clutter.begin_turn()
        self._drop_lost(plots[0].time_s)
        time_s = np.array([plot.time_s for plot in plots])
        if self._reference == "relative":
            self._follow_own_turn(plots, time_s)
        seen = [self._measured(plot) for plot in plots]
        updated, free = self._update(seen, time_s)
        self._start(seen, time_s, free)
        if self._reference == "relative":
            self._stop_orbiting()
        self._end_turn(float(time_s[-1]), updated)
        reports = [self._report(track, track.state) for track in updated if track.confirmed]
        return sorted([*reports, *self._coasted(float(time_s[-1]), updated)], key=lambda report: report.time_s or 0.0)

    def _measured(self, plot: RadarPlot) -> cv.Measured:
        bearing_deg = plot.bearing_deg + self._yaw.at(plot.time_s)
        range_sigma_m = float(self._radar.sigma_of_range_m(plot.range_m))
        return cv.measured(plot.range_m, bearing_deg, range_sigma_m, self._radar.bearing_sigma_deg)

    def _follow_own_turn(self, plots: Sequence[RadarPlot], time_s: FloatArray) -> None:
        """Find how own ship has turned since the last look, from all tracks at once."""
        middle_s = float(np.median(time_s))
        proven = [track for track in self._tracks if track.confirmed]
        tracks = proven if len(proven) >= LEAST_TRACKS else self._tracks
        ahead = [cv.predict(track.state, middle_s, self._model.relative_acceleration_mps2) for track in tracks]
        before = np.array([state.range_m for state in ahead]), np.array([state.bearing_deg for state in ahead])
        range_m = np.array([plot.range_m for plot in plots])
        plane_deg = np.array([plot.bearing_deg + self._yaw.at(plot.time_s) for plot in plots])
        gate_m = _RANGE_GATE_SIGMA * np.sqrt(
            np.array([np.trace(state.covariance[:2, :2]) / 2.0 for state in ahead])
            + self._radar.sigma_of_range_m(before[0]) ** 2
        )
        change_deg = common_change_deg(
            before, (range_m, plane_deg), gate_m=gate_m, widest_deg=self._model.widest_turn_deg
        )
        self._yaw.correct(middle_s, None if change_deg is None else -change_deg)

    def _stop_orbiting(self) -> None:
        """Give a part of what all targets seem to circle back to own ship's turn, where it belongs."""
        proven = [track.state for track in self._tracks if track.confirmed]
        mean = np.array([state.mean for state in proven]).reshape(-1, 4)
        rate_rad_s = _ORBIT_GAIN * orbit_rate_rad_s(mean[:, :2], mean[:, 2:])
        self._yaw.slow_down(math.degrees(rate_rad_s))
        for track in self._tracks:
            north_m, east_m = track.state.mean[:2]
            slower = track.state.mean - rate_rad_s * np.array([0.0, 0.0, -east_m, north_m])
            track.state = replace(track.state, mean=slower)

    def _update(self, seen: list[cv.Measured], time_s: FloatArray) -> tuple[list[Track], set[int]]:
        """Give the plots to the tracks, confirmed ones first; return the tracks that were seen and the plots left."""
        free, updated = set(range(len(seen))), []
        # A target where the turn is cut may be seen twice in one turn: hence a second round.
        for confirmed in (True, False, True, False):
            tracks = [track for track in self._tracks if track.confirmed is confirmed]
            for track in self._assign(tracks, seen, time_s, free):
                if track not in updated:
                    updated.append(track)
        return updated, free

    def _assign(self, tracks: list[Track], seen: list[cv.Measured], time_s: FloatArray, free: set[int]) -> list[Track]:
        """Assign free plots to tracks and update these; plots used, and pieces of the same hull, leave ``free``."""
        left = np.array(sorted(free), dtype=np.intp)
        if not tracks or not len(left):
            return []
        found = distances(
            [track.state for track in tracks],
            [seen[index] for index in left],
            time_s[left],
            self._model.relative_acceleration_mps2,
        )
        age_s = time_s[left][None, :] - np.array([track.state.time_s for track in tracks])[:, None]
        pairs = assign(found, age_s > _ANOTHER_LOOK * self._turn_s, self._model.gate_chi2)
        free.difference_update(int(left[plot]) for _, plot in pairs)
        for row, column in pairs:
            track, plot = tracks[row], int(left[column])
            clutter = self._clutter.per_m2(seen[plot].position)
            score_hit(track, float(found.log_likelihood[row, column]), clutter, self._model)
            pieces = self._pieces(plot, seen, time_s, free)
            free.difference_update(pieces)
            ahead = cv.predict(track.state, float(time_s[plot]), self._model.relative_acceleration_mps2)
            track.state, track.coasted = cv.update(ahead, joined(seen, [plot, *pieces])), 0
            if not track.confirmed:
                track.plots.append(seen[plot].position)
        return [tracks[row] for row, _ in pairs]

    def _pieces(self, plot: int, seen: list[cv.Measured], time_s: FloatArray, free: set[int]) -> list[int]:
        others = [i for i in sorted(free) if abs(time_s[i] - time_s[plot]) <= _SAME_LOOK * self._turn_s]
        places = np.array([seen[index].position for index in others]).reshape(-1, 2)
        near = beside(
            seen[plot].position,
            places,
            piece_m=self._model.piece_m,
            bearing_sigma_deg=self._radar.bearing_sigma_deg,
        )
        return [index for index, close in zip(others, near, strict=True) if close]

    def _start(self, seen: list[cv.Measured], time_s: FloatArray, free: set[int]) -> None:
        """Begin a tentative track with each plot, or group of pieces, that no track explains."""
        groups = clusters(
            seen,
            time_s,
            np.array(sorted(free), dtype=np.intp),
            piece_m=self._model.piece_m,
            bearing_sigma_deg=self._radar.bearing_sigma_deg,
            near_s=_SAME_LOOK * self._turn_s,
        )
        for group in groups:
            state = cv.start(float(time_s[group[0]]), joined(seen, group), self._model.relative_speed_mps)
            self._tracks.append(Track(state, plots=[state.mean[:2]]))

    def _end_turn(self, now_s: float, updated: list[Track]) -> None:
        """Confirm what is proven, count the misses, drop the younger of two tracks of one hull."""
        for track in self._tracks:
            if track not in updated and now_s - track.state.time_s > _ANOTHER_LOOK * self._turn_s:
                score_miss(track, self._model)
        confirmed = sorted((track for track in updated if track.confirmed), key=lambda track: track.number)
        for track in [track for track in updated if not track.confirmed and proves_a_ship(track, self._model)]:
            if self._beside_any(track, confirmed):
                continue  # another piece of a hull that has its number
            self._numbers += 1
            track.number = self._numbers
            track.plots.clear()
            confirmed.append(track)
        for index, track in enumerate(confirmed):
            twin = self._beside_any(track, confirmed[:index])
            track.twin_turns = track.twin_turns + 1 if twin else max(track.twin_turns - 1, 0)
        self._tracks = [track for track in self._tracks if track.twin_turns < self._model.twin_turns]

    def _drop_lost(self, now_s: float) -> None:
        for track in [track for track in self._tracks if is_over(track, now_s, self._turn_s, self._model)]:
            self._clutter.add(track.plots)
            self._tracks.remove(track)

    def _beside_any(self, track: Track, others: Sequence[Track]) -> bool:
        near = beside(
            track.state.mean[:2],
            np.array([other.state.mean[:2] for other in others]).reshape(-1, 2),
            piece_m=self._model.piece_m,
            bearing_sigma_deg=self._radar.bearing_sigma_deg,
        )
        return bool(near.any())

    def _coasted(self, now_s: float, updated: list[Track]) -> list[TargetReport]:
        """Return where confirmed targets that this turn missed should be, for ``coast_turns`` after their last plot."""
        reports = []
        for track in self._tracks:
            if not track.confirmed or track in updated:
                continue
            # The beam has passed it so often since, and its plot would be here even if it came a little late.
            turns = math.floor((now_s - track.state.time_s) / self._turn_s - _LATE)
            if track.coasted < turns <= self._model.coast_turns:
                track.coasted = turns
                due_s = track.state.time_s + turns * self._turn_s
                ahead = cv.predict(track.state, due_s, self._model.relative_acceleration_mps2)
                reports.append(self._report(track, ahead))
        return reports

    def _report(self, track: Track, state: cv.State) -> TargetReport:
        relative = self._reference == "relative"
        yaw_deg = self._yaw.at(state.time_s)
        course_deg = float(np.degrees(np.arctan2(state.mean[3], state.mean[2]))) - yaw_deg
        return TargetReport(
            time_s=state.time_s,
            number=track.number,
            range_m=state.range_m,
            bearing_deg=wrap_360(state.bearing_deg - yaw_deg),
            bearing_reference=self._reference,
            speed_mps=state.speed_mps if relative else None,
            course_deg=wrap_360(course_deg) if relative else None,
            course_reference="relative" if relative else None,
            status="T" if track.hits >= self._model.settle_hits else "Q",
        )
