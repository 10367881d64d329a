"""Radar and AIS in one format, and fused by inverse variances in range, bearing, speed and course."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.catalog import RadarModel, TrackModel, ais_model, radar_model, track_model
from navfix.geodesy import direct, inverse
from navfix.picture.hull import facing
from navfix.types import (
    Association,
    BearingReference,
    Epoch,
    FloatArray,
    Mark,
    Position,
    RadarTarget,
    TargetList,
    TrackedShip,
)
from navfix.units import wrap_180, wrap_360

STEERING_MPS = 0.5  # slower, a course says nothing
AIDS = ("aton", "charted")
SAME_SHIP_CHI2 = 13.816  # 99.9 % of a chi-square of two
WORST_ANGLE_DEG2 = 180.0**2


@dataclass(frozen=True, slots=True, eq=False)
class OwnPose:
    """Own place, heading [deg] (None: not known) and covariance (3, 3) or (2, 2): north m, east m, heading rad."""

    position: Position
    heading_deg: float | None
    covariance: FloatArray
    compass_error_deg: float | None = None
    compass_variance_deg2: float = 0.0


def fuse(values: FloatArray, variances: FloatArray) -> tuple[float, float]:
    """Return the mean weighted by inverse variances and its variance: eq. (9.5) to (9.7)."""
    weights = 1.0 / np.asarray(variances, dtype=np.float64)  # eq. (12) of [11]
    return float(weights @ values / weights.sum()), float(1.0 / weights.sum())  # eq. (13), (14)


def fuse_angles(values_deg: FloatArray, variances_deg2: FloatArray) -> tuple[float, float]:
    """Return the same of angles [deg], right across north."""
    first = float(values_deg[0])
    mean_deg, variance = fuse(first + wrap_180(np.asarray(values_deg, dtype=np.float64) - first), variances_deg2)
    return wrap_360(mean_deg), variance


def fused_list(
    epoch: Epoch,
    own: OwnPose,
    association: Association,
    *,
    radar: RadarModel | str = "imo",
    model: TrackModel | str = "polar",
) -> TargetList:
    """Return every ship of an epoch: fused where target and mark are a pair, else by the sensor that sees it.

    Radar and AIS are brought to one point, the side of the hull that own ship sees. The variance of own place counts to
    AIS, that of own heading to radar; that a fix rests on both is left out. A pair whose ranges and bearings contradict
    each other (a false AIS position, a wrong pair) is not fused: both stand alone.
    """
    constants, instrument = track_model(model), radar_model(radar)
    seen = facing(facing(epoch, own.position, association.pairs), own.position)
    pairs = {int(t): (int(m), float(p)) for (t, m), p in zip(association.pairs, association.probability, strict=True)}
    ships = []
    for index, target in enumerate(seen.targets):
        by_radar = radar_ship(_with_sigmas(target, instrument), epoch, own, constants)
        if index in pairs and by_radar.bearing_reference == "true":
            mark, probability = pairs[index]
            by_ais = ais_ship(seen.marks[mark], epoch, own)
            if _agree(by_radar, by_ais):
                by_radar = placed(replace(fuse_ships(by_radar, by_ais), probability=probability), own.position)
        ships.append(by_radar)
    paired = {ship.mark for ship in ships}
    ships += [ais_ship(mark, epoch, own) for mark in seen.marks if mark.label not in paired]
    return TargetList(epoch.time_utc, tuple(ships), own.position, own.heading_deg)


def lists_apart(
    epoch: Epoch,
    *,
    reason: str,
    message: str,
    radar: RadarModel | str = "imo",
    model: TrackModel | str = "polar",
) -> TargetList:
    """Return what radar sees and what AIS says, unfused: without own place nothing joins them."""
    constants, instrument = track_model(model), radar_model(radar)
    ships = [radar_ship(_with_sigmas(target, instrument), epoch, None, constants) for target in epoch.targets]
    ships += [ais_ship(mark, epoch, None) for mark in epoch.marks]
    return TargetList(epoch.time_utc, tuple(ships), reason=reason, message=message)


def radar_ship(target: RadarTarget, epoch: Epoch, own: OwnPose | None, model: TrackModel) -> TrackedShip:
    """Bring a target that carries its sigmas into the common format; its bearing is true where the heading is known."""
    bearing_deg, variance, reference = _true_bearing(target, own)
    speed_m2ps2, course_deg2 = _velocity_variances(target.speed_mps, target.course_deg, model.radar_speed_sigma_mps)
    ship = TrackedShip(
        sensor="radar",
        label=target.label,
        target=target.label,
        time_utc=epoch.time_utc,
        range_m=target.range_m,
        range_variance_m2=None if target.range_sigma_m is None else target.range_sigma_m**2,
        bearing_deg=bearing_deg,
        bearing_variance_deg2=variance,
        bearing_reference=reference,
        speed_mps=target.speed_mps,
        speed_variance_m2ps2=speed_m2ps2,
        course_deg=None if course_deg2 is None else target.course_deg,
        course_variance_deg2=course_deg2,
    )
    return ship if own is None else placed(ship, own.position)


def ais_ship(mark: Mark, epoch: Epoch, own: OwnPose | None) -> TrackedShip:
    """Bring a mark into the common format; range and bearing where own place is known."""
    sigma_mps = ais_model("class_b" if mark.ais_class == "B" else "class_a").speed_sigma_mps
    speed_m2ps2, course_deg2 = _velocity_variances(mark.speed_mps, mark.course_deg, sigma_mps)
    ship = TrackedShip(
        sensor="ais",
        label=mark.label,
        mark=mark.label,
        mmsi=mark.mmsi,
        name=mark.name,
        kind=mark.kind,
        time_utc=epoch.time_utc,
        speed_mps=mark.speed_mps,
        speed_variance_m2ps2=speed_m2ps2,
        course_deg=None if course_deg2 is None else mark.course_deg,
        course_variance_deg2=course_deg2,
        position=mark.position,
    )
    if own is None:
        return ship
    range_m, bearing_deg = inverse(own.position, mark.position)
    along = np.array([math.cos(math.radians(bearing_deg)), math.sin(math.radians(bearing_deg))])
    across = np.array([-along[1], along[0]])
    place = own.covariance[:2, :2]
    return replace(
        ship,
        range_m=range_m,
        range_variance_m2=mark.sigma_m**2 + float(along @ place @ along),
        bearing_deg=bearing_deg,
        bearing_variance_deg2=_angle_deg2(mark.sigma_m**2 + float(across @ place @ across), range_m),
    )


def fuse_ships(radar: TrackedShip, ais: TrackedShip) -> TrackedShip:
    """Fuse what radar and AIS say of one ship, both with true bearings; what only one says is taken from it.

    An aid to navigation keeps its place: what speed and course the radar's track has are noise and stay out.
    """
    if ais.kind in AIDS:
        radar = replace(radar, speed_mps=None, speed_variance_m2ps2=None, course_deg=None, course_variance_deg2=None)
    range_m, range_m2 = _joined(radar.range_m, radar.range_variance_m2, ais.range_m, ais.range_variance_m2)
    bearing_deg, bearing_deg2 = _joined(
        radar.bearing_deg, radar.bearing_variance_deg2, ais.bearing_deg, ais.bearing_variance_deg2, angle=True
    )
    speed_mps, speed_m2ps2 = _joined(
        radar.speed_mps, radar.speed_variance_m2ps2, ais.speed_mps, ais.speed_variance_m2ps2
    )
    course_deg, course_deg2 = _joined(
        radar.course_deg, radar.course_variance_deg2, ais.course_deg, ais.course_variance_deg2, angle=True
    )
    return replace(
        ais,
        sensor="fused",
        target=radar.target,
        range_m=range_m,
        range_variance_m2=range_m2,
        bearing_deg=bearing_deg,
        bearing_variance_deg2=bearing_deg2,
        speed_mps=speed_mps,
        speed_variance_m2ps2=speed_m2ps2,
        course_deg=course_deg,
        course_variance_deg2=course_deg2,
    )


def placed(ship: TrackedShip, own: Position) -> TrackedShip:
    """Return a ship with the place that its range and true bearing give."""
    if ship.range_m is None or ship.bearing_deg is None or ship.bearing_reference != "true":
        return ship
    return replace(ship, position=direct(own, ship.bearing_deg, ship.range_m))


def _agree(radar: TrackedShip, ais: TrackedShip) -> bool:
    """Tell whether range and bearing of two sensors differ by no more than their variances explain."""
    misfit = 0.0
    for one, one_variance, other, other_variance, angle in (
        (radar.range_m, radar.range_variance_m2, ais.range_m, ais.range_variance_m2, False),
        (radar.bearing_deg, radar.bearing_variance_deg2, ais.bearing_deg, ais.bearing_variance_deg2, True),
    ):
        if one is None or one_variance is None or other is None or other_variance is None:
            return False
        difference = wrap_180(one - other) if angle else one - other
        misfit += difference**2 / (one_variance + other_variance)
    return misfit <= SAME_SHIP_CHI2


def _joined(
    one: float | None,
    one_variance: float | None,
    other: float | None,
    other_variance: float | None,
    *,
    angle: bool = False,
) -> tuple[float | None, float | None]:
    """Return the fused value and variance of what is known of both."""
    if one is None or one_variance is None:
        return other, other_variance
    if other is None or other_variance is None:
        return one, one_variance
    join = fuse_angles if angle else fuse
    return join(np.array([one, other]), np.array([one_variance, other_variance]))


def _with_sigmas(target: RadarTarget, radar: RadarModel) -> RadarTarget:
    """Return a target that brings its sigmas: its own, else those of the radar."""
    return replace(
        target,
        range_sigma_m=target.range_sigma_m or float(radar.sigma_of_range_m(target.range_m)),
        bearing_sigma_deg=target.bearing_sigma_deg or radar.bearing_sigma_deg,
    )


def _true_bearing(target: RadarTarget, own: OwnPose | None) -> tuple[float, float, BearingReference]:
    """Return bearing [deg], variance [deg2] and reference: true where the heading, or the compass in it, is known."""
    assert target.bearing_sigma_deg is not None
    variance = target.bearing_sigma_deg**2
    if target.bearing_reference == "true":
        error_deg = 0.0 if own is None else own.compass_error_deg or 0.0
        added = 0.0 if own is None else own.compass_variance_deg2
        return wrap_360(target.bearing_deg + error_deg), variance + added, "true"
    if own is None or own.heading_deg is None:
        return target.bearing_deg, variance, "relative"
    added = math.degrees(1.0) ** 2 * float(own.covariance[2, 2])
    return wrap_360(target.bearing_deg + own.heading_deg), variance + added, "true"


def _velocity_variances(
    speed_mps: float | None, course_deg: float | None, sigma_mps: float
) -> tuple[float | None, float | None]:
    """Return the variances of speed and course; a course counts only of a ship that moves."""
    if speed_mps is None:
        return None, None
    moves = course_deg is not None and speed_mps >= STEERING_MPS
    return sigma_mps**2, _angle_deg2(sigma_mps**2, speed_mps) if moves else None


def _angle_deg2(across_variance: float, distance: float) -> float:
    """Return the variance [deg2] of the direction of a vector of this length and variance across."""
    return min(math.degrees(1.0) ** 2 * across_variance / max(distance, 1e-3) ** 2, WORST_ANGLE_DEG2)
