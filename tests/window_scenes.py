"""Seeded passages of many epochs for the adjustment of windows: known pairs, offsets that stay, gyro, log, current."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import numpy as np

from navfix.geodesy import LocalPlane
from navfix.types import Epoch, HeadingHint, Mark, Position, RadarTarget, SpeedHint
from navfix.units import wrap_180

START = datetime(2026, 5, 1, tzinfo=UTC)
OWN = Position(54.5, 18.8)


@dataclass(frozen=True)
class Passage:
    """Epochs with their pairs for the whole passage, and the truth: (E, 3) north m, east m, heading rad about `OWN`."""

    epochs: tuple[Epoch, ...]
    pairs: Mapping[str, str]
    truth: np.ndarray
    plane: LocalPlane

    def error(self, position: Position, epoch: int = -1) -> np.ndarray:
        """Return (north, east) [m] of a position less the truth of an epoch."""
        return self.plane.to_plane(position) - self.truth[epoch, :2]

    def heading_error_deg(self, heading_deg: float | None, epoch: int = -1) -> float:
        """Return a heading less the truth of an epoch; meridians converge."""
        assert heading_deg is not None
        north_m, east_m, turn_rad = self.truth[epoch].tolist()
        true_deg = math.degrees(turn_rad) + self.plane.convergence_deg(self.plane.to_position(north_m, east_m))
        return float(wrap_180(heading_deg - true_deg))


@dataclass(frozen=True)
class Errors:
    """1 sigma of the errors: ``steady`` share of the radar's variance stays with a track."""

    range_m: float = 30.0
    bearing_deg: float = 0.5
    steady: float = 0.0
    mark_m: float = 10.0
    range_bias_m: float = 5.0
    current_mps: tuple[float, float] = (0.5, -0.33)
    gyro_deg: float = 0.2
    gyro_bias_deg: float = 1.5
    log_mps: float = 0.05


def passage(
    rng: np.random.Generator,
    *,
    epochs: int = 20,
    step_s: float = 3.0,
    targets: int = 20,
    wrong: int = 0,
    mates: float = 0.0,
    errors: Errors = Errors(),
    sensors: bool = True,
    turn_deg_per_min: float = 0.0,
    speed_mps: float = 7.0,
    reach_m: tuple[float, float] = (1e3, 15e3),
    own: Position = OWN,
    sector_deg: float = 360.0,
    bearing_reference: str = "relative",
) -> Passage:
    """Return a passage; the first ``wrong`` marks are 200 to 3000 m off, a share ``mates`` of marks under way."""
    plane = LocalPlane(own)
    truth, water = _own_track(rng, epochs, step_s, speed_mps, turn_deg_per_min, errors)
    distance = np.exp(rng.uniform(math.log(reach_m[0]), math.log(reach_m[1]), targets))
    azimuth = math.radians(sector_deg) * rng.uniform(-0.5, 0.5, targets)
    place = np.stack([distance * np.cos(azimuth), distance * np.sin(azimuth)], axis=1)
    speed = rng.uniform(2.0, 8.0, targets) * (rng.random(targets) < mates)
    course = rng.uniform(0.0, 2.0 * math.pi, targets)
    velocity = speed[:, None] * np.stack([np.cos(course), np.sin(course)], axis=1)
    offset = errors.mark_m * rng.normal(size=(targets, 2))
    far, direction = rng.uniform(200.0, 3000.0, wrong), rng.uniform(0.0, 2.0 * math.pi, wrong)
    offset[:wrong] += np.stack([far * np.cos(direction), far * np.sin(direction)], axis=1)
    steady = math.sqrt(errors.steady) * rng.normal(size=(targets, 2))
    sigma = np.array([errors.range_m, math.radians(errors.bearing_deg)])
    found = []
    for e in range(epochs):
        at = START + timedelta(seconds=e * step_s)
        there = place + velocity * e * step_s
        sight = there - truth[e, :2]
        noise = sigma * (steady + math.sqrt(1.0 - errors.steady) * rng.normal(size=(targets, 2)))
        ranges = np.hypot(*sight.T) + errors.range_bias_m + noise[:, 0]
        turn = 0.0 if bearing_reference == "true" else truth[e, 2]
        bearings = np.degrees(np.arctan2(sight[:, 1], sight[:, 0]) - turn + noise[:, 1])
        marks, echoes = [], []
        for i in range(targets):
            told = there[i] + offset[i]
            moving = speed[i] > 0.0
            marks.append(
                Mark(
                    f"m{i}",
                    plane.to_position(*told.tolist()),
                    errors.mark_m,
                    speed_mps=float(speed[i]) if moving else 0.0,
                    course_deg=math.degrees(course[i]) if moving else None,
                )
            )
            echoes.append(
                RadarTarget(
                    f"t{i}", max(float(ranges[i]), 1.0), float(bearings[i]), bearing_reference,  # type: ignore[arg-type]
                    range_sigma_m=errors.range_m, bearing_sigma_deg=errors.bearing_deg,
                )
            )  # fmt: skip
        hints = _hints(rng, truth[e], water[e], errors) if sensors else (None, None)
        found.append(Epoch(at, tuple(echoes), tuple(marks), heading_hint=hints[0], speed_hint=hints[1]))
    return Passage(tuple(found), {f"t{i}": f"m{i}" for i in range(targets)}, truth, plane)


def _own_track(
    rng: np.random.Generator, epochs: int, step_s: float, speed_mps: float, turn_deg_per_min: float, errors: Errors
) -> tuple[np.ndarray, np.ndarray]:
    """Return poses (E, 3) and speed through water (E,); the step is integrated finely."""
    heading0 = rng.uniform(-math.pi, math.pi)
    rate = math.radians(turn_deg_per_min) / 60.0
    fine_s = 0.1
    steps = round(step_s / fine_s)
    pose, track = np.array([0.0, 0.0, heading0]), []
    for _ in range(epochs):
        track.append(pose.copy())
        for _ in range(steps):
            middle = pose[2] + 0.5 * rate * fine_s
            pose[:2] += fine_s * (speed_mps * np.array([math.cos(middle), math.sin(middle)]) + errors.current_mps)
            pose[2] += rate * fine_s
    return np.array(track), np.full(epochs, speed_mps)


def _hints(
    rng: np.random.Generator, pose: np.ndarray, water_mps: float, errors: Errors
) -> tuple[HeadingHint, SpeedHint]:
    heading_deg = math.degrees(pose[2]) + errors.gyro_bias_deg + errors.gyro_deg * rng.normal()
    speed_mps = water_mps + errors.log_mps * rng.normal()
    return HeadingHint(float(wrap_180(heading_deg)), 1.5), SpeedHint(float(speed_mps), 0.1)


def without_sensors(epoch: Epoch) -> Epoch:
    """Return the epoch without gyro and log."""
    return replace(epoch, heading_hint=None, speed_hint=None)
