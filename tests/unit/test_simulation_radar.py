"""The simulated radar: errors consistent with the model, detection, resolution, tracker, false targets, references."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from navfix.catalog import radar_model
from navfix.geodesy import inverse
from navfix.nmea import read_log
from navfix.nmea.records import TargetReport
from navfix.simulation import radar
from navfix.simulation.motion import Motion
from navfix.simulation.radar import Plot
from navfix.simulation.scenario import Recording, Scenario, from_text, load, simulate
from navfix.simulation.settings import RadarSettings
from navfix.simulation.tracker import Tracker
from navfix.simulation.world import Body
from navfix.types import Hull, Position
from navfix.units import NM_M, wrap_180

SHIP = Hull(bow_m=100.0, stern_m=100.0, port_m=15.0, starboard_m=15.0)


def marks_scenario(radar_table: str, *, speed_mps: float = 6.0) -> Scenario:
    """Return a scenario of still marks only: what is measured is a point, and its place is known."""
    return from_text(f"""
        title = "marks"
        source = "test"
        start_utc = 2026-03-01T09:00:00Z
        duration_s = 150.0
        lat_deg = 60.0
        lon_deg = 179.95
        [own]
        speed_mps = {speed_mps}
        course_deg = 80.0
        yaw_deg = 1.0
        [[traffic]]
        layout = "uniform"
        kind = "aton"
        count = 60
        radius_m = 9000.0
        inner_radius_m = 1500.0
        [radar]
        minimum_range_m = 100.0
        range_decimals = 5
        bearing_decimals = 4
        edge_share = 0.0
        range_resolution_m = 0.0
        maximum_targets = 99
        {radar_table}
        """)


def errors(scenario: Scenario, seed: int, *, reference: str = "relative") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return range errors [m], bearing errors [deg] and true ranges [m] of every TTM against the geodesic truth."""
    recording, world = simulate(scenario, seed), scenario.world(seed)
    places = {body.mmsi: body for body in world.bodies}
    found = []
    for report, row in zip(reports(recording), recording.association, strict=True):
        if report.status == "L":
            continue
        own = world.own.at(row.unix_s - world.start_s)
        body = places[row.mmsi].motion.at(row.unix_s - world.start_s)
        here, there = (Position(*map(float, world.stage.places(p.north_m, p.east_m))) for p in (own, body))
        range_m, bearing_deg = inverse(here, there)
        heading_deg = float(world.true_deg(own, own.heading_rad)) if reference == "relative" else 0.0
        found.append((report.range_m - range_m, wrap_180(report.bearing_deg - bearing_deg + heading_deg), range_m))
    columns = np.array(found).T
    return columns[0], columns[1], columns[2]


def reports(recording: Recording) -> list[TargetReport]:
    """Return the targets as our own reader sees them, in the order of the association's rows."""
    targets = [record for record in read_log(list(recording.lines)).records if isinstance(record, TargetReport)]
    assert [target.number for target in targets] == [row.target_number for row in recording.association]
    return targets


@pytest.mark.parametrize("model_name", ["imo", "solid_state", "small_craft"])
def test_range_and_bearing_errors_are_consistent_with_the_model(model_name: str) -> None:
    model = radar_model(model_name)
    range_error_m, bearing_error_deg, range_m = errors(
        marks_scenario(f'model = "{model_name}"\nsteady_share = 0.0\nmaximum_range_m = 20000.0'), 1
    )
    for standardised in (range_error_m / model.sigma_of_range_m(range_m), bearing_error_deg / model.bearing_sigma_deg):
        count = len(standardised)
        assert count > 1000
        assert np.mean(standardised) == pytest.approx(0.0, abs=4.0 / math.sqrt(count))
        # Chi-square with `count` degrees of freedom: standard deviation sqrt(2 count).
        assert np.sum(standardised**2) == pytest.approx(count, abs=4.0 * math.sqrt(2.0 * count))
        assert np.mean(np.abs(standardised) < 1.96) == pytest.approx(0.95, abs=0.02)


def test_biases_are_the_same_for_every_target() -> None:
    table = 'model = "solid_state"\nsteady_share = 0.0\nbearing_bias_deg = -3.0\nrange_bias_m = 40.0'
    range_error_m, bearing_error_deg, _ = errors(marks_scenario(table), 2)
    assert np.mean(bearing_error_deg) == pytest.approx(-3.0, abs=0.05)
    assert np.mean(range_error_m) == pytest.approx(40.0, abs=4.0)


def test_a_steady_error_stays_with_its_target() -> None:
    model = radar_model("imo")
    scenario = marks_scenario('model = "imo"\nsteady_share = 1.0')
    world = scenario.world(3)
    settings = scenario.radar
    seen = radar.view(world, world.bodies[0], np.arange(40.0), 0.0)
    range_m, _ = radar.measure(seen, settings, model, np.random.default_rng(1))
    standardised = (range_m - seen.range_m) / model.sigma_of_range_m(seen.range_m)
    assert np.ptp(standardised) < 1e-9
    fresh, _ = radar.measure(seen, replace(settings, steady_share=0.0), model, np.random.default_rng(1))
    assert np.ptp(fresh - seen.range_m) > 50.0


