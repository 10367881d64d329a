"""Position error against report age for every motion model, and the sigma that it should have: real logs, simulation.

One report of a ship is left out and predicted from those before it (spline and smoother: from both sides). Errors count
against the reported position, so they hold its noise and its time error too.

Run: python tests/benchmarks/bench_motion.py [--fit] [--quick] - prints the tables; with --fit alone it writes
docs/motion_models.md.
"""

from __future__ import annotations

import math
import sys
import time
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix.catalog import AisModel, ais_model, persisting_model
from navfix.picture.motion import DEFAULT, MODELS, Carried, History, Point, history
from navfix.picture.motion.steering import Steering, steering
from navfix.picture.traffic import HISTORY_REPORTS, HISTORY_S
from tests.benchmarks.motion_data import Track, real_tracks, simulated_tracks

AGES_S = (2, 5, 10, 20, 30, 60, 120, 180, 300, 600, 900)
MOST_PER_STATION = 25
BOTH_SIDES = ("spline", "smoother")
SLOW, SLOW_SHARE = ("smoother", "extended", "unscented"), 20  # milliseconds each: run on one sample of twenty
BOUND = math.sqrt(-2.0 * math.log(0.05))  # 95 % of two dimensions: 2.448
PAGE = Path(__file__).resolve().parents[2] / "docs" / "motion_models.md"
FITTED = (
    "clock_sigma_s", "speed_sigma_mps", "path_share", "path_floor_mps", "path_time_s",
    "turn_share", "unsteady_share", "typical_unsteadiness_rad",
)  # fmt: skip
FREE = {  # class B, with 43 ships, keeps how class A turns; its share of the speed is 0: boats wander as much at any
    "A": FITTED,
    "B": ("clock_sigma_s", "speed_sigma_mps", "path_floor_mps", "path_time_s", "unsteady_share"),
}
HALVES = 3  # times that the ships are halved
MOST_FITTED = 8000  # samples of a fit, drawn at random


@dataclass(frozen=True)
class Sample:
    """One report left out: the age class, what was known before it, what came after it too, and where it was."""

    log: str
    station: int
    ais_class: str
    age_s: int
    past: History
    around: History
    left_out: Point
    scatter_s: float


@dataclass(frozen=True)
class Outcome:
    """Errors [m] and sigmas [m] of one model over samples, NaN where it declined."""

    error_m: np.ndarray
    sigma_m: np.ndarray


def samples(tracks: Iterable[Track], seed: int = 1) -> list[Sample]:
    """Return reports to predict: per station and age at most `MOST_PER_STATION`, their ages within -25 to +33 %."""
    rng, found = np.random.default_rng(seed), []
    for track in tracks:
        time_s = np.array([p.time_s for p in track.points])
        for age in AGES_S:
            pairs = [(k, j) for j in range(1, len(time_s)) if (k := _before(track, time_s, j, age)) is not None]
            if len(pairs) > MOST_PER_STATION:
                pairs = [pairs[i] for i in sorted(rng.choice(len(pairs), MOST_PER_STATION, replace=False))]
            found += [_sample(track, age, k, j) for k, j in pairs]
    return found


def _before(track: Track, time_s: np.ndarray, j: int, age: float) -> int | None:
    """Return the moving report before the j-th whose age then is nearest to ``age``, None where none is near."""
    near = int(np.searchsorted(time_s, time_s[j] - age))
    fits = [
        k
        for k in (near - 1, near)
        if 0 <= k < j
        and 0.75 * age <= time_s[j] - time_s[k] <= 1.33 * age + 0.5
        and track.moves[k]
        and track.points[k].course_deg is not None
    ]
    return min(fits, key=lambda k: abs(time_s[j] - time_s[k] - age)) if fits else None


