"""Radar and AIS in one format, filtered and fused; the board that keeps, finds and tells."""

import json
import math
from dataclasses import fields, replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix import pipeline
from navfix.catalog import ais_model, track_model
from navfix.errors import InputError
from navfix.geodesy import direct, inverse
from navfix.picture.board import TargetBoard
from navfix.picture.fusion import OwnPose, fuse, fuse_angles, fused_list, lists_apart
from navfix.picture.kalman import predict, start, update
from navfix.picture.sensor_tracks import SensorTracks
from navfix.report.targets import WRITERS, to_dict
from navfix.types import Association, Epoch, Mark, Position, RadarTarget, TargetList, TrackedShip

T0 = datetime(2026, 3, 1, 12, 0, tzinfo=UTC)
OWN = Position(54.0, 8.0)
POSE = OwnPose(OWN, 20.0, np.diag([100.0, 100.0, math.radians(0.2) ** 2]))
NAMES = ("FIRST", "SECOND")


def scene(time_utc: datetime = T0, noise: tuple[float, float] = (0.0, 0.0)) -> Epoch:
    """Two ships with echo and AIS, one echo alone, one AIS alone; relative bearings, heading 20."""
    marks = tuple(
        Mark(
            f"21100000{k}",
            direct(OWN, bearing, 4000.0),
            20.0,
            mmsi=211000000 + k,
            name=NAMES[k] if k < 2 else None,
            speed_mps=5.0,
            course_deg=358.0,
            time_utc=time_utc,
            ais_class="A",
        )
        for k, bearing in enumerate((10.0, 100.0, 250.0))
    )
    targets = tuple(
        RadarTarget(
            f"{k + 1:02d}",
            range_m + noise[0],
            bearing - 20.0 + noise[1],
            range_sigma_m=25.0,
            bearing_sigma_deg=1.0,
            speed_mps=6.0,
            course_deg=2.0,
        )
        for k, (bearing, range_m) in enumerate(((10.0, 4030.0), (100.0, 4030.0), (300.0, 2000.0)))
    )
    return Epoch(time_utc, targets, marks)


PAIRS = Association(pairs=np.array([[0, 0], [1, 1]]), probability=np.array([0.99, 0.9]))


# --------------------------------------------------------------------------------------------------------------- fuse


def test_the_fused_value_lies_nearer_to_the_surer_one_and_is_surer_than_both():
    value, variance = fuse(np.array([10.0, 20.0]), np.array([1.0, 4.0]))
    assert value == pytest.approx(12.0)
    assert variance == pytest.approx(0.8)


def test_angles_are_fused_across_north():
    value, _ = fuse_angles(np.array([359.0, 3.0]), np.array([1.0, 1.0]))
    assert value == pytest.approx(1.0)


@pytest.mark.parametrize("kind", ["aton", "charted"])
def test_an_aid_to_navigation_does_not_take_the_speed_of_the_radar_track(kind):
    epoch = scene()
    buoy = replace(epoch.marks[0], kind=kind, speed_mps=None, course_deg=None)
    first, second = fused_list(replace(epoch, marks=(buoy, *epoch.marks[1:])), POSE, PAIRS).ships[:2]
    assert first.sensor == "fused"
    assert (first.speed_mps, first.course_deg) == (None, None)
    assert (first.speed_variance_m2ps2, first.course_variance_deg2) == (None, None)
    assert first.range_m == pytest.approx(second.range_m), "place is fused as that of a ship"
    assert second.speed_mps is not None


