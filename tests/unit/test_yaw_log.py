"""A place that is carried along turns with the ship: else a turn makes a rival of the place itself."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix.association.window.joint import prepare
from navfix.catalog import navigator_model
from navfix.geodesy import direct
from navfix.sequence.places import Place, as_prior
from navfix.sequence.yaw import YawLog
from navfix.types import Epoch, Mark, Position, RadarTarget
from navfix.units import wrap_180

START = datetime(2026, 5, 1, tzinfo=UTC)


def scans(rate_degps: float, count: int = 12, step_s: float = 2.5) -> list[Epoch]:
    found = []
    for k in range(count):
        heading_deg = 350.0 + rate_degps * k * step_s
        targets = tuple(RadarTarget(f"t{i}", 2000.0 + 500.0 * i, (70.0 * i - heading_deg) % 360.0) for i in range(5))
        found.append(Epoch(START + timedelta(seconds=k * step_s), targets, ()))
    return found


@pytest.mark.parametrize("rate_degps", [0.0, 3.5, -4.0])
def test_a_place_carried_through_a_turn_lies_as_the_ship_does(rate_degps: float) -> None:
    yaw, model, begin_s = YawLog(), navigator_model("default"), START.timestamp()
    for epoch in scans(rate_degps):
        yaw.feed(epoch)
    place = Place(begin_s, Position(54.0, 18.0), 350.0, 0j, np.diag([100.0, 100.0, 1e-4]), yaw)
    after = place.carried(begin_s + 27.5, model)
    seen = Place(begin_s + 27.5, place.position, (350.0 + 27.5 * rate_degps) % 360.0, 0j, place.covariance)
    assert after.turn_deg(seen) < 0.1
    assert not after.differs(seen, model.apart_m, model.apart_deg)
    back = after.carried(begin_s, model)
    assert back.turn_deg(place) < 0.1


@pytest.mark.parametrize("found_at", [0, 3, 5])
def test_the_prior_of_a_window_has_the_heading_at_its_first_scan(found_at: int) -> None:
    """A window of the scans from the fourth on; the place was known before it, at its first scan, or after it."""
    yaw, model, rate_degps = YawLog(), navigator_model("default"), 3.0
    marks = tuple(Mark(f"m{i}", direct(Position(54.0, 18.0), 70.0 * i, 2000.0 + 500.0 * i), 10.0) for i in range(5))
    turning = [replace(epoch, marks=marks) for epoch in scans(rate_degps)]
    for epoch in turning:
        yaw.feed(epoch)
    at_s = START.timestamp() + 2.5 * found_at
    heading_deg = (350.0 + rate_degps * 2.5 * found_at) % 360.0
    place = Place(at_s, Position(54.0, 18.0), heading_deg, 0j, np.diag([100.0, 100.0, 1e-4]), yaw)
    prior = as_prior([place], prepare(turning[3:]), model)
    first_deg = 350.0 + rate_degps * 2.5 * 3
    assert wrap_180(np.degrees(prior.heading_rad[0]) - first_deg) == pytest.approx(0.0, abs=0.1)


def test_without_scans_or_log_a_heading_is_kept() -> None:
    model, begin_s = navigator_model("default"), START.timestamp()
    for yaw in (None, YawLog()):
        place = Place(begin_s, Position(54.0, 18.0), 123.0, 0j, np.eye(3), yaw)
        assert place.carried(begin_s + 30.0, model).heading_deg == 123.0


def test_what_turned_while_radar_was_silent_may_lie_any_way_round_and_be_the_same() -> None:
    model, begin_s = navigator_model("default"), START.timestamp()
    watched, gap = YawLog(), YawLog()
    for epoch in scans(0.0, count=17):
        watched.feed(epoch)
        if not 10.0 < (epoch.time_utc - START).total_seconds() < 30.0:  # type: ignore[operator]
            gap.feed(epoch)
    other = Place(begin_s + 40.0, Position(54.0, 18.0), 170.0, 0j, np.eye(3))
    for yaw, apart in ((watched, True), (gap, False)):
        place = Place(begin_s, Position(54.0, 18.0), 350.0, 0j, np.eye(3), yaw).carried(begin_s + 40.0, model)
        assert place.differs(other, model.apart_m, model.apart_deg) is apart
        assert other.differs(place, model.apart_m, model.apart_deg) is apart
        far = replace(other, position=direct(other.position, 0.0, 2.0 * model.apart_m))
        assert place.differs(far, model.apart_m, model.apart_deg)


def test_true_bearings_miss_no_turn() -> None:
    yaw, begin_s = YawLog(), START.timestamp()
    for epoch in scans(0.0, count=3):
        yaw.feed(replace(epoch, targets=tuple(replace(t, bearing_reference="true") for t in epoch.targets)))
    assert not yaw.missed(begin_s, begin_s + 60.0)


def test_an_empty_scan_does_not_lose_the_turn() -> None:
    yaw, whole = YawLog(), scans(2.0, count=4)
    for number, epoch in enumerate(whole):
        yaw.feed(Epoch(epoch.time_utc, (), ()) if number == 2 else epoch)
    begin_s = START.timestamp()
    assert yaw.between_deg(begin_s, begin_s + 7.5) == pytest.approx(15.0)
