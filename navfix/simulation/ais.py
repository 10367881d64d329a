"""What an AIS receiver hears of the world: class-true report intervals, delays, gaps, noise, wrong positions.

Report intervals: ITU-R M.1371-5, annex 1, tables 1 and 2 (class A by navigation status, speed and turning; class B
carrier sense; aids to navigation 3 min; static data 6 min). A position is latched a little before its slot and sent
up to a tenth of the interval early or late, as self-organised slots allow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from navfix.nmea import write_ais
from navfix.nmea.records import AisKind, AisPosition, AisStatic
from navfix.simulation.motion import Pose
from navfix.simulation.outages import WAIGAOQIAO, draw_outages, in_outage
from navfix.simulation.settings import AisSettings
from navfix.simulation.world import Body, World, random_stream
from navfix.units import KNOT_MPS

STATIC_INTERVAL_S = 360.0
_TURNING_DEG_PER_MIN = 10.0  # the table's 5 deg from the mean of 30 s
_JITTER = 0.1
_SPEED_SIGMA_MPS = 0.05
_HEADING_SIGMA_DEG = 0.4
Offsets = dict[int, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class AisMessage:
    """One message as received: ``time_s`` of reception [POSIX, true clock] and ``position_time_s`` of its content."""

    time_s: float
    position_time_s: float
    record: AisPosition | AisStatic


@dataclass(frozen=True, slots=True)
class _Station:
    """What stays with one station's transmissions: GNSS bias, wrong offset (north, east) [m], heading sensor."""

    body: Body
    bias_m: tuple[float, float]
    wrong_m: tuple[float, float]
    has_heading: bool
    accurate: bool


def report_interval_s(body: Body, speed_mps: float, turn_rate_deg_per_min: float) -> float:
    """Return the nominal interval [s] of position reports (ITU-R M.1371-5, annex 1, tables 1 and 2)."""
    speed_kn = speed_mps / KNOT_MPS
    if body.kind in ("aton", "virtual_aton", "long_range"):
        return 180.0
    if body.kind in ("base_station", "aircraft"):
        return 10.0
    if body.unit == "B":
        return 30.0 if speed_kn > 2.0 else 180.0
    if body.navigation_status in (1, 5) and speed_kn <= 3.0:
        return 180.0
    turning = abs(turn_rate_deg_per_min) > _TURNING_DEG_PER_MIN
    if speed_kn > 23.0:
        return 2.0
    if speed_kn > 14.0:
        return 2.0 if turning else 6.0
    return 10.0 / 3.0 if turning else 10.0


def wrong_offsets(world: World, settings: AisSettings, radar_range_m: float, rng: np.random.Generator) -> Offsets:
    """Return the stations that claim a wrong place, MMSI -> (north, east) [m]: single ones and the coherent group.

    They are drawn from what own ship's radar could see first, from the others when these do not suffice.
    """
    candidates = [body for body in world.bodies if body.mmsi and body.echoes]
    own = world.own.at(0.0)
    near = [
        math.hypot(float(b.motion.north_m - own.north_m), float(b.motion.east_m - own.east_m)) < radar_range_m
        for b in candidates
    ]
    order = rng.permutation(len(candidates))
    chosen = sorted(order, key=lambda index: not near[index])[: settings.wrong_count + settings.group_count]
    azimuth = math.radians(settings.group_azimuth_deg)
    offsets: Offsets = {}
    for rank, index in enumerate(chosen):
        if rank < settings.wrong_count:
            logs = math.log(settings.wrong_offset_min_m), math.log(settings.wrong_offset_max_m)
            size, angle = math.exp(rng.uniform(*logs)), rng.uniform(0.0, 2.0 * math.pi)
        else:
            size, angle = settings.group_offset_m, azimuth
        offsets[candidates[index].mmsi] = size * math.cos(angle), size * math.sin(angle)
    return offsets


def receive(
    world: World, settings: AisSettings, duration_s: float, radar_range_m: float, seed: int
) -> tuple[list[AisMessage], Offsets]:
    """Return every message heard within the recording, by time of reception, and the wrong offsets by MMSI."""
    rng = random_stream(seed, "ais")
    offsets = wrong_offsets(world, settings, radar_range_m, rng)
    messages: list[AisMessage] = []
    for body in world.bodies:
        if not body.mmsi:
            continue
        own_rng = np.random.default_rng(rng.integers(2**63, size=2))
        if _heard(world, body, settings):
            messages += _transmissions(world, _station(body, settings, offsets, own_rng), settings, duration_s, own_rng)
    return sorted(messages, key=lambda message: message.time_s), offsets


def _heard(world: World, body: Body, settings: AisSettings) -> bool:
    pose, own = body.motion.at(0.0), world.own.at(0.0)
    distance_m = math.hypot(float(pose.north_m - own.north_m), float(pose.east_m - own.east_m))
    return distance_m <= settings.range_m or body.kind == "long_range"


def _station(body: Body, settings: AisSettings, offsets: Offsets, rng: np.random.Generator) -> _Station:
    north, east = rng.normal(0.0, settings.gnss_bias_sigma_m, 2)
    has_heading = body.unit == "A" and bool(rng.random() >= settings.no_heading)
    return _Station(
        body, (float(north), float(east)), offsets.get(body.mmsi, (0.0, 0.0)), has_heading, bool(rng.random() < 0.4)
    )


