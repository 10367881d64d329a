"""Simulated raw plots with their truth, and how well the tracks of a tracker keep to it."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from navfix.nmea.plots import RadarPlot
from navfix.nmea.records import TargetReport
from navfix.simulation import radar
from navfix.simulation.scenario import Scenario, from_text
from navfix.units import wrap_180

SCENE = """
    title = "plots"
    source = "test"
    start_utc = 2026-03-01T09:00:00Z
    duration_s = 200.0
    lat_deg = 60.0
    lon_deg = 10.0
    [own]
    speed_mps = 5.0
    course_deg = 80.0
    yaw_deg = 3.0
    yaw_period_s = 15.0
    turn_at_s = 80.0
    turn_deg = 140.0
    turn_rate_deg_per_min = 120.0
    [[traffic]]
    layout = "uniform"
    count = 20
    radius_m = 9000.0
    inner_radius_m = 1000.0
    turning = 0.3
    speed_max_mps = 9.0
    [radar]
    model = "imo"
    detection = {detection}
    edge_share = 0.5
    false_per_turn = {clutter}
    false_turns = 1.0
    maximum_range_m = 11000.0
    """


@dataclass(frozen=True, slots=True, eq=False)
class PlotScene:
    """Plots by time, the same turn by turn with the bodies' keys, and the scenario with its seed."""

    scenario: Scenario
    seed: int
    plots: tuple[RadarPlot, ...]
    keys: tuple[tuple[float, int], ...]


def plot_scene(*, detection: float = 0.9, clutter: float = 10.0, seed: int = 1, text: str = SCENE) -> PlotScene:
    """Return plots of a simulated radar: own ship turns through 140 deg, ``clutter`` one-turn echoes in each turn."""
    scenario = from_text(text.format(detection=detection, clutter=clutter))
    world, model = scenario.world(seed), scenario.radar_model()
    settings = replace(scenario.radar, maximum_range_m=scenario.radar.maximum_range_m or model.maximum_range_m)
    turns, _ = radar.turns(world, settings, model, scenario.duration_s, seed)
    found = [plot for turn in turns for plot in turn]
    plots = tuple(RadarPlot(world.start_s + p.time_s, p.range_m, p.relative_deg) for p in found)
    return PlotScene(scenario, seed, plots, tuple((world.start_s + p.time_s, p.key) for p in found))


@dataclass(frozen=True, slots=True)
class TrackingFigures:
    """Shares of reports: on a body at all, on the track's main body; tracks per body; turns of a body with a report.

    ``range_rmse_m`` and ``bearing_rmse_deg`` are those of the reports against the truth, ``plot_...`` of the plots.
    """

    true_share: float
    purity: float
    tracks_per_body: float
    coverage: float
    false_tracks: int
    range_rmse_m: float
    bearing_rmse_deg: float
    plot_range_rmse_m: float
    plot_bearing_rmse_deg: float


def figures(scene: PlotScene, reports: Sequence[TargetReport], *, settled_s: float = 20.0) -> TrackingFigures:
    """Return how well reports keep to the bodies of a scene."""
    world, model = scene.scenario.world(scene.seed), scene.scenario.radar_model()
    start_s = min(plot.time_s for plot in scene.plots)
    settled = [r for r in reports if (r.time_s or 0.0) > start_s + settled_s]
    times = np.array([r.time_s for r in settled]) - world.start_s
    seen = [radar.view(world, body, times, scene.scenario.radar.edge_share) for body in world.bodies]
    range_error = np.array([[r.range_m for r in settled] - view.range_m for view in seen])
    bearing_error = np.array([wrap_180([r.bearing_deg for r in settled] - view.relative_deg) for view in seen])
    across = np.radians(bearing_error) * np.array([view.range_m for view in seen])
    off_m = np.hypot(range_error, across)
    body = np.argmin(off_m, axis=0)
    columns = np.arange(len(settled))
    allowed_m = np.hypot(80.0, np.radians(3.0) * np.array([r.range_m for r in settled]))
    on_body = off_m[body, columns] <= allowed_m
    of_track: dict[int, Counter[int]] = defaultdict(Counter)
    for report, key, true in zip(settled, body, on_body, strict=True):
        of_track[report.number][int(key) if true else -1] += 1
    main = {number: counts.most_common(1)[0] for number, counts in of_track.items()}
    # A body counts where its echo came back in most of the turns.
    plots_of = Counter(key for time_s, key in scene.keys if key >= 0 and time_s > start_s + settled_s)
    turns = (scene.scenario.duration_s - settled_s) / model.turn_s
    steady = {key for key, count in plots_of.items() if count > 0.6 * turns}
    tracks_of = Counter(key for key, _ in main.values() if key in steady)
    reports_of = Counter(int(key) for key, true in zip(body, on_body, strict=True) if true)
    true = np.flatnonzero(on_body)
    rms = {name: float(np.sqrt(np.mean(e[body[true], true] ** 2))) for name, e in
           (("range", range_error), ("bearing", bearing_error))}  # fmt: skip
    noise = model.range_sigma_m, model.bearing_sigma_deg
    return TrackingFigures(
        true_share=float(np.mean(on_body)),
        purity=sum(count for _, count in main.values()) / max(len(settled), 1),
        tracks_per_body=float(np.mean([tracks_of[key] for key in steady])),
        coverage=float(np.mean([min(1.0, reports_of[key] / plots_of[key]) for key in steady])),
        false_tracks=sum(key < 0 for key, _ in main.values()),
        range_rmse_m=rms["range"],
        bearing_rmse_deg=rms["bearing"],
        plot_range_rmse_m=noise[0],
        plot_bearing_rmse_deg=noise[1],
    )
