"""From antenna to echo: the hull's centre, the side that own ship sees, and what is not known of either."""

import math
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from navfix import adjust, pipeline
from navfix.catalog import hull_model_of
from navfix.geodesy import direct, inverse
from navfix.nmea.records import AisPosition, AisStatic
from navfix.picture.hull import Size, at_centre, echo, facing, hull_shift, size_of
from navfix.picture.traffic import Traffic
from navfix.simulation.radar import edge_distance_m
from navfix.types import Association, Epoch, Hull, Mark, Position, RadarTarget

OWN = Position(54.0, 8.0)
LONG = Hull(bow_m=180.0, stern_m=20.0, port_m=10.0, starboard_m=20.0)
T0 = datetime(2026, 3, 1, 12, 0, tzinfo=UTC).timestamp()


def ship(bearing_deg: float, range_m: float, heading_deg: float | None, hull: Hull | None = LONG) -> Mark:
    return Mark(
        "ship",
        direct(OWN, bearing_deg, range_m),
        sigma_m=50.0,
        heading_deg=heading_deg,
        hull=hull,
        hull_sigma_m=40.0,
        ais_class="A",
    )


def test_the_centre_lies_where_the_four_distances_say():
    shift = hull_shift(size_of(LONG), 90.0)
    assert (shift.north_m, shift.east_m) == pytest.approx((-5.0, 80.0))


def test_a_hull_seen_beam_on_and_bow_on_shows_its_edge():
    size = Size(200.0, 30.0)
    assert echo(size, math.pi / 2.0).depth_m == pytest.approx(15.0)
    assert echo(size, 0.0).depth_m == pytest.approx(100.0)


@pytest.mark.parametrize("aspect_deg", [3.0, 40.0, 117.0, 200.0, 305.0])
def test_the_depth_is_the_mean_of_the_visible_side_over_its_width(aspect_deg: float):
    """Rays across the whole width of a box, each stopped by the nearest side: eq. (8.1) without its derivation."""
    a, b, aspect = 70.0, 11.0, math.radians(aspect_deg)
    towards, across = np.array([math.cos(aspect), math.sin(aspect)]), np.array([-math.sin(aspect), math.cos(aspect)])
    half_width = a * abs(math.sin(aspect)) + b * abs(math.cos(aspect))
    offsets = np.linspace(-half_width, half_width, 20001)[1:-1]
    start = offsets[:, None] * across
    with np.errstate(divide="ignore"):
        reach = np.min((np.array([a, b]) * np.sign(towards) - start) / towards, axis=1)  # to the far wall, towards us
    assert echo(Size(2 * a, 2 * b), aspect).depth_m == pytest.approx(float(np.mean(reach)), rel=1e-3)


def test_the_simulated_echo_lies_within_two_sigma_of_the_model_from_every_side():
    """Another shape (an ellipse) and another rule (0.8 of the edge): the model must hold it all the same."""
    for hull in (LONG, Hull(20.0, 10.0, 4.0, 4.0), Hull(6.0, 6.0, 2.0, 2.0)):
        for aspect_deg in range(0, 360, 5):
            seen = echo(size_of(hull), math.radians(aspect_deg))
            simulated_m = 0.8 * float(edge_distance_m(hull, np.radians([float(aspect_deg)]))[0])
            assert abs(simulated_m - seen.depth_m) <= 2.0 * seen.along_sigma_m


def test_facing_moves_a_mark_towards_own_ship_and_takes_the_hull_out_of_its_sigma():
    epoch = Epoch(None, (), (ship(30.0, 4000.0, heading_deg=120.0),))
    (seen,) = facing(epoch, OWN).marks
    range_m, bearing_deg = inverse(OWN, seen.position)
    assert range_m == pytest.approx(4000.0 - 15.0, abs=0.01)
    assert bearing_deg == pytest.approx(30.0, abs=1e-6)
    assert seen.hull_sigma_m == 0.0
    assert 30.0 < seen.sigma_m < 50.0


def test_facing_twice_changes_nothing_and_a_mark_given_as_its_echo_stays():
    epoch = Epoch(None, (), (ship(30.0, 4000.0, 75.0), replace(ship(80.0, 900.0, 75.0), hull_sigma_m=0.0)))
    once = facing(epoch, OWN)
    assert facing(once, OWN) == once
    assert once.marks[1] == epoch.marks[1]


def test_a_hull_that_is_nearer_than_its_own_length_does_not_change_sides():
    (seen,) = facing(Epoch(None, (), (ship(30.0, 60.0, heading_deg=30.0),)), OWN).marks
    assert inverse(OWN, seen.position)[0] == pytest.approx(30.0, abs=0.01)


