"""Scenarios: TOML in, a recording out - the log's lines, own ship's truth, and which target is which ship."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from navfix import catalog
from navfix.errors import CatalogError, InputError
from navfix.nmea import write
from navfix.nmea.records import AisStatic
from navfix.simulation import ais, radar, sensors, tracker
from navfix.simulation.settings import AisSettings, OwnSensors, OwnShip, RadarSettings, TrafficGroup
from navfix.simulation.world import World, make_world, random_stream
from navfix.types import Position
from navfix.types.checks import require

MAXIMUM_DURATION_S = 86400.0
_TRUTH_INTERVAL_S = 1.0


@dataclass(frozen=True, slots=True)
class Scenario:
    """A world to simulate; ``origin`` is the place that everything counts from, ``start_utc`` aware UTC."""

    name: str
    title: str
    source: str
    start_utc: datetime
    duration_s: float
    origin: Position
    own: OwnShip
    traffic: tuple[TrafficGroup, ...]
    ais: AisSettings = field(default_factory=AisSettings)
    radar: RadarSettings = field(default_factory=RadarSettings)
    sensors: OwnSensors = field(default_factory=OwnSensors)

    def __post_init__(self) -> None:
        duration = self.duration_s
        require(0 < duration <= MAXIMUM_DURATION_S, "duration_s", f"must be > 0 and <= {MAXIMUM_DURATION_S}", duration)
        require(self.start_utc.tzinfo is not None, "start_utc", "must carry a time zone (UTC)", self.start_utc)
        require(abs(self.origin.lat_deg) <= 88.0, "lat_deg", "must be within -88 .. 88", self.origin.lat_deg)

    def world(self, seed: int) -> World:
        """Return the world that `simulate` uses for this seed."""
        start_s = self.start_utc.timestamp()
        return make_world(self.origin, start_s, self.duration_s, self.own, self.traffic, seed)

    def radar_model(self) -> catalog.RadarModel:
        """Return the radar's model of the catalogue.

        Raises
        ------
        CatalogError : unknown model
        """
        return catalog.radar_model(self.radar.model)


@dataclass(frozen=True, slots=True)
class TruthRow:
    """Own ship at one instant; ``radar_zero_deg`` is where the radar's zero mark points (heading less bearing bias)."""

    unix_s: float
    lat_deg: float
    lon_deg: float
    heading_deg: float
    speed_mps: float
    course_deg: float
    radar_zero_deg: float


@dataclass(frozen=True, slots=True)
class AssociationRow:
    """One TTM: the radar's time stamp, the target number, and the MMSI of what it is (0: no AIS, or nothing)."""

    unix_s: float
    target_number: int
    mmsi: int


@dataclass(frozen=True, slots=True)
class Recording:
    """What a simulation gives. ``lines`` stand in the order of their time stamps, each with its TAG block.

    ``wrong`` holds the stations that claim a wrong place: MMSI -> (north, east) offset [m].
    """

    scenario: Scenario
    seed: int
    lines: tuple[str, ...]
    truth: tuple[TruthRow, ...]
    association: tuple[AssociationRow, ...]
    wrong: dict[int, tuple[float, float]]


# ------------------------------------------------------------------------------------------------- reading


def names() -> list[str]:
    """Return the names of the shipped scenarios."""
    return sorted(path.stem for path in _folder().glob("*.toml"))


def load(name_or_path: str | Path) -> Scenario:
    """Return a shipped scenario by its name, or the one of a TOML file.

    Raises
    ------
    CatalogError : unknown name; not a TOML file; an unknown or missing key, a table where none belongs
    InputError : a value that cannot be right
    """
    path = Path(name_or_path)
    if str(name_or_path) in names():
        path = _folder() / f"{name_or_path}.toml"
    elif path.suffix != ".toml":
        raise CatalogError(
            f"no scenario named {str(name_or_path)!r}; there are {', '.join(names())}", key=str(name_or_path)
        )
    return from_table(catalog.read_table(path), name=path.stem)


def from_text(text: str, *, name: str = "scenario") -> Scenario:
    """Return the scenario of a TOML text; raises like `load`."""
    try:
        return from_table(tomllib.loads(text), name=name)
    except tomllib.TOMLDecodeError as error:
        raise CatalogError(f"{name}: not a readable TOML text: {error}", path=name) from error


