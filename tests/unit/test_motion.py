"""Motion models: exact on the motion that they assume, honest about what they lack, right anywhere on the globe."""

from __future__ import annotations

import math

import numpy as np
import pytest

from navfix.catalog import ais_model, persisting_model
from navfix.errors import InputError
from navfix.geodesy import direct, inverse
from navfix.picture.motion import DEFAULT, MODELS, Carried, Declined, Point, carry, history
from navfix.picture.motion.constant_acceleration import accelerated
from navfix.picture.motion.constant_turn import arc
from navfix.picture.motion.growth import step_sigma_m
from navfix.picture.motion.steering import Steering, steering
from navfix.types import Position

T0 = 1_700_000_000.0
A = ais_model("class_a")
START = Position(54.0, 8.0)
# What each model is short of the straight way, m: an exponential bends, speed fades in 3000 s, and the mean over
# uncertain courses (unscented) lies inside the arc.
BOTH_SIDES = {"spline", "smoother"}
SHORT = {"grey": 0.5, DEFAULT: 0.6, "unscented": 1.5}


def track(
    speed_mps: float = 8.0,
    course_deg: float = 60.0,
    *,
    turn_deg_per_min: float = 0.0,
    gain_mps2: float = 0.0,
    count: int = 7,
    every_s: float = 10.0,
    start: Position = START,
    told_turn: bool = False,
) -> list[Point]:
    """Return reports of a ship that moves exactly so, oldest first, the last at T0."""
    place, points = start, []
    steps = round(every_s)
    for k in range(count * steps):
        seconds = k - (count - 1) * steps
        if seconds > 0:
            break
        speed = speed_mps + gain_mps2 * seconds
        course = course_deg + turn_deg_per_min / 60.0 * seconds
        if k % steps == 0:
            told = turn_deg_per_min if told_turn else None
            points.append(Point(T0 + seconds, place.lat_deg, place.lon_deg, speed, course % 360.0, told))
        middle = course + turn_deg_per_min / 120.0
        place = direct(place, middle, speed + 0.5 * gain_mps2)
    return points


def off_m(points: list[Point], age_s: float, name: str, **motion: float) -> float:
    """Return how far a model is from where the ship really is at ``age_s`` after the newest report."""
    carried = MODELS[name](history(points), T0 + age_s, A)
    assert isinstance(carried, Carried)
    newest = points[-1]
    place = Position(newest.lat_deg, newest.lon_deg)
    truth = place
    for k in range(round(age_s)):
        course = newest.course_deg + motion.get("turn_deg_per_min", 0.0) / 60.0 * (k + 0.5)
        truth = direct(truth, course, newest.speed_mps + motion.get("gain_mps2", 0.0) * (k + 0.5))
    distance_m, azimuth_deg = inverse(place, truth)
    north, east = distance_m * math.cos(math.radians(azimuth_deg)), distance_m * math.sin(math.radians(azimuth_deg))
    return math.hypot(carried.north_m - north, carried.east_m - east)


def test_constant_velocity_carries_along_the_course_and_back():
    past = history([Point(T0, 54.0, 8.0, 10.0, 90.0)])
    ahead, behind = (MODELS["constant_velocity"](past, T0 + age, A) for age in (30.0, -3.0))
    assert (ahead.north_m, ahead.east_m) == pytest.approx((0.0, 300.0), abs=1e-9)
    assert behind.east_m == pytest.approx(-30.0)


@pytest.mark.parametrize("name", sorted(set(MODELS) - BOTH_SIDES))
def test_every_model_carries_a_straight_track_straight_on(name: str):
    assert off_m(track(told_turn=True), 20.0, name) < 2.0 * SHORT.get(name, 0.05)


def test_an_acceleration_goes_on_and_ends_when_the_ship_has_stopped():
    assert off_m(track(gain_mps2=0.03), 20.0, "constant_acceleration", gain_mps2=0.03) < 6.0
    stopping = Steering(4.0, 0.0, acceleration_mps2=-0.1)
    assert accelerated(stopping, 400.0) == pytest.approx((80.0, 0.0))
    assert accelerated(Steering(4.0, 0.0, acceleration_mps2=0.1), -400.0) == pytest.approx((-80.0, 0.0))
    limit = 60.0 * 1852.0 / 3600.0
    assert accelerated(Steering(limit - 1.0, 0.0, acceleration_mps2=0.1), 100.0)[0] < limit * 100.0


def test_a_reported_rate_of_turn_makes_an_arc():
    points = track(turn_deg_per_min=40.0, told_turn=True)
    assert off_m(points, 60.0, "constant_turn", turn_deg_per_min=40.0) < 0.2
    assert off_m(points, 60.0, "constant_velocity", turn_deg_per_min=40.0) > 100.0
    assert arc(5.0, 0.3, 0.0, 10.0) == pytest.approx(arc(5.0, 0.3, 1e-8, 10.0), abs=1e-5)


