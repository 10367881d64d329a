"""Pairs held against clutter: an echo beside a ship by accident does not turn the heading."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix.association.window import jackknife, joint
from navfix.association.window.associate import solve_jointly
from navfix.association.window.settle import settle
from navfix.geodesy import LocalPlane
from navfix.types import Epoch, Mark, Position, RadarTarget

BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
PLANE = LocalPlane(Position(50.7, -1.1))
NEAR = ((640.0, 160.0), (1300.0, 150.0), (1900.0, 125.0), (2050.0, 105.0), (2450.0, 100.0), (2600.0, 112.0))
FAR_M, FAR_DEG = 7000.0, 228.0
HEADING_DEG = 30.0


@dataclass(frozen=True)
class Sector:
    """Scans of ships near by in one sector, and of an echo far off beside a ship that gives none."""

    epochs: tuple[Epoch, ...]

    def error_m(self, position: Position) -> float:
        return float(np.hypot(*PLANE.to_plane(position)))


def sector(seed: int, *, off_deg: float = 5.0, off_m: float = 110.0, scans: int = 12) -> Sector:
    """Own ship lies at the origin; ranges err by 20 m and bearings by 0.7 deg that stay, AIS by 10 m."""
    rng = np.random.default_rng(seed)
    places = [(r, a) for r, a in NEAR] + [(FAR_M, FAR_DEG)]
    places += [(float(r), float(a)) for r, a in zip(rng.uniform(9e3, 2e4, 6), rng.uniform(0, 360, 6), strict=True)]
    stays = [(rng.normal(0.0, 20.0), rng.normal(0.0, 0.7)) for _ in NEAR]
    echoes = [(r + dr, a + da) for (r, a), (dr, da) in zip(NEAR, stays, strict=True)]
    echoes += [(FAR_M + off_m, FAR_DEG + off_deg), (4200.0, 20.0), (3300.0, 300.0)]
    marks = []
    for number, (range_m, azimuth_deg) in enumerate(places):
        north, east = _plane(range_m, azimuth_deg) + rng.normal(0.0, 10.0, 2)
        marks.append(Mark(f"ship{number}", PLANE.to_position(north, east), 15.0, "ship", speed_mps=0.0, course_deg=0.0))
    made = []
    for k in range(scans):
        time_utc = BEGIN + timedelta(seconds=2.5 * k)
        seen = tuple(
            RadarTarget(
                f"T{i}", r + rng.normal(0.0, 8.0), (a + rng.normal(0.0, 0.2) - HEADING_DEG) % 360.0, time_utc=time_utc
            )
            for i, (r, a) in enumerate(echoes)
        )
        made.append(Epoch(time_utc, seen, tuple(marks)))
    return Sector(tuple(made))


def _plane(range_m: float, azimuth_deg: float) -> np.ndarray:
    azimuth = math.radians(azimuth_deg)
    return range_m * np.array([math.cos(azimuth), math.sin(azimuth)])


def climbed_m(window: tuple[Epoch, ...]) -> float:
    """Return how far off the place is that the EM alone reaches."""
    found = joint.cold(joint.prepare(window))
    p = jackknife.at_end(found.window.field, found.answers.knots.take(np.array([0])))[0][0]
    origin = found.window.field.scene.flat.origin
    return float(np.hypot(*PLANE.to_plane(LocalPlane(origin).to_position(p.real, p.imag))))


@pytest.mark.parametrize("seed", [3, 4])
def test_an_echo_beside_a_ship_by_accident_does_not_turn_the_heading(seed: int):
    window = sector(seed, off_deg=-5.5)
    assert climbed_m(window.epochs) > 50.0, "the climb takes the echo for the ship"
    found = solve_jointly(window.epochs)
    assert window.error_m(found.fix.position) < 25.0
    assert 6 not in found.association.pairs[:, 0]
    assert all("T6" not in labels for labels in found.labels)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_far_ship_that_is_the_echo_stays_a_pair(seed: int):
    found = solve_jointly(sector(seed, off_deg=0.4, off_m=20.0).epochs)
    assert [6, 6] in found.association.pairs.tolist()


def test_a_pair_that_was_refused_stays_in_the_covariance():
    found = joint.cold(joint.prepare(sector(3, off_deg=-5.5).epochs))
    field, prior = found.window.field, found.window.prior
    settled = settle(found, prior, fewest_marks=3)
    assert settled.knots.barred is not None
    assert settled.knots.barred.sum() == 1
    with_pair = jackknife.end_vector(field, found.answers.knots.take(np.array([0])))[0]
    step = with_pair - jackknife.end_vector(field, settled.knots)[0]
    left = jackknife.left_out(field, settled.knots, prior)
    without = settled.pose.formal + jackknife.spread(field, left)
    added = settled.pose.covariance - without
    probability = float(np.trace(added) / (step @ step))
    assert 0.0 < probability < 0.5
    assert np.allclose(added, probability * np.outer(step, step))


def test_no_more_tracks_are_refused_than_leave_enough_marks():
    found = joint.cold(joint.prepare(sector(3, off_deg=-5.5).epochs))
    settled = settle(found, found.window.prior, fewest_marks=int(found.answers.marks[0]))
    assert settled.knots.barred is None
    assert settled.marks == found.answers.marks[0]