def test_a_true_bearing_is_relative_plus_gyro() -> None:
    table = 'model = "solid_state"\nsteady_share = 0.0\nbearing_reference = "true"\n[sensors]\nheading_bias_deg = 2.0'
    scenario = marks_scenario(table)
    assert {report.bearing_reference for report in reports(simulate(scenario, 1))} == {"true"}
    _, bearing_error_deg, _ = errors(scenario, 1, reference="true")
    assert np.mean(bearing_error_deg) == pytest.approx(2.0, abs=0.05)


def test_a_radar_with_its_own_clock_shifts_stamps_not_positions() -> None:
    right, late = (simulate(marks_scenario(f"clock_offset_s = {offset}"), 1) for offset in (0.0, 2.0))
    assert [row.unix_s + 2.0 for row in right.association] == pytest.approx([row.unix_s for row in late.association])
    pairs = list(zip(reports(right), reports(late), strict=True))
    assert all(one.range_m == two.range_m for one, two in pairs)
    assert {round((two.utc_of_day_s or 0.0) - (one.utc_of_day_s or 0.0), 2) for one, two in pairs} == {2.0}


# ------------------------------------------------------------------------------------------------- echoes


def test_the_echo_lies_on_the_side_of_the_hull_that_faces_own_ship() -> None:
    assert radar.edge_distance_m(SHIP, np.array([0.0, math.pi, math.pi / 2.0])) == pytest.approx([100.0, 100.0, 15.0])
    world = load("open_sea").world(1)
    body = Body(1, "X", "ship", Motion(5000.0, 0.0, course_rad=0.0), SHIP)  # end on
    for share, shorter_m in ((0.0, 0.0), (1.0, 100.0)):
        own = radar.view(replace(world, own=Motion(0.0, 0.0)), body, np.array([0.0]), share)
        assert float(own.centre_range_m[0] - own.range_m[0]) == pytest.approx(shorter_m)


def test_detection_falls_with_range_and_with_smaller_size() -> None:
    settings = RadarSettings(detection=0.95, minimum_range_m=200.0, maximum_range_m=40000.0)
    boat, ship = (
        Body(1, "X", "ship", Motion(0.0, 0.0), Hull(length / 2.0, length / 2.0, 2.0, 2.0)) for length in (10.0, 200.0)
    )
    ranges_m = np.array([500.0, 5000.0, 10000.0, 30000.0])
    for_boat, for_ship = (radar.detection_probability(body, ranges_m, settings) for body in (boat, ship))
    assert np.all(np.diff(for_boat) < 0.0)
    assert np.all(for_boat < for_ship)
    assert float(for_ship[0]) == pytest.approx(0.95, abs=1e-4)
    # Half of the echoes at the range of first detection that IMO asks for a 10 m craft.
    assert float(radar.detection_probability(boat, np.array([3.4 * NM_M]), settings)[0]) == pytest.approx(0.475)
    assert radar.detection_probability(ship, np.array([199.0, 40001.0]), settings).tolist() == [0.0, 0.0]


def test_echoes_are_missed_at_the_stated_rate() -> None:
    scenario = marks_scenario("detection = 0.8\nmaximum_range_m = 4000.0", speed_mps=0.0)
    world, model = scenario.world(1), scenario.radar_model()
    plots, _ = radar.turns(world, scenario.radar, model, 2000.0, 1)
    for key, seen in Counter(plot.key for turn in plots for plot in turn).items():
        range_m = radar.view(world, world.bodies[key], np.array([0.0]), 0.0).range_m
        expected = float(radar.detection_probability(world.bodies[key], range_m, scenario.radar)[0])
        assert seen / len(plots) == pytest.approx(expected, abs=0.06)


def test_of_two_echoes_within_the_resolution_the_larger_one_is_seen() -> None:
    scenario = load("open_sea")
    own = Motion(0.0, 0.0)
    bodies = tuple(
        Body(number, "X", "ship", Motion(3000.0, east_m), Hull(length, length, 2.0, 2.0))
        for number, east_m, length in ((1, 0.0, 10.0), (2, 30.0, 100.0), (3, 900.0, 10.0))
    )
    settings = RadarSettings(detection=1.0, edge_share=0.0, bearing_resolution_deg=2.5, range_resolution_m=200.0)
    world = replace(scenario.world(1), own=own, bodies=bodies)
    plots, _ = radar.turns(world, settings, radar_model("solid_state"), 250.0, 1)
    seen = Counter(plot.key for turn in plots for plot in turn)
    assert seen[1] == 100
    assert seen[0] < 10
    assert seen[2] > 90


def test_false_targets_appear_at_the_stated_rate_and_persist_as_long_as_said() -> None:
    scenario = load("open_sea")
    settings = replace(scenario.radar, false_per_turn=0.4, false_turns=8.0)
    world = replace(scenario.world(1), bodies=())
    plots, windows = radar.turns(world, settings, radar_model("imo"), 2500.0, 2)
    assert len(windows) == pytest.approx(0.4 * len(plots), abs=4.0 * math.sqrt(0.4 * len(plots)))
    assert np.mean([last - first + 1 for first, last in windows]) == pytest.approx(8.0, rel=0.2)
    assert {plot.key for turn in plots for plot in turn} <= {-1 - index for index in range(len(windows))}
    for turn, found in enumerate(plots):
        assert all(windows[-plot.key - 1][0] <= turn <= windows[-plot.key - 1][1] for plot in found)


