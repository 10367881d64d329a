"""The parts of a scenario: own ship, traffic, AIS, radar, own sensors. Checked, in SI units and degrees."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from navfix.types.checks import require

LAYOUTS = ("uniform", "anchorage", "lane", "buoy_channel")
KINDS = ("ship", "aton", "virtual_aton", "base_station", "aircraft", "long_range")


def check_numbers(record: Any, *, signed: tuple[str, ...] = (), shares: tuple[str, ...] = ()) -> None:
    """Require finite numbers everywhere, >= 0 unless named in ``signed``, within 0 .. 1 where named in ``shares``."""
    where = type(record).__name__
    for field in fields(record):
        value, kind = getattr(record, field.name), str(field.type)
        name = f"{where}.{field.name}"
        if value is None and "None" in kind:
            continue
        if kind.startswith("bool"):
            require(isinstance(value, bool), name, "must be true or false", value)
        elif kind.startswith("int"):
            require(isinstance(value, int) and not isinstance(value, bool), name, "must be a whole number", value)
        elif kind.startswith("str"):
            require(isinstance(value, str), name, "must be a text", value)
        if kind.startswith(("int", "float")):
            require(math.isfinite(value), name, "must be finite", value)
            require(field.name in signed or value >= 0, name, "must be >= 0", value)
            require(field.name not in shares or value <= 1, name, "must be within 0 .. 1", value)


@dataclass(frozen=True, slots=True)
class OwnShip:
    """Own ship's track: position at the start, constant speed, one optional turn, leeway and yawing.

    ``north_m``, ``east_m`` count from the scenario's place. ``turn_deg`` (to starboard) begins at ``turn_at_s``.
    Heading = course + ``drift_deg`` + ``yaw_deg`` sin(...).
    """

    speed_mps: float
    course_deg: float
    north_m: float = 0.0
    east_m: float = 0.0
    turn_at_s: float = 0.0
    turn_deg: float = 0.0
    turn_rate_deg_per_min: float = 30.0
    drift_deg: float = 0.0
    yaw_deg: float = 0.0
    yaw_period_s: float = 12.0
    mmsi: int = 200999001

    def __post_init__(self) -> None:
        check_numbers(self, signed=("course_deg", "north_m", "east_m", "turn_deg", "drift_deg"))
        require(self.yaw_period_s > 0, "OwnShip.yaw_period_s", "must be > 0", self.yaw_period_s)
        require(
            self.turn_rate_deg_per_min > 0, "OwnShip.turn_rate_deg_per_min", "must be > 0", self.turn_rate_deg_per_min
        )


@dataclass(frozen=True, slots=True)
class TrafficGroup:
    """A group of ships or aids to navigation laid out alike; ``north_m``, ``east_m`` is its centre.

    - ``uniform``: anywhere between ``inner_radius_m`` and ``radius_m``, any course
    - ``anchorage``: within ``radius_m``, at least ``spacing_m`` apart, anchored, heads to ``axis_deg``, swinging
    - ``lane``: two-way traffic along ``axis_deg``, keeping to starboard, ``length_m`` x ``width_m``
    - ``buoy_channel``: pairs of marks along ``axis_deg``, every ``spacing_m``, ``width_m`` apart

    ``with_ais`` is the share that carries AIS, ``class_b`` the share of these with class B, ``turning`` the share
    that alters course, ``unknown_size`` the share that sends no dimensions.
    """

    layout: str
    count: int
    kind: str = "ship"
    north_m: float = 0.0
    east_m: float = 0.0
    radius_m: float = 10000.0
    inner_radius_m: float = 0.0
    axis_deg: float = 0.0
    length_m: float = 20000.0
    width_m: float = 1000.0
    spacing_m: float = 600.0
    irregularity_m: float = 0.0
    speed_min_mps: float = 2.0
    speed_max_mps: float = 8.0
    hull_min_m: float = 40.0
    hull_max_m: float = 250.0
    with_ais: float = 1.0
    class_b: float = 0.0
    turning: float = 0.0
    unknown_size: float = 0.1

    def __post_init__(self) -> None:
        require(self.layout in LAYOUTS, "TrafficGroup.layout", f"must be one of {', '.join(LAYOUTS)}", self.layout)
        require(self.kind in KINDS, "TrafficGroup.kind", f"must be one of {', '.join(KINDS)}", self.kind)
        check_numbers(
            self, signed=("north_m", "east_m", "axis_deg"), shares=("with_ais", "class_b", "turning", "unknown_size")
        )
        for low, high in (
            ("inner_radius_m", "radius_m"),
            ("speed_min_mps", "speed_max_mps"),
            ("hull_min_m", "hull_max_m"),
        ):
            require(
                getattr(self, low) <= getattr(self, high),
                f"TrafficGroup.{low}",
                f"must be <= {high}",
                getattr(self, low),
            )
        require(self.hull_min_m >= 2.0, "TrafficGroup.hull_min_m", "must be >= 2", self.hull_min_m)
        require(self.spacing_m > 0, "TrafficGroup.spacing_m", "must be > 0", self.spacing_m)


@dataclass(frozen=True, slots=True)
class AisSettings:
    """What the AIS receiver hears.

    ``outages`` "none" or "waigaoqiao" (no update within 2/3/5/15 min for 30/15/10/2 % of the stations).
    ``wrong_count`` stations claim a place between the two offsets away, each its own; ``group_count`` stations are
    shifted alike by ``group_offset_m`` towards ``group_azimuth_deg``. ``clock_offset_s`` is added to the time stamps
    of the receiver's lines (the positions' own UTC second stays right).
    """

    range_m: float = 55000.0
    loss: float = 0.03
    position_age_max_s: float = 1.2
    gnss_bias_sigma_m: float = 4.0
    gnss_noise_sigma_m: float = 1.0
    no_heading: float = 0.1
    outages: str = "none"
    wrong_count: int = 0
    wrong_offset_min_m: float = 300.0
    wrong_offset_max_m: float = 3000.0
    group_count: int = 0
    group_offset_m: float = 1000.0
    group_azimuth_deg: float = 90.0
    clock_offset_s: float = 0.0

    def __post_init__(self) -> None:
        check_numbers(self, signed=("group_azimuth_deg", "clock_offset_s"), shares=("loss", "no_heading"))
        require(
            self.outages in ("none", "waigaoqiao"), "AisSettings.outages", "must be none or waigaoqiao", self.outages
        )
        require(
            0 < self.wrong_offset_min_m <= self.wrong_offset_max_m,
            "AisSettings.wrong_offset_min_m", "must be > 0 and <= wrong_offset_max_m", self.wrong_offset_min_m,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class RadarSettings:
    """What the radar sees and says; noise, turn and range come from the catalogue's ``model``.

    ``steady_share`` of the error variance stays with a target, the rest is drawn anew in each turn. ``detection`` is
    the probability of one echo of a large ship near by. ``acquired`` is the share of objects that are tracked at all.
    ``false_per_turn`` false targets appear in each turn and persist ``false_turns`` on average.
    ``edge_share`` places the echo between the hull's centre (0) and its edge that faces own ship (1).
    ``target_speed`` "true", "relative" or "blank"; ``bearing_reference`` "relative" or "true" (by the gyro).
    """

    model: str = "imo"
    maximum_range_m: float | None = None
    minimum_range_m: float = 200.0
    steady_share: float = 0.5
    range_bias_m: float = 0.0
    bearing_bias_deg: float = 0.0
    clock_offset_s: float = 0.0
    detection: float = 0.95
    acquired: float = 1.0
    maximum_targets: int = 40
    highest_number: int = 99
    range_resolution_m: float = 40.0
    bearing_resolution_deg: float = 2.5
    range_decimals: int = 2
    bearing_decimals: int = 1
    edge_share: float = 0.8
    false_per_turn: float = 0.0
    false_turns: float = 12.0
    acquire_hits: int = 3
    settle_turns: int = 12
    lost_turns: int = 5
    target_speed: str = "true"
    speed_sigma_mps: float = 0.3
    bearing_reference: str = "relative"

    def __post_init__(self) -> None:
        check_numbers(
            self,
            signed=("range_bias_m", "bearing_bias_deg", "clock_offset_s"),
            shares=("steady_share", "detection", "acquired", "edge_share"),
        )
        speeds, references = ("true", "relative", "blank"), ("relative", "true")
        require(
            self.target_speed in speeds, "RadarSettings.target_speed", f"must be one of {speeds}", self.target_speed
        )
        require(
            self.bearing_reference in references,
            "RadarSettings.bearing_reference", f"must be one of {references}", self.bearing_reference,
        )  # fmt: skip
        require(
            1 <= self.highest_number <= 999, "RadarSettings.highest_number", "must be 1 .. 999", self.highest_number
        )
        require(self.acquire_hits >= 1, "RadarSettings.acquire_hits", "must be >= 1", self.acquire_hits)
        require(self.lost_turns >= 1, "RadarSettings.lost_turns", "must be >= 1", self.lost_turns)
        require(self.false_turns >= 1, "RadarSettings.false_turns", "must be >= 1", self.false_turns)


@dataclass(frozen=True, slots=True)
class OwnSensors:
    """What own ship's sensors add to the log: nothing by default.

    ``heading`` "none", "hdt" or "ths"; ``log`` adds VHW; ``gnss`` RMC and GGA; ``own_ais`` own AIVDO reports. A spoofed
    GNSS: ``spoof`` "jump" moves it by ``spoof_offset_m`` at ``spoof_at_s``, "drag_off" lets it run away from then on
    at ``spoof_rate_mps``, both towards ``spoof_azimuth_deg``.
    """

    heading: str = "none"
    heading_bias_deg: float = 0.0
    heading_sigma_deg: float = 0.2
    log: bool = False
    log_scale: float = 1.0
    log_sigma_mps: float = 0.05
    gnss: bool = False
    own_ais: bool = False
    gnss_sigma_m: float = 3.0
    interval_s: float = 1.0
    spoof: str = "none"
    spoof_at_s: float = 60.0
    spoof_offset_m: float = 500.0
    spoof_rate_mps: float = 2.0
    spoof_azimuth_deg: float = 45.0

    def __post_init__(self) -> None:
        check_numbers(self, signed=("heading_bias_deg", "spoof_azimuth_deg"))
        require(self.heading in ("none", "hdt", "ths"), "OwnSensors.heading", "must be none, hdt or ths", self.heading)
        spoofs = ("none", "jump", "drag_off")
        require(self.spoof in spoofs, "OwnSensors.spoof", f"must be one of {spoofs}", self.spoof)
        require(self.interval_s > 0, "OwnSensors.interval_s", "must be > 0", self.interval_s)