def _transmissions(
    world: World, station: _Station, settings: AisSettings, duration_s: float, rng: np.random.Generator
) -> list[AisMessage]:
    """Return what of one station is received: position reports and static data, less losses and outages."""
    body = station.body
    outages = draw_outages(WAIGAOQIAO, duration_s, rng) if settings.outages == "waigaoqiao" else []
    report = partial(_position_message, world, station, settings, rng)
    sent = [report(time_s) for time_s in _schedule(body, duration_s, rng)]
    if body.kind == "ship":
        static = AisStatic(
            time_s=None,
            mmsi=body.mmsi,
            message_type=5 if body.unit == "A" else 24,
            hull=body.hull if body.sends_size else None,
            ship_type=body.ship_type,
            name=body.name,
        )
        times = np.arange(rng.uniform(0.0, STATIC_INTERVAL_S), duration_s, STATIC_INTERVAL_S)
        sent += [AisMessage(world.start_s + float(t), world.start_s + float(t), static) for t in times]
    lost = rng.random(len(sent)) < settings.loss
    return [
        message
        for message, gone in zip(sent, lost, strict=True)
        if not gone and not in_outage(outages, message.time_s - world.start_s)
    ]


def _schedule(body: Body, duration_s: float, rng: np.random.Generator) -> list[float]:
    """Return the times [s] of a station's position reports: nominal increments, each slot within +- 10 % of them."""
    times: list[float] = []
    nominal_s = -_interval_s(body, 0.0) * float(rng.random())
    while nominal_s < duration_s * (1.0 + _JITTER):
        interval_s = _interval_s(body, max(nominal_s, 0.0))
        sent_s = nominal_s + interval_s * float(rng.uniform(-_JITTER, _JITTER))
        if 0.0 <= sent_s < duration_s:
            times.append(sent_s)
        nominal_s += interval_s
    return times


def _interval_s(body: Body, time_s: float) -> float:
    pose = body.motion.at(time_s)
    return report_interval_s(body, float(pose.speed_mps), math.degrees(float(pose.turn_rate_rad_s)) * 60.0)


def _position_message(
    world: World, station: _Station, settings: AisSettings, rng: np.random.Generator, time_s: float
) -> AisMessage:
    body = station.body
    latched_s = time_s - float(rng.uniform(0.0, settings.position_age_max_s))
    pose = body.motion.at(latched_s)
    lat_deg, lon_deg = _reported_place(world, station, settings, pose, rng)
    position_time_s = world.start_s + latched_s
    message_type, kind = _MESSAGE_TYPE.get(body.kind, (1 if body.unit == "A" else 18, "ship"))
    record = AisPosition(
        time_s=position_time_s,
        mmsi=body.mmsi,
        message_type=message_type,
        kind=kind,
        lat_deg=lat_deg,
        lon_deg=lon_deg,
        accurate=station.accurate,
        utc_second=math.floor(position_time_s) % 60,
        ais_class=body.unit,
        navigation_status=body.navigation_status if body.unit == "A" else None,
        virtual=body.kind == "virtual_aton",
        aid_type=body.aid_type if kind == "aton" else None,
        name=body.name,
        hull=body.hull if body.kind == "aton" else None,
    )
    return AisMessage(world.start_s + time_s, position_time_s, _with_movement(record, world, station, pose, rng))


_MESSAGE_TYPE: dict[str, tuple[int, AisKind]] = {
    "aton": (21, "aton"),
    "virtual_aton": (21, "aton"),
    "base_station": (4, "base_station"),
    "aircraft": (9, "aircraft"),
    "long_range": (27, "long_range"),
}


def _reported_place(
    world: World, station: _Station, settings: AisSettings, pose: Pose, rng: np.random.Generator
) -> tuple[float, float]:
    """Return latitude and longitude [deg] of the antenna as the station believes or claims it."""
    forward, starboard = -station.body.hull.centre_forward_m, -station.body.hull.centre_starboard_m
    north, east = pose.offset(forward, starboard)
    noise = rng.normal(0.0, settings.gnss_noise_sigma_m, 2)
    lat, lon = world.stage.places(
        north + station.bias_m[0] + station.wrong_m[0] + noise[0],
        east + station.bias_m[1] + station.wrong_m[1] + noise[1],
    )
    return float(lat), float(lon)


def _with_movement(
    record: AisPosition, world: World, station: _Station, pose: Pose, rng: np.random.Generator
) -> AisPosition:
    """Return the report with speed, course, heading and turn rate as the station's sensors say, where it has any."""
    speed_noise, course_noise, heading_noise = (float(noise) for noise in rng.normal(0.0, 1.0, 3))
    if station.body.kind not in ("ship", "aircraft", "long_range"):
        return record
    speed_mps = float(pose.speed_mps)
    course_sigma_deg = math.degrees(math.atan2(_SPEED_SIGMA_MPS, speed_mps))
    record = replace(
        record,
        speed_mps=abs(speed_mps + _SPEED_SIGMA_MPS * speed_noise),
        course_deg=float(world.true_deg(pose, pose.course_rad)) + course_sigma_deg * course_noise,
    )
    if not station.has_heading:
        return record
    return replace(
        record,
        heading_deg=float(world.true_deg(pose, pose.heading_rad)) + _HEADING_SIGMA_DEG * heading_noise,
        turn_rate_deg_per_min=math.degrees(float(pose.turn_rate_rad_s)) * 60.0,
    )


def sentences(message: AisMessage, *, channel: write_ais.Channel, sequence: int) -> list[str]:
    """Return the message as AIVDM sentences."""
    if isinstance(message.record, AisStatic):
        return write_ais.static_report(message.record, channel=channel, sequence=sequence)
    return write_ais.position_report(message.record, channel=channel)
