"""The default motion model on ships that its constants were not chosen with, beside plain constant velocity.

Ships are halved at random. On one half the constants of the persisting motion are chosen, one after the other from a
few values each; the other half is predicted with them, and the other way round.

Run: python tests/benchmarks/bench_motion_halves.py
"""

from __future__ import annotations

import math
import sys
import zlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix.catalog import PersistingModel, persisting_model
from navfix.picture.motion import history
from navfix.picture.motion.constant_velocity import straight
from navfix.picture.motion.persisting import faded
from navfix.picture.motion.steering import Steering, steering
from tests.benchmarks.bench_motion import Sample, samples
from tests.benchmarks.motion_data import real_tracks

AGES_S = (10, 60, 180)
MOST = 1500  # samples of a half and age
VALUES = {
    "turn_persist_s": (0.1, 15.0, 30.0, 60.0),
    "reported_turn_share": (0.0, 0.5, 1.0),
    "turn_memory_s": (5.0, 10.0, 30.0),
    "speed_persist_s": (0.1, 20.0, 40.0, 80.0),
    "way_persist_s": (1500.0, 3000.0, 1e9),
    "lag_s": (0.0, 1.0, 2.0),
}
Step = Callable[[PersistingModel, Steering, float], tuple[float, float]]


def by_constant_velocity(_: PersistingModel, steers: Steering, age_s: float) -> tuple[float, float]:
    """Return the step of constant speed and course."""
    return straight(steers, age_s)


def errors_m(chosen: Sequence[Sample], constants: PersistingModel, step: Step) -> np.ndarray:
    """Return how far each report lies from where it was predicted."""
    found = []
    for sample in chosen:
        steers = steering(sample.past, constants)
        assert steers is not None, "moving samples tell speed and course"
        north_m, east_m = step(constants, steers, sample.left_out.time_s - float(sample.past.time_s[0]))
        origin = replace(
            sample.left_out, time_s=-1.0, lat_deg=sample.past.origin.lat_deg, lon_deg=sample.past.origin.lon_deg
        )
        there = history([replace(sample.left_out, time_s=0.0), origin])
        found.append(math.hypot(there.north_m[1] + north_m, there.east_m[1] + east_m))
    return np.array(found)


def loss(chosen: Sequence[Sample], constants: PersistingModel) -> float:
    """Return the mean over ages of the logarithms of median and 95 % quantile."""
    error, age = errors_m(chosen, constants, faded), np.array([s.age_s for s in chosen])
    return float(np.mean([np.log(np.percentile(error[age == a], [50, 95])).mean() for a in AGES_S]))


def chosen_constants(used: Sequence[Sample]) -> PersistingModel:
    """Return constants chosen on a half, from a start that knows nothing: no turn, no change of speed goes on."""
    best = replace(
        persisting_model(),
        turn_persist_s=0.1,
        reported_turn_share=0.0,
        speed_persist_s=0.1,
        way_persist_s=1e9,
        lag_s=0.0,
    )
    lowest = loss(used, best)
    for key, values in VALUES.items():
        for value in values:
            tried = replace(best, **{key: value})
            found = loss(used, tried)
            if found < lowest:
                best, lowest = tried, found
    return best


def halves(chosen: Sequence[Sample], seed: int = 1) -> tuple[list[Sample], list[Sample]]:
    """Return the samples of a random half of the ships, and of the others, at most `MOST` an age."""
    rng = np.random.default_rng(seed)
    ships = np.array([zlib.crc32(f"{s.log} {s.station}".encode()) for s in chosen])
    one = np.isin(ships, rng.permutation(np.unique(ships))[: len(np.unique(ships)) // 2])
    age = np.array([s.age_s for s in chosen])
    made = []
    for mine in (one, ~one):
        rows = [i for a in AGES_S for i in rng.permutation(np.flatnonzero(mine & (age == a)))[:MOST]]
        made.append([chosen[i] for i in rows])
    return made[0], made[1]


def report(chosen: Sequence[Sample]) -> str:
    """Return what was chosen on each half, and the errors on the other one, as Markdown."""
    one, two = halves([s for s in chosen if s.age_s in AGES_S])
    found: dict[str, list[np.ndarray]] = {"constant_velocity": [], "chosen on the other half": [], "as shipped": []}
    lines = []
    for used, other in ((one, two), (two, one)):
        constants = chosen_constants(used)
        lines.append("- " + ", ".join(f"{key} {getattr(constants, key):g}" for key in VALUES))
        found["constant_velocity"].append(errors_m(other, constants, by_constant_velocity))
        found["chosen on the other half"].append(errors_m(other, constants, faded))
        found["as shipped"].append(errors_m(other, persisting_model(), faded))
    age = np.array([s.age_s for s in [*two, *one]])
    lines += ["", "| model | " + " | ".join(f"{a} s" for a in AGES_S) + " |", "|---|" + "---|" * len(AGES_S)]
    for name, parts in found.items():
        error = np.concatenate(parts)
        cells = ["{:.1f} / {:.0f}".format(*np.percentile(error[age == a], [50, 95])) for a in AGES_S]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Print the report."""
    tracks = real_tracks()
    print(report(samples(tracks)) if tracks else "shared data absent")


if __name__ == "__main__":
    main()
