"""Dead reckoning: continuous, growing as its law says, honest after gaps, never joined across restarts."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import pytest

from navfix.catalog import own_motion_model
from navfix.geodesy import LocalPlane, inverse
from navfix.sequence.dead_reckoning import DeadReckoner
from navfix.types import DeadReckoning, Position
from tests.reckoning_scenes import OWN, epoch_at, fix_at

STEP_S = 3.0


def test_the_error_grows_with_the_cube_of_time_where_nothing_tells_the_velocity() -> None:
    reckoner = DeadReckoner()
    for k in range(41):
        reckoner.feed(epoch_at(3.0 * k), fix_at(OWN))
    sigma = {}
    for second in (180.0, 300.0, 600.0, 900.0):
        found = reckoner.feed(epoch_at(second))
        assert found is not None
        sigma[second] = math.sqrt(float(found.covariance[0, 0]))
    assert sigma[180.0] < sigma[300.0] < sigma[600.0] < sigma[900.0]
    model = own_motion_model()
    law = model.velocity_walk_mps * math.sqrt((900.0 - 120.0) ** 3 / (3.0 * model.velocity_walk_s))
    assert law < sigma[900.0] < 1.2 * law


def test_the_position_is_continuous_and_follows_the_log() -> None:
    reckoner = DeadReckoner()
    for k in range(41):
        place = LocalPlane(OWN).to_position(5.0 * 3.0 * k, 0.0)
        reckoner.feed(epoch_at(3.0 * k, gyro=2.0, log=5.0), fix_at(place, 0.0))
    before = reckoner.feed(epoch_at(123.0, gyro=2.0, log=5.0))
    after = reckoner.feed(epoch_at(126.0, gyro=92.0, log=5.0))
    later = reckoner.feed(epoch_at(186.0, gyro=92.0, log=5.0))
    assert before is not None
    assert after is not None
    assert later is not None
    assert before.source == "log_and_gyro"
    assert inverse(before.position, after.position)[0] < 17.0
    distance_m, azimuth_deg = inverse(after.position, later.position)
    assert distance_m == pytest.approx(300.0, abs=15.0)
    assert azimuth_deg == pytest.approx(90.0, abs=4.0), "the gyro's constant error cancels"
    assert later.heading_deg == pytest.approx(90.0, abs=0.5)
    assert later.age_s == pytest.approx(66.0)


def test_a_log_that_falls_silent_leaves_the_velocity_over_ground() -> None:
    reckoner = DeadReckoner()
    for k in range(41):
        place = LocalPlane(OWN).to_position(0.0, 6.0 * 3.0 * k)
        reckoner.feed(epoch_at(3.0 * k, gyro=90.0, log=5.0), fix_at(place, 90.0))
    found = reckoner.feed(epoch_at(180.0))
    assert found is not None
    assert found.source == "last_velocity"
    assert LocalPlane(OWN).to_plane(found.position)[1] == pytest.approx(6.0 * 180.0, abs=40.0)


def test_one_contradicting_fix_is_left_out_and_two_begin_a_new_track() -> None:
    reckoner = DeadReckoner()
    for k in range(20):
        reckoner.feed(epoch_at(3.0 * k), fix_at(OWN))
    far = LocalPlane(OWN).to_position(5000.0, 0.0)
    reckoner.feed(epoch_at(60.0), fix_at(far))
    after_one = reckoner.feed(epoch_at(63.0), fix_at(far))
    assert after_one is not None
    assert inverse(after_one.position, OWN)[0] < 200.0
    after_two = reckoner.feed(epoch_at(66.0))
    assert after_two is not None
    assert inverse(after_two.position, far)[0] < 200.0


def test_no_dead_reckoning_before_the_first_fix_after_half_an_hour_or_a_restart() -> None:
    reckoner = DeadReckoner()
    assert reckoner.feed(epoch_at(0.0)) is None
    assert reckoner.feed(epoch_at(3.0), fix_at(OWN)) is None
    assert reckoner.feed(epoch_at(6.0)) is not None
    assert reckoner.feed(epoch_at(3.0)) is None, "the clock was set back"
    assert reckoner.feed(epoch_at(9.0), fix_at(OWN)) is None
    assert reckoner.feed(epoch_at(9.0 + 1801.0)) is None
    assert DeadReckoner().feed(replace(epoch_at(0.0), time_utc=None), fix_at(OWN)) is None


def test_dead_reckoning_goes_on_across_the_date_line() -> None:
    own = Position(10.0, 179.9999)
    reckoner = DeadReckoner()
    for k in range(41):
        reckoner.feed(epoch_at(3.0 * k), fix_at(LocalPlane(own).to_position(0.0, 24.0 * k)))
    found = reckoner.feed(epoch_at(180.0))
    assert found is not None
    assert LocalPlane(own).to_plane(found.position)[1] == pytest.approx(8.0 * 180.0, abs=40.0)
    assert found.position.lon_deg < -179.0


CURRENT, LOG_MPS, TURN_DEGPS = 0.6 - 0.4j, 7.0, 2.0


def way(to_s: float, current: complex) -> complex:
    """Return the integral of the velocity in a turn from a heading of 30 deg."""
    rate = math.radians(TURN_DEGPS)
    circle = LOG_MPS * cmath.exp(1j * math.radians(30.0)) * (cmath.exp(1j * rate * to_s) - 1.0) / (1j * rate)
    return circle + current * to_s


def after_a_turn(error_deg: float, *, log: bool, current: complex) -> DeadReckoning:
    """Return the dead reckoning 40 s after a fix whose window told the velocity, turning all the time."""
    reckoner, found = DeadReckoner(), None
    velocity = LOG_MPS * cmath.exp(1j * math.radians(30.0)) + current
    for k in range(41):
        heading_deg = 30.0 + TURN_DEGPS * k
        epoch = epoch_at(float(k), gyro=(heading_deg + error_deg) % 360.0, log=LOG_MPS if log else None)
        found = reckoner.carry(epoch)
        if k == 0:
            reckoner.take(epoch, fix_at(OWN, heading_deg), velocity)
    assert found is not None
    return found


@pytest.mark.parametrize("error_deg", [0.0, 90.0, -179.0])
@pytest.mark.parametrize(("log", "current"), [(True, CURRENT), (False, 0j)])
def test_from_the_first_fix_on_it_leads_through_a_turn_whatever_constant_error_the_gyro_has(
    error_deg: float, log: bool, current: complex
) -> None:
    found = after_a_turn(error_deg, log=log, current=current)
    true = way(40.0, current)
    north_m, east_m = LocalPlane(OWN).to_plane(found.position).tolist()
    assert math.hypot(north_m - true.real, east_m - true.imag) < 1.0
    assert found.heading_deg == pytest.approx(110.0, abs=1e-6)
    assert found.source == ("log_and_gyro" if log else "last_velocity")
    sigma_m = math.sqrt(float(found.covariance[0, 0]))
    assert 40.0 < sigma_m < 60.0, "the velocity of a window is known to 1 m/s"
