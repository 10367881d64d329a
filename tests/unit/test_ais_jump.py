"""A jump of all AIS is told from the reports alone; a clock that jumps, a few ships and a tail of noise are none."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix.catalog import navigator_model
from navfix.geodesy import LocalPlane
from navfix.sequence.ais_jump import AisJump
from navfix.types import Epoch, Mark, Position

PLANE = LocalPlane(Position(54.5, 18.8))
BEGIN = datetime(2026, 5, 1, tzinfo=UTC)
SHIPS = 8


def scans(
    shift: np.ndarray | None = None, *, clock_s: float = 0.0, seed: int = 1, hull_sigma_m: float = 0.0
) -> list[Epoch]:
    """Return 20 scans, 3 s apart: from the tenth on each ship is shifted (n, 2) m or late by ``clock_s``."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(-8e3, 8e3, (SHIPS, 2))
    speed, course = rng.uniform(3.0, 9.0, SHIPS), rng.uniform(0.0, 360.0, SHIPS)
    way = speed[:, None] * np.stack([np.cos(np.radians(course)), np.sin(np.radians(course))], axis=1)
    found = []
    for scan in range(20):
        changed = np.array([scan >= 10 + number % 3 for number in range(SHIPS)])  # reports come one after the other
        there = place + way * (3.0 * scan + np.where(changed, clock_s, 0.0))[:, None] + rng.normal(0.0, 8.0, (SHIPS, 2))
        there += 0.0 if shift is None else np.where(changed[:, None], shift, 0.0)
        marks = tuple(
            Mark(
                f"m{number}",
                PLANE.to_position(*there[number].tolist()),
                float(np.hypot(15.0, hull_sigma_m)),
                hull_sigma_m=hull_sigma_m,
                speed_mps=float(speed[number]),
                course_deg=float(course[number]),
                age_s=0.0,
            )
            for number in range(SHIPS)
        )
        found.append(Epoch(BEGIN + timedelta(seconds=3 * scan), (), marks))
    return found


def jumps(epochs: list[Epoch]) -> list[tuple[int, float]]:
    check = AisJump(navigator_model())
    found = [(number, check.feed(epoch)) for number, epoch in enumerate(epochs)]
    return [(number, by_m) for number, by_m in found if by_m is not None]


def test_a_jump_alike_is_told_with_its_size_as_soon_as_most_ships_have_reported():
    found = jumps(scans(np.tile([180.0, -240.0], (SHIPS, 1))))
    assert found[0] == (11, pytest.approx(300.0, abs=20.0))


def test_what_is_not_known_of_a_hull_hides_no_jump_for_it_is_in_both_positions_alike():
    found = jumps(scans(np.tile([96.0, -128.0], (SHIPS, 1)), hull_sigma_m=30.0))
    assert found[0] == (11, pytest.approx(160.0, abs=20.0))


@pytest.mark.parametrize("seed", range(20))
def test_ships_that_keep_their_way_never_jump(seed: int):
    assert not jumps(scans(seed=seed))


def test_a_clock_that_jumps_moves_each_ship_along_its_own_way_and_is_none():
    assert not jumps(scans(clock_s=60.0))


def test_half_of_the_ships_are_not_most_of_them():
    shift = np.zeros((SHIPS, 2))
    shift[: SHIPS // 2] = 1500.0
    assert not jumps(scans(shift))


def test_ships_that_jump_each_elsewhere_are_no_common_jump():
    turns = np.radians(np.arange(SHIPS) * 360.0 / SHIPS)
    assert not jumps(scans(900.0 * np.stack([np.cos(turns), np.sin(turns)], axis=1)))


def test_charted_marks_do_not_count():
    epochs = scans(np.tile([180.0, -240.0], (SHIPS, 1)))
    assert not jumps([replace(e, marks=tuple(replace(m, kind="charted") for m in e.marks)) for e in epochs])
