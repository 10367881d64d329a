"""Scenarios and recordings: loading and its refusals, determinism, what stands in log, truth and association."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from navfix.errors import CatalogError, InputError, NavfixError
from navfix.geodesy import inverse
from navfix.nmea import read_log
from navfix.nmea.records import AisPosition, OwnHeading, OwnPosition, OwnSpeed, TargetReport
from navfix.simulation import files, scenario
from navfix.simulation.scenario import Recording, from_text, load, simulate
from navfix.simulation.settings import AisSettings, OwnSensors, OwnShip, RadarSettings, TrafficGroup
from navfix.simulation.traffic import place
from navfix.types import Position
from navfix.units import KNOT_MPS, wrap_180

SMALL = """
title = "small"
source = "test"
start_utc = 2026-03-01T09:00:00Z
duration_s = 60.0
lat_deg = 54.0
lon_deg = 12.0
[own]
speed_mps = 5.0
course_deg = 30.0
[[traffic]]
layout = "uniform"
count = 8
radius_m = 6000.0
inner_radius_m = 500.0
"""


@pytest.fixture(scope="module")
def approach() -> Recording:
    return simulate(load("approach"), 1)


# ------------------------------------------------------------------------------------------------- loading


def test_the_shipped_scenarios_are_those_that_the_documents_name() -> None:
    wanted = {"approach", "anchorage", "lane", "buoyed_channel", "open_sea", "date_line", "high_latitude"}
    assert wanted <= set(scenario.names())


@pytest.mark.parametrize("name", scenario.names())
def test_every_shipped_scenario_loads_runs_and_is_read_without_a_problem(name: str) -> None:
    recording = simulate(load(name), 2, duration_s=40.0)
    log = read_log(list(recording.lines))
    assert log.problems == ()
    assert {type(record) for record in log.records} >= {TargetReport, AisPosition}
    assert recording.scenario.source


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[own]", "[own]\nspeed_kn = 3.0"), "unknown key 'speed_kn'"),
        (("course_deg = 30.0\n", ""), "missing key 'course_deg'"),
        (("lat_deg = 54.0\n", ""), "missing key 'lat_deg'"),
        (("lat_deg = 54.0", 'lat_deg = "north"'), "must be numbers"),
        (("lat_deg = 54.0", "lat_deg = 89.5"), "-88 .. 88"),
        (("duration_s = 60.0", "duration_s = 0.0"), "duration_s must be > 0"),
        (("2026-03-01T09:00:00Z", "2026-03-01T09:00:00"), "time zone"),
        (("2026-03-01T09:00:00Z", '"nine"'), "must be a TOML time"),
        (("count = 8", "count = 8.5"), "whole number"),
        (("count = 8", "count = -1"), ">= 0"),
        (('layout = "uniform"', 'layout = "circle"'), "must be one of uniform"),
        (("inner_radius_m = 500.0", "inner_radius_m = 9000.0"), "must be <= radius_m"),
        (("inner_radius_m = 500.0", "with_ais = 1.5"), "within 0 .. 1"),
        (("[own]", "[radar]\nrange_bias_m = true\n[own]"), "must be a number"),
        (("[own]", "[radar]\ndetection = nan\n[own]"), "finite"),
        (("[own]", "[sensors]\nlog = 1\n[own]"), "true or false"),
        (("[own]", '[ais]\noutages = "some"\n[own]'), "none or waigaoqiao"),
        (("[[traffic]]", "[traffic]"), r"\[\[traffic\]\] tables"),
        (("[own]", "ais = 3\n[own]"), "must be a table"),
        (("[own]", "[own"), "not a readable TOML"),
    ],
)
def test_a_scenario_that_cannot_be_right_is_refused_with_the_reason(change: tuple[str, str], message: str) -> None:
    assert change[0] in SMALL
    with pytest.raises(NavfixError, match=message) as caught:
        from_text(SMALL.replace(*change))
    assert isinstance(caught.value, CatalogError | InputError)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(CatalogError, match=r"no scenario named 'harbor'; there are .*approach"):
        load("harbor")


def test_a_scenario_file_outside_the_catalogue_loads(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(SMALL)
    assert load(path).name == "mine"


def test_a_missing_scenario_file_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(CatalogError, match=r"none\.toml: no such file"):
        load(tmp_path / "none.toml")


def test_an_unknown_radar_model_is_refused() -> None:
    with pytest.raises(CatalogError, match="no radar model"):
        simulate(replace(from_text(SMALL), radar=RadarSettings(model="sonar")), 1)


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(InputError, match="seed"):
        simulate(from_text(SMALL), -1)


@pytest.mark.parametrize("record", [OwnShip, TrafficGroup, AisSettings, RadarSettings, OwnSensors])
def test_every_setting_says_its_unit_or_is_a_count_share_or_word(record: type) -> None:
    suffixes = ("_m", "_s", "_deg", "_mps", "_deg_per_min")
    for field in fields(record):
        if "float" in str(field.type) and not field.name.endswith(suffixes):
            assert field.name in {
                "with_ais", "class_b", "turning", "unknown_size", "loss", "no_heading", "steady_share", "detection",
                "acquired", "edge_share", "false_per_turn", "false_turns", "log_scale",
            }  # fmt: skip


# ------------------------------------------------------------------------------------------------- determinism


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    one, same, other = (files.log_text(simulate(from_text(SMALL), seed)) for seed in (7, 7, 8))
    assert one == same
    assert one != other


def test_a_sensor_switched_on_leaves_radar_and_ais_as_they_were() -> None:
    plain = from_text(SMALL)
    more = replace(plain, sensors=OwnSensors(heading="hdt", log=True, gnss=True, own_ais=True))
    without = [line for line in simulate(more, 3).lines if "s:II0001" not in line]
    assert tuple(without) == simulate(plain, 3).lines


def test_a_radar_setting_leaves_the_ais_as_it_was() -> None:
    plain = from_text(SMALL)
    other = replace(plain, radar=RadarSettings(bearing_bias_deg=3.0, false_per_turn=1.0))
    ais_lines = [[line for line in simulate(s, 3).lines if "AIVDM" in line] for s in (plain, other)]
    assert ais_lines[0] == ais_lines[1]
    assert len(ais_lines[0]) > 20


# ------------------------------------------------------------------------------------------------- the recording


def test_lines_stand_in_the_order_of_their_time_stamps(approach: Recording) -> None:
    stamps = [int(line.split("c:")[1].split("*")[0]) for line in approach.lines]
    assert stamps == sorted(stamps)
    assert stamps[-1] - stamps[0] == pytest.approx(180, abs=3)


def test_the_demo_scene_is_as_busy_as_it_should_be(approach: Recording) -> None:
    log = read_log(list(approach.lines))
    stations = {record.mmsi for record in log.records if isinstance(record, AisPosition)}
    assert 75 <= len(stations) <= 90
    last_s = approach.association[-1].unix_s
    seen = {row.target_number: row.mmsi for row in approach.association if row.unix_s > last_s - 5.0}
    assert 22 <= len(seen) <= 30
    assert sum(mmsi == 0 for mmsi in seen.values()) >= 3
    assert len(set(seen.values()) & set(approach.wrong)) >= 2
    kinds = {record.kind for record in log.records if isinstance(record, AisPosition)}
    assert kinds == {"ship", "aton", "base_station", "aircraft", "long_range"}
    assert any(record.virtual for record in log.records if isinstance(record, AisPosition))


def test_the_log_holds_nothing_of_own_ship_by_default(approach: Recording) -> None:
    assert {line.split("\\")[2][1:6] for line in approach.lines} == {"AIVDM", "RATTM"}
    own = approach.scenario.own.mmsi
    positions = [r for r in read_log(list(approach.lines)).records if isinstance(r, AisPosition)]
    assert all(record.mmsi != own and not record.own for record in positions)


def test_neither_virtual_aids_nor_stations_ashore_nor_aircraft_have_an_echo(approach: Recording) -> None:
    blocks = {str(row.mmsi)[:6] for row in approach.association if row.mmsi}
    assert blocks <= {"200100", "992001"}


def test_no_ship_without_ais_is_heard(approach: Recording) -> None:
    world = approach.scenario.world(1)
    silent = [body for body in world.bodies if body.kind == "ship" and body.mmsi == 0]
    assert len(silent) == 10
    assert all(body.unit is None for body in silent)


@pytest.mark.parametrize("name", ["date_line", "high_latitude", "approach"])
def test_truth_is_the_path_that_speed_and_course_say(name: str) -> None:
    truth = simulate(load(name), 1, duration_s=60.0).truth
    for one, two in pairwise(truth):
        places = Position(one.lat_deg, one.lon_deg), Position(two.lat_deg, two.lon_deg)
        distance_m, azimuth_deg = inverse(*places)
        assert distance_m == pytest.approx((one.speed_mps + two.speed_mps) / 2.0, abs=0.01)
        assert abs(wrap_180(azimuth_deg - one.course_deg)) < 0.5


def test_the_date_line_scene_lies_on_both_sides_of_it() -> None:
    recording = simulate(load("date_line"), 1)
    log = read_log(list(recording.lines))
    longitudes = {np.sign(r.lon_deg or 0.0) for r in log.records if isinstance(r, AisPosition)}
    assert longitudes == {-1.0, 1.0}
    assert {np.sign(row.lon_deg) for row in recording.truth} == {-1.0, 1.0}
    assert all(-180.0 <= row.lon_deg <= 180.0 for row in recording.truth)


def test_the_zero_mark_is_the_heading_less_the_bearing_bias(approach: Recording) -> None:
    for row in approach.truth[::20]:
        assert wrap_180(row.heading_deg - row.radar_zero_deg) == pytest.approx(0.4)


# ------------------------------------------------------------------------------------------------- own sensors


def with_sensors(**settings: object) -> Recording:
    return simulate(replace(from_text(SMALL), sensors=OwnSensors(**settings)), 5)  # type: ignore[arg-type]


def truth_at(recording: Recording, time_s: float | None) -> scenario.TruthRow:
    assert time_s is not None
    return recording.truth[round(time_s - recording.truth[0].unix_s)]


@pytest.mark.parametrize("sentence", ["hdt", "ths"])
def test_the_gyro_has_its_bias_and_scatter(sentence: str) -> None:
    recording = with_sensors(heading=sentence, heading_bias_deg=1.5, heading_sigma_deg=0.2)
    headings = [r for r in read_log(list(recording.lines)).records if isinstance(r, OwnHeading)]
    errors = [wrap_180(r.heading_deg - truth_at(recording, r.time_s).heading_deg) for r in headings]
    assert len(errors) == 60
    assert np.mean(errors) == pytest.approx(1.5, abs=0.1)
    assert np.std(errors) == pytest.approx(0.2, abs=0.08)


def test_the_log_shows_speed_through_the_water() -> None:
    recording = with_sensors(log=True, log_scale=1.1, log_sigma_mps=0.0)
    speeds = [r.speed_mps for r in read_log(list(recording.lines)).records if isinstance(r, OwnSpeed)]
    assert speeds == pytest.approx([5.5] * 60, abs=0.01 * KNOT_MPS)


def gnss_errors(recording: Recording) -> list[tuple[float, float, float]]:
    """Return (seconds from the start, distance [m], azimuth [deg]) of the GNSS from the truth, each GGA and RMC."""
    found = []
    for record in read_log(list(recording.lines)).records:
        if isinstance(record, OwnPosition):
            row = truth_at(recording, record.time_s)
            here = Position(row.lat_deg, row.lon_deg)
            found.append(
                (row.unix_s - recording.truth[0].unix_s, *inverse(here, Position(record.lat_deg, record.lon_deg)))
            )
    return found


def test_an_honest_gnss_is_metres_off() -> None:
    errors = gnss_errors(with_sensors(gnss=True, gnss_sigma_m=3.0))
    assert len(errors) == 120
    assert max(distance_m for _, distance_m, _ in errors) < 15.0


def test_a_gnss_that_jumps_is_right_before_and_wrong_after() -> None:
    errors = gnss_errors(with_sensors(gnss=True, spoof="jump", spoof_at_s=30.0, spoof_offset_m=800.0))
    for since_s, distance_m, azimuth_deg in errors:
        if since_s < 30.0:
            assert distance_m < 15.0
        else:
            assert distance_m == pytest.approx(800.0, abs=15.0)
            assert azimuth_deg == pytest.approx(45.0, abs=1.5)


def test_a_gnss_that_is_dragged_off_runs_away_steadily_and_its_speed_agrees() -> None:
    recording = with_sensors(gnss=True, spoof="drag_off", spoof_at_s=20.0, spoof_rate_mps=10.0, spoof_azimuth_deg=30.0)
    for since_s, distance_m, _ in gnss_errors(recording):
        assert distance_m == pytest.approx(10.0 * max(0.0, since_s - 20.0), abs=15.0)
    speeds = [
        r.speed_mps for r in read_log(list(recording.lines)).records if isinstance(r, OwnPosition) and r.speed_mps
    ]
    assert (speeds[0], speeds[-1]) == pytest.approx((5.0, 15.0), abs=0.01)


def test_own_ais_reports_are_marked_as_own() -> None:
    records = [
        r for r in read_log(list(with_sensors(own_ais=True).lines)).records if isinstance(r, AisPosition) and r.own
    ]
    assert [record.mmsi for record in records] == [from_text(SMALL).own.mmsi] * 6


# ------------------------------------------------------------------------------------------------- layouts


def placed(**settings: object) -> np.ndarray:
    group = TrafficGroup(**settings)  # type: ignore[arg-type]
    return np.array([[p.north_m, p.east_m, p.course_deg, p.speed_mps] for p in place(group, np.random.default_rng(1))])


def test_uniform_traffic_fills_its_ring_evenly() -> None:
    rows = placed(layout="uniform", count=2000, radius_m=8000.0, inner_radius_m=2000.0, north_m=500.0, east_m=-100.0)
    distance_m = np.hypot(rows[:, 0] - 500.0, rows[:, 1] + 100.0)
    assert distance_m.min() >= 2000.0
    assert distance_m.max() <= 8000.0
    inner_share = (5000.0**2 - 2000.0**2) / (8000.0**2 - 2000.0**2)
    assert np.mean(distance_m < 5000.0) == pytest.approx(inner_share, abs=0.04)


def test_anchored_ships_keep_their_distance_and_lie_alike() -> None:
    rows = placed(layout="anchorage", count=20, radius_m=4000.0, spacing_m=600.0, axis_deg=250.0)
    apart_m = [math.dist(a, b) for i, a in enumerate(rows[:, :2]) for b in rows[:i, :2]]
    assert min(apart_m) >= 600.0
    assert np.std(rows[:, 2]) < 20.0
    assert np.all(rows[:, 3] == 0.0)


def test_ships_of_a_lane_keep_to_starboard() -> None:
    rows = placed(layout="lane", count=40, axis_deg=0.0, length_m=20000.0, width_m=2000.0)
    northbound = np.cos(np.radians(rows[:, 2])) > 0.0
    assert np.all(rows[northbound, 1] > 0.0)
    assert np.all(rows[~northbound, 1] < 0.0)
    assert np.sum(northbound) == 20


def test_a_regular_channel_is_a_lattice() -> None:
    rows = placed(layout="buoy_channel", count=8, axis_deg=90.0, spacing_m=1000.0, width_m=400.0)
    assert sorted({round(value) for value in rows[:, 0]}) == [-200, 200]
    assert sorted({round(value) for value in rows[:, 1]}) == [-1500, -500, 500, 1500]


# ------------------------------------------------------------------------------------------------- files


def test_the_truth_file_has_its_columns_at_one_hertz(approach: Recording) -> None:
    rows = list(csv.DictReader(io.StringIO(files.truth_csv(approach))))
    assert list(rows[0])[:6] == ["unix", "lat", "lon", "heading_deg", "sog_kn", "cog_deg"]
    assert [float(row["unix"]) for row in rows] == pytest.approx([1772355600.0 + s for s in range(181)])
    for row, truth in zip(rows, approach.truth, strict=True):
        assert (float(row["lat"]), float(row["lon"])) == pytest.approx((truth.lat_deg, truth.lon_deg), abs=1e-8)
        assert float(row["sog_kn"]) == pytest.approx(truth.speed_mps / KNOT_MPS, abs=0.0051)
        assert 0.0 <= float(row["heading_deg"]) < 360.0
        assert abs(wrap_180(float(row["heading_deg"]) - truth.heading_deg)) < 0.0051


def test_the_association_file_has_a_row_for_each_target_sentence(approach: Recording) -> None:
    rows = list(csv.DictReader(io.StringIO(files.association_csv(approach))))
    assert list(rows[0]) == ["unix", "target_no", "mmsi"]
    targets = [record for record in read_log(list(approach.lines)).records if isinstance(record, TargetReport)]
    assert [int(row["target_no"]) for row in rows] == [target.number for target in targets]
    for row, target in zip(rows, targets, strict=True):
        assert float(row["unix"]) % 86400.0 == pytest.approx(target.utc_of_day_s or 0.0, abs=0.011)


def test_files_are_written_beside_the_log(tmp_path: Path) -> None:
    recording = simulate(from_text(SMALL), 1)
    paths = files.write_files(recording, tmp_path / "x.nmea")
    assert [path.name for path in paths] == ["x.nmea", "x_truth.csv", "x_assoc.csv"]
    assert read_log(paths[0]).counts == read_log(list(recording.lines)).counts


def test_one_file_for_two_purposes_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="three files"):
        files.write_files(simulate(from_text(SMALL), 1), tmp_path / "x.nmea", tmp_path / "x.nmea")


# ------------------------------------------------------------------------------------------------- the shipped log


def test_the_shipped_log_is_what_the_simulator_makes_of_its_scenario(approach: Recording, repository: Path) -> None:
    logs = repository / "data" / "logs"
    assert (logs / "approach.nmea").read_bytes() == files.log_text(approach).encode("ascii")
    assert (logs / "approach_truth.csv").read_bytes() == files.truth_csv(approach).encode("ascii")
    assert (logs / "approach_assoc.csv").read_bytes() == files.association_csv(approach).encode("ascii")


def test_the_shipped_log_is_small(repository: Path) -> None:
    assert (repository / "data" / "logs" / "approach.nmea").stat().st_size < 400_000
