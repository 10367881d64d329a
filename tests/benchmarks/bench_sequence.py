"""Windows and navigator in figures: cold windows, one change at a time, whole runs, restarts, negative controls, ports.

    python tests/benchmarks/bench_sequence.py                      everything, short
    python tests/benchmarks/bench_sequence.py controls --hours 20  radar of one place with the AIS of another
    ... controls --first 10 --runs 10 --results controls.jsonl     ten of them, kept in a file and not done again
    python tests/benchmarks/bench_sequence.py windows runs ports   some of it

Prints tables in Markdown. Measured recordings are used where the shared data are beside the project.
"""

from __future__ import annotations

import argparse
import contextlib
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import sequence_controls
import sequence_scenes as scenes
from bench_hulls import at_antenna

from navfix.association.window import associate
from navfix.association.window.tracks import epoch_time
from navfix.catalog import AssociationModel, WindowModel, association_model, window_model
from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.refinement import refined
from navfix.report.truth import TruthTrack
from navfix.sequence import Navigator
from navfix.types import Epoch, Fix, TrackState

WRONG_M = 500.0
UNCONFIRMED_S = 60.0
HEAD = "| run | tried | answered % | median m | 95 % m | worst m | ellipse holds % | wrong > 500 m | CPU s each |"
RULE = "|---|---|---|---|---|---|---|---|---|"


@dataclass
class Tally:
    """Answers of one run."""

    name: str
    tried: int = 0
    cpu_s: float = 0.0
    first_s: float | None = None

    def __post_init__(self) -> None:
        self.errors_m: list[float] = []
        self.held: list[bool] = []
        self.doubts: list[float] = []
        self.unconfirmed_s = 0.0

    def take(self, fix: Fix | None, epoch: Epoch, track: TruthTrack | None) -> None:
        """Count one answer."""
        self.tried += 1
        there = None if track is None else track.at(epoch_time(epoch))
        if fix is None or there is None:
            return
        distance_m, azimuth_deg = inverse(there.position, fix.position)
        azimuth = np.radians(azimuth_deg)
        self.errors_m.append(distance_m)
        self.held.append(fix.ellipse(0.95).holds(distance_m * np.cos(azimuth), distance_m * np.sin(azimuth)))

    def note(self, track: TrackState, step_s: float = 5.0) -> None:
        """Take what the navigator says of its place: the doubt, and for how long it was given out unconfirmed."""
        if track.probability_wrong is not None:
            self.doubts.append(track.probability_wrong)
            self.unconfirmed_s += step_s * ((track.confirmed_age_s or 0.0) > UNCONFIRMED_S)

    def told(self) -> str:
        """Return the words for what was said of a navigator's place."""
        first = "never" if self.first_s is None else f"{self.first_s:.0f} s"
        doubt = f", doubt {np.median(self.doubts):.3f}, at most {max(self.doubts):.3f}" if self.doubts else ""
        return f", first fix {first}{doubt}, unconfirmed for {self.unconfirmed_s:.0f} s"

    def row(self) -> str:
        """Return the row of a table."""
        e = np.array(self.errors_m) if self.errors_m else np.full(1, np.nan)
        share = 100.0 * len(self.errors_m) / max(self.tried, 1)
        held = 100.0 * np.mean(self.held) if self.held else np.nan
        wrong = int((e > WRONG_M).sum())
        return (
            f"| {self.name} | {self.tried} | {share:.0f} | {np.median(e):.0f} | {np.percentile(e, 95):.0f} "
            f"| {e.max():.0f} | {held:.0f} | {wrong} | {self.cpu_s / max(self.tried, 1):.2f} |"
        )


def cut(scans: Sequence[Epoch], length_s: float, step_s: float) -> Iterator[tuple[Epoch, ...]]:
    """Yield windows that end ``step_s`` apart."""
    kept: deque[Epoch] = deque()
    due_s = epoch_time(scans[0]) + length_s
    for epoch in scans:
        kept.append(epoch)
        while epoch_time(epoch) - epoch_time(kept[0]) > length_s:
            kept.popleft()
        if epoch_time(epoch) >= due_s:
            due_s += step_s
            yield tuple(kept)


def cold(
    run: scenes.Run,
    length_s: float,
    step_s: float,
    model: WindowModel,
    shared: AssociationModel,
    *,
    seen: Callable[[Epoch], Epoch] = lambda epoch: epoch,
) -> Tally:
    """Solve every window of a run with nothing known beforehand; ``seen`` changes each of its epochs."""
    tally = Tally(f"{run.name} {length_s:.0f} s")
    for window in cut([seen(epoch) for epoch in run.epochs()], length_s, step_s):
        began_s, fix = time.process_time(), None
        with contextlib.suppress(NoFix):
            fix = refined(window, associate.solve_jointly(window, model=model, shared=shared))
        tally.cpu_s += time.process_time() - began_s
        tally.take(fix, window[-1], run.truth)
    return tally


def navigated(run: scenes.Run, step_s: float = 5.0, begin_s: float = 0.0, *, first_only: bool = False) -> Tally:
    """Run the whole navigator, or up to its first fix; scans before that are not counted."""
    tally, navigator, last_s, origin_s = Tally(run.name), Navigator(), -np.inf, None
    for epoch in run.epochs():
        now_s = epoch_time(epoch)
        origin_s = now_s + begin_s if origin_s is None else origin_s
        if now_s < origin_s:
            continue
        navigator.feed(epoch)
        if now_s - last_s < step_s - 0.1:
            continue
        last_s, began_s = now_s, time.process_time()
        outcome = navigator.step()
        tally.cpu_s += time.process_time() - began_s
        if outcome.fix is not None and tally.first_s is None:
            tally.first_s = now_s - origin_s
            tally.tried = 0
        tally.take(outcome.fix, epoch, run.truth)
        tally.note(outcome.track)
        if first_only and tally.first_s is not None:
            break
    return tally


