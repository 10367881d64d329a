"""Fixes and epochs for the tests of dead reckoning."""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta

import numpy as np

from navfix.types import Epoch, Fix, HeadingHint, Position, SpeedHint

START = datetime(2026, 5, 1, tzinfo=UTC)
OWN = Position(54.5, 18.8)


def fix_at(position: Position, heading_deg: float | None = 30.0, sigma_m: float = 10.0) -> Fix:
    covariance = np.diag([sigma_m**2, sigma_m**2, math.radians(0.3) ** 2])
    if heading_deg is None:
        covariance = covariance[:2, :2]
    return Fix(
        position, heading_deg, covariance, 1.0, 9, (), None, None, covariance, "a_priori", 9.0, "hampel"
    )  # fmt: skip


def epoch_at(second: float, *, gyro: float | None = None, log: float | None = None) -> Epoch:
    hint = None if gyro is None else HeadingHint(gyro, 1.5)
    speed = None if log is None else SpeedHint(log, 0.1)
    return Epoch(START + timedelta(seconds=second), (), (), heading_hint=hint, speed_hint=speed)