def from_table(content: dict[str, Any], *, name: str) -> Scenario:
    """Return the scenario of a parsed TOML table; raises like `load`."""
    where = f"scenario {name}"
    flat = dict(content)
    try:
        flat["origin"] = Position(flat.pop("lat_deg"), flat.pop("lon_deg"))
    except KeyError as error:
        raise CatalogError(f"{where}: missing key {error.args[0]!r}", path=name, key=str(error.args[0])) from error
    except TypeError as error:
        raise InputError(f"{where}: lat_deg and lon_deg must be numbers", source=name) from error
    require(
        isinstance(flat.get("start_utc"), datetime), f"{where}: start_utc", "must be a TOML time", flat.get("start_utc")
    )
    for key, record in (("own", OwnShip), ("ais", AisSettings), ("radar", RadarSettings), ("sensors", OwnSensors)):
        if key in flat:
            flat[key] = catalog.build(record, _table(flat[key], f"{where}: [{key}]"), where=f"{where}: [{key}]")
    groups = flat.get("traffic", [])
    require(isinstance(groups, list), f"{where}: traffic", "must be given as [[traffic]] tables", groups)
    flat["traffic"] = tuple(
        catalog.build(TrafficGroup, _table(group, f"{where}: [[traffic]]"), where=f"{where}: [[traffic]] {number}")
        for number, group in enumerate(groups, start=1)
    )
    return catalog.build(Scenario, {"name": name, **flat}, where=where)


def _folder() -> Path:
    return catalog.data_folder("data") / "scenarios"


def _table(value: object, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise CatalogError(f"{where} must be a table, got {value!r}", key=where)
    return value


# ------------------------------------------------------------------------------------------------- simulating


def simulate(scenario: Scenario, seed: int, *, duration_s: float | None = None) -> Recording:
    """Return the recording of a scenario; the same scenario, duration and seed give the same bytes.

    Raises
    ------
    CatalogError : an unknown radar model; InputError : a seed below 0, a duration that cannot be right
    """
    if duration_s is not None:
        scenario = replace(scenario, duration_s=duration_s)
    world, model = scenario.world(seed), scenario.radar_model()
    settings = replace(scenario.radar, maximum_range_m=scenario.radar.maximum_range_m or model.maximum_range_m)
    messages, wrong = ais.receive(world, scenario.ais, scenario.duration_s, settings.maximum_range_m or 0.0, seed)
    plots, _ = radar.turns(world, settings, model, scenario.duration_s, seed)
    targets = tracker.follow(
        world,
        settings,
        model,
        plots,
        gyro_bias_deg=scenario.sensors.heading_bias_deg,
        rng=random_stream(seed, "tracker"),
    )
    stamped = [
        *_ais_lines(messages, scenario.ais.clock_offset_s),
        *((report.time_s or 0.0, "RA0001", write.ttm(report)) for report, _ in targets),
        *((time_s, "II0001", text) for time_s, text in _own_lines(world, scenario, seed)),
    ]
    stamped.sort(key=lambda line: line[0])
    return Recording(
        scenario=scenario,
        seed=seed,
        lines=tuple(write.tag_block(time_s, source) + text for time_s, source, text in stamped),
        truth=tuple(_truth(world, scenario)),
        association=tuple(AssociationRow(report.time_s or 0.0, report.number, mmsi) for report, mmsi in targets),
        wrong=wrong,
    )


def _ais_lines(messages: list[ais.AisMessage], clock_offset_s: float) -> Iterator[tuple[float, str, str]]:
    """Yield the AIVDM lines: channels in turn, parts of one message tied by a running number."""
    multipart = count()
    for index, message in enumerate(messages):
        is_static = isinstance(message.record, AisStatic)
        sequence = next(multipart) % 10 if is_static else 0
        for text in ais.sentences(message, channel="AB"[index % 2], sequence=sequence):  # type: ignore[arg-type]
            yield message.time_s + clock_offset_s, "AI0001", text


def _own_lines(world: World, scenario: Scenario, seed: int) -> list[tuple[float, str]]:
    return sensors.own_sentences(world, scenario.sensors, scenario.duration_s, scenario.own.mmsi, seed)


def _truth(world: World, scenario: Scenario) -> Iterator[TruthRow]:
    times = np.arange(0.0, scenario.duration_s + 0.5 * _TRUTH_INTERVAL_S, _TRUTH_INTERVAL_S)
    own = world.own.at(times)
    lat, lon = world.stage.places(own.north_m, own.east_m)
    heading, course = world.true_deg(own, own.heading_rad), world.true_deg(own, own.course_rad)
    zero = (heading - scenario.radar.bearing_bias_deg) % 360.0
    for row in zip(times + world.start_s, lat, lon, heading, own.speed_mps, course, zero, strict=True):
        yield TruthRow(*map(float, row))