def _sample(track: Track, age: int, k: int, j: int) -> Sample:
    first = max(k - HISTORY_REPORTS + 1, 0)
    before = [p for p in track.points[first : k + 1] if track.points[k].time_s - p.time_s <= HISTORY_S]
    gap_s = track.points[j].time_s - track.points[k].time_s
    after = [p for p in track.points[j + 1 :] if p.time_s >= track.points[j].time_s + 0.8 * gap_s][:HISTORY_REPORTS]
    past = history(before)
    around = history([*before, *after]) if after else past
    return Sample(track.log, track.station, track.ais_class, age, past, around, track.points[j], track.scatter_s)


def outcome(name: str, chosen: Sequence[Sample]) -> Outcome:
    """Run one model over the samples."""
    error, sigma = np.full(len(chosen), np.nan), np.full(len(chosen), np.nan)
    for i, sample in enumerate(chosen):
        if name in SLOW and i % SLOW_SHARE:
            continue
        past = sample.around if name in BOTH_SIDES else sample.past
        carried = MODELS[name](past, sample.left_out.time_s, growth_model(sample.ais_class, sample.scatter_s))
        if isinstance(carried, Carried):
            there = history([replace(sample.left_out, time_s=0.0), _origin(past)])
            error[i] = math.hypot(there.north_m[1] + carried.north_m, there.east_m[1] + carried.east_m)
            sigma[i] = carried.sigma_m
    return Outcome(error, sigma)


@cache
def growth_model(ais_class: str, scatter_s: float) -> AisModel:
    """Return the growth of a class where the times of the reports scatter."""
    model = ais_model(f"class_{ais_class.lower()}")
    return replace(model, clock_sigma_s=math.hypot(model.clock_sigma_s, scatter_s))


def _origin(past: History) -> Point:
    return Point(-1.0, past.origin.lat_deg, past.origin.lon_deg)


