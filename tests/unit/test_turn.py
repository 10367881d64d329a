"""Own motion within a turn of the antenna: what bringing all targets to one instant takes off the error."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix.nmea.records import OwnHeading, OwnTurnRate, TargetReport
from navfix.picture import Picture
from navfix.picture.scans import Scan
from navfix.picture.turn import TurnMotion
from navfix.types import HeadingHint, SpeedHint
from navfix.units import KNOT_MPS, wrap_180

T0 = 1_772_366_400.0
TURN_S = 2.5
OWN_MPS, RATE_DEG_S = 20.0 * KNOT_MPS, 1.0
TARGETS = np.random.default_rng(11).uniform(-6000.0, 6000.0, (12, 2))  # north, east [m], all lie still


def own_at(time_s: float, rate_deg_s: float) -> tuple[float, float, float]:
    """Return north, east [m] and heading [deg] of own ship on its circle."""
    rate = math.radians(rate_deg_s)
    if rate == 0.0:
        return OWN_MPS * time_s, 0.0, 0.0
    radius = OWN_MPS / rate
    return radius * math.sin(rate * time_s), radius * (1.0 - math.cos(rate * time_s)), rate_deg_s * time_s


def seen(number: int, time_s: float, rate_deg_s: float, noise: np.ndarray) -> TargetReport:
    """Return what the radar says of a target at a time."""
    north, east, heading = own_at(time_s, rate_deg_s)
    dn, de = TARGETS[number] - [north, east]
    bearing = math.degrees(math.atan2(de, dn)) - heading + noise[1]
    return TargetReport(T0 + time_s, number, math.hypot(dn, de) + noise[0], bearing % 360.0, "relative", status="T")


def scans(rate_deg_s: float, *, turns: int = 14, noise: tuple[float, float] = (0.0, 0.0)) -> list[Scan]:
    """Return scans of a rotating antenna: each target is seen when the beam passes it."""
    rng, found = np.random.default_rng(2), []
    for turn in range(turns):
        reports = []
        for number in range(len(TARGETS)):
            guess = seen(number, TURN_S * turn, rate_deg_s, np.zeros(2))
            at = TURN_S * (turn + guess.bearing_deg / 360.0)
            reports.append(seen(number, at, rate_deg_s, rng.normal(size=2) * noise))
        reports.sort(key=lambda r: r.time_s)
        found.append(Scan(reports[-1].time_s, TURN_S, tuple(reports)))
    return found


def errors(reports, scan: Scan, rate_deg_s: float) -> tuple[float, float]:
    """Return the rms error of range [m] and of the place across the beam [m] against the instant of the scan."""
    exact = [seen(r.number, scan.time_s - T0, rate_deg_s, np.zeros(2)) for r in reports]
    ranges = [r.range_m - e.range_m for r, e in zip(reports, exact, strict=True)]
    across = [
        math.radians(wrap_180(r.bearing_deg - e.bearing_deg)) * e.range_m for r, e in zip(reports, exact, strict=True)
    ]
    return float(np.sqrt(np.mean(np.square(ranges)))), float(np.sqrt(np.mean(np.square(across))))


def turned(rate_deg_s: float, *, gyro: bool, log: bool, noise: tuple[float, float] = (0.0, 0.0)):
    """Return errors without and with alignment, the rms over the last scans."""
    motion, before, after = TurnMotion(), [], []
    for k, scan in enumerate(scans(rate_deg_s, noise=noise)):
        if gyro:
            for tenth in range(25):
                time_s = TURN_S * k + 0.1 * tenth
                motion.heading(OwnHeading(T0 + time_s, (rate_deg_s * time_s) % 360.0, "true", "HDT"))
        motion.note(scan)
        heading = HeadingHint(own_at(scan.time_s - T0, rate_deg_s)[2], 1.0) if gyro else None
        aligned = motion.aligned(scan, SpeedHint(OWN_MPS, 0.1) if log else None, heading)
        if k >= 8:
            before.append(errors(scan.reports, scan, rate_deg_s))
            after.append(errors(aligned, scan, rate_deg_s))
    return np.sqrt(np.mean(np.square(before), axis=0)), np.sqrt(np.mean(np.square(after), axis=0))


def test_log_and_gyro_take_off_the_motion_within_a_turn():
    before, after = turned(RATE_DEG_S, gyro=True, log=True)
    assert before[0] > 6.0
    assert before[1] > 80.0
    assert after.max() < 1.0


def test_without_log_and_gyro_common_bearing_and_ranges_do_most_of_it():
    before, after = turned(RATE_DEG_S, gyro=False, log=False)
    assert after[0] < 0.35 * before[0]
    assert after[1] < 0.25 * before[1]


def test_with_the_noise_of_a_radar_the_common_turn_still_pays():
    noise = (15.0, 0.4)
    plain, aligned = turned(RATE_DEG_S, gyro=False, log=False, noise=noise)
    assert aligned[1] < 0.75 * plain[1]
    assert aligned[0] < 1.05 * plain[0]


def test_a_ship_that_does_not_turn_is_not_turned_by_the_noise():
    plain, aligned = turned(0.0, gyro=False, log=False, noise=(15.0, 0.4))
    assert aligned[1] < 1.1 * plain[1]


def test_a_rate_of_turn_indicator_serves_where_there_is_no_gyro():
    motion = TurnMotion()
    found = scans(RATE_DEG_S, turns=4)
    for scan in found:
        motion.note(scan)
    motion.turn_rate(OwnTurnRate(found[-1].time_s, 60.0 * RATE_DEG_S))
    aligned = motion.aligned(found[-1], SpeedHint(OWN_MPS, 0.1), None)
    assert errors(aligned, found[-1], RATE_DEG_S)[1] < 1.0


def test_true_bearings_are_not_turned():
    scan = scans(RATE_DEG_S, turns=1)[0]
    true = replace(scan, reports=tuple(replace(r, bearing_reference="true") for r in scan.reports))
    motion = TurnMotion()
    motion.turn_rate(OwnTurnRate(scan.time_s, 60.0))
    motion.note(true)
    assert [r.bearing_deg for r in motion.aligned(true, None, None)] == [r.bearing_deg for r in true.reports]


def test_a_scan_of_one_instant_stays_as_it_is():
    scan = scans(RATE_DEG_S, turns=1)[0]
    one = replace(scan, reports=tuple(replace(r, time_s=scan.time_s) for r in scan.reports))
    assert TurnMotion().aligned(one, SpeedHint(OWN_MPS, 0.1), None) is one.reports


def test_a_target_with_its_own_speed_over_ground_is_carried_with_it():
    report = TargetReport(T0, 1, 3000.0, 0.0, "relative", speed_mps=OWN_MPS, course_deg=0.0, course_reference="true")
    scan = Scan(T0 + 2.0, TURN_S, (report, replace(report, time_s=T0 + 2.0, number=2)))
    aligned = TurnMotion().aligned(scan, SpeedHint(OWN_MPS, 0.1), HeadingHint(0.0, 1.0))
    assert aligned[0].range_m == pytest.approx(3000.0)


def test_the_picture_makes_epochs_of_one_instant():
    picture = Picture()
    for scan in scans(RATE_DEG_S):
        picture.feed(OwnTurnRate(scan.time_s - 2.0, 60.0))
        for report in scan.reports:
            done = picture.feed(report)
            if done is not None:
                epoch = picture.epoch(done)
    assert {t.time_utc for t in epoch.targets} == {epoch.time_utc}
