"""The simulated AIS: report intervals by class, outages, noise, wrong positions, what is sent and what is not."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from navfix.errors import InputError
from navfix.geodesy import inverse
from navfix.nmea.records import AisPosition, AisStatic
from navfix.simulation import ais
from navfix.simulation.motion import Motion
from navfix.simulation.outages import WAIGAOQIAO, draw_outages, in_outage, outage_model
from navfix.simulation.scenario import Scenario, load
from navfix.simulation.settings import AisSettings, TrafficGroup
from navfix.simulation.world import Body, World
from navfix.types import Hull, Position
from navfix.units import KNOT_MPS

HULL = Hull(bow_m=80.0, stern_m=20.0, port_m=6.0, starboard_m=10.0)


def ship(unit: str = "A", status: int = 0, kind: str = "ship", **motion: float) -> Body:
    return Body(200100001, "X", kind, Motion(0.0, 0.0, **motion), HULL, unit=unit, navigation_status=status)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("body", "speed_kn", "turn_deg_per_min", "interval_s"),
    [
        (ship(status=1), 0.4, 20.0, 180.0),
        (ship(status=5), 0.0, 0.0, 180.0),
        (ship(status=1), 3.5, 0.0, 10.0),
        (ship(), 0.0, 0.0, 10.0),
        (ship(), 13.9, 0.0, 10.0),
        (ship(), 13.9, 15.0, 10.0 / 3.0),
        (ship(), 14.1, 0.0, 6.0),
        (ship(), 14.1, -15.0, 2.0),
        (ship(), 23.1, 0.0, 2.0),
        (ship(), 23.1, 15.0, 2.0),
        (ship("B"), 1.9, 0.0, 180.0),
        (ship("B"), 2.1, 0.0, 30.0),
        (ship(kind="aton"), 0.0, 0.0, 180.0),
        (ship(kind="base_station"), 0.0, 0.0, 10.0),
        (ship(kind="aircraft"), 100.0, 0.0, 10.0),
    ],
)
def test_report_intervals_are_those_of_the_recommendation(
    body: Body, speed_kn: float, turn_deg_per_min: float, interval_s: float
) -> None:
    assert ais.report_interval_s(body, speed_kn * KNOT_MPS, turn_deg_per_min) == pytest.approx(interval_s)


def world_of(*bodies: Body) -> World:
    world = load("open_sea").world(1)
    return replace(world, bodies=tuple(replace(body, mmsi=200100001 + index) for index, body in enumerate(bodies)))


def received(world: World, duration_s: float, **settings: object) -> dict[int, list[ais.AisMessage]]:
    quiet = {"loss": 0.0, "range_m": 1e9} | settings
    messages, _ = ais.receive(world, AisSettings(**quiet), duration_s, 1e5, 3)  # type: ignore[arg-type]
    by_station: dict[int, list[ais.AisMessage]] = defaultdict(list)
    for message in messages:
        by_station[message.record.mmsi].append(message)
    return by_station


@pytest.mark.parametrize(
    ("body", "interval_s"),
    [
        (ship(speed_mps=10.0 * KNOT_MPS), 10.0),
        (ship(speed_mps=18.0 * KNOT_MPS), 6.0),
        (ship(speed_mps=30.0 * KNOT_MPS), 2.0),
        (ship("B", speed_mps=8.0 * KNOT_MPS), 30.0),
        (ship(status=1), 180.0),
    ],
)
def test_intervals_heard_are_the_nominal_ones_within_a_fifth(body: Body, interval_s: float) -> None:
    heard = received(world_of(body), 3600.0)[200100001]
    gaps = np.diff([m.time_s for m in heard if isinstance(m.record, AisPosition)])
    assert np.mean(gaps) == pytest.approx(interval_s, rel=0.01)
    assert np.all(np.abs(gaps - interval_s) <= 0.2 * interval_s + 1e-9)


def test_a_turning_ship_reports_more_often_while_it_turns() -> None:
    turning = ship(speed_mps=5.0, turn_at_s=300.0, turn_rate_rad_s=math.radians(0.5), turn_time_s=120.0)
    world = world_of(turning)
    times = np.array([m.time_s for m in received(world, 600.0)[200100001] if isinstance(m.record, AisPosition)])
    since_s = times - world.start_s
    assert np.sum((since_s > 310.0) & (since_s < 410.0)) == pytest.approx(30, abs=2)
    assert np.sum((since_s > 100.0) & (since_s < 200.0)) == pytest.approx(10, abs=1)


def test_static_data_come_every_six_minutes_by_the_type_of_the_class() -> None:
    heard = received(world_of(ship(speed_mps=5.0), ship("B", speed_mps=5.0)), 3600.0)
    for mmsi, message_type in ((200100001, 5), (200100002, 24)):
        static = [m for m in heard[mmsi] if isinstance(m.record, AisStatic)]
        assert {m.record.message_type for m in static} == {message_type}
        assert np.diff([m.time_s for m in static]) == pytest.approx(360.0)


def test_a_position_is_a_little_older_than_its_reception_and_says_its_second() -> None:
    heard = received(world_of(ship(speed_mps=8.0)), 1200.0, position_age_max_s=1.2)[200100001]
    positions = [m for m in heard if isinstance(m.record, AisPosition)]
    ages = np.array([m.time_s - m.position_time_s for m in positions])
    assert ages.min() >= 0.0
    assert ages.max() <= 1.2
    assert np.mean(ages) == pytest.approx(0.6, abs=0.1)
    for message in positions:
        assert isinstance(message.record, AisPosition)
        assert message.record.utc_second == math.floor(message.position_time_s) % 60


def test_the_reported_place_is_the_antennas_with_the_stated_noise() -> None:
    world = world_of(*[ship(speed_mps=6.0, course_rad=float(c)) for c in np.linspace(0.0, 6.2, 60)])
    heard, errors = received(world, 60.0), []
    for body in world.bodies:
        for message in heard[body.mmsi]:
            if isinstance(message.record, AisPosition):
                pose = body.motion.at(message.position_time_s - world.start_s)
                antenna = world.stage.places(*pose.offset(-30.0, -2.0))  # bow 80 stern 20, port 6 starboard 10
                report = message.record
                assert report.lat_deg is not None
                assert report.lon_deg is not None
                antenna_place = Position(*map(float, antenna))
                errors.append(inverse(antenna_place, Position(report.lat_deg, report.lon_deg))[0])
    assert len(errors) > 100
    # Rayleigh: mean square is twice the variance per axis, 4^2 + 1^2 m^2.
    assert np.mean(np.square(errors)) == pytest.approx(2.0 * 17.0, rel=0.35)


def test_lost_messages_are_lost_at_the_stated_rate() -> None:
    world = world_of(ship(speed_mps=16.0))
    everything, some = (len(received(world, 3600.0, loss=loss)[200100001]) for loss in (0.0, 0.25))
    assert some / everything == pytest.approx(0.75, abs=0.04)


def test_a_ship_beyond_ais_range_is_not_heard() -> None:
    far = replace(ship(speed_mps=6.0), motion=Motion(90000.0, 0.0))
    assert received(world_of(far), 600.0, range_m=50000.0) == {}


# ------------------------------------------------------------------------------------------------- outages


def test_ages_in_outages_have_the_published_quantiles() -> None:
    rng = np.random.default_rng(5)
    ages_min = []
    for _ in range(2000):
        now_s = 3600.0
        current = [start for start, end in draw_outages(WAIGAOQIAO, now_s + 1.0, rng) if start <= now_s < end]
        ages_min.append((now_s - current[0]) / 60.0 if current else 0.0)
    for limit_min, share in ((2.0, 0.30), (3.0, 0.15), (5.0, 0.10), (15.0, 0.02)):
        sigma = math.sqrt(share * (1.0 - share) / len(ages_min))
        assert np.mean(np.array(ages_min) > limit_min) == pytest.approx(share, abs=4.0 * sigma)


def test_the_age_of_what_a_receiver_holds_has_the_published_quantiles() -> None:
    world = world_of(*[ship(speed_mps=5.0) for _ in range(45)])  # 10 s intervals: all that is older is an outage
    heard = received(world, 3600.0, outages="waigaoqiao")
    ages_min = []
    for body in world.bodies:
        times = np.array([m.time_s - world.start_s for m in heard[body.mmsi]])
        for now_s in (1800.0, 2700.0, 3599.0):
            past = times[times <= now_s]
            ages_min.append((now_s - past[-1]) / 60.0 if len(past) else math.inf)
    for limit_min, share in ((2.0, 0.30), (3.0, 0.15), (5.0, 0.10), (15.0, 0.02)):
        sigma = math.sqrt(share * (1.0 - share) / len(ages_min))
        assert np.mean(np.array(ages_min) > limit_min) == pytest.approx(share, abs=3.5 * sigma)


def test_an_outage_ends_when_it_ends() -> None:
    outages = [(10.0, 20.0), (50.0, 60.0)]
    assert [in_outage(outages, t) for t in (9.9, 10.0, 19.9, 20.0, 55.0, 60.0)] == [
        False,
        True,
        True,
        False,
        True,
        False,
    ]


@pytest.mark.parametrize(
    ("ages", "shares"), [((3.0, 2.0), (0.3, 0.1)), ((2.0, 3.0), (0.3, 0.29)), ((0.5, 9.0), (0.9, 0.1))]
)
def test_a_table_that_no_outages_can_meet_is_refused(ages: tuple[float, ...], shares: tuple[float, ...]) -> None:
    with pytest.raises(InputError, match="outage table"):
        outage_model(ages, shares, longest_min=10.0)


# ------------------------------------------------------------------------------------------------- wrong positions


def crowd(**settings: object) -> Scenario:
    group = TrafficGroup(layout="uniform", count=40, radius_m=9000.0, inner_radius_m=500.0, speed_max_mps=4.0)
    return replace(load("open_sea"), traffic=(group,), ais=AisSettings(**settings))  # type: ignore[arg-type]


def claimed_offsets(scenario: Scenario) -> tuple[dict[int, tuple[float, float]], dict[int, tuple[float, float]]]:
    """Return what is claimed less where the antenna is (north, east) [m], and what the recording says was wrong."""
    world = scenario.world(4)
    messages, wrong = ais.receive(world, scenario.ais, 60.0, 1e5, 4)
    bodies = {body.mmsi: body for body in world.bodies}
    offsets = {}
    for message in messages:
        if isinstance(message.record, AisPosition):
            body, report = bodies[message.record.mmsi], message.record
            pose = body.motion.at(message.position_time_s - world.start_s)
            antenna = world.stage.places(*pose.offset(-body.hull.centre_forward_m, -body.hull.centre_starboard_m))
            claimed = Position(report.lat_deg, report.lon_deg)  # type: ignore[arg-type]
            distance_m, azimuth_deg = inverse(Position(*map(float, antenna)), claimed)
            azimuth = math.radians(azimuth_deg)
            offsets[body.mmsi] = (distance_m * math.cos(azimuth), distance_m * math.sin(azimuth))
    return offsets, wrong


def test_stations_with_wrong_positions_are_where_they_do_not_claim_to_be() -> None:
    offsets, wrong = claimed_offsets(crowd(wrong_count=6, wrong_offset_min_m=400.0, wrong_offset_max_m=2500.0))
    assert len(wrong) == 6
    for mmsi, offset in offsets.items():
        assert (math.hypot(*offset) > 350.0) == (mmsi in wrong)
        assert math.hypot(*offset) < 2550.0


def test_a_coherent_group_is_shifted_by_one_vector() -> None:
    offsets, wrong = claimed_offsets(crowd(group_count=5, group_offset_m=1500.0, group_azimuth_deg=130.0))
    assert len(wrong) == 5
    for mmsi in wrong:
        assert offsets[mmsi] == pytest.approx(
            (1500.0 * math.cos(math.radians(130.0)), 1500.0 * math.sin(math.radians(130.0))), abs=25.0
        )


def test_more_wrong_stations_than_there_are_is_all_of_them() -> None:
    _, wrong = claimed_offsets(crowd(wrong_count=500))
    assert len(wrong) == 40
