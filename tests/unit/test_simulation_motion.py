"""Motion and stage: hand-checkable paths, velocities as derivatives of positions, the ellipsoid held exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navfix.geodesy import direct, inverse
from navfix.simulation.motion import Motion
from navfix.simulation.stage import Stage, range_and_bearing
from navfix.types import Position

MOTIONS = {
    "straight": Motion(10.0, -20.0, course_rad=1.0, speed_mps=7.0),
    "turn": Motion(
        0.0, 0.0, course_rad=0.3, speed_mps=6.0, turn_at_s=40.0, turn_rate_rad_s=-0.02, turn_time_s=30.0, drift_rad=0.05
    ),
    "yaw": Motion(0.0, 0.0, course_rad=2.0, speed_mps=5.0, yaw_rad=0.02, yaw_period_s=11.0),
    "anchored": Motion(
        500.0, 100.0, course_rad=4.0, yaw_rad=0.15, yaw_period_s=600.0, yaw_phase_rad=1.0, swing_radius_m=220.0
    ),
}


def test_a_quarter_turn_ends_where_the_circle_says() -> None:
    rate = math.radians(3.0)
    turn = Motion(0.0, 0.0, course_rad=0.0, speed_mps=5.0, turn_at_s=0.0, turn_rate_rad_s=rate, turn_time_s=30.0)
    pose = turn.at(30.0)
    radius_m = 5.0 / rate
    assert (float(pose.north_m), float(pose.east_m)) == pytest.approx((radius_m, radius_m))
    assert math.degrees(float(pose.heading_rad)) == pytest.approx(90.0)


def test_after_the_turn_the_ship_goes_straight_on() -> None:
    turn = MOTIONS["turn"]
    first, second = turn.at(80.0), turn.at(90.0)
    run_m = math.hypot(float(second.north_m - first.north_m), float(second.east_m - first.east_m))
    assert run_m == pytest.approx(60.0)
    assert float(first.turn_rate_rad_s) == 0.0


@pytest.mark.parametrize("name", MOTIONS)
def test_velocity_is_the_derivative_of_position(name: str) -> None:
    times = np.array([5.0, 45.0, 69.0, 100.0, 333.0])
    step = 1e-3
    before, after, pose = MOTIONS[name].at(times - step), MOTIONS[name].at(times + step), MOTIONS[name].at(times)
    assert (after.north_m - before.north_m) / (2 * step) == pytest.approx(pose.north_mps, abs=1e-5)
    assert (after.east_m - before.east_m) / (2 * step) == pytest.approx(pose.east_mps, abs=1e-5)
    assert (after.heading_rad - before.heading_rad) / (2 * step) == pytest.approx(pose.turn_rate_rad_s, abs=1e-7)


def test_an_anchored_ship_lies_astern_of_its_anchor_at_the_length_of_its_chain() -> None:
    pose = MOTIONS["anchored"].at(np.linspace(0.0, 600.0, 50))
    ahead_north, ahead_east = pose.offset(220.0, 0.0)
    assert ahead_north == pytest.approx(500.0)
    assert ahead_east == pytest.approx(100.0)


def test_an_offset_is_forward_and_to_starboard() -> None:
    heading_east = Motion(0.0, 0.0, course_rad=math.pi / 2.0).at(0.0)
    assert [float(value) for value in heading_east.offset(10.0, 3.0)] == pytest.approx([-3.0, 10.0])


@pytest.mark.parametrize(
    "origin", [Position(54.0, 12.0), Position(-16.75, 179.98), Position(75.0, 19.0), Position(0.0, 0.0)]
)
def test_the_stage_keeps_distances_and_directions_about_its_place(origin: Position) -> None:
    stage = Stage(origin)
    lat, lon = stage.places(np.array([3000.0, -20000.0]), np.array([4000.0, 15000.0]))
    for index, (expected_m, expected_deg) in enumerate([(5000.0, math.degrees(math.atan2(4, 3))), (25000.0, 143.1301)]):
        distance_m, azimuth_deg = inverse(origin, Position(float(lat[index]), float(lon[index])))
        assert distance_m == pytest.approx(expected_m, rel=2e-5)
        assert azimuth_deg == pytest.approx(expected_deg, abs=1e-3)


@pytest.mark.parametrize("origin", [Position(54.0, 12.0), Position(-16.75, 179.98), Position(75.0, 19.0)])
def test_a_plane_direction_becomes_the_true_one(origin: Position) -> None:
    stage = Stage(origin)
    north, east, direction = 12000.0, 25000.0, math.radians(70.0)
    ahead = (north + 10.0 * math.cos(direction), east + 10.0 * math.sin(direction))
    here, there = (Position(*map(float, stage.places(*point))) for point in ((north, east), ahead))
    true_deg = math.degrees(direction + float(stage.convergence_rad(north, east)))
    assert true_deg % 360.0 == pytest.approx(inverse(here, there)[1], abs=1e-3)


def test_at_75_north_the_meridians_converge_by_more_than_a_degree_within_radar_range() -> None:
    assert abs(math.degrees(float(Stage(Position(75.0, 19.0)).convergence_rad(0.0, 40000.0)))) > 1.0


@pytest.mark.parametrize("start", [Position(54.0, 12.0), Position(-16.75, 179.98), Position(75.0, 19.0)])
@pytest.mark.parametrize("distance_m", [50.0, 9000.0, 60000.0])
def test_range_and_bearing_agree_with_the_geodesic(start: Position, distance_m: float) -> None:
    for azimuth_deg in (0.0, 77.0, 200.0, 359.0):
        end = direct(start, azimuth_deg, distance_m)
        range_m, bearing_deg = range_and_bearing(start.lat_deg, start.lon_deg, end.lat_deg, end.lon_deg)
        assert float(range_m) == pytest.approx(distance_m, abs=0.06)
        assert abs((float(bearing_deg) - azimuth_deg + 180.0) % 360.0 - 180.0) < 2e-4
