"""Marks from the chart and nothing else: a buoyed channel without any AIS, and one that is regular."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from navfix import adjust, pipeline
from navfix.catalog import data_folder
from navfix.chart import marks
from navfix.chart.csv_file import read_csv
from navfix.geodesy import direct, inverse
from navfix.nmea import read_log
from navfix.report import Answer
from navfix.simulation import files, scenario
from navfix.types import Association, Epoch, Mark, Position, PositionHint, RadarTarget

CHANNEL = (data_folder("data") / "scenarios" / "buoyed_channel.toml").read_text(encoding="utf-8")
RELATIVE = CHANNEL.replace('bearing_reference = "true"', 'bearing_reference = "relative"')
REGULAR = RELATIVE.replace("irregularity_m = 90.0", "irregularity_m = 0.0")
SPACING_M = 1300.0
SEEDS = (1, 2, 3)
OWN = Position(54.0, 8.0)
SWING_M = 70.0  # 25 m of water on three times as much chain


@cache
def radar_and_chart(text: str, seed: int) -> tuple[Epoch, Position]:
    """Return the last epoch of a log from which every AIS sentence was taken out, with the chart, and the truth."""
    recording = scenario.simulate(scenario.from_text(text), seed, duration_s=40.0)
    objects, _ = read_csv(files.chart_csv(recording), source="chart")
    log = read_log([line for line in recording.lines if "VDM" not in line], name="channel", report=False)
    epoch = next(pipeline.epochs(log, last=True, charted=marks(objects)))
    assert epoch.time_utc is not None
    assert {mark.kind for mark in epoch.marks} == {"charted"}
    at_s = epoch.time_utc.timestamp()
    row = min(recording.truth, key=lambda row: abs(row.unix_s - at_s))
    return epoch, Position(row.lat_deg, row.lon_deg)


def error_m(answer: Answer, truth: Position) -> float:
    assert answer.fix is not None
    assert isinstance(answer.fix.position, Position)
    return inverse(answer.fix.position, truth)[0]


@pytest.mark.parametrize("text", [CHANNEL, RELATIVE], ids=["true bearings", "relative bearings"])
def test_a_buoyed_channel_with_a_heading_gives_a_fix_without_any_ais(text: str) -> None:
    errors_m = []
    for seed in SEEDS:
        epoch, truth = radar_and_chart(text, seed)
        assert epoch.heading_hint is not None
        errors_m.append(error_m(pipeline.answer(epoch), truth))
    assert np.max(errors_m) < 30.0
    print(f"chart alone: median error {np.median(errors_m):.0f} m, worst {np.max(errors_m):.0f} m")


@pytest.mark.parametrize("seed", SEEDS)
def test_a_regular_channel_without_a_prior_is_ambiguous_and_the_step_is_told(seed: int) -> None:
    epoch, truth = radar_and_chart(REGULAR, seed)
    answer = pipeline.answer(replace(epoch, heading_hint=None))
    assert answer.error is not None
    assert answer.error.reason == "ambiguous"
    assert f"{SPACING_M / 1852.0:.2f} NM apart along 120°" in str(answer.error)
    places = [place.position for place in answer.error.alternatives]  # type: ignore[attr-defined]
    assert min(inverse(place, truth)[0] for place in places) < 60.0


def test_a_rough_position_selects_in_a_regular_channel_or_leaves_it_open() -> None:
    fixed = 0
    for seed in SEEDS:
        epoch, truth = radar_and_chart(REGULAR, seed)
        told = PositionHint(direct(truth, 30.0, 200.0), 200.0)
        answer = pipeline.answer(replace(epoch, position_hint=told))
        if answer.fix is not None:
            fixed += 1
            assert error_m(answer, truth) < 30.0
        else:
            assert answer.error is not None
            assert answer.error.reason == "ambiguous"
    assert fixed >= 2


def test_charted_marks_that_are_elsewhere_give_no_fix() -> None:
    epoch, _ = radar_and_chart(RELATIVE, 1)
    rng = np.random.default_rng(5)
    moved = tuple(
        replace(mark, position=direct(mark.position, float(rng.uniform(0, 360)), float(rng.uniform(500, 3000))))
        for mark in epoch.marks
    )
    answer = pipeline.answer(replace(epoch, marks=moved))
    assert answer.fix is None


def swinging(rng: np.random.Generator, *, tight: bool) -> Epoch:
    """Return twelve charted marks about own ship: six beacons, and six buoys on 70 m of radius."""
    targets, told = [], []
    for number in range(12):
        floats = number % 2 == 0
        charted = direct(OWN, float(rng.uniform(0.0, 360.0)), float(rng.uniform(500.0, 5000.0)))
        swing_m = SWING_M * float(np.sqrt(rng.uniform())) if floats else abs(float(rng.normal(0.0, 4.0)))
        range_m, azimuth_deg, *_ = inverse(OWN, direct(charted, float(rng.uniform(0.0, 360.0)), swing_m))
        noise = rng.normal(size=2)
        targets.append(RadarTarget(f"{number}", range_m + 10.0 * noise[0], azimuth_deg - 40.0 + 0.25 * noise[1]))
        sigma_m = 4.0 if tight or not floats else float(np.hypot(SWING_M / 2.0, 8.0))
        told.append(Mark(f"m{number}", charted, sigma_m, "charted"))
    return Epoch(None, tuple(targets), tuple(told))


def test_the_watch_circle_as_sigma_gives_a_better_fix_than_tight_marks() -> None:
    rms_m = {}
    for tight in (False, True):
        rng = np.random.default_rng(1)
        squared = []
        for _ in range(60):
            epoch = swinging(rng, tight=tight)
            fix = adjust(epoch, Association.from_pairs(epoch, [(i, i) for i in range(12)]), radar="solid_state")
            assert isinstance(fix.position, Position)
            squared.append(inverse(OWN, fix.position)[0] ** 2)
        rms_m[tight] = float(np.sqrt(np.mean(squared)))
    print(f"watch circle as sigma: rms {rms_m[False]:.1f} m, all marks tight: {rms_m[True]:.1f} m")
    assert rms_m[False] < 0.8 * rms_m[True]
