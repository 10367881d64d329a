"""Negative controls: the whole navigator on the radar of one place with the AIS of another, run by run.

Nothing right exists in them, so whatever is held is wrong. Each run is a line, written as soon as it is known; runs
that a file of results holds already are not done again.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from functools import cache
from itertools import permutations
from pathlib import Path

import numpy as np
import sequence_scenes as scenes

from navfix.association.window.tracks import epoch_time
from navfix.sequence import Navigator

RUN_S = 1800.0
STEP_S = 5.0
FIRST_PORT = 5000
SAME_AIS = {("semi_real/dense_sf", "ais_logs/PacCupStart.txt"), ("semi_real/coastal_hakefjord", "ais_logs/hakan.txt")}
PORTS = ((0.5, 20), (0.35, 24), (0.3, 12), (0.2, 30), (0.13, 24), (0.13, 40))  # share with AIS, echoes


@dataclass
class Control:
    """What one run gave: longest hold of a wrong place, and how far the best place of the bank came in each update."""

    name: str
    hours: float = 0.0
    steps: int = 0
    fixes: int = 0
    longest_s: float = 0.0
    least_doubt: float | None = None
    score: list[float] = field(default_factory=list)
    ahead: list[float] = field(default_factory=list)

    def line(self) -> str:
        """Return the line of this run."""
        doubt = "" if self.least_doubt is None else f", stated to be wrong with {self.least_doubt:.3f} at least"
        best = max(self.score, default=-math.inf)
        return (
            f"{self.name}: {60 * self.hours:.0f} min, {self.fixes} of {self.steps} steps with a fix, longest hold "
            f"{self.longest_s:.0f} s{doubt}; highest score of a place {best:.1f}"
        )


def run_control(run: scenes.Run) -> Control:
    """Run the navigator over a control."""
    navigator, control, last_s, bank_s, held_s = Navigator(), Control(run.name), -np.inf, -np.inf, None
    scans = [e for e in run.epochs() if epoch_time(e) - run.first_s <= RUN_S]
    for epoch in scans:
        navigator.feed(epoch)
        now_s = epoch_time(epoch)
        if now_s - last_s < STEP_S - 0.1:
            continue
        last_s, outcome = now_s, navigator.step()
        control.steps += 1
        if outcome.fix is None:
            held_s = None
        else:
            held_s = now_s if held_s is None else held_s
            control.fixes += 1
            control.longest_s = max(control.longest_s, now_s - held_s + STEP_S)
            stated = outcome.track.probability_wrong or 1.0
            control.least_doubt = min(stated, control.least_doubt or 1.0)
        if navigator.bank.hypotheses and now_s - bank_s >= 30.0:
            bank_s = now_s
            control.score.append(round(navigator.bank.hypotheses[0].score, 2))
            control.ahead.append(round(min(navigator.bank.ahead, 99.0), 2))
    if scans:
        control.hours = (epoch_time(scans[-1]) - epoch_time(scans[0])) / 3600.0
    return control


# ------------------------------------------------------------------------------------------------ which runs there are


@cache
def _measured(name: str) -> scenes.Run:
    return scenes.ais_alone(name) if name in scenes.AIS_ALONE else scenes.measured(name)


@cache
def _port(seed: int) -> scenes.Run:
    share, targets = PORTS[seed % len(PORTS)]
    return scenes.port(seed, ais_share=share, targets=targets, duration_s=RUN_S + 60.0)


def control_runs() -> Iterator[tuple[str, str]]:
    """Yield pairs of a radar and the AIS of another place: ports with ports, with measured between them, on and on."""
    real = recorded_runs()
    seed = FIRST_PORT
    while True:
        yield (f"port:{seed}", f"port:{seed + 1}")
        yield (f"port:{seed + 1}", f"port:{seed}")
        pair = next(real, None)
        if pair is not None:
            yield pair
        seed += 2


def recorded_runs() -> Iterator[tuple[str, str]]:
    """Yield every pair of a measured radar and the AIS of another recording; two logs hold the AIS of a recording."""
    recordings = [name for name in scenes.MEASURED if (scenes.SHARED / f"{name}.nmea").exists()]
    others = [name for name in scenes.AIS_ALONE if recordings]
    yield from permutations(recordings, 2)
    yield from ((radar, ais) for radar in recordings for ais in others if (radar, ais) not in SAME_AIS)


def make_run(radar: str, ais: str, *, gyro: str = "none", seed: int = 0) -> scenes.Run:
    """Return the radar of one place with the AIS of another by their names; with a ``gyro`` beside the radar."""
    seen, heard = (_port(int(name[5:])) if name.startswith("port:") else _measured(name) for name in (radar, ais))
    if gyro != "none":
        seen = scenes.with_gyro(seen, scenes.gyro_error_deg(gyro, seed), seed)
    return scenes.foreign(seen, heard)


def controls(
    *,
    hours: float,
    first: int,
    runs: int | None,
    results: Path | None,
    gyro: str = "none",
    recorded: bool = False,
) -> None:
    """Do the runs from ``first`` on until there are so many or they hold so many hours, and print what they say."""
    known = {} if results is None or not results.exists() else _read(results)
    done: list[Control] = []
    for number, (radar, ais) in enumerate(recorded_runs() if recorded else control_runs()):
        if number < first:
            continue
        if sum(c.hours for c in done) >= hours or (runs is not None and number >= first + runs):
            break
        name = f"{Path(radar).name}+{Path(ais).name}" + ("" if gyro == "none" else f", gyro {gyro}")
        if name not in known:
            known[name] = run_control(make_run(radar, ais, gyro=gyro, seed=number))
            known[name].name = name
            if results is not None:
                with results.open("a") as lines:
                    lines.write(json.dumps(asdict(known[name])) + "\n")
        done.append(known[name])
        print(f"{number} {known[name].line()}", flush=True)
    print(summary(done))


def _read(results: Path) -> dict[str, Control]:
    with results.open() as lines:
        found = [Control(**json.loads(line)) for line in lines]
    return {control.name: control for control in found}


def summary(done: list[Control]) -> str:
    """Return what the controls say together. None of n runs wrong bounds the share of wrong runs by 3 / n (95 %)."""
    hours = sum(c.hours for c in done)
    wrong = [c for c in done if c.fixes]
    bound = _upper_95(len(wrong), len(done)) if done else math.nan
    best = np.array([max(c.score, default=-99.0) for c in done])
    tail = "" if not done else " / ".join(f"{q:.1f}" for q in np.percentile(best, [50, 90, 100]))
    longest_s = max((c.longest_s for c in wrong), default=0.0)
    return (
        f"\n## Negative controls\n\n{len(done)} runs, {hours:.1f} h: {len(wrong)} with a wrong place, at most "
        f"{100 * bound:.1f} % of runs (95 %), longest hold {longest_s:.0f} s\n"
        f"highest score of a run, 50 / 90 / 100 %: {tail}"
    )


def _upper_95(wrong: int, runs: int) -> float:
    """Return the share of wrong runs that these counts do not exclude, 95 %: of a Poisson count."""
    from scipy.special import gammaincinv

    return min(1.0, float(gammaincinv(wrong + 1.0, 0.95)) / runs)
