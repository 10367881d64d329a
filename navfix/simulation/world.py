"""The seeded world: own ship, ships with hulls, aids to navigation real and virtual, a base station, an aircraft.

Every subject (world, AIS, radar, own sensors) draws from its own stream of random numbers, so that switching one
sensor on leaves the others as they were.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from navfix.errors import InputError
from navfix.simulation.motion import Motion, Pose
from navfix.simulation.settings import OwnShip, TrafficGroup
from navfix.simulation.stage import Stage
from navfix.simulation.traffic import Placement, place
from navfix.types import FloatArray, Hull, Position
from navfix.units import wrap_360

Unit = Literal["A", "B"]
_SUBJECTS = ("world", "ais", "radar", "tracker", "sensors")
_BUOY = Hull(bow_m=1.0, stern_m=1.0, port_m=1.0, starboard_m=1.0)
_NO_HULL = Hull(bow_m=0.0, stern_m=0.0, port_m=0.0, starboard_m=0.0)
# MMSI blocks: MID 200 is not allotted to any country, so no real ship is meant.
_MMSI_BLOCK = {
    "ship": 200100000, "aton": 992001000, "virtual_aton": 992006000,
    "base_station": 2000000, "aircraft": 111200000, "long_range": 200300000,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Body:
    """One thing of the world. ``motion`` is that of the hull's centre; ``mmsi`` is 0 for a ship without AIS.

    ``hull`` is the true one, counted from the AIS antenna; ``sends_size`` tells whether AIS says so.
    """

    mmsi: int
    name: str
    kind: str
    motion: Motion
    hull: Hull
    unit: Unit | None = None
    ship_type: int = 0
    navigation_status: int = 0
    sends_size: bool = True
    aid_type: int = 0

    @property
    def echoes(self) -> bool:
        """Whether a radar sees it: virtual aids, far ships, stations ashore and aircraft are not tracked."""
        return self.kind in ("ship", "aton")


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Own ship and everything about it; times count in seconds from ``start_s`` (POSIX)."""

    stage: Stage
    start_s: float
    own: Motion
    bodies: tuple[Body, ...]

    def true_deg(self, pose: Pose, direction_rad: FloatArray) -> FloatArray:
        """Return plane directions at a pose as true directions [deg]."""
        return wrap_360(np.degrees(direction_rad + self.stage.convergence_rad(pose.north_m, pose.east_m)))


def random_stream(seed: int, subject: str) -> np.random.Generator:
    """Return the random numbers of one subject: "world", "ais", "radar", "tracker" or "sensors".

    Raises
    ------
    InputError : a seed below 0
    """
    if seed < 0:
        raise InputError(f"the seed must be >= 0, got {seed}")
    return np.random.default_rng([seed, _SUBJECTS.index(subject)])


def make_world(
    origin: Position, start_s: float, duration_s: float, own: OwnShip, traffic: tuple[TrafficGroup, ...], seed: int
) -> World:
    """Return the world of a scenario; the same seed gives the same world."""
    rng = random_stream(seed, "world")
    bodies: list[Body] = []
    for group in traffic:
        for placement in place(group, rng):
            serial = 1 + sum(body.kind == group.kind for body in bodies)
            bodies.append(_body(group, placement, serial, duration_s, rng))
    return World(Stage(origin), start_s, own_motion(own), tuple(bodies))


def own_motion(own: OwnShip) -> Motion:
    """Return own ship's motion."""
    rate = math.radians(math.copysign(own.turn_rate_deg_per_min, own.turn_deg)) / 60.0
    return Motion(
        north_m=own.north_m,
        east_m=own.east_m,
        course_rad=math.radians(own.course_deg),
        speed_mps=own.speed_mps,
        turn_at_s=own.turn_at_s,
        turn_rate_rad_s=rate,
        turn_time_s=math.radians(own.turn_deg) / rate,
        drift_rad=math.radians(own.drift_deg),
        yaw_rad=math.radians(own.yaw_deg),
        yaw_period_s=own.yaw_period_s,
    )


# ------------------------------------------------------------------------------------------------- bodies


