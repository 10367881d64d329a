"""Association of one scan: right pairs, honest refusals, every answer listed."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

import navfix
from navfix.catalog import association_model
from navfix.errors import Ambiguous, NoAgreement, NoFix, TooFewPairs
from navfix.geodesy import LocalPlane, direct, inverse
from navfix.simulation.scenes import SceneRecipe, make_scene
from navfix.types import Epoch, HeadingHint, Mark, Position, RadarTarget
from navfix.units import NM_M, wrap_180

BUSY = SceneRecipe(25, 80, 12.0, 20.0, clutter=0.25, false_ais=0.1)


def seen_from(position: Position, heading_deg: float, marks: tuple[Mark, ...]) -> tuple[RadarTarget, ...]:
    polar = [inverse(position, mark.position) for mark in marks]
    return tuple(
        RadarTarget(f"{i:02d}", r, b - heading_deg, range_sigma_m=20.0, bearing_sigma_deg=0.5)
        for i, (r, b) in enumerate(polar)
    )


def test_a_busy_scene_gives_the_true_pose_and_right_pairs():
    made = make_scene(BUSY, 11)
    found = navfix.associate(made.epoch)
    right = {tuple(pair) for pair in made.pairs}
    mine = {tuple(pair) for pair in found.pairs}
    assert inverse(found.position, made.position)[0] < 100.0
    assert abs(wrap_180(found.heading_deg - made.heading_deg)) < 1.0
    assert len(mine & right) >= 0.8 * len(right)
    assert found.margin > 7.0
    assert found.probability_wrong < 0.02


def test_probabilities_tell_right_pairs_from_wrong_ones():
    likely, unlikely = [], []
    for seed in range(20):
        made = make_scene(BUSY, seed)
        found = navfix.associate(made.epoch)
        right = {tuple(pair) for pair in made.pairs}
        for pair, probability in zip(found.pairs, found.probability, strict=True):
            (likely if probability > 0.95 else unlikely).append(tuple(pair) in right)
    assert np.mean(likely) > 0.97
    assert np.mean(unlikely) < np.mean(likely)


def test_order_of_targets_and_marks_changes_nothing():
    made = make_scene(BUSY, 3)
    turned = replace(made.epoch, targets=made.epoch.targets[::-1], marks=made.epoch.marks[::-1])
    one, other = navfix.associate(made.epoch), navfix.associate(turned)
    assert inverse(one.position, other.position)[0] < 1.0
    labels = lambda epoch, found: {(epoch.targets[t].label, epoch.marks[m].label) for t, m in found.pairs}  # noqa: E731
    assert labels(made.epoch, one) == labels(turned, other)


def test_too_few_targets_or_marks_are_said_to_be_too_few():
    made = make_scene(BUSY, 1)
    with pytest.raises(TooFewPairs, match="2 radar targets") as caught:
        navfix.associate(replace(made.epoch, targets=made.epoch.targets[:2]))
    assert (caught.value.observations, caught.value.unknowns) == (4, 3)
    with pytest.raises(TooFewPairs, match="0 marks"):
        navfix.associate(replace(made.epoch, marks=()))


def test_echoes_that_are_no_ships_agree_with_nothing():
    for seed in range(20):
        made = make_scene(replace(BUSY, clutter=1.0), seed)
        with pytest.raises(NoFix):
            navfix.associate(made.epoch)


def test_a_mirrored_scene_is_refused():
    made = make_scene(replace(BUSY, clutter=0.0, false_ais=0.0), 5)
    mirrored = tuple(replace(t, bearing_deg=-t.bearing_deg) for t in made.epoch.targets)
    with pytest.raises((NoAgreement, Ambiguous)):
        navfix.associate(replace(made.epoch, targets=mirrored))


def test_a_refusal_of_echoes_in_one_line_does_not_call_the_bearings_anticlockwise():
    """In one line the mirrored echoes fit exactly as well."""
    own, rng = Position(54.0, 8.0), np.random.default_rng(7)
    marks = tuple(
        Mark(f"{i}", direct(own, 33.0, r), 10.0, kind="ship") for i, r in enumerate(rng.uniform(7e2, 15e3, 8))
    )
    with pytest.raises(NoAgreement, match=r"fit the marks as well .* all in one line"):
        navfix.associate(Epoch(None, seen_from(own, 200.0, marks), marks))


def test_a_regular_row_of_buoys_gives_every_place_and_never_one():
    plane = LocalPlane(Position(54.0, 8.0))
    row = tuple(Mark(f"buoy {i}", plane.to_position(0.0, i * NM_M), 10.0, kind="aton") for i in range(12))
    targets = seen_from(plane.to_position(-900.0, 5.4 * NM_M), 40.0, row[3:9])
    with pytest.raises(Ambiguous) as caught:
        navfix.associate(Epoch(None, targets, row))
    assert len(caught.value.alternatives) >= 7
    truth = plane.to_position(-900.0, 5.4 * NM_M)
    assert min(inverse(a.position, truth)[0] for a in caught.value.alternatives) < 100.0


@pytest.mark.parametrize(
    "centre", [Position(-17.0, 179.99), Position(80.0, 10.0), Position(0.0, 0.0), Position(-54.0, -68.0)]
)
def test_the_place_on_earth_changes_nothing(centre: Position):
    made = make_scene(replace(BUSY, centre=centre), 2)
    found = navfix.associate(made.epoch)
    assert inverse(found.position, made.position)[0] < 100.0


def _far_east_of_the_ships(random: np.random.Generator, time_utc: datetime | None = None) -> Epoch:
    """Twelve ships about own ship at 75 N on 30 degrees, sixty farther west: meridians converge by a degree."""
    own = Position(75.0, 20.0)
    near = [direct(own, a, r) for a, r in zip(np.arange(12) * 29.0, 3000.0 + 900.0 * np.arange(12), strict=True)]
    away = [
        direct(own, a, r) for a, r in zip(random.uniform(230.0, 310.0, 60), random.uniform(3e4, 6e4, 60), strict=True)
    ]
    seen = [inverse(own, place) for place in near]
    return Epoch(
        time_utc,
        tuple(RadarTarget(f"{k}", r, (a - 30.0) % 360.0, range_sigma_m=20.0) for k, (r, a) in enumerate(seen)),
        tuple(Mark(f"{k}", place, 10.0, mmsi=200000000 + k) for k, place in enumerate(near + away)),
    )


def test_the_heading_counts_from_the_meridian_of_own_ship():
    """Not from that of the middle of the AIS picture, a degree away."""
    found = navfix.associate(_far_east_of_the_ships(np.random.default_rng(1)))
    assert wrap_180(found.heading_deg - 30.0) == pytest.approx(0.0, abs=0.02)
    exact = replace(_far_east_of_the_ships(np.random.default_rng(1)), heading_hint=HeadingHint(30.0, 0.1))
    tight = replace(association_model(), alignment_sigma_deg=0.1)
    assert navfix.associate(exact, method=tight).evidence > found.evidence + 3.0


def test_the_heading_of_a_window_counts_from_there_too():
    begin = datetime(2026, 3, 1, tzinfo=UTC)
    scans = [_far_east_of_the_ships(np.random.default_rng(1), begin + timedelta(seconds=10 * k)) for k in range(4)]
    found = navfix.associate(scans)
    assert wrap_180(found.heading_deg - 30.0) == pytest.approx(0.0, abs=0.05)


def test_true_bearings_are_associated_too():
    made = make_scene(BUSY, 8)
    true = tuple(
        replace(t, bearing_deg=t.bearing_deg + made.heading_deg, bearing_reference="true") for t in made.epoch.targets
    )
    found = navfix.associate(replace(made.epoch, targets=true))
    assert inverse(found.position, made.position)[0] < 100.0


def test_ships_of_another_place_far_away_do_not_matter():
    made = make_scene(BUSY, 4)
    far = tuple(Mark(f"far {i}", Position(-30.0 + i, 100.0), 10.0) for i in range(20))
    found = navfix.associate(replace(made.epoch, marks=made.epoch.marks + far))
    assert inverse(found.position, made.position)[0] < 100.0