def test_only_the_marks_of_pairs_are_moved_and_a_measured_centre_stays_the_centre():
    targets = (
        RadarTarget("1", 4000.0, 30.0),
        RadarTarget("2", 4000.0, 60.0, point="hull_centre"),
    )
    marks = (ship(30.0, 4000.0, 75.0), ship(60.0, 4000.0, 75.0), ship(90.0, 4000.0, 75.0))
    epoch = Epoch(None, targets, marks)
    seen = facing(epoch, OWN, np.array([[0, 0], [1, 1]]))
    assert inverse(OWN, seen.marks[0].position)[0] < 3999.0
    assert seen.marks[1].position == marks[1].position
    assert seen.marks[1].sigma_m == pytest.approx(30.0)  # 50 without the hull's 40: the antenna's place is known
    assert seen.marks[2] == marks[2]


def test_a_size_without_the_antenna_leaves_the_centre_uncertain_along_the_hull():
    mark = ship(60.0, 4000.0, 75.0, hull=Hull(0.0, 200.0, 0.0, 30.0))
    assert at_centre(mark).sigma_m == pytest.approx(math.hypot(30.0, 200.0 / math.sqrt(12.0) / math.sqrt(2.0)))


def test_without_a_heading_the_antenna_may_be_on_either_side_of_the_centre():
    with_heading, without = hull_shift(size_of(LONG), 20.0), hull_shift(size_of(LONG), None)
    assert (without.north_m, without.east_m) == (0.0, 0.0)
    assert without.sigma_m == pytest.approx(math.hypot(with_heading.sigma_m, math.hypot(80.0, 5.0) / math.sqrt(2.0)))


def test_an_aid_without_dimensions_is_a_point():
    assert echo(size_of(None, aid=True), 1.0).depth_m == 0.0
    assert hull_shift(size_of(None, aid=True), None).sigma_m == 0.0


@pytest.mark.parametrize(
    ("ais_class", "ship_type", "name"),
    [("A", 70, "cargo"), ("A", 89, "tanker"), ("A", 52, "service"), ("A", None, "class_a"), ("A", 20, "class_a"),
     ("B", 70, "class_b"), (None, 0, "class_a")],
)  # fmt: skip
def test_an_unknown_size_is_expected_from_class_and_type(ais_class: str | None, ship_type: int | None, name: str):
    assert hull_model_of(ais_class, ship_type).name == name


def test_a_ship_without_dimensions_has_a_smaller_sigma_as_class_b_than_as_class_a():
    report = AisPosition(T0, 211000001, 1, "ship", 54.0, 8.0, True, 5.0, 90.0, 85.0, ais_class="A")
    sigma_m = {}
    for ais_class in ("A", "B"):
        traffic = Traffic()
        traffic.feed(replace(report, ais_class=ais_class))
        (mark,), _ = traffic.marks(T0)
        sigma_m[ais_class] = mark.hull_sigma_m
        assert mark.hull_sigma_m < mark.sigma_m
    assert sigma_m["B"] < 8.0 < 20.0 < sigma_m["A"]


def test_the_type_of_the_static_report_tells_the_size_to_expect():
    traffic = Traffic()
    traffic.feed(AisPosition(T0, 211000001, 1, "ship", 54.0, 8.0, True, 5.0, 90.0, 90.0, ais_class="A"))
    traffic.feed(AisStatic(T0, 211000001, 5, ship_type=80))
    (mark,), _ = traffic.marks(T0)
    assert inverse(Position(54.0, 8.0), mark.position)[0] == pytest.approx(0.25 * 150.0, abs=0.01)


def test_marks_at_their_visible_side_give_own_place_back_where_centres_do_not():
    """Six long ships on one side of own ship: with their centres the fix lies away from them."""
    marks = tuple(
        replace(ship(bearing, 3000.0 + 200.0 * k, (bearing + 50.0 * k) % 360.0), label=f"ship {k}")
        for k, bearing in enumerate((10.0, 30.0, 50.0, 70.0, 90.0, 110.0))
    )
    targets = []
    for k, mark in enumerate(facing(Epoch(None, (), marks), OWN).marks):
        range_m, bearing_deg = inverse(OWN, mark.position)
        targets.append(RadarTarget(f"{k}", range_m, (bearing_deg - 20.0) % 360.0))
    epoch = Epoch(None, tuple(targets), marks)
    by_hand = Association.from_pairs(epoch, [(k, k) for k in range(6)])
    found = pipeline.answer(epoch, association=by_hand).fix
    assert found is not None
    assert isinstance(found.position, Position)
    assert inverse(OWN, found.position)[0] < 1.0
    assert found.heading_deg == pytest.approx(20.0, abs=0.01)
    centres = adjust(epoch, by_hand)
    assert isinstance(centres.position, Position)
    assert inverse(OWN, centres.position)[0] > 10.0
