"""What a radar sees of the world in each antenna turn: plots with noise, bias, missed echoes and false targets.

Errors: the sigmas of a catalogue model (IMO MSC.192(79) and finer ones), part of them steady for one target.
Detection: the range at which half of the echoes are seen grows with the square root of the length and follows the
first-detection ranges of IMO MSC.192(79) (10 m craft 3.4 NM, 5000 GT ship 11 NM, buoy with reflector 4.9 NM).
The echo lies on the side of the hull that faces own ship, not at the AIS antenna. Of two echoes within the resolution
only the stronger is seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.catalog import RadarModel
from navfix.simulation.motion import Motion, Pose
from navfix.simulation.settings import RadarSettings
from navfix.simulation.stage import range_and_bearing
from navfix.simulation.world import Body, World, random_stream
from navfix.types import FloatArray, Hull
from navfix.units import NM_M, wrap_180, wrap_360

_HALF_RANGE_OF_10_M = 3.4 * NM_M
_HALF_RANGE_OF_A_BUOY = 4.9 * NM_M
_CLUTTER_DETECTION = 0.85
_CLUTTER = Hull(bow_m=0.0, stern_m=0.0, port_m=0.0, starboard_m=0.0)


@dataclass(frozen=True, slots=True)
class Plot:
    """One echo of one turn. ``key`` is the body's index, below 0 for a false target; times count from the start.

    ``relative_deg`` is the measured bearing from the radar's zero mark; the velocity is the true one over ground, in
    the plane of the stage.
    """

    key: int
    time_s: float
    range_m: float
    relative_deg: float
    north_mps: float
    east_mps: float


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """How one body is seen from own ship at given times: true values, no noise; arrays of one shape.

    ``range_m`` is that of the echo (the hull's near side), ``centre_range_m`` that of the hull's centre.
    """

    time_s: FloatArray
    range_m: FloatArray
    centre_range_m: FloatArray
    relative_deg: FloatArray
    pose: Pose


def view(world: World, body: Body, time_s: FloatArray, edge_share: float) -> View:
    """Return how a body is seen at times [s] from the start."""
    own, pose = world.own.at(time_s), body.motion.at(time_s)
    range_m, bearing_deg = range_and_bearing(
        *world.stage.places(own.north_m, own.east_m), *world.stage.places(pose.north_m, pose.east_m)
    )
    relative_deg = wrap_360(bearing_deg - world.true_deg(own, own.heading_rad))
    line_of_sight = np.arctan2(pose.east_m - own.east_m, pose.north_m - own.north_m)
    edge_m = edge_share * edge_distance_m(body.hull, line_of_sight - pose.heading_rad)
    return View(time_s, np.maximum(range_m - edge_m, 1.0), range_m, relative_deg, pose)


def edge_distance_m(hull: Hull, aspect_rad: FloatArray) -> FloatArray:
    """Return the distance [m] from the hull's centre to its edge towards own ship: an ellipse of length and beam."""
    a, b = hull.length_m / 2.0, hull.beam_m / 2.0
    if a <= 0.0 or b <= 0.0:
        return np.zeros_like(aspect_rad)
    return a * b / np.hypot(b * np.cos(aspect_rad), a * np.sin(aspect_rad))


def half_range_m(body: Body) -> float:
    """Return the range [m] at which half of a body's echoes are seen."""
    if body.kind == "aton":
        return _HALF_RANGE_OF_A_BUOY
    return _HALF_RANGE_OF_10_M * math.sqrt(max(body.hull.length_m, 2.0) / 10.0)


def detection_probability(body: Body, range_m: FloatArray, settings: RadarSettings) -> FloatArray:
    """Return the probability that one turn shows an echo: falls with the fourth power of range over half range."""
    usable = (range_m >= settings.minimum_range_m) & (range_m <= (settings.maximum_range_m or math.inf))
    return usable * settings.detection / (1.0 + (np.asarray(range_m) / half_range_m(body)) ** 4)


@dataclass(frozen=True, slots=True, eq=False)
class _Antenna:
    """The radar of one recording: what turns, from when, and how well it measures."""

    world: World
    settings: RadarSettings
    model: RadarModel
    starts_s: FloatArray

    def sweep(
        self,
        plots: list[list[Plot]],
        body: Body,
        key: int,
        rng: np.random.Generator,
        window: tuple[int, int] | None = None,
    ) -> None:
        """Add the plots of one body; ``window`` limits a false target to some turns, with its own detection."""
        share, count = self.settings.edge_share, len(self.starts_s)
        first_look = view(self.world, body, self.starts_s, share)
        passed_s = self.starts_s + self.model.turn_s * first_look.relative_deg / 360.0
        seen = view(self.world, body, passed_s, share)
        range_m, relative_deg = measure(seen, self.settings, self.model, rng)
        probability = detection_probability(body, seen.range_m, self.settings)
        if window is not None:
            alive = (np.arange(count) >= window[0]) & (np.arange(count) <= window[1])
            probability = np.where(alive & (probability > 0.0), _CLUTTER_DETECTION, 0.0)
        for turn in np.flatnonzero(rng.random(count) < probability):
            polar = float(range_m[turn]), float(relative_deg[turn])
            velocity = float(seen.pose.north_mps[turn]), float(seen.pose.east_mps[turn])
            plots[turn].append(Plot(key, float(seen.time_s[turn]), *polar, *velocity))


def turns(
    world: World, settings: RadarSettings, model: RadarModel, duration_s: float, seed: int
) -> tuple[list[list[Plot]], list[tuple[int, int]]]:
    """Return the plots of each antenna turn in the order of the sweep, and each false target's (first, last) turn."""
    rng = random_stream(seed, "radar")
    starts_s = np.arange(int(duration_s / model.turn_s), dtype=np.float64) * model.turn_s
    antenna = _Antenna(world, settings, model, starts_s)
    tracked = rng.random(len(world.bodies)) < settings.acquired
    plots: list[list[Plot]] = [[] for _ in starts_s]
    for key, body in enumerate(world.bodies):
        own_rng = np.random.default_rng(rng.integers(2**63, size=2))
        if body.echoes and tracked[key]:
            antenna.sweep(plots, body, key, own_rng)
    windows = _add_clutter(antenna, plots, rng)
    sizes = {key: body.hull.length_m for key, body in enumerate(world.bodies)}
    return [_resolved(turn, settings, sizes) for turn in plots], windows


def measure(
    seen: View, settings: RadarSettings, model: RadarModel, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return measured ranges [m] and relative bearings [deg]: steady and fresh noise of the model, and the biases."""
    steady, fresh = rng.normal(0.0, 1.0, 2), rng.normal(0.0, 1.0, (2, len(seen.time_s)))
    noise = math.sqrt(settings.steady_share) * steady[:, None] + math.sqrt(1.0 - settings.steady_share) * fresh
    range_m = seen.range_m + settings.range_bias_m + model.sigma_of_range_m(seen.range_m) * noise[0]
    bearing_deg = seen.relative_deg + settings.bearing_bias_deg + model.bearing_sigma_deg * noise[1]
    return np.maximum(range_m, 1.0), wrap_360(bearing_deg)


def _add_clutter(antenna: _Antenna, plots: list[list[Plot]], rng: np.random.Generator) -> list[tuple[int, int]]:
    """Add false targets, more of them near by: each drifts a little and persists for some turns."""
    windows: list[tuple[int, int]] = []
    settings = antenna.settings
    for turn, time_s in enumerate(antenna.starts_s):
        for _ in range(int(rng.poisson(settings.false_per_turn))):
            body = Body(0, "CLUTTER", "ship", _clutter_motion(antenna, float(time_s), rng), _CLUTTER)
            windows.append((turn, turn + int(rng.geometric(1.0 / settings.false_turns)) - 1))
            antenna.sweep(plots, body, -len(windows), rng, windows[-1])
    return windows


def _clutter_motion(antenna: _Antenna, time_s: float, rng: np.random.Generator) -> Motion:
    """Return a slow motion that passes a place near own ship at a time [s]; ranges are exponential."""
    own, settings = antenna.world.own.at(time_s), antenna.settings
    reach_m = (settings.maximum_range_m or antenna.model.maximum_range_m) / 3.0
    range_m, angle = settings.minimum_range_m + rng.exponential(reach_m), rng.uniform(0.0, 2.0 * math.pi)
    speed_mps, course = abs(rng.normal(0.0, 1.0)), rng.uniform(0.0, 2.0 * math.pi)
    run_m = speed_mps * time_s
    return Motion(
        float(own.north_m + range_m * math.cos(angle) - run_m * math.cos(course)),
        float(own.east_m + range_m * math.sin(angle) - run_m * math.sin(course)),
        course_rad=float(course),
        speed_mps=float(speed_mps),
    )


def _resolved(turn: list[Plot], settings: RadarSettings, sizes: dict[int, float]) -> list[Plot]:
    """Return the plots of a turn without those that merge with a stronger one (larger first, then nearer)."""
    kept: list[Plot] = []
    for plot in sorted(turn, key=lambda p: (-sizes.get(p.key, 0.0), p.range_m)):
        if not any(
            abs(plot.range_m - other.range_m) < settings.range_resolution_m
            and abs(wrap_180(plot.relative_deg - other.relative_deg)) < settings.bearing_resolution_deg
            for other in kept
        ):
            kept.append(plot)
    return sorted(kept, key=lambda p: p.time_s)