def test_false_targets_are_associated_with_nothing() -> None:
    recording = simulate(replace(load("open_sea"), traffic=()), 3, duration_s=600.0)
    assert {row.mmsi for row in recording.association} == {0}


def test_each_target_is_measured_when_the_antenna_passes_it() -> None:
    recording = simulate(marks_scenario('model = "solid_state"', speed_mps=0.0), 1)
    start_s = recording.truth[0].unix_s
    for report, row in zip(reports(recording), recording.association, strict=True):
        swept_deg = ((row.unix_s - start_s) % 2.5) / 2.5 * 360.0
        assert report.status == "L" or abs(wrap_180(swept_deg - report.bearing_deg)) < 5.0


# ------------------------------------------------------------------------------------------------- tracker


def plot(key: int, time_s: float = 0.0) -> Plot:
    return Plot(key, time_s, 1000.0, 10.0, 0.0, 0.0)


def test_a_target_begins_as_query_becomes_tracked_and_ends_as_lost() -> None:
    tracker = Tracker(RadarSettings(acquire_hits=3, settle_turns=4, lost_turns=2), 2.5)
    states = [[(t.number, t.status) for t in tracker.turn([plot(5, 2.5 * turn)])] for turn in range(8)]
    assert states == [[], [], [(1, "Q")], [(1, "Q")], [(1, "Q")], [(1, "Q")], [(1, "T")], [(1, "T")]]
    assert tracker.turn([]) == []
    lost = tracker.turn([])
    assert [(t.number, t.status, t.plot.time_s) for t in lost] == [(1, "L", 22.5)]
    assert tracker.turn([]) == []


def test_a_broken_row_of_echoes_is_not_acquired() -> None:
    tracker = Tracker(RadarSettings(acquire_hits=3), 2.5)
    assert [tracker.turn([plot(1)] if seen else []) for seen in (1, 1, 0, 1, 1)] == [[], [], [], [], []]


def test_target_numbers_are_recycled() -> None:
    tracker = Tracker(RadarSettings(acquire_hits=1, lost_turns=1, highest_number=3), 2.5)
    numbers = [tracker.turn([plot(key)])[0].number for key in range(7)]
    assert numbers == [1, 2, 3, 1, 2, 3, 1]


def test_no_two_targets_carry_one_number_in_a_turn() -> None:
    recording = simulate(load("anchorage"), 1)
    numbers = {row.target_number for row in recording.association}
    assert max(numbers) <= 40
    live: dict[int, int] = {}
    for report, row in zip(reports(recording), recording.association, strict=True):
        if row.mmsi:
            assert live.setdefault(row.target_number, row.mmsi) == row.mmsi
        if report.status == "L":
            live.pop(row.target_number, None)


def test_a_full_tracker_takes_no_more_targets() -> None:
    tracker = Tracker(RadarSettings(acquire_hits=1, maximum_targets=2), 2.5)
    assert len(tracker.turn([plot(1), plot(2), plot(3)])) == 2


# ------------------------------------------------------------------------------------------------- target speeds


def ground_velocities(recording: Recording) -> list[tuple[TargetReport, int]]:
    rows = zip(reports(recording), recording.association, strict=True)
    return [(report, row.mmsi) for report, row in rows if report.status == "T" and row.mmsi]


def test_true_target_speeds_are_those_over_ground() -> None:
    scenario = replace(load("date_line"), radar=RadarSettings(speed_sigma_mps=0.0, maximum_range_m=14816.0))
    world = scenario.world(1)
    bodies = {body.mmsi: body for body in world.bodies}
    for report, mmsi in ground_velocities(simulate(scenario, 1)):
        body = bodies[mmsi]
        if body.kind == "ship" and body.motion.turn_rate_rad_s == 0.0:
            assert report.speed_mps == pytest.approx(body.motion.speed_mps, abs=0.05)
            assert report.course_deg is not None
            assert (
                body.motion.speed_mps < 0.3
                or abs(wrap_180(report.course_deg - math.degrees(body.motion.course_rad))) < 0.3
            )


def test_relative_target_speeds_of_still_marks_are_own_speed_backwards() -> None:
    scenario = marks_scenario('target_speed = "relative"\nspeed_sigma_mps = 0.0')
    for report, _ in ground_velocities(simulate(scenario, 1)):
        assert report.course_reference == "relative"
        assert report.speed_mps == pytest.approx(6.0, abs=0.05)
        assert report.course_deg == pytest.approx(180.0, abs=1.2)  # leeway none, yaw 1 deg


def test_blank_target_speeds_are_blank() -> None:
    assert {report.speed_mps for report in reports(simulate(marks_scenario('target_speed = "blank"'), 1))} == {None}