def table(names: Sequence[str], chosen: Sequence[Sample], outcomes: dict[str, Outcome]) -> str:
    """Return errors (median / 95 %), share declined and share inside the 95 % bound by age and model, as Markdown."""
    age = np.array([s.age_s for s in chosen])
    lines = ["| age s | reports | " + " | ".join(names) + " |", "|---|---|" + "---|" * len(names)]
    for a in AGES_S:
        here = age == a
        if np.count_nonzero(here) >= 20:
            cells = [_cell(name, outcomes[name], here) for name in names]
            lines.append(f"| {a} | {np.count_nonzero(here)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cell(name: str, result: Outcome, here: np.ndarray) -> str:
    error, sigma = result.error_m[here], result.sigma_m[here]
    if name in SLOW:
        asked = np.flatnonzero(here) % SLOW_SHARE == 0
        error, sigma = error[asked], sigma[asked]
    known = np.isfinite(error)
    if np.count_nonzero(known) < 0.02 * len(known) or np.count_nonzero(known) < 10:
        return "-"
    median, most = np.percentile(error[known], [50, 95])
    inside = np.mean(error[known] < BOUND * sigma[known])
    declined = "" if known.all() else f", {100 * (1.0 - known.mean()):.0f} % declined"
    return f"{median:.1f} / {most:.0f} ({100 * inside:.0f} %{declined})"


# ---------------------------------------------------------------------------------------------- growth of sigma


def features(chosen: Sequence[Sample]) -> list[tuple[Steering, float]]:
    """Return steering and true age of every sample."""
    found = []
    for sample in chosen:
        steers = steering(sample.past, persisting_model())
        assert steers is not None, "moving samples tell speed and course"
        found.append((steers, sample.left_out.time_s - float(sample.past.time_s[0])))
    return found


class Growth:
    """The sigma of `step_sigma_m` over many samples at once, as a function of its constants."""

    def __init__(self, chosen: Sequence[Sample]) -> None:
        rows = [(s.speed_mps, abs(s.turn_rate_rad_s), s.unsteadiness_rad, s.span_s, age) for s, age in features(chosen)]
        self.speed, self.rate, self.unsteady, self.span, self.age = np.array(rows).T
        self.scatter = np.array([sample.scatter_s for sample in chosen])

    def sigma_m(self, x: np.ndarray, where: np.ndarray | slice = slice(None)) -> np.ndarray:
        clock, speed_sigma, share, floor, time_s, turn, unsteady, typical = x
        v, t = self.speed[where], self.age[where]
        rough = np.minimum(np.hypot(self.unsteady[where], typical * np.exp(-0.5 * self.span[where] / 30.0)), 1.5)
        turned = np.minimum(self.rate[where] * t, 1.5)
        return np.sqrt(
            1.0
            + (np.hypot(clock, self.scatter[where]) * v) ** 2
            + (speed_sigma * t) ** 2
            + ((share * v + floor) * t * t / (t + time_s)) ** 2
            + (turn * turned * v * t) ** 2
            + (unsteady * rough * v * t * t / (t + 30.0)) ** 2
        )


def fitted(
    growth: Growth, error_m: np.ndarray, where: np.ndarray, start: np.ndarray, free: Sequence[str] = FITTED
) -> np.ndarray:
    """Return the constants whose 95 % bound is the 95 % quantile of the errors: quantile regression of logarithms.

    Constants that are not ``free`` stay as in ``start``.
    """
    from scipy.optimize import minimize

    rows = np.flatnonzero(where)
    if len(rows) > MOST_FITTED:
        rows = np.sort(np.random.default_rng(1).choice(rows, MOST_FITTED, replace=False))
    logs, at = np.log(np.maximum(error_m[rows], 0.05)), [FITTED.index(key) for key in free]

    def constants(log_x: np.ndarray) -> np.ndarray:
        x = start.copy()
        x[at] = np.exp(np.clip(log_x, -9.0, 8.0))
        return x

    def loss(log_x: np.ndarray) -> float:
        off = logs - np.log(BOUND * growth.sigma_m(constants(log_x), rows))
        return float(np.mean(np.where(off > 0.0, 0.95 * off, -0.05 * off)))

    x = np.log(np.maximum(start[at], 1e-3))
    for _ in range(4):
        x = minimize(loss, x, method="Nelder-Mead", options={"maxiter": 2500, "xatol": 1e-3, "fatol": 1e-6}).x
    return constants(x)


def coverage(inside: np.ndarray, chosen: Sequence[Sample], where: np.ndarray) -> list[str]:
    """Return the shares [%] by age of samples within a class, "-" where there are fewer than 20."""
    age = np.array([s.age_s for s in chosen])
    cells = [inside[where & (age == a)] for a in AGES_S]
    return [f"{100.0 * c.mean():.0f}" if len(c) >= 20 else "-" for c in cells]


def fit_report(chosen: Sequence[Sample], error_m: np.ndarray) -> str:
    """Fit each class by itself; return the constants, and as Markdown the coverage of ships that were not used.

    The ships are halved at random: the constants of one half are tried on the other, and the other way round.
    """
    growth, fits, rows = Growth(chosen), [], []
    ship = np.array([zlib.crc32(f"{s.log} {s.station}".encode()) for s in chosen])
    for name in ("A", "B"):
        where = np.array([s.ais_class == name for s in chosen])
        start = np.array([getattr(ais_model(f"class_{name.lower()}"), key) for key in FITTED])
        x = fitted(growth, error_m, where, start, FREE[name])
        fits.append(f"fitted to class {name}: " + ", ".join(f"{k} {v:.3g}" for k, v in zip(FITTED, x, strict=True)))
        inside, ships = np.zeros(len(chosen)), np.unique(ship[where])
        for seed in range(HALVES):
            one = np.isin(ship, np.random.default_rng(seed).permutation(ships)[: len(ships) // 2])
            for used, tried in ((where & one, where & ~one), (where & ~one, where & one)):
                other = fitted(growth, error_m, used, x, FREE[name])
                inside[tried] += (error_m[tried] < BOUND * growth.sigma_m(other, tried)) / HALVES
        count = [len(np.unique(ship[where & (np.array([s.age_s for s in chosen]) == a)])) for a in AGES_S]
        rows.append(f"| {name} | " + " | ".join(coverage(inside, chosen, where)) + " |")
        rows.append(f"| {name}: ships | " + " | ".join(str(c) for c in count) + " |")
    head = ["| class | " + " | ".join(f"{a} s" for a in AGES_S) + " |", "|---|" + "---|" * len(AGES_S)]
    return "\n".join([*fits, "", *head, *rows])


def shipped_coverage(chosen: Sequence[Sample], result: Outcome) -> str:
    """Return the coverage by class and age of the sigma that epochs use, as Markdown."""
    inside = result.error_m < BOUND * result.sigma_m
    lines = ["| class | " + " | ".join(f"{a} s" for a in AGES_S) + " |", "|---|" + "---|" * len(AGES_S)]
    for name in ("A", "B"):
        where = np.array([s.ais_class == name for s in chosen])
        lines.append(f"| {name} | " + " | ".join(coverage(inside, chosen, where)) + " |")
    return "\n".join(lines)


def main() -> None:
    """Print and write the tables."""
    names = [DEFAULT, *sorted(set(MODELS) - {DEFAULT})]
    names = [name for name in names if "--quick" not in sys.argv or name in (DEFAULT, "constant_velocity")]
    parts = [INTRODUCTION]
    for title, tracks in (("Real AIS logs", real_tracks()), ("Simulated manoeuvres", simulated_tracks(60, 7))):
        if not tracks:
            print(f"{title}: shared data absent")
            continue
        chosen = samples(tracks)
        outcomes, cost = {}, []
        for name in names:
            began = time.process_time()
            outcomes[name] = outcome(name, chosen)
            run = len(chosen) // (SLOW_SHARE if name in SLOW else 1)
            cost.append(f"{name} {1e6 * (time.process_time() - began) / run:.0f} us")
        text = f"## {title}\n\n{table(names, chosen, outcomes)}\n"
        parts.append(text)
        print(text, "\nCPU per prediction, history made: " + ", ".join(cost), flush=True)
        if title.startswith("Real"):
            text = f"{COVERAGE}\n\n{shipped_coverage(chosen, outcomes[DEFAULT])}\n"
            parts.append(text)
            print(text)
            if "--fit" in sys.argv:
                fit = fit_report(chosen, outcomes[DEFAULT].error_m)
                constants, shares = fit.split("\n\n")
                print(constants, "\n", shares)
                parts.append(f"{HALVED}\n\n{shares}\n")
                from tests.benchmarks.bench_motion_halves import report

                parts.append(f"{UNUSED}\n\n{report(chosen)}\n")
                print(parts[-1])
    if len(parts) >= 4 and "--quick" not in sys.argv and "--fit" in sys.argv:
        PAGE.write_text("\n".join(parts), encoding="utf-8")


INTRODUCTION = """# Motion models in figures

One report of a moving ship is left out and predicted: error in metres, median / 95 %, in brackets the share inside the
95 % bound of the sigma that the model states. Spline and smoother know the reports on both sides, from the same
distance in time; the others the reports before alone. Written by `python tests/benchmarks/bench_motion.py --fit`.
"""
UNUSED = """## The default on ships that it was not chosen with

Ships are halved at random; on one half the constants of the persisting motion are chosen anew, one after the other from
a few values each, beginning with none of turn or change of speed going on (`bench_motion_halves.py`):
"""
COVERAGE = """Share of the errors inside the 95 % bound of the default, in %, by class and age; 20 reports and more a
cell. The constants in `models/ais` come from these ships."""
HALVED = """The same of ships that the constants were not fitted to: each class is halved by ships three times at
random, fitted on one half and tried on the other, and the other way round. Up to 10 s the reports of class B come from
one or two boats."""

if __name__ == "__main__":
    main()