def test_pairs_are_fused_and_the_others_stand_alone():
    ships = fused_list(scene(), POSE, PAIRS)
    assert [ship.sensor for ship in ships.ships] == ["fused", "fused", "radar", "ais"]
    first = ships.ships[0]
    assert (first.target, first.mmsi, first.name, first.probability) == ("01", 211000000, "FIRST", 0.99)
    # AIS: 20 m and own place 10 m; radar 25 m. Both ranges count by their inverse variances.
    assert first.range_m == pytest.approx((4000.0 / 500.0 + 4030.0 / 625.0) / (1 / 500.0 + 1 / 625.0), abs=0.01)
    assert first.range_variance_m2 == pytest.approx(1.0 / (1 / 500.0 + 1 / 625.0))
    assert first.bearing_deg == pytest.approx(10.0, abs=0.01)
    # Courses of 2 deg at 6 m/s (radar) and 358 deg at 5 m/s (AIS), each as sure as its sensor's speeds are.
    radar, ais = (6.0 / track_model().radar_speed_sigma_mps) ** 2, (5.0 / ais_model("class_a").speed_sigma_mps) ** 2
    assert first.course_deg == pytest.approx((358.0 * ais + 362.0 * radar) / (ais + radar) % 360.0, abs=0.01)
    assert first.position is not None
    assert inverse(OWN, first.position)[0] == pytest.approx(first.range_m, abs=1e-3)


def test_a_pair_that_contradicts_itself_is_not_fused():
    epoch = scene()
    wrong = replace(epoch.targets[0], range_m=4300.0)
    ships = fused_list(replace(epoch, targets=(wrong, *epoch.targets[1:])), POSE, PAIRS)
    assert [ship.mark for ship in ships.of("fused")] == ["211000001"]
    assert "01" in {ship.target for ship in ships.of("radar")}
    assert "211000000" in {ship.mark for ship in ships.of("ais")}


def test_an_echo_alone_has_a_true_bearing_and_a_place_by_own_heading():
    echo = fused_list(scene(), POSE, PAIRS).of("radar")[0]
    assert (echo.bearing_deg, echo.bearing_reference) == (pytest.approx(300.0), "true")
    assert echo.bearing_variance_deg2 == pytest.approx(1.0 + 0.04)
    assert echo.position is not None


def test_without_a_fix_both_lists_stand_apart_and_nothing_is_fused():
    ships = lists_apart(scene(), reason="ambiguous", message="two places")
    assert {ship.sensor for ship in ships.ships} == {"radar", "ais"}
    assert all(ship.bearing_reference == "relative" for ship in ships.of("radar"))
    assert all(ship.range_m is None and ship.position is not None for ship in ships.of("ais"))


def test_an_unknown_heading_leaves_relative_bearings_unfused():
    pose = OwnPose(OWN, None, np.diag([100.0, 100.0]))
    assert fused_list(scene(), pose, PAIRS).of("fused") == ()


def test_a_value_without_its_variance_is_refused():
    with pytest.raises(InputError, match="range_m"):
        TrackedShip("radar", "01", range_m=100.0)


# ------------------------------------------------------------------------------------------------------------- filters


def test_the_filter_of_a_steady_course_halves_the_noise_and_knows_it():
    rng, errors, sigmas = np.random.default_rng(1), [], []
    for _ in range(200):
        track = start(0.0, float(rng.normal(0.0, 10.0)), 100.0, rate_variance=400.0)
        for step in range(1, 25):
            track = update(predict(track, 2.5 * step, 0.02), 12.5 * step + float(rng.normal(0.0, 10.0)), 100.0)
        errors.append(track.value - 300.0)
        sigmas.append(math.sqrt(track.covariance[0, 0]))
    assert np.std(errors) < 5.0
    assert np.std(errors) == pytest.approx(np.mean(sigmas), rel=0.2)


def test_a_rate_measured_moves_the_rate():
    track = update(start(0.0, 0.0, 1.0, rate_variance=4.0), 3.0, 1.0, row=1)
    assert track.rate == pytest.approx(2.4)


