"""The tracker for raw plots: parts by hand, whole scenes against their truth."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from navfix.catalog import radar_model, tracking_model
from navfix.nmea.plots import RadarPlot
from navfix.nmea.records import AisStatic, OtherMessage, TargetReport
from navfix.picture.tracking import PlotTracker, track_plots, turn_length_s, turns, with_tracked_plots
from navfix.picture.tracking import filter as cv
from navfix.picture.tracking.assignment import assign
from navfix.picture.tracking.gating import Distances, distances
from navfix.picture.tracking.pieces import beside
from navfix.picture.tracking.rotation import Yaw, common_change_deg, orbit_rate_rad_s, weighted_median
from navfix.units import wrap_180
from tests.plot_scenes import PlotScene, figures, plot_scene

TURN_S = 2.5


def plots_of(
    echoes: list[tuple[float, float, float, float]], turns_count: int, *, yaw_deg_per_turn: float = 0.0, seed: int = 3
) -> list[RadarPlot]:
    """Return noisy plots of echoes (north m, east m, north m/s, east m/s relative to own ship), turn by turn."""
    rng = np.random.default_rng(seed)
    found = []
    for turn in range(turns_count):
        for north, east, north_mps, east_mps in echoes:
            sweep_s = TURN_S * turn
            for _ in range(2):  # where the echo is when the beam passes
                x, y = north + north_mps * sweep_s, east + east_mps * sweep_s
                bearing = math.degrees(math.atan2(y, x)) - yaw_deg_per_turn * sweep_s / TURN_S
                sweep_s = TURN_S * (turn + bearing / 360.0)
            noisy_m, noisy_deg = math.hypot(x, y) + rng.normal(0, 15), bearing + rng.normal(0, 0.4)
            found.append(RadarPlot(1000.0 + sweep_s, noisy_m, noisy_deg % 360.0))
    return sorted(found, key=lambda plot: plot.time_s)


ECHOES = [
    (3000.0, 1000.0, -4.0, 0.0),
    (-2500.0, 2000.0, -4.0, 3.0),
    (1000.0, -4000.0, -8.0, 0.0),
    (-900.0, -2500.0, 0, 5),
]


# ------------------------------------------------------------------------------------------------- parts


def test_the_turn_is_read_from_the_plots_of_a_sweep_and_of_images() -> None:
    sweep = plots_of(ECHOES, 30)
    assert turn_length_s(sweep, 9.0) == pytest.approx(TURN_S, rel=0.01)
    images = [replace(p, time_s=1.7 * round((p.time_s - 1000.0) // TURN_S)) for p in sweep]
    assert turn_length_s(images, 9.0) == pytest.approx(1.7, rel=0.01)
    assert turn_length_s(sweep[:5], 9.0) == 9.0


def test_the_turns_hold_every_plot_once_and_last_no_longer_than_a_turn() -> None:
    plots = plots_of(ECHOES, 30)
    found = list(turns(plots, TURN_S))
    assert [plot for turn in found for plot in turn] == plots
    assert all(turn[-1].time_s - turn[0].time_s < TURN_S for turn in found)


def test_the_weighted_median_has_half_of_the_weight_below() -> None:
    assert weighted_median(np.array([5.0, 1.0, 3.0]), np.array([1.0, 1.0, 1.0])) == 3.0
    assert weighted_median(np.array([5.0, 1.0, 3.0]), np.array([10.0, 1.0, 1.0])) == 5.0


@pytest.mark.parametrize("turned_deg", [0.0, 7.0, -22.0])
def test_the_change_that_all_bearings_share_is_found_among_clutter(turned_deg: float) -> None:
    rng = np.random.default_rng(5)
    range_m, bearing_deg = rng.uniform(500, 8000, 12), rng.uniform(0, 360, 12)
    clutter = rng.uniform(500, 8000, 30), rng.uniform(0, 360, 30)
    now = (
        np.concatenate([range_m[2:] + rng.normal(0, 20, 10), clutter[0]]),
        np.concatenate([bearing_deg[2:] + turned_deg + rng.normal(0, 0.5, 10), clutter[1]]) % 360.0,
    )
    change = common_change_deg((range_m, bearing_deg), now, gate_m=np.full(12, 80.0), widest_deg=30.0)
    assert change == pytest.approx(turned_deg, abs=0.6)


def test_two_tracks_prove_no_turn() -> None:
    two = np.array([1000.0, 2000.0]), np.array([10.0, 50.0])
    turned = two[0], two[1] + 9.0
    assert common_change_deg(two, turned, gate_m=np.full(2, 50.0), widest_deg=30.0) is None
    nothing = np.empty(0), np.empty(0)
    assert common_change_deg(nothing, two, gate_m=np.empty(0), widest_deg=30.0) is None


def test_a_turn_that_is_not_seen_any_more_fades() -> None:
    yaw = Yaw()
    for look in range(10):
        yaw.correct(2.5 * look, 0.0 if look == 0 else 5.0 - (yaw.at(2.5 * look) - yaw.at(2.5 * (look - 1))))
    assert yaw.at(22.5 + 2.5) - yaw.at(22.5) == pytest.approx(5.0, abs=0.1)
    for look in range(10, 20):
        yaw.correct(2.5 * look, None)
    assert yaw.at(50.0) - yaw.at(47.5) < 0.02


def test_the_filter_agrees_with_least_squares_when_nothing_accelerates() -> None:
    rng = np.random.default_rng(2)
    times = np.arange(8) * TURN_S
    places = np.array([1000.0, -500.0]) + times[:, None] * np.array([3.0, -2.0]) + rng.normal(0, 20, (8, 2))
    spread = 400.0 * np.eye(2)
    state = cv.start(0.0, cv.Measured(places[0], spread), 1e4)
    for time_s, place in zip(times[1:], places[1:], strict=True):
        state = cv.update(cv.predict(state, float(time_s), 0.0), cv.Measured(place, spread))
    design = np.stack([np.ones(8), times - times[-1]], axis=1)
    line, *_ = np.linalg.lstsq(design, places, rcond=None)
    assert state.mean == pytest.approx(np.concatenate([line[0], line[1]]), abs=1e-2)
    cofactor = 400.0 * np.linalg.inv(design.T @ design)
    assert state.covariance[0, 0] == pytest.approx(cofactor[0, 0], rel=1e-3)
    assert state.covariance[2, 2] == pytest.approx(cofactor[1, 1], rel=1e-3)


def test_the_measured_covariance_is_that_of_range_and_bearing() -> None:
    seen = cv.measured(5000.0, 90.0, 20.0, 1.0)
    assert seen.position == pytest.approx([0.0, 5000.0], abs=1e-6)
    assert seen.covariance == pytest.approx(np.diag([(5000.0 * math.radians(1.0)) ** 2, 400.0]))


def test_distances_at_once_are_those_of_each_track_alone() -> None:
    states = [
        cv.predict(cv.start(0.0, cv.measured(3000.0, b, 25.0, 1.0), 8.0), 2.0, 0.15) for b in (20.0, 100.0, 300.0)
    ]
    seen = [cv.measured(3050.0, b, 25.0, 1.0) for b in (21.0, 99.0)]
    time_s = np.array([4.0, 5.0])
    found = distances(states, seen, time_s, 0.15)
    for i, state in enumerate(states):
        for j, plot in enumerate(seen):
            ahead = cv.predict(state, float(time_s[j]), 0.15)
            miss, total = plot.position - ahead.mean[:2], ahead.covariance[:2, :2] + plot.covariance
            assert found.chi2[i, j] == pytest.approx(miss @ np.linalg.inv(total) @ miss, rel=1e-9)
            assert found.log_det[i, j] == pytest.approx(np.linalg.slogdet(total)[1], rel=1e-9)


def test_the_assignment_prefers_a_missed_track_to_two_bad_pairs() -> None:
    found = Distances(np.array([[0.5, 10.0], [9.0, 99.0]]), np.zeros((2, 2)))
    assert assign(found, np.ones((2, 2), dtype=bool), 11.8) == [(0, 0)]
    assert assign(found, np.zeros((2, 2), dtype=bool), 11.8) == []


def test_pieces_lie_side_by_side_and_farther_apart_across_the_beam() -> None:
    others = np.array([[8000.0, 120.0], [8100.0, 0.0], [8040.0, 30.0]])
    near = beside(np.array([8000.0, 0.0]), others, piece_m=60.0, bearing_sigma_deg=1.0)
    assert near.tolist() == [True, False, True]


# ------------------------------------------------------------------------------------------------- scenes


def test_every_echo_becomes_one_target_whose_number_stays() -> None:
    reports = track_plots(plots_of(ECHOES, 40))
    assert {report.number for report in reports} == {1, 2, 3, 4}
    assert all(count >= 36 for count in Counter(report.number for report in reports).values())
    assert [report.time_s for report in reports] == sorted(report.time_s or 0.0 for report in reports)


def test_the_relative_velocity_of_a_target_is_told_from_the_bow() -> None:
    rng = np.random.default_rng(4)
    still = [(*rng.uniform(-5000, 5000, 2), -6.0, 0.0) for _ in range(12)]
    last = {report.number: report for report in track_plots(plots_of(still, 100))}
    assert {report.course_reference for report in last.values()} == {"relative"}
    assert np.median([report.speed_mps for report in last.values()]) == pytest.approx(6.0, abs=1.0)
    assert abs(wrap_180(np.median([report.course_deg for report in last.values()]) - 180.0)) < 10.0


def test_what_circles_about_own_ship_is_told_from_what_moves() -> None:
    rng = np.random.default_rng(4)
    position = rng.uniform(-5000, 5000, (12, 2))
    orbit = 0.002 * np.stack([-position[:, 1], position[:, 0]], axis=1)
    velocity = np.array([-5.0, 1.0]) + orbit
    assert orbit_rate_rad_s(position, velocity) == pytest.approx(0.002, rel=1e-9)
    velocity[:3] += rng.normal(0, 8, (3, 2))
    assert orbit_rate_rad_s(position, velocity) == pytest.approx(0.002, abs=3e-4)
    assert orbit_rate_rad_s(position[:4], velocity[:4]) == 0.0


@pytest.mark.parametrize("yaw", [4.0, -9.0])
def test_own_ship_may_turn_round_and_round(yaw: float) -> None:
    """4 and 9 degrees in each turn of the antenna: more than three turns of the compass in the second case."""
    plots = plots_of([*ECHOES, (4000.0, -3000.0, 1.0, 1.0), (500.0, 5200.0, 0.0, 0.0)], 130, yaw_deg_per_turn=yaw)
    reports = track_plots(plots)
    counts = Counter(report.number for report in reports)
    assert len(counts) == 6
    assert min(counts.values()) >= 120
    north_up = [replace(p, bearing_deg=(p.bearing_deg + yaw * (p.time_s - 1000.0) / TURN_S) % 360.0) for p in plots]
    true_ones = track_plots(north_up, reference="true")
    assert {report.bearing_reference for report in true_ones} == {"true"}
    assert len({report.number for report in true_ones}) == 6


def test_pieces_of_one_hull_are_one_target() -> None:
    bow_and_stern = [(3000.0, 1000.0, -4.0, 0.0), (3020.0, 1025.0, -4.0, 0.0)]
    reports = track_plots(plots_of(bow_and_stern + ECHOES[1:], 40))
    assert len({report.number for report in reports}) == 4
    alone = [r for r in reports if r.range_m > 3050.0 and abs(wrap_180(r.bearing_deg - 18.6)) < 3.0]
    assert len(alone) > 5


def test_a_lost_target_comes_back_under_a_new_number() -> None:
    plots = plots_of(ECHOES, 60)
    silent = [p for p in plots if not (1040.0 < p.time_s < 1070.0)]
    numbers = {report.number for report in track_plots(silent)}
    assert numbers == set(range(1, 9))


def test_a_target_that_is_missed_is_carried_on_for_two_turns_and_no_longer() -> None:
    plots = plots_of(ECHOES, 40)
    shown = track_plots(plots)
    hidden = track_plots([p for p in plots if not (1050.0 < p.time_s < 1060.0 and abs(p.bearing_deg - 18.5) < 9.0)])
    times = {round((r.time_s or 0.0) - 1050.0, 1): r for r in hidden if abs(r.bearing_deg - 18.5) < 9.0}
    carried = [r for seconds, r in times.items() if 0.0 < seconds < 10.0]
    assert len(carried) == 2
    for report in carried:
        near = min(
            shown, key=lambda r: (abs((r.time_s or 0.0) - (report.time_s or 0.0)), abs(r.range_m - report.range_m))
        )
        assert report.range_m == pytest.approx(near.range_m, abs=40.0)
        assert report.bearing_deg == pytest.approx(near.bearing_deg, abs=1.0)


def test_clutter_alone_gives_nothing() -> None:
    rng = np.random.default_rng(8)
    plots = [
        RadarPlot(1000.0 + TURN_S * turn + TURN_S * share, 9000.0 * math.sqrt(spot), 360.0 * share)
        for turn in range(120)
        for share, spot in zip(np.sort(rng.random(25)), rng.random(25), strict=True)
    ]
    reports = track_plots(plots)
    assert len({report.number for report in reports}) <= 1


def test_nothing_in_nothing_out() -> None:
    assert track_plots([]) == ()
    assert PlotTracker(2.5).feed([]) == []


@pytest.fixture(scope="module", params=[(0.9, 10.0, 1), (0.7, 10.0, 2), (0.8, 40.0, 1)])
def scene(request: pytest.FixtureRequest) -> PlotScene:
    detection, clutter, seed = request.param
    return plot_scene(detection=detection, clutter=clutter, seed=seed)


def test_tracks_keep_to_their_ships_through_clutter_missed_echoes_and_a_turn(scene: PlotScene) -> None:
    found = figures(scene, track_plots(scene.plots, model=replace(tracking_model("plots"), coast_turns=0.0)))
    assert found.true_share > 0.99
    assert found.purity > 0.99
    assert found.tracks_per_body < 1.2
    assert found.coverage > 0.95
    assert found.false_tracks <= 4
    assert found.range_rmse_m < 1.05 * found.plot_range_rmse_m
    assert found.bearing_rmse_deg < 1.05 * found.plot_bearing_rmse_deg


def test_the_constants_of_a_tracker_may_be_given() -> None:
    eager = replace(tracking_model("plots"), least_hits=2, confirm_score=0.0)
    assert len(track_plots(plots_of(ECHOES, 20), model=eager)) > len(track_plots(plots_of(ECHOES, 20)))
    assert track_plots(plots_of(ECHOES, 20), radar=radar_model("small_craft"))


# ------------------------------------------------------------------------------------------------- beside a log


def test_the_targets_of_the_log_give_way_to_those_of_the_plots() -> None:
    old = TargetReport(5.0, 1, 100.0, 10.0, "relative")
    new = [TargetReport(time_s, 7, 200.0, 20.0, "relative") for time_s in (9.0, 2.0)]
    log = [OtherMessage(1.0, "XXX"), old, AisStatic(4.0, 211000000, 5), OtherMessage(None, "YYY")]
    found = list(with_tracked_plots(log, new))
    assert found == [log[0], new[1], log[2], log[3], new[0]]
