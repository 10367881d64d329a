"""Grey relational association: sections, models, degrees and their axioms, weights, decisions, whole tracks."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from navfix.association.grey import (
    PolarTrack,
    candidate_radius_m,
    lagrange_weights,
    match_track,
    match_tracks,
    relational_degrees,
    report_interval_s,
    section_length,
)
from navfix.association.grey_pairs import grey_association, poses_between
from navfix.association.grey_tracks import SeenFrom, polar_tracks
from navfix.catalog import radar_model, track_association_model
from navfix.errors import InputError
from navfix.geodesy import direct, inverse
from navfix.types import Epoch, Mark, Position, RadarTarget

START = datetime(2026, 1, 1, tzinfo=UTC)
MODEL, RADAR = track_association_model("grey"), radar_model("imo")
apart = arrays(np.float64, st.integers(1, 6), elements=st.floats(0.0, 1e4))


def track(label: str, north: float, east: float, north_mps: float, east_mps: float, *, every_s: float = 3.0,
          lasts_s: float = 90.0, sigma_m: float = 0.0, seed: int = 0) -> PolarTrack:  # fmt: skip
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, lasts_s, every_s)
    x = north + north_mps * time_s + rng.normal(0, sigma_m, len(time_s))
    y = east + east_mps * time_s + rng.normal(0, sigma_m, len(time_s))
    speed = np.full(len(time_s), math.hypot(north_mps, east_mps))
    return PolarTrack(label, 1000.0 + time_s, np.hypot(x, y), np.degrees(np.arctan2(y, x)) % 360.0, speed)


# ------------------------------------------------------------------------------------------------- series


def test_a_section_ends_where_a_class_ratio_leaves_the_cover() -> None:
    steady = np.full(20, 5.0)
    jump = np.concatenate([np.full(8, 5.0), np.full(12, 15.0)])
    assert section_length([steady, steady], 5) == 20
    assert section_length([steady, jump], 5) == 8
    assert section_length([steady[:3]], 5) == 3
    growing = 1.2 ** np.arange(20)  # ln 1.2 = 0.182 < 2 / (n + 1) up to n = 9
    assert section_length([growing], 5) == 9


def test_values_at_zero_have_no_class_ratio() -> None:
    assert section_length([np.zeros(20)], 5) == 5


# ------------------------------------------------------------------------------------------------- degrees


@given(st.lists(apart, min_size=1, max_size=5), st.floats(0.05, 0.95))
def test_the_degree_is_normal_between_zero_and_one(differences: list[np.ndarray], rho: float) -> None:
    degrees = relational_degrees(differences, rho)
    assert ((degrees > 0.0) & (degrees <= 1.0 + 1e-12)).all()


@given(st.lists(apart, min_size=2, max_size=5), st.floats(0.05, 0.95))
def test_the_degree_grows_with_closeness(differences: list[np.ndarray], rho: float) -> None:
    """Closeness: a candidate that is nowhere farther off has no smaller degree."""
    nearer = differences[0] * 0.5
    degrees = relational_degrees([nearer, *differences], rho)
    assert degrees[0] >= degrees[1] - 1e-12


@given(apart, st.floats(0.05, 0.95))
def test_two_series_are_as_close_as_seen_from_either(difference: np.ndarray, rho: float) -> None:
    """Even symmetry: with one candidate the absolute differences, and so the degree, are the same both ways."""
    assert relational_degrees([np.abs(-difference)], rho) == pytest.approx(relational_degrees([difference], rho))


@given(apart, apart, st.floats(0.05, 0.95))
def test_the_degree_depends_on_all_that_are_compared(one: np.ndarray, other: np.ndarray, rho: float) -> None:
    """Wholeness: a farther third candidate lifts the degrees of the others, which stay in their order."""
    third = np.array([10.0 * max(one.max(), other.max()) + 1.0])
    two, three = relational_degrees([one, other], rho), relational_degrees([one, other, third], rho)
    assert (three[:2] >= two - 1e-9).all()


def test_no_difference_at_all_is_degree_one() -> None:
    assert relational_degrees([np.zeros(4), np.zeros(2)], 0.5).tolist() == [1.0, 1.0]
    assert len(relational_degrees([], 0.5)) == 0


def test_a_degree_by_hand() -> None:
    degrees = relational_degrees([np.array([1.0, 3.0]), np.array([9.0])], 0.5)
    assert degrees == pytest.approx([(5.5 / 5.5 + 5.5 / 7.5) / 2.0, 5.5 / 13.5])


@given(arrays(np.float64, 3, elements=st.floats(0.01, 1.0)), arrays(np.float64, 3, elements=st.floats(0.01, 1.0)))
def test_the_weights_of_lagrange_are_the_best_ones(degrees: np.ndarray, other: np.ndarray) -> None:
    weights, least = lagrange_weights(degrees)
    assert weights.sum() == pytest.approx(1.0)
    assert np.sum(weights**2 / degrees) == pytest.approx(least)
    assert np.sum((other / other.sum()) ** 2 / degrees) >= least - 1e-9


# ------------------------------------------------------------------------------------------------- candidates


def test_the_reach_counts_way_range_and_bearing() -> None:
    near, far = (candidate_radius_m(5.0, range_m, RADAR, MODEL) for range_m in (500.0, 20000.0))
    assert near == pytest.approx(5.0 * 10.0 + 3.0 * (math.hypot(25.5, 500.0 * math.radians(1.02)) + 15.0))
    assert far > 1000.0


def test_fast_ships_report_more_often() -> None:
    assert [report_interval_s(v) for v in (0.0, 5.0, 10.0, 15.0)] == [180.0, 10.0, 6.0, 2.0]


# ------------------------------------------------------------------------------------------------- tracks


def test_each_track_finds_its_ship_also_across_north() -> None:
    places = {"A": (4000.0, -100.0, -6.0, 3.0), "B": (4300.0, 150.0, -2.0, -3.0), "C": (-2000.0, 900.0, 0.0, 8.0)}
    ais = [track(name, *place, every_s=7.0) for name, place in places.items()]
    seen = [track(name.lower(), *place, sigma_m=15.0, seed=3) for name, place in places.items()]
    found = {match.radar: match for match in match_tracks(seen, ais)}
    assert {radar: match.ais for radar, match in found.items()} == {"a": "A", "b": "B", "c": "C"}
    assert all(match.degree > match.next_best for match in found.values())


def test_the_whole_track_decides_over_its_sections() -> None:
    seen = track("a", 4000.0, 0.0, -6.0, 0.0)
    faster = replace(seen, speed_mps=np.where(seen.time_s < 1045.0, 6.0, 60.0))
    ais = [track("A", 4000.0, 20.0, -6.0, 0.0, every_s=5.0), track("B", 4100.0, -80.0, -6.5, 0.0, every_s=5.0)]
    match = match_track(faster, ais)
    assert (match.ais, match.sections) == ("A", 2)


def test_nobody_within_reach_is_no_match() -> None:
    match = match_track(track("a", 4000.0, 0.0, -6.0, 0.0), [track("A", -4000.0, 0.0, 0.0, 0.0)])
    assert (match.ais, match.degree) == (None, 0.0)
    assert match_track(track("a", 4000.0, 0.0, 0.0, 0.0), []).ais is None
    assert match_track(track("a", 4000.0, 0.0, 0.0, 0.0).part(0, 3), [track("A", 4000.0, 0.0, 0.0, 0.0)]).ais is None


def test_epochs_about_known_poses_become_tracks() -> None:
    own, epochs, poses = Position(60.0, 179.999), [], []
    ship = direct(own, 45.0, 3000.0)
    for turn in range(20):
        here = direct(own, 90.0, 5.0 * 2.5 * turn)
        range_m, bearing_deg = inverse(here, ship)
        target = RadarTarget("07", range_m, bearing_deg - 30.0)
        now = datetime(2026, 1, 1, tzinfo=UTC) + timedelta(seconds=2.5 * turn)
        epochs.append(Epoch(now, (target,), (Mark("1", ship, 10.0, speed_mps=0.0), Mark("2", own, 10.0))))
        poses.append(SeenFrom(here, 30.0))
    targets, marks = polar_tracks(epochs, poses)
    assert [t.label for t in targets] == ["07"]
    assert targets[0].bearing_deg == pytest.approx(marks[0].bearing_deg)
    assert targets[0].speed_mps == pytest.approx(np.zeros(20), abs=0.1)
    assert match_track(targets[0], marks).ais == "1"


def past_two_ships(turns: int = 20) -> tuple[list[Epoch], list[SeenFrom]]:
    """Return epochs of a ship that runs past two others at anchor, across 180 deg, of which one is seen twice."""
    own, epochs, poses = Position(60.0, 179.999), [], []
    ships = [direct(own, 45.0, 3000.0), direct(own, 300.0, 5000.0)]
    for turn in range(turns):
        here = direct(own, 90.0, 5.0 * 2.5 * turn)
        places = [ships[0], ships[1], direct(ships[1], 10.0, 120.0)]
        targets = []
        for label, place in zip(("07", "08", "09"), places, strict=True):
            range_m, bearing_deg = inverse(here, place)
            targets.append(RadarTarget(label, range_m, bearing_deg - 30.0))
        marks = tuple(Mark(str(k), ship, 10.0, speed_mps=0.0) for k, ship in enumerate(ships))
        epochs.append(Epoch(START + timedelta(seconds=2.5 * turn), tuple(targets), marks))
        poses.append(SeenFrom(here, 30.0))
    return epochs, poses


def test_of_two_echoes_near_one_ship_the_nearer_is_paired() -> None:
    epochs, poses = past_two_ships()
    found = grey_association(epochs, poses)
    assert sorted(map(tuple, found.pairs.tolist())) == [(0, 0), (1, 1)]
    assert found.method == "grey_relational"
    assert found.probability.max() <= 1.0


def test_poses_between_fixes_lie_on_straight_lines_and_headings_go_the_short_way() -> None:
    epochs, poses = past_two_ships(5)
    first, last = (epoch.time_utc.timestamp() for epoch in (epochs[0], epochs[-1]))
    known = {first: SeenFrom(poses[0].position, 350.0), last: SeenFrom(poses[-1].position, 10.0)}
    between = poses_between(epochs, known)
    assert inverse(between[2].position, poses[2].position)[0] < 0.1
    assert math.cos(math.radians(between[2].heading_deg)) == pytest.approx(1.0)
    alone = poses_between(epochs, {last: poses[-1]})
    assert inverse(alone[0].position, poses[-1].position)[0] < 1e-6


def test_grey_pairs_need_a_pose_for_every_epoch() -> None:
    epochs, poses = past_two_ships(5)
    with pytest.raises(InputError, match="as many own poses as epochs"):
        grey_association(epochs, poses[1:])
    with pytest.raises(InputError, match="one known pose at least"):
        poses_between(epochs, {})