# ------------------------------------------------------------------------------------------------ the tables


def windows(args: argparse.Namespace) -> None:
    """Cold windows of every recording, by length."""
    print("\n## Cold windows\n\n" + HEAD + "\n" + RULE)
    for run in measured():
        for length_s in (10.0, 30.0, 60.0, 120.0):
            print(cold(run, length_s, args.step, window_model(), association_model()).row(), flush=True)


def changes(args: argparse.Namespace) -> None:
    """One change at a time, windows of 60 s."""
    model, shared = window_model(), association_model()
    table = {
        "as it is": (model, shared),
        "no velocity gate": (replace(model, velocity_gate_sigma=1e3), shared),
        "velocities hardly used": (replace(model, slope_mps=5.0, still_mps=5.0), shared),
        "no missed detections": (model, replace(shared, use_missed=False)),
        "uniform clutter": (model, replace(shared, use_local_clutter=False)),
        "own motion free": (replace(model, acceleration_mps2=1.0, heading_walk_deg=10.0), shared),
        "clock known": (replace(model, clock_s=0.01), shared),
        "no jumping clutter": (replace(model, jumping_share=1e-9), shared),
        "bins of 5 s": (replace(model, bin_s=5.0), shared),
    }
    print("\n## One change at a time, 60 s\n\n" + HEAD + "\n" + RULE)
    for run in measured():
        for name, (changed, changed_shared) in table.items():
            tally = cold(run, 60.0, 2.0 * args.step, changed, changed_shared)
            tally.name = f"{run.name}, {name}"
            print(tally.row(), flush=True)
        tally = cold(run, 60.0, 2.0 * args.step, model, shared, seen=at_antenna)
        tally.name = f"{run.name}, hulls left out"
        print(tally.row(), flush=True)


def runs(args: argparse.Namespace) -> None:
    """The navigator on every recording, and restarted every minute."""
    print("\n## Navigator, after the first fix\n\n" + HEAD + "\n" + RULE)
    for run in measured():
        tally = navigated(run)
        tally.name += tally.told()
        print(tally.row(), flush=True)
    for run in measured(("marce/marce_01_004", "marce/marce_01_010")):
        if not args.restart:
            break
        length_s = epoch_time(run.epochs()[-1]) - epoch_time(run.epochs()[0])
        begins = np.arange(0.0, length_s - 200.0, args.restart)
        first = [navigated(run, begin_s=float(begin), first_only=True).first_s for begin in begins]
        waits = np.array([np.inf if f is None else f for f in first])
        print(f"\n{run.name}: {len(begins)} restarts, median wait {np.median(waits):.0f} s, worst {waits.max():.0f} s")


def ports(args: argparse.Namespace) -> None:
    """Simulated ports from dense to sparse."""
    print("\n## Simulated ports (share of echoes with AIS, echoes)\n\n" + HEAD + "\n" + RULE)
    for seed in range(args.seeds):
        for share, targets in sequence_controls.PORTS:
            run = scenes.port(100 + seed, ais_share=share, targets=targets, duration_s=600.0)
            if args.gyro != "none":
                run = scenes.with_gyro(run, scenes.gyro_error_deg(args.gyro, seed), seed)
            tally = navigated(run)
            tally.name = f"{run.name}, {targets} echoes{tally.told()}"
            print(tally.row(), flush=True)


def controls(args: argparse.Namespace) -> None:
    """Radar of one place with the AIS of another: nothing right exists, whatever is accepted is wrong."""
    sequence_controls.controls(
        hours=args.hours,
        first=args.first,
        runs=args.runs,
        results=args.results,
        gyro=args.gyro,
        recorded=args.recorded,
    )


def measured(names: Sequence[str] = scenes.MEASURED) -> Iterator[scenes.Run]:
    """Yield the measured recordings that there are."""
    for name in names:
        if (scenes.SHARED / f"{name}.nmea").exists():
            yield scenes.measured(name)


TABLES = {"windows": windows, "changes": changes, "runs": runs, "ports": ports, "controls": controls}


def main() -> None:
    """Print the tables that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tables", nargs="*", help=f"some of {', '.join(TABLES)} (default: all)")
    parser.add_argument("--hours", type=float, default=1.0, help="of negative controls")
    parser.add_argument("--first", type=int, default=0, help="number of the first negative control")
    parser.add_argument("--runs", type=int, help="how many negative controls at most")
    parser.add_argument("--results", type=Path, help="file that keeps the negative controls done so far")
    parser.add_argument(
        "--gyro", choices=("none", "right", "wrong"), default="none", help="own gyro in the ports and controls"
    )
    parser.add_argument("--recorded", action="store_true", help="every pair of recordings, no ports, as controls")
    parser.add_argument("--seeds", type=int, default=1, help="of simulated ports")
    parser.add_argument("--step", type=float, default=20.0, help="seconds between cold windows")
    parser.add_argument("--restart", type=float, default=120.0, help="seconds between restarts, 0 for none")
    args = parser.parse_args()
    for name in args.tables or TABLES:
        TABLES[name](args)


if __name__ == "__main__":
    main()