def _body(group: TrafficGroup, placement: Placement, serial: int, duration_s: float, rng: np.random.Generator) -> Body:
    if group.kind in ("ship", "long_range"):
        return _ship(group, placement, serial, duration_s, rng)
    mmsi = _MMSI_BLOCK[group.kind] + serial
    if group.kind == "aton":
        drift_north, drift_east = rng.normal(0.0, 4.0, 2)  # on its chain
        motion = Motion(placement.north_m + float(drift_north), placement.east_m + float(drift_east))
        aid_type = (24, 25, 30)[int(rng.integers(3))]  # port hand, starboard hand, special mark
        return Body(mmsi, f"BUOY {serial:02d}", "aton", motion, _BUOY, aid_type=aid_type)
    moving = group.kind == "aircraft"
    motion = Motion(
        placement.north_m,
        placement.east_m,
        math.radians(placement.course_deg),
        placement.speed_mps if moving else 0.0,
    )
    name = {"virtual_aton": "VIRTUAL", "base_station": "BASE", "aircraft": "RESCUE"}[group.kind]
    aid_type = 1 if group.kind == "virtual_aton" else 0
    return Body(mmsi, f"{name} {serial:02d}", group.kind, motion, _NO_HULL, aid_type=aid_type)


def _ship(group: TrafficGroup, placement: Placement, serial: int, duration_s: float, rng: np.random.Generator) -> Body:
    hull = _hull(group, rng)
    ship_type, word = _ship_type(hull.length_m, rng)
    has_ais = bool(rng.random() < group.with_ais)
    unit: Unit = "B" if rng.random() < group.class_b else "A"
    turns, sends_size = bool(rng.random() < group.turning), bool(rng.random() >= group.unknown_size)
    return Body(
        mmsi=_MMSI_BLOCK[group.kind] + serial if has_ais else 0,
        name=f"{word} {serial:03d}",
        kind=group.kind,
        motion=_at_anchor(placement, hull, rng)
        if placement.anchored
        else _under_way(placement, duration_s, turns, rng),
        hull=hull,
        unit=unit if has_ais else None,
        ship_type=ship_type,
        navigation_status=1 if placement.anchored else 0,
        sends_size=sends_size,
    )


def _hull(group: TrafficGroup, rng: np.random.Generator) -> Hull:
    """Return a hull: length log-uniform, beam by the usual ratio, antenna mostly aft, a little off the middle."""
    length_m = round(math.exp(rng.uniform(math.log(group.hull_min_m), math.log(group.hull_max_m))))
    beam_m = max(2, round(length_m / rng.uniform(5.5, 7.0))) if length_m > 25 else max(2, round(length_m / 3.2))
    from_bow = rng.uniform(0.6, 0.95) if rng.random() < 0.75 else rng.uniform(0.1, 0.6)
    bow_m, port_m = round(length_m * from_bow), round(beam_m * rng.uniform(0.3, 0.7))
    return Hull(float(bow_m), float(length_m - bow_m), float(port_m), float(beam_m - port_m))


def _ship_type(length_m: float, rng: np.random.Generator) -> tuple[int, str]:
    small = ((37, "YACHT"), (36, "SAIL"), (30, "FISHER"))
    middle = ((52, "TUG"), (30, "TRAWLER"), (60, "FERRY"), (50, "PILOT"))
    large = ((70, "CARGO"), (70, "CARGO"), (80, "TANKER"), (60, "LINER"))
    choices = small if length_m < 20.0 else middle if length_m < 60.0 else large
    return choices[int(rng.integers(len(choices)))]


def _at_anchor(placement: Placement, hull: Hull, rng: np.random.Generator) -> Motion:
    """Swing about the anchor: chain of about 80 to 200 m, 3 to 12 deg either way within 8 to 20 minutes."""
    return Motion(
        placement.north_m,
        placement.east_m,
        course_rad=math.radians(placement.course_deg),
        yaw_rad=math.radians(float(rng.uniform(3.0, 12.0))),
        yaw_period_s=float(rng.uniform(480.0, 1200.0)),
        yaw_phase_rad=float(rng.uniform(0.0, 2.0 * math.pi)),
        swing_radius_m=hull.length_m / 2.0 + float(rng.uniform(80.0, 200.0)),
    )


def _under_way(placement: Placement, duration_s: float, turns: bool, rng: np.random.Generator) -> Motion:
    """Constant speed and leeway; a turning ship alters course by 20 to 90 deg once within the recording."""
    turn_rad = math.radians(float(rng.uniform(20.0, 90.0))) * (1.0 if rng.random() < 0.5 else -1.0)
    rate = math.copysign(math.radians(float(rng.uniform(15.0, 60.0))) / 60.0, turn_rad)
    turn_at_s, drift_deg = float(rng.uniform(0.0, duration_s)), float(rng.normal(0.0, 1.5))
    return Motion(
        placement.north_m,
        placement.east_m,
        course_rad=math.radians(placement.course_deg),
        speed_mps=placement.speed_mps,
        turn_at_s=turn_at_s,
        turn_rate_rad_s=rate if turns else 0.0,
        turn_time_s=turn_rad / rate if turns else 0.0,
        drift_rad=math.radians(drift_deg),
    )