def test_a_turn_that_was_seen_in_the_courses_helps_the_default():
    points = track(turn_deg_per_min=30.0)
    assert off_m(points, 20.0, DEFAULT, turn_deg_per_min=30.0) < 0.5 * off_m(
        points, 20.0, "constant_velocity", turn_deg_per_min=30.0
    )


def test_a_course_through_north_is_no_turn():
    past = history(
        [Point(T0 + 10.0 * k, 54.0 + 0.0005 * k, 8.0, 5.0, course) for k, course in enumerate((359, 1, 359, 1))]
    )
    assert abs(steering(past, persisting_model()).turn_rate_rad_s) < math.radians(0.3)


@pytest.mark.parametrize("name", sorted(BOTH_SIDES))
def test_a_turn_that_both_sides_know_is_interpolated(name: str):
    points = track(turn_deg_per_min=40.0, count=12)
    left_out = points.pop(6)
    past = history(points)
    carried = MODELS[name](past, left_out.time_s, A)
    place = direct(
        past.origin,
        math.degrees(math.atan2(carried.east_m, carried.north_m)),
        math.hypot(carried.north_m, carried.east_m),
    )
    assert inverse(place, Position(left_out.lat_deg, left_out.lon_deg))[0] < 1.0


@pytest.mark.parametrize(
    ("name", "points", "age_s", "reason"),
    [
        ("spline", track(), 10.0, "each side"),
        ("smoother", track(), 10.0, "each side"),
        ("spline", track(count=3), -10.0, "needs 4"),
        ("grey", track(count=3), 10.0, "needs 5"),
        ("grey", track(), 100.0, "too far"),
        ("grey", [*track(count=4, every_s=2.0), Point(T0 + 60.0, 54.0, 8.0, 5.0, 0.0)], 65.0, "uneven"),
        ("constant_turn", track(), 10.0, "no rate"),
        ("constant_turn", track(turn_deg_per_min=30.0, told_turn=True), 600.0, "180°"),
        ("constant_turn", [Point(T0, 54.0, 8.0, 5.0, 0.0, 720.0)], 10.0, "no ship turns"),
        ("constant_acceleration", track(count=1), 10.0, "two reports"),
        ("unscented", [Point(T0, 54.0, 8.0)], 10.0, "cannot start"),
        ("extended", [Point(T0, 54.0, 8.0, 0.0, 10.0)], 10.0, "lies still"),
    ],
)
def test_a_model_says_why_it_would_rather_not(name: str, points: list[Point], age_s: float, reason: str):
    answer = MODELS[name](history(points), T0 + age_s, A)
    assert isinstance(answer, Declined)
    assert reason in answer.reason


def test_where_a_model_would_rather_not_the_default_answers():
    past = history(track(count=2))
    assert carry(past, T0 + 10.0, A, name="grey") == carry(past, T0 + 10.0, A)
    with pytest.raises(InputError, match="persisting"):
        carry(past, T0, A, name="clairvoyant")


@pytest.mark.parametrize("start", [Position(0.0, 179.9999), Position(-33.0, -179.9999), Position(85.0, 30.0)])
@pytest.mark.parametrize("name", ["constant_velocity", "grey", "unscented", "extended", DEFAULT])
def test_models_work_across_180_east_and_far_north(start: Position, name: str):
    assert off_m(track(start=start), 30.0, name) < 3.0 * SHORT.get(name, 0.05)


def test_sigma_grows_with_age_speed_turning_and_unsteadiness():
    steady = Steering(6.0, 0.0, span_s=300.0)
    ages = [step_sigma_m(steady, age, A) for age in (0.0, 10.0, 60.0, 180.0, 900.0)]
    assert ages == sorted(ages)
    assert step_sigma_m(steady, -30.0, A) == step_sigma_m(steady, 30.0, A)
    for other in (
        Steering(12.0, 0.0, span_s=300.0),
        Steering(6.0, 0.0, turn_rate_rad_s=0.02, span_s=300.0),
        Steering(6.0, 0.0, unsteadiness_rad=0.3, span_s=300.0),
        Steering(6.0, 0.0, span_s=0.0),
    ):
        assert step_sigma_m(other, 60.0, A) > 1.2 * step_sigma_m(steady, 60.0, A)


def test_a_ship_without_speed_may_have_gone_anywhere_and_one_that_lies_still_swings():
    unknown, still = history([Point(T0, 54.0, 8.0)]), history([Point(T0, 54.0, 8.0, 0.1, 200.0)])
    assert carry(unknown, T0 + 60.0, A).sigma_m > 60.0
    assert carry(still, T0 + 600.0, A).sigma_m <= 2.0 * A.swing_sigma_m


def test_reports_in_any_order_make_one_history_and_doubles_are_dropped():
    points = track()
    shuffled = [points[i] for i in np.random.default_rng(3).permutation(len(points))]
    past, other = history(points), history([*shuffled, points[2]])
    assert np.array_equal(past.time_s, other.time_s)
    assert np.all(np.diff(past.time_s) < 0.0)
    assert (past.north_m[0], past.east_m[0]) == (0.0, 0.0)
    with pytest.raises(InputError, match="at least one"):
        history([])
