"""Recordings for the studies over time: measured, simulated ports, the radar of one place with the AIS of another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from navfix.nmea import read_log
from navfix.nmea.records import AisPosition, AisStatic, OwnHeading, Record, TargetReport
from navfix.picture import epochs
from navfix.report.truth import TruthTrack
from navfix.simulation import scenario
from navfix.simulation.files import truth_csv
from navfix.types import Epoch

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
MEASURED = (
    "marce/marce_01_004", "marce/marce_01_010", "marce/marce_01_001", "semi_real/dense_sf",
    "semi_real/coastal_hakefjord", "semi_real/moored_harlingen_atons",
)  # fmt: skip
AIS_ALONE = ("ais_logs/hakan.txt", "ais_logs/PacCupStart.txt")


@dataclass(frozen=True, eq=False)
class Run:
    """A recording: its records in the order of reception and, where there is one, own ship's true track."""

    name: str
    records: tuple[Record, ...]
    truth: TruthTrack | None = None

    @property
    def first_s(self) -> float:
        """When its radar begins [POSIX s]."""
        return next(r.time_s for r in self.records if isinstance(r, TargetReport) and r.time_s is not None)

    def epochs(self) -> list[Epoch]:
        """Return an epoch for each radar scan."""
        return list(epochs(self.records))


def measured(name: str) -> Run:
    """Return a recording of the shared data by its path without suffix."""
    with (SHARED / f"{name}_truth.csv").open() as lines:
        track = TruthTrack.parse(lines)
    return Run(Path(name).name, tuple(read_log(SHARED / f"{name}.nmea", report=False).records), track)


def ais_alone(name: str) -> Run:
    """Return the AIS of a log without radar."""
    return Run(Path(name).stem, tuple(read_log(SHARED / name, report=False).records))


def port(
    seed: int, *, ais_share: float = 0.3, targets: int = 24, duration_s: float = 1200.0, sensors: bool = False
) -> Run:
    """Return a simulated port: quays, an anchorage, a lane, small craft; ``ais_share`` of the echoes have a partner.

    With ``sensors`` own ship has a gyro and a log.
    """
    rng = np.random.default_rng(seed)
    common = max(3, round(ais_share * targets))
    quay = float(rng.uniform(0.0, 360.0))
    content = {
        "title": "A port",
        "source": "made up",
        "start_utc": datetime(2026, 5, 1, 12, tzinfo=UTC),
        "duration_s": duration_s,
        "lat_deg": float(rng.uniform(-50.0, 60.0)),
        "lon_deg": float(rng.uniform(-170.0, 170.0)),
        "own": {
            "speed_mps": float(rng.uniform(0.0, 6.0)),
            "course_deg": float(rng.uniform(0.0, 360.0)),
            "turn_at_s": 0.4 * duration_s,
            "turn_deg": float(rng.uniform(-60.0, 60.0)),
            "yaw_deg": 2.0,
        },
        "traffic": [*_with_ais(targets, common, quay), *_without_ais(targets - common, quay, rng)],
        "radar": {
            "maximum_range_m": 9260.0,
            "acquired": 0.7,
            "detection": 0.85,
            "bearing_bias_deg": -3.0,
            "clock_offset_s": float(rng.uniform(-4.0, 2.0)),
            "target_speed": "blank",
            "false_per_turn": 0.05,
        },
    }
    if sensors:
        content["sensors"] = {"heading": "hdt", "heading_bias_deg": float(rng.normal()), "log": True}
    recording = scenario.simulate(scenario.from_table(content, name=f"port{seed}"), seed)
    track = TruthTrack.parse(truth_csv(recording).splitlines())
    return Run(f"port{seed}_{ais_share:g}", tuple(read_log(list(recording.lines), report=False).records), track)


