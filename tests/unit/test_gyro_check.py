"""A gyro that turns otherwise than the bearings is not heard; one with any constant error is, and one without scans."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import pytest

from navfix.catalog import navigator_model
from navfix.sequence.gyro_check import GyroCheck
from navfix.sequence.yaw import YawLog
from navfix.types import Epoch, HeadingHint, RadarTarget

BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
TURN_DEGPS = 2.0


def epochs(error_deg: float = 0.0, *, frozen: bool = False) -> list[Epoch]:
    """Return a minute of a steady turn from a heading of 30 deg."""
    return [
        Epoch(
            BEGIN + timedelta(seconds=k),
            (RadarTarget("1", 5000.0, (90.0 - TURN_DEGPS * k) % 360.0),),
            (),
            heading_hint=HeadingHint((30.0 + error_deg + (0.0 if frozen else TURN_DEGPS * k)) % 360.0, 1.5),
        )
        for k in range(61)
    ]


def believed(scans: list[Epoch]) -> list[bool]:
    """Tell for each epoch whether its gyro is heard."""
    yaw = YawLog()
    check, heard = GyroCheck(yaw, navigator_model()), []
    for epoch in scans:
        yaw.feed(epoch)
        heard.append(check.believed(epoch).heading_hint is not None)
    return heard


@pytest.mark.parametrize("error_deg", [0.0, 90.0, -179.0])
def test_a_gyro_that_turns_as_the_bearings_do_is_heard_whatever_constant_error_it_has(error_deg: float) -> None:
    assert all(believed(epochs(error_deg)))


def test_a_frozen_gyro_is_refuted_in_a_turn_and_stays_so() -> None:
    heard = believed(epochs(frozen=True))
    assert heard[5]
    assert not any(heard[15:])


def test_a_turn_that_no_scan_showed_does_not_refute_the_gyro() -> None:
    yaw = YawLog()
    check = GyroCheck(yaw, navigator_model())
    for k in range(121):
        hint = HeadingHint(30.0 if k <= 30 else min(30.0 + 2.0 * (k - 30), 120.0), 1.5)
        echoes = () if 20 < k < 100 else (RadarTarget("1", 5000.0, 90.0 if k <= 20 else 0.0),)
        epoch = Epoch(BEGIN + timedelta(seconds=k), echoes, (), heading_hint=hint)
        yaw.feed(epoch)
        assert check.believed(epoch).heading_hint is not None
    begin_s = BEGIN.timestamp()
    assert yaw.between_deg(begin_s, begin_s + 120.0) == pytest.approx(0.0), "nothing is known of it"
    assert not yaw.watched(begin_s, begin_s + 120.0)
    assert yaw.watched(begin_s + 101.0, begin_s + 120.0)
