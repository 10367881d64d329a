"""Echo outlines: the ellipse through boundary points, the extent where there is none, and reading the file."""

import json
import logging
import math
from datetime import UTC, datetime

import numpy as np
import pytest

from navfix.errors import InputError
from navfix.picture.ellipse import antenna_step, fit_ellipse, fit_known_ellipse
from navfix.picture.outlines import Outline, hull_centre, read_outlines, with_outlines
from navfix.types import Epoch, RadarTarget

T0 = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
CENTRE, LENGTH_M, BEAM_M = np.array([4000.0, 4000.0]), 249.0, 44.0  # the ship of source [11]


def boundary(heading_deg: float, angles: np.ndarray) -> np.ndarray:
    heading = math.radians(heading_deg)
    own = np.column_stack([LENGTH_M / 2.0 * np.cos(angles), BEAM_M / 2.0 * np.sin(angles)])
    turn = np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
    return CENTRE + own @ turn.T


def polar(points: np.ndarray) -> np.ndarray:
    return np.column_stack([np.hypot(*points.T), np.degrees(np.arctan2(points[:, 1], points[:, 0])) % 360.0])


def line(target: object = 7, points: object = ((4000.0, 30.0), (4010.0, 30.2), (4020.0, 30.1)), **more: object) -> str:
    return json.dumps({"time_utc": T0.isoformat(), "target": target, "points": points} | more)


# ------------------------------------------------------------------------------------------------------------ ellipses


@pytest.mark.parametrize("heading_deg", [0.0, 45.0, 90.0, 225.0, 305.0])
@pytest.mark.parametrize("count", [5, 6, 40])
def test_points_without_noise_give_the_ellipse_back(heading_deg: float, count: int):
    angles = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False) + 0.3
    found = fit_ellipse(boundary(heading_deg, angles))
    assert found is not None
    assert (found.north_m, found.east_m) == pytest.approx(tuple(CENTRE), abs=1e-4)
    assert (found.length_m, found.beam_m) == pytest.approx((LENGTH_M, BEAM_M), abs=1e-3)
    assert found.azimuth_deg == pytest.approx(heading_deg % 180.0, abs=1e-3)


def test_the_near_half_alone_holds_the_ellipse_when_it_is_exact():
    found = fit_ellipse(boundary(225.0, np.linspace(-1.4, 1.4, 12)))
    assert found is not None
    assert (found.north_m, found.east_m) == pytest.approx(tuple(CENTRE), abs=0.01)


def test_the_ellipse_is_the_same_wherever_its_plane_begins():
    points = boundary(60.0, np.linspace(0.0, 5.5, 9)) + np.random.default_rng(1).normal(0.0, 3.0, (9, 2))
    here, there = fit_ellipse(points), fit_ellipse(points + [1e5, -2e5])
    assert here is not None
    assert there is not None
    assert there.north_m - here.north_m == pytest.approx(1e5, abs=1e-3)
    assert there.length_m == pytest.approx(here.length_m, abs=1e-3)


@pytest.mark.parametrize(
    "points",
    [
        boundary(0.0, np.array([0.1, 1.0, 2.0, 4.0])),
        np.zeros((6, 2)),
        np.column_stack([np.arange(6.0), 2.0 * np.arange(6.0)]),
        np.full((5, 2), np.nan),
    ],
)
def test_too_few_points_one_point_a_line_or_no_numbers_give_no_ellipse(points: np.ndarray):
    assert fit_ellipse(points) is None


def test_a_hull_of_known_size_is_placed_by_its_near_side_alone():
    points = boundary(225.0, np.linspace(-0.9, 0.9, 6))
    found = fit_known_ellipse(points, LENGTH_M, BEAM_M, 225.0)
    assert (found.north_m, found.east_m) == pytest.approx(tuple(CENTRE), abs=0.01)


def test_the_bridge_is_a_quarter_of_the_length_aft():
    assert antenna_step(200.0, 90.0) == pytest.approx([0.0, -50.0], abs=1e-9)


# ------------------------------------------------------------------------------------------------------------- centres


def test_a_clear_outline_gives_the_centre_by_its_ellipse():
    near = boundary(225.0, np.linspace(0.0, 6.0, 30)) / 4.0  # at 1.4 km
    centre = hull_centre(Outline(0.0, "07", polar(near)))
    assert centre is not None
    assert centre.method == "ellipse"
    assert centre.range_m == pytest.approx(float(np.hypot(*CENTRE)) / 4.0, abs=0.5)
    assert centre.bearing_deg == pytest.approx(45.0, abs=0.02)


@pytest.mark.parametrize("count", [3, 4])
def test_fewer_than_five_points_give_the_middle_of_the_extent_with_its_larger_sigma(count: int):
    points = polar(boundary(225.0, np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)))
    centre = hull_centre(Outline(0.0, "07", points))
    assert centre is not None
    assert centre.method == "extent"
    assert centre.range_sigma_m > np.ptp(points[:, 0]) / math.sqrt(12.0)