def with_gyro(run: Run, error_deg: float, seed: int = 0) -> Run:
    """Return the run with a gyro that is ``error_deg`` off all the time, a heading a second; it needs a true track."""
    if run.truth is None:
        return run
    rng = np.random.default_rng(seed)
    headings = []
    for time_s in np.arange(run.truth.times_s[0], run.truth.times_s[-1], 1.0):
        there = run.truth.at(float(time_s))
        if there is not None and there.heading_deg is not None:
            heading_deg = (there.heading_deg + error_deg + 0.2 * float(rng.normal())) % 360.0
            headings.append(OwnHeading(float(time_s), heading_deg, "true", "HDT"))
    others = (r for r in run.records if not isinstance(r, OwnHeading) and r.time_s is not None)
    records = sorted([*headings, *others], key=lambda r: r.time_s or 0.0)
    return Run(run.name, tuple(records), run.truth)


def gyro_error_deg(gyro: str, seed: int) -> float:
    """Return the constant error of a gyro: a degree of a "right" one; of a "wrong" one 90 deg or anything above 10."""
    rng = np.random.default_rng(9000 + seed)
    if gyro == "right":
        return float(rng.normal())
    return (90.0, -90.0)[seed // 2 % 2] if seed % 2 else float(rng.uniform(10.0, 350.0))


def _with_ais(targets: int, common: int, quay_deg: float) -> list[dict[str, Any]]:
    """Return the ships with AIS: those in radar range, and as many again that radar does not see."""
    anchored = max(round(0.4 * common), 1)
    far = {"count": round(0.8 * targets), "radius_m": 7000.0, "north_m": 9000.0, "east_m": -12000.0}
    return [
        {"layout": "anchorage", "count": anchored, "radius_m": 4500.0, "spacing_m": 400.0, "axis_deg": quay_deg},
        {"layout": "lane", "count": max(common - anchored, 1), "axis_deg": quay_deg + 60.0, "length_m": 16000.0},
        {"layout": "uniform", "count": round(0.8 * targets), "radius_m": 40000.0, "inner_radius_m": 9000.0},
        {"layout": "anchorage", "spacing_m": 400.0, **far},
    ]


def _without_ais(count: int, quay_deg: float, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Return what radar sees and AIS does not tell: small craft that move, and a mooring."""
    craft = {"radius_m": 7000.0, "inner_radius_m": 600.0, "speed_min_mps": 0.0, "speed_max_mps": 5.0, "turning": 0.5}
    place = {"north_m": float(rng.uniform(-3000, 3000)), "east_m": float(rng.uniform(-3000, 3000)), "radius_m": 2500.0}
    hulls = {"with_ais": 0.0, "hull_min_m": 8.0, "hull_max_m": 60.0}
    return [
        {"layout": "uniform", "count": count // 3, **craft, **hulls},
        {
            "layout": "anchorage",
            "count": count - count // 3,
            "spacing_m": 150.0,
            "axis_deg": quay_deg,
            **place,
            **hulls,
        },
    ]


def foreign(radar: Run, ais: Run, *, skip_s: float = 0.0) -> Run:
    """Return the radar of one place with the AIS of another: nothing in it is right.

    The AIS is moved in time by whole minutes, so that the second in its messages still fits.
    """
    seen = [r for r in radar.records if not isinstance(r, AisPosition | AisStatic) and r.time_s is not None]
    heard = [r for r in ais.records if isinstance(r, AisPosition | AisStatic) and r.time_s is not None and not r.own]
    seen = [r for r in seen if r.time_s >= seen[0].time_s + skip_s]
    shift_s = 60.0 * round((seen[0].time_s - heard[0].time_s) / 60.0 - 0.5)
    moved = [replace(r, time_s=r.time_s + shift_s) for r in heard]
    last_s = moved[-1].time_s
    records = sorted([*moved, *(r for r in seen if r.time_s <= last_s)], key=lambda r: r.time_s)
    return Run(f"{radar.name}+{ais.name}", tuple(records))
