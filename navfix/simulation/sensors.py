"""Own ship's sensors in the log: heading, log, GNSS (honest or spoofed) and own AIS. All off by default."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from navfix.nmea import write, write_ais
from navfix.nmea.records import AisPosition
from navfix.simulation.motion import Pose
from navfix.simulation.settings import OwnSensors
from navfix.simulation.world import World, random_stream
from navfix.types import FloatArray, Position

_OWN_AIS_INTERVAL_S = 10.0


def own_sentences(
    world: World, settings: OwnSensors, duration_s: float, own_mmsi: int, seed: int
) -> list[tuple[float, str]]:
    """Return (time of reception [POSIX s], sentence) of every own sensor that is switched on."""
    rng = random_stream(seed, "sensors")
    bias_m = rng.normal(0.0, settings.gnss_sigma_m * 0.8, 2)
    lines: list[tuple[float, str]] = []
    for time_s in np.arange(0.0, duration_s, settings.interval_s):
        pose = world.own.at(time_s)
        stamp_s = world.start_s + float(time_s)
        noise = rng.normal(0.0, 1.0, 4)
        place = _gnss_place(world, settings, pose, float(time_s), bias_m + 0.6 * settings.gnss_sigma_m * noise[:2])
        lines += [(stamp_s, text) for text in _inner(world, settings, pose, noise[2:])]
        if settings.gnss:
            speed_mps, course_deg = _gnss_velocity(world, settings, pose, float(time_s))
            lines.append((stamp_s, write.rmc(stamp_s, place, speed_mps=speed_mps, course_deg=course_deg)))
            lines.append((stamp_s, write.gga(stamp_s, place)))
        if settings.own_ais and time_s % _OWN_AIS_INTERVAL_S < settings.interval_s:
            lines += [(stamp_s, text) for text in _own_ais(world, pose, place, stamp_s, own_mmsi)]
    return lines


def _inner(world: World, settings: OwnSensors, pose: Pose, noise: FloatArray) -> Iterator[str]:
    """Yield heading and log: what does not come from GNSS."""
    heading_deg = float(world.true_deg(pose, pose.heading_rad)) + settings.heading_bias_deg
    heading_deg += settings.heading_sigma_deg * float(noise[0])
    if settings.heading == "hdt":
        yield write.hdt(heading_deg)
    elif settings.heading == "ths":
        yield write.ths(heading_deg)
    if settings.log:
        ahead_mps = float(pose.speed_mps * np.cos(pose.course_rad - pose.heading_rad)) * settings.log_scale
        yield write.vhw(
            heading_deg=heading_deg, speed_mps=max(0.0, ahead_mps + settings.log_sigma_mps * float(noise[1]))
        )


def _spoof_m(settings: OwnSensors, time_s: float) -> float:
    """Return how far the GNSS is led away at a time [m]."""
    since_s = time_s - settings.spoof_at_s
    if settings.spoof == "none" or since_s < 0.0:
        return 0.0
    return settings.spoof_offset_m if settings.spoof == "jump" else settings.spoof_rate_mps * since_s


def _gnss_place(world: World, settings: OwnSensors, pose: Pose, time_s: float, error_m: FloatArray) -> Position:
    azimuth, offset_m = math.radians(settings.spoof_azimuth_deg), _spoof_m(settings, time_s)
    lat, lon = world.stage.places(
        pose.north_m + error_m[0] + offset_m * math.cos(azimuth),
        pose.east_m + error_m[1] + offset_m * math.sin(azimuth),
    )
    return Position(float(lat), float(lon))


def _gnss_velocity(world: World, settings: OwnSensors, pose: Pose, time_s: float) -> tuple[float, float]:
    """Return speed [m/s] and course [deg] as the GNSS says: a drag-off adds its own velocity."""
    dragged = settings.spoof == "drag_off" and time_s >= settings.spoof_at_s
    rate_mps, azimuth = settings.spoof_rate_mps if dragged else 0.0, math.radians(settings.spoof_azimuth_deg)
    north = float(pose.north_mps) + rate_mps * math.cos(azimuth)
    east = float(pose.east_mps) + rate_mps * math.sin(azimuth)
    return math.hypot(north, east), float(world.true_deg(pose, np.asarray(math.atan2(east, north))))


def _own_ais(world: World, pose: Pose, place: Position, stamp_s: float, own_mmsi: int) -> list[str]:
    report = AisPosition(
        time_s=stamp_s,
        mmsi=own_mmsi,
        message_type=1,
        kind="ship",
        lat_deg=place.lat_deg,
        lon_deg=place.lon_deg,
        speed_mps=float(pose.speed_mps),
        course_deg=float(world.true_deg(pose, pose.course_rad)),
        utc_second=math.floor(stamp_s) % 60,
        navigation_status=0,
        own=True,
    )
    return write_ais.position_report(report)