def test_the_sensors_are_filtered_and_what_stays_of_their_errors_stays():
    tracks, rng = SensorTracks(), np.random.default_rng(2)
    for step in range(25):
        noise = float(rng.normal(0.0, 25.0 / math.sqrt(2.0))), float(rng.normal(0.0, 1.0 / math.sqrt(2.0)))
        filtered = tracks.feed(scene(T0 + timedelta(seconds=2.5 * step), noise))
    assert abs(filtered.targets[0].range_m - 4030.0) < 12.0
    assert 25.0 / math.sqrt(2.0) < (filtered.targets[0].range_sigma_m or 0.0) < 20.0
    assert filtered.marks[0].sigma_m < 20.0


def test_a_number_that_is_given_to_another_ship_starts_a_new_track():
    tracks = SensorTracks()
    tracks.feed(scene())
    moved = replace(scene(T0 + timedelta(seconds=2.5)).targets[0], range_m=9000.0)
    filtered = tracks.feed(Epoch(T0 + timedelta(seconds=2.5), (moved,), ()))
    assert filtered.targets[0].range_m == pytest.approx(9000.0)


def test_a_bearing_that_crosses_north_is_followed():
    tracks = SensorTracks()
    for step in range(20):
        target = RadarTarget("01", 4000.0, (355.0 + 0.5 * step) % 360.0, range_sigma_m=25.0, bearing_sigma_deg=0.5)
        filtered = tracks.feed(Epoch(T0 + timedelta(seconds=2.5 * step), (target,), ()))
    assert filtered.targets[0].bearing_deg == pytest.approx(4.5, abs=0.2)


def test_no_epoch_is_no_list():
    with pytest.raises(InputError, match="at least one epoch"):
        pipeline.targets([])


def test_a_scene_without_a_fix_says_why():
    ships = pipeline.targets([scene()])
    assert ships.own_position is None
    assert ships.reason in ("too_few_pairs", "no_agreement", "ambiguous")
    assert ships.message


# --------------------------------------------------------------------------------------------------------------- board


def test_the_board_finds_by_target_mmsi_and_name():
    board = TargetBoard()
    assert board.find("01") == ()
    board.update(fused_list(scene(), POSE, PAIRS))
    for key in ("01", "1", 1, 211000000, "211000000", "first"):
        assert [ship.name for ship in board.find(key)] == ["FIRST"]
    assert len(board.find("S")) == 2  # FIRST, SECOND
    assert board.find("") == board.find("ZZ") == ()


def test_the_board_tells_each_watcher_until_it_stops_watching():
    board, told = TargetBoard(), []
    stop = board.watch(told.append)
    first, second = TargetList(T0, ()), TargetList(T0, ())
    board.update(first)
    stop()
    stop()
    board.update(second)
    assert told == [first]
    assert board.newest is second


# ------------------------------------------------------------------------------------------------------------- writers


def test_radar_ais_and_fused_ships_have_the_same_keys():
    """One format for both streams and for what is fused of them."""
    rows = to_dict(fused_list(scene(), POSE, PAIRS))["targets"]
    apart = to_dict(lists_apart(scene(), reason="ambiguous", message="two places"))["targets"]
    assert {row["sensor"] for row in rows} == {"radar", "ais", "fused"}
    assert len({tuple(row) for row in rows + apart}) == 1
    assert {f.name for f in fields(TrackedShip)} - {"time_utc"} <= set(rows[0])


def test_every_writer_writes_every_ship_also_without_a_fix():
    for ships in (fused_list(scene(), POSE, PAIRS), lists_apart(scene(), reason="ambiguous", message="two places")):
        count = len(ships.ships)
        assert len(json.loads(WRITERS[".json"](ships))["targets"]) == count
        assert len(WRITERS[".csv"](ships).splitlines()) == count + 1
        own = ships.own_position is not None
        located = sum(ship.position is not None for ship in ships.ships)
        assert len(json.loads(WRITERS[".geojson"](ships))["features"]) == located + own
        text = WRITERS[".txt"](ships)
        assert all(len(line) <= 100 for line in text.splitlines())
        assert ("NOT FUSED: no fix (ambiguous): two places" in text) == (not own)
