"""The source's track (180 periods of 10 s) through the unscented and the extended filter: RMSE over 50 runs.

The paper prints R = diag(0.1^2, 0.1^2) and plots only; its unit is open. Taken as degrees it is 11 km, so three
readings are run: 10 m (GNSS), 0.1 arc minutes, 0.1 degrees. Distance and bearing are those of the ship from a place
10 km south of the start; "place" is the distance between estimate and truth. The filter starts as printed: 10 m/s,
course 0, the truth being 45 deg. Q as printed, and the process noise of models/motion/turn_filter.toml.

Run: python tests/benchmarks/bench_source_track.py [runs]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix.catalog import FilterModel, filter_model
from navfix.geodesy import cloud_to_plane
from navfix.picture.motion import ekf, ukf
from navfix.picture.motion.geodetic_turn import LAT, LON, SPEED, metres_per_degree
from navfix.picture.motion.turn_filter import Predict, Report, State, corrected
from navfix.simulation.manoeuvres import SOURCE_LEGS, SOURCE_START, Run, run
from navfix.types import Position

PERIOD_S = 10.0
OBSERVER = Position(39.91, 100.0)
READINGS = {"10 m": 10.0, "0.1 arc minutes": 185.0, "0.1 deg": 11100.0}
FILTERS: dict[str, Predict] = {"unscented": ukf.predict, "extended": ekf.predict}


def ours(constants: FilterModel) -> FilterModel:
    """Return the process noise of the catalogue."""
    return constants


def as_printed(constants: FilterModel) -> FilterModel:
    """Return Q = diag(1e-6, 1e-6, 100, 1, 1) a period [deg^2, (m/s)^2, rad^2, (rad/s)^2] as walks."""
    lat_m, _ = (float(m) for m in metres_per_degree(SOURCE_START.lat_deg))
    root = PERIOD_S**0.5
    return replace(
        constants,
        position_walk_m=1e-3 * lat_m / root,
        speed_walk_mps=10.0 / root,
        course_walk_rad=1.0 / root,
        turn_walk_rad_s=1.0 / root,
        turn_persist_s=1e12,
    )


def filtered(
    truth: Run, sigma_m: float, predict: Predict, constants: FilterModel, rng: np.random.Generator
) -> np.ndarray:
    """Return the filter's states (n, 5) from noisy positions alone."""
    lat_m, lon_m = (float(m) for m in metres_per_degree(SOURCE_START.lat_deg))
    sigma_deg = np.array([sigma_m / lon_m, sigma_m / lat_m])
    R = np.diag(sigma_deg**2)
    start = np.array([SOURCE_START.lon_deg, SOURCE_START.lat_deg, 10.0, 0.0, 0.0])
    state = State(0.0, start, np.diag([*sigma_deg**2, 25.0, 1.0, 0.01**2]))
    states = [state.mean]
    for k in range(1, len(truth.time_s)):
        state = predict(state, float(truth.time_s[k]), constants)
        value = np.array([truth.lon_deg[k], truth.lat_deg[k]]) + sigma_deg * rng.normal(size=2)
        state = corrected(state, Report(state.time_s, (LON, LAT), value, R))
        states.append(state.mean)
    return np.array(states)


def squared_errors(truth: Run, states: np.ndarray) -> np.ndarray:
    """Return squared errors (n, 4): distance [m], bearing [deg], speed [m/s], place [m]."""
    real = cloud_to_plane(OBSERVER, truth.lat_deg, truth.lon_deg)
    found = cloud_to_plane(OBSERVER, states[:, LAT], states[:, LON])
    distance = np.hypot(*found.T) - np.hypot(*real.T)
    bearing = np.degrees(np.arctan2(found[:, 1], found[:, 0]) - np.arctan2(real[:, 1], real[:, 0]))
    bearing = (bearing + 180.0) % 360.0 - 180.0
    speed = states[:, SPEED] - truth.speed_mps
    return np.column_stack([distance, bearing, speed, np.hypot(*(found - real).T)]) ** 2


def rmse(
    truth: Run, sigma_m: float, predict: Predict, noise: Callable[[FilterModel], FilterModel], runs: int
) -> np.ndarray:
    """Return the RMSE of distance, bearing, speed and place over all runs and periods after the first ten."""
    constants, rng = noise(filter_model()), np.random.default_rng(3)
    squares = [squared_errors(truth, filtered(truth, sigma_m, predict, constants, rng))[10:] for _ in range(runs)]
    return np.sqrt(np.mean(squares, axis=(0, 1)))


def main(runs: int = 50) -> None:
    """Print one line a case."""
    truth = run(SOURCE_LEGS, period_s=PERIOD_S)
    print("speeds m/s at periods 0, 45, 60, 120, 180:", truth.speed_mps[[0, 45, 60, 120, 180]].round(6).tolist())
    print(f"RMSE over {runs} runs: distance m, bearing deg, speed m/s, place m (raw: place of one observation)")
    for reading, sigma_m in READINGS.items():
        for noise in (ours, as_printed):
            for name, predict in FILTERS.items():
                distance, bearing, speed, place = rmse(truth, sigma_m, predict, noise, runs)
                print(
                    f"  R {reading:16} Q {noise.__name__:10} {name:10} {distance:9.1f} {bearing:7.3f} {speed:8.2f} "
                    f"{place:9.1f}  (raw {sigma_m * 2.0**0.5:.0f})",
                    flush=True,
                )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
