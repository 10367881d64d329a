"""All data, or those that the source's decision table picks: share of fixes and errors, printed as a table.

Two shipped scenarios with a log of own speed, simulated anew for each seed: the port approach, where aids are few
among ships, and the buoyed channel with four echoes in ten tracked. Aids come from AIS and chart. Ships, own
speed or aids are taken out of the same log to make the eight cases. Bearings are relative and no heading is given.
"""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from navfix import pipeline
from navfix.catalog import data_folder
from navfix.chart import marks
from navfix.chart.csv_file import read_csv
from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.nmea import read_log
from navfix.nmea.records import AisPosition, OwnSpeed, Record
from navfix.picture import epochs
from navfix.picture.choice import as_the_source_chooses
from navfix.simulation import files, scenario
from navfix.types import Epoch, Position

SEEDS = 12
LENGTH_S = 60.0
Case = tuple[bool, bool, bool]


SCENES = {"port approach": "approach", "buoyed channel": "buoyed_channel"}
CHANGES = (
    ('bearing_reference = "true"', 'bearing_reference = "relative"'),
    ('target_speed = "blank"', 'target_speed = "true"'),
    ("acquired = 0.9", "acquired = 0.4"),
    ('[sensors]\nheading = "ths"', "[sensors]\nlog = true"),
)


def main(seeds: int) -> None:
    """Print one table for each scene in Markdown."""
    for title, name in SCENES.items():
        print(f"\n{title}, {seeds} seeds\n")
        table(name, seeds)


def table(name: str, seeds: int) -> None:
    """Print the table of one scene."""
    found: dict[tuple[Case, str], list[float | None]] = defaultdict(list)
    for seed in range(1, seeds + 1):
        for case, epoch, truth in cases(name, seed):
            found[case, "all"].append(error_m(epoch, truth))
            found[case, "source"].append(error_m(as_the_source_chooses(epoch), truth))
    print(
        "| AIS of ships | own speed | >= 3 aids | all: fixes, median, worst | source's choice: fixes, median, worst |"
    )
    print("|---|---|---|---|---|")
    for case in product((True, False), repeat=3):
        yes = " | ".join("yes" if there else "no" for there in case)
        print(f"| {yes} | {summary(found[case, 'all'])} | {summary(found[case, 'source'])} |")


def cases(name: str, seed: int) -> Iterator[tuple[Case, Epoch, Position]]:
    """Yield the eight cases of one simulated log: what is there, the last epoch, the true position."""
    text = (data_folder("data") / "scenarios" / f"{name}.toml").read_text(encoding="utf-8")
    for old, new in CHANGES:
        text = text.replace(old, new)
    text += "" if "[sensors]" in text else "\n[sensors]\nlog = true\n"
    recording = scenario.simulate(scenario.from_text(text), seed, duration_s=LENGTH_S)
    records = read_log(list(recording.lines), name=name, report=False).records
    objects, _ = read_csv(files.chart_csv(recording), source=name)
    for case in product((True, False), repeat=3):
        left = [record for record in records if _kept(record, *case)]
        epoch = next(epochs(left, charted=marks(objects) if case[2] else (), last=True), None)
        if epoch is None or epoch.time_utc is None:
            continue
        at_s = epoch.time_utc.timestamp()
        row = min(recording.truth, key=lambda row: abs(row.unix_s - at_s))
        yield case, replace(epoch, heading_hint=None), Position(row.lat_deg, row.lon_deg)


def error_m(epoch: Epoch, truth: Position) -> float | None:
    """Return the error of the fix [m], None without one."""
    try:
        fix = pipeline.fix(epoch)
    except NoFix:
        return None
    assert isinstance(fix.position, Position)
    return inverse(fix.position, truth)[0]


def summary(errors: list[float | None]) -> str:
    """Return share of fixes, median and largest error."""
    fixes = [error for error in errors if error is not None]
    share = f"{100.0 * len(fixes) / max(len(errors), 1):.0f} %"
    return f"{share}, {np.median(fixes):.0f} m, {math.ceil(max(fixes))} m" if fixes else f"{share}, -, -"


def _kept(record: Record, ships: bool, own_speed: bool, aids: bool) -> bool:
    if isinstance(record, OwnSpeed):
        return own_speed
    if isinstance(record, AisPosition):
        return aids if record.kind == "aton" else ships
    return True


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS)
