"""AIS veracity over seeds and scenarios: true ships accused, and false AIS found; on recordings with --log too.

Run: python tests/benchmarks/bench_veracity.py [seeds a scenario] [first seed]
     python tests/benchmarks/bench_veracity.py --log LOG.nmea ...     every accusation in recordings
"""

from __future__ import annotations

import io
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from navfix import pipeline
from navfix.integrity import AisVeracity
from navfix.nmea import Log, read_log
from navfix.simulation.scenario import Recording, load, simulate
from navfix.types import ShipVeracity

SCENARIOS = ("approach", "anchorage", "lane", "open_sea", "buoyed_channel")
DURATION_S, EVERY, WRONG = 300.0, 5, 5
ACCUSED = ("disagrees", "elsewhere", "no_echo")


def judged(log: Log, every: int) -> tuple[tuple[ShipVeracity, ...], int, int]:
    """Solve every so many scans, each alone; return the rows, the fixes and the scans tried."""
    veracity, fixes, tried = AisVeracity(), 0, 0
    for count, epoch in enumerate(pipeline.epochs(log)):
        if count % every:
            continue
        tried += 1
        found = pipeline.answer(epoch).fix
        if found is not None:
            fixes += 1
            veracity.feed(found, epoch.time_utc)
    return veracity.ships(), fixes, tried


def recorded(name: str, seed: int) -> Recording:
    """Simulate a shipped scenario with five false positions 200 m to 4 km off, whatever it has by itself."""
    scenario = load(name)
    ais = replace(scenario.ais, wrong_count=WRONG, wrong_offset_min_m=200.0, wrong_offset_max_m=4000.0)
    return simulate(replace(scenario, ais=ais), seed, duration_s=DURATION_S)


def count_scenario(name: str, seeds: Iterable[int]) -> Counter[str]:
    """Count rows of true and false stations by status over seeds, and print every accusation of a true one."""
    total: Counter[str] = Counter()
    for seed in seeds:
        recording = recorded(name, seed)
        log = read_log(io.BytesIO("".join(f"{line}\n" for line in recording.lines).encode()), report=False)
        rows, fixes, tried = judged(log, EVERY)
        total.update(fixes=fixes, tried=tried, runs=1)
        for row in rows:
            kind = "false" if row.mmsi in recording.wrong else "true"
            total[f"{kind} {row.status}"] += 1
            if kind == "true" and row.status in ACCUSED:
                print(f"  {name} seed {seed}: {_shown(row)}", flush=True)
    return total


def _shown(row: ShipVeracity) -> str:
    size = "" if row.offset_m is None else f", {row.offset_m:.0f} m off, sigma {row.sigma_m:.0f} m"
    chance = "" if row.p_value is None else f", p {row.p_value:.1e}"
    return f"{row.mark} {row.status}{size}{chance}, seen {row.seen} of {row.epochs} {row.note}"


def summary(name: str, total: Counter[str]) -> str:
    """Return one line: accused of the judged, true and false."""
    parts = []
    for kind in ("true", "false"):
        accused = sum(total[f"{kind} {status}"] for status in ACCUSED)
        judged_ = accused + total[f"{kind} agrees"]
        parts.append(f"{kind} AIS accused {accused} of {judged_} judged (+ {total[f'{kind} too_little']} too little)")
    return f"{name}: {total['runs']} runs, {total['fixes']} fixes of {total['tried']} scans; {'; '.join(parts)}"


def of_logs(paths: Iterable[str]) -> Iterator[str]:
    """Yield a line for every station that is accused in a recording, and a summary for each."""
    for path in paths:
        rows, fixes, tried = judged(read_log(path, report=False), 10)
        yield from (f"  {_shown(row)}" for row in rows if row.status in ACCUSED)
        yield f"{Path(path).name}: {fixes} fixes of {tried} scans, {dict(Counter(row.status for row in rows))}"


def main(arguments: list[str]) -> None:
    """Print the figures."""
    if arguments[:1] == ["--log"]:
        for line in of_logs(arguments[1:]):
            print(line, flush=True)
        return
    seeds, first = (int(arguments[0]) if arguments else 2), (int(arguments[1]) if len(arguments) > 1 else 9000)
    everything: Counter[str] = Counter()
    for name in SCENARIOS:
        found = count_scenario(name, range(first, first + seeds))
        everything += found
        print(summary(name, found), flush=True)
    print(summary("all", everything))


if __name__ == "__main__":
    main(sys.argv[1:])