def test_an_ellipse_that_is_no_hull_falls_back_to_the_extent():
    """Five noisy points far away: in more than half of the draws what comes out is no hull, or surer by its extent."""
    rng, methods = np.random.default_rng(7), []
    for _ in range(100):
        points = polar(boundary(225.0, rng.uniform(0.0, 6.28, 5)))
        points += rng.normal(0.0, 1.0, points.shape) * [20.0, math.sqrt(2.0)]
        centre = hull_centre(Outline(0.0, "07", points))
        assert centre is not None
        methods.append(centre.method)
    assert methods.count("extent") > 70


def test_points_that_miss_their_ellipse_make_it_less_sure():
    rough = np.random.default_rng(5).normal(0.0, 1.0, (24, 2)) * [25.0, 0.8]
    points = polar(boundary(225.0, np.linspace(0.0, 6.0, 24)) / 4.0)
    smooth, noisy = hull_centre(Outline(0.0, "07", points)), hull_centre(Outline(0.0, "07", points + rough))
    assert smooth is not None
    assert noisy is not None
    assert noisy.range_sigma_m > 1.5 * smooth.range_sigma_m


def test_two_points_say_nothing_of_a_centre():
    assert hull_centre(Outline(0.0, "07", np.array([[4000.0, 30.0], [4010.0, 30.1]]))) is None


def test_an_outline_across_north_has_its_middle_at_north():
    points = np.array([[1000.0, 359.0], [1010.0, 1.0], [1020.0, 0.0]])
    centre = hull_centre(Outline(0.0, "07", points))
    assert centre is not None
    assert min(centre.bearing_deg, 360.0 - centre.bearing_deg) < 1e-9


def test_the_sigma_of_an_ellipse_holds_its_error():
    """The centre's error in range and bearing, in units of its sigma, over seeded outlines of the stated noise."""
    rng, ratios = np.random.default_rng(3), []
    for _ in range(150):
        points = polar(boundary(float(rng.uniform(0, 360)), rng.uniform(0.0, 6.28, 24)) / 4.0)
        points += rng.normal(0.0, 1.0, points.shape) * [7.5, 0.25]
        centre = hull_centre(Outline(0.0, "07", points))
        if centre is not None and centre.method == "ellipse":
            off_m = centre.range_m - float(np.hypot(*CENTRE)) / 4.0
            ratios += [off_m / centre.range_sigma_m, (centre.bearing_deg - 45.0) / centre.bearing_sigma_deg]
    assert len(ratios) > 100
    assert 0.6 < float(np.sqrt(np.mean(np.square(ratios)))) < 1.5


# ------------------------------------------------------------------------------------------------------------- reading


def test_lines_are_read_by_target_and_bad_ones_counted_and_reported_once(caplog: pytest.LogCaptureFixture):
    bad = [
        "not json", "[]", line(points=[[1, 2, 3]]), line(points=[["a", 2]]), line(points=[]), line(points="x"),
        line(points=[[-5.0, 20.0]]), line(points=[[math.nan, 20.0]]), line(bearing_reference="compass"),
        json.dumps({"target": 3, "points": [[1, 2]]}), line().replace("2026", "year"), "[" * 5000, line(points=None),
        json.dumps({"time_utc": 5, "target": 3, "points": [[1, 2]]}),
    ]  # fmt: skip
    with caplog.at_level(logging.WARNING):
        found = read_outlines(["\n", line(), *bad, line("BUOY")])
    assert set(found.by_target) == {"07", "BUOY"}
    assert sum(found.problems.values()) == len(bad)
    assert len(caplog.records) == 1
    assert f"{len(bad)} lines were not used" in caplog.text


def test_a_file_without_any_outline_is_refused():
    for lines in ([], ["{}"], ["rubbish"]):
        with pytest.raises(InputError, match="no echo outline"):
            read_outlines(lines)


def test_a_target_takes_the_centre_of_its_outline_with_a_larger_sigma():
    epoch = Epoch(T0, (RadarTarget("07", 4000.0, 30.0, range_sigma_m=20.0, bearing_sigma_deg=1.0),), ())
    (target,) = with_outlines(epoch, read_outlines([line()])).targets
    assert target.point == "hull_centre"
    assert target.range_m == pytest.approx(4010.0)
    assert target.bearing_deg == pytest.approx(30.1)
    assert target.range_sigma_m is not None
    assert target.range_sigma_m > 20.0


@pytest.mark.parametrize(
    "text",
    [
        line(8),
        line(bearing_reference="true"),
        line(points=[[9000.0, 30.0]] * 3),
        line(points=[[4000.0, 210.0]] * 3),
        line(points=[[4000.0, 30.0]]),
        line(time_utc="2026-03-01T12:00:10+00:00"),
    ],
)
def test_an_outline_of_another_target_reference_place_or_time_changes_nothing(text: str):
    epoch = Epoch(T0, (RadarTarget("07", 4000.0, 30.0),), ())
    assert with_outlines(epoch, read_outlines([text])) == epoch
