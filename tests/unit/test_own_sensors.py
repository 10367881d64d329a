"""Between fixes the navigator's place goes on by gyro and log: through a turn, over a current, with any gyro error."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix.catalog import navigator_model
from navfix.geodesy import LocalPlane, inverse
from navfix.sequence.own_sensors import OwnSensors
from navfix.sequence.places import Place
from navfix.sequence.yaw import YawLog
from navfix.types import Epoch, HeadingHint, Position, RadarTarget, SpeedHint

BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
OWN = Position(54.0, 10.0)
CURRENT, LOG_MPS, TURN_DEGPS = 0.6 - 0.4j, 7.0, 2.0


def heard(
    error_deg: float = 0.0, *, log: bool = True, silent: tuple[int, ...] = (), frozen: bool = False
) -> OwnSensors:
    """Return sensors that heard a minute of a steady turn from a heading of 30 deg, which the bearings show too."""
    yaw = YawLog()
    sensors = OwnSensors(yaw)
    for k in range(61):
        hint = HeadingHint((30.0 + error_deg + (0.0 if frozen else TURN_DEGPS * k)) % 360.0, 1.5)
        yaw.feed(Epoch(BEGIN + timedelta(seconds=k), (RadarTarget("1", 5000.0, (90.0 - TURN_DEGPS * k) % 360.0),), ()))
        sensors.feed(
            Epoch(
                BEGIN + timedelta(seconds=k), (), (), heading_hint=None if k in silent else hint,
                speed_hint=SpeedHint(LOG_MPS, 0.1) if log else None,
            )
        )  # fmt: skip
    return sensors


def place(current: complex = CURRENT) -> Place:
    velocity = LOG_MPS * np.exp(1j * np.radians(30.0)) + current
    return Place(BEGIN.timestamp(), OWN, 30.0, complex(velocity), np.diag([100.0, 100.0, 1e-4]))


def way(to_s: float, current: complex) -> complex:
    """Return the integral of the velocity in the turn."""
    rate = np.radians(TURN_DEGPS)
    circle = LOG_MPS * np.exp(1j * np.radians(30.0)) * (np.exp(1j * rate * to_s) - 1.0) / (1j * rate)
    return complex(circle + current * to_s)


@pytest.mark.parametrize("error_deg", [0.0, 90.0, -179.0])
def test_log_gyro_and_current_lead_through_a_turn_whatever_constant_error_the_gyro_has(error_deg: float):
    sailed = heard(error_deg).since(place(), BEGIN.timestamp() + 40.0)
    assert sailed is not None
    assert sailed.by == "log and gyro"
    assert sailed.turned_deg == pytest.approx(80.0, abs=1e-6)
    assert abs(sailed.way_m - way(40.0, CURRENT)) < 0.1


def test_without_a_log_the_velocity_turns_with_the_ship():
    sailed = heard(log=False).since(place(0j), BEGIN.timestamp() + 40.0)
    assert sailed is not None
    assert sailed.by == "gyro"
    assert abs(sailed.way_m - way(40.0, 0j)) < 0.1


def test_a_gyro_that_is_silent_or_contradicted_by_the_bearings_says_nothing():
    assert heard(frozen=True).since(place(), BEGIN.timestamp() + 40.0) is None
    assert heard(silent=(7,)).since(place(), BEGIN.timestamp() + 40.0) is None
    assert heard().since(replace(place(), time_s=BEGIN.timestamp() - 5.0), BEGIN.timestamp() + 40.0) is None
    assert heard().since(place(), BEGIN.timestamp() + 90.0) is None


def test_a_place_that_is_carried_follows_the_sensors_and_is_as_unsure_as_without_them():
    model, there_s = navigator_model(), BEGIN.timestamp() + 40.0
    sensors = heard()
    carried, straight = place().sailed(sensors.since(place(), there_s), there_s, model), place().carried(there_s, model)
    true = LocalPlane(OWN).to_position(way(40.0, CURRENT).real, way(40.0, CURRENT).imag)
    assert inverse(carried.position, true)[0] < 0.2
    assert inverse(straight.position, true)[0] > 100.0
    assert carried.heading_deg == pytest.approx(110.0, abs=1e-6)
    assert np.array_equal(carried.covariance, straight.covariance)


def test_a_gyro_that_the_bearings_refute_is_not_believed_for_minutes_and_a_right_one_is():
    hinted = Epoch(BEGIN + timedelta(seconds=60), (), (), heading_hint=HeadingHint(150.0, 1.5))
    assert heard(90.0).believed(hinted).heading_hint is not None
    assert heard(frozen=True).believed(hinted).heading_hint is None


def test_a_turn_that_no_scan_showed_does_not_refute_the_gyro():
    yaw = YawLog()
    sensors = OwnSensors(yaw)
    for k in range(121):
        second = BEGIN + timedelta(seconds=k)
        hint = HeadingHint(30.0 if k <= 30 else min(30.0 + 2.0 * (k - 30), 120.0), 1.5)
        echoes = () if 20 < k < 100 else (RadarTarget("1", 5000.0, 90.0 if k <= 20 else 0.0),)
        epoch = Epoch(second, echoes, (), heading_hint=hint, speed_hint=SpeedHint(LOG_MPS, 0.1))
        yaw.feed(epoch)
        sensors.feed(epoch)
        assert sensors.believed(epoch).heading_hint is not None
    begin_s = BEGIN.timestamp()
    assert yaw.between_deg(begin_s, begin_s + 120.0) == pytest.approx(0.0), "nothing is known of it"
    assert not yaw.watched(begin_s, begin_s + 120.0)
    assert yaw.watched(begin_s + 101.0, begin_s + 120.0)
    sailed = sensors.since(place(), begin_s + 120.0)
    assert sailed is not None
    assert sailed.turned_deg == pytest.approx(90.0)
