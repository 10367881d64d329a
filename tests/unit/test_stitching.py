"""Stable labels: cuts, joins and swaps by hand, in simulated traffic whose truth is known, and in recordings."""

from __future__ import annotations

import csv
from collections import Counter
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from navfix.catalog import radar_model
from navfix.nmea import read_log
from navfix.nmea.records import TargetReport
from navfix.picture.scans import ScanBuilder
from navfix.picture.stitching import stitch, stitch_scans
from navfix.types import Epoch, RadarTarget
from tests.number_scenes import (
    LabelFigures,
    LinkFigures,
    epochs_of,
    label_figures,
    link_figures,
    recycled_numbers,
    with_swaps,
)

TURN_S = 2.5
START = datetime(2026, 3, 1, tzinfo=UTC)
STILL = {"01": (3000.0, 500.0), "02": (-2000.0, 2500.0), "03": (800.0, -4200.0), "04": (-900.0, -2500.0)}


def scene(
    tracks: dict[str, tuple[float, float, float, float, range]], turns: int, *, yaw_deg: float = 0.0, seed: int = 0
) -> list[Epoch]:
    """Return epochs of tracks (north m, east m at turn 0, north m/s, east m/s, turns that show them) with noise."""
    rng = np.random.default_rng(seed)
    everything = {**{label: (*place, 0.0, 0.0, range(turns)) for label, place in STILL.items()}, **tracks}
    epochs = []
    for turn in range(turns):
        targets = []
        for label, (north, east, north_mps, east_mps, seen) in everything.items():
            if turn in seen:
                x, y = north + TURN_S * turn * north_mps, east + TURN_S * turn * east_mps
                bearing = np.degrees(np.arctan2(y, x)) - yaw_deg * turn + rng.normal(0, 0.5)
                targets.append(RadarTarget(label.split("/")[0], np.hypot(x, y) + rng.normal(0, 15), bearing))
        epochs.append(Epoch(START + timedelta(seconds=TURN_S * turn), tuple(targets), ()))
    return epochs


def labels_of(epochs: tuple[Epoch, ...]) -> list[tuple[str, ...]]:
    return [tuple(target.label for target in epoch.targets) for epoch in epochs]


@pytest.mark.parametrize("yaw_deg", [0.0, 6.0])
def test_labels_that_are_right_stay_as_they_are(yaw_deg: float) -> None:
    epochs = scene({"09": (4000.0, 0.0, -8.0, 3.0, range(40))}, 40, yaw_deg=yaw_deg)
    found = stitch(epochs)
    assert labels_of(found.epochs) == labels_of(tuple(epochs))
    assert (found.cuts, found.joins, found.swaps) == (0, 0, 0)


def test_a_number_used_again_elsewhere_is_another_target() -> None:
    epochs = scene({"09/a": (4000.0, 0.0, -8.0, 0.0, range(18)), "09/b": (-600.0, 5000.0, 4.0, 0.0, range(20, 40))}, 40)
    found = stitch(epochs)
    assert [row[-1] for row in labels_of(found.epochs)] == ["09"] * 18 + ["04"] * 2 + ["09b"] * 20
    assert (found.cuts, found.joins, found.swaps) == (1, 0, 0)


def test_an_echo_that_comes_back_under_another_number_keeps_its_label() -> None:
    moving = (4000.0, 0.0, -8.0, 3.0)
    epochs = scene({"09": (*moving, range(18)), "17": (*moving, range(24, 40))}, 40)
    found = stitch(epochs)
    assert {row[-1] for row in labels_of(found.epochs)[24:]} == {"09"}
    assert (found.cuts, found.joins, found.swaps) == (0, 1, 0)


def test_an_echo_that_comes_back_after_a_long_silence_elsewhere_is_not_joined() -> None:
    epochs = scene({"09": (4000.0, 0.0, -8.0, 3.0, range(18)), "17": (5500.0, 0.0, 6.0, -3.0, range(24, 40))}, 40)
    found = stitch(epochs)
    assert {row[-1] for row in labels_of(found.epochs)[24:]} == {"17"}
    assert found.joins == 0


def test_numbers_that_change_over_where_two_ships_pass_are_undone() -> None:
    one, other = (3000.0, 0.0, -7.0, 6.0), (3000.0, 600.0, -7.0, -6.0)  # they meet at turn 20
    epochs = scene(
        {
            "11/a": (*one, range(21)), "12/a": (*other, range(21)),
            "12/b": (*one, range(21, 45)), "11/b": (*other, range(21, 45)),
        }, 45,
    )  # fmt: skip
    found = stitch(epochs)
    after = labels_of(found.epochs)[-1]
    assert found.swaps == 1
    assert after[-2:] == ("11", "12")  # the order of the scene: first ``one``, then ``other``


def test_ships_that_pass_and_keep_their_numbers_are_left_alone() -> None:
    epochs = scene({"11": (3000.0, 0.0, -7.0, 6.0, range(45)), "12": (3000.0, 600.0, -7.0, -6.0, range(45))}, 45)
    assert stitch(epochs).swaps == 0


def test_one_number_twice_in_a_scan_is_two_targets() -> None:
    epochs = scene({}, 10)
    doubled = [replace(e, targets=(*e.targets, RadarTarget("01", 7000.0, 200.0))) for e in epochs]
    assert {row[-1] for row in labels_of(stitch(doubled).epochs)} == {"01b"}


@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_targets_or_none_are_no_trouble(count: int) -> None:
    epochs = [replace(e, targets=e.targets[:count]) for e in scene({}, 12, yaw_deg=4.0)]
    assert labels_of(stitch(epochs).epochs) == labels_of(tuple(epochs))
    assert stitch([]).epochs == ()


def test_scans_get_the_labels_of_their_epochs() -> None:
    reports = [report for report, _ in recycled_numbers(duration_s=100.0)]
    builder = ScanBuilder()
    scans = [scan for report in reports if (scan := builder.feed(report)) is not None]
    found = stitch_scans(scans)
    assert [len(row) for row in found] == [len(scan.reports) for scan in scans]
    assert any(label.endswith("b") for row in found for label in row)


# ------------------------------------------------------------------------------------------------- whole scenes


def before_and_after(
    reports: list[tuple[TargetReport, int]],
) -> tuple[LabelFigures, LabelFigures, LinkFigures, int]:
    """Return the figures of the radar's numbers, of the stitched labels and their links, and the swaps found."""
    epochs, mmsi = epochs_of(reports, radar_model("imo"))
    found = stitch(epochs)
    raw = [[target.label for target in epoch.targets] for epoch in epochs]
    labels = labels_of(found.epochs)
    return label_figures(raw, mmsi), label_figures(labels, mmsi), link_figures(raw, labels, mmsi), found.swaps


@pytest.mark.parametrize(("detection", "seed", "labels"), [(0.95, 1, 1.3), (0.8, 1, 2.5), (0.8, 2, 2.5)])
def test_recycled_numbers_become_pure_labels(detection: float, seed: int, labels: float) -> None:
    raw, stitched, links, _ = before_and_after(recycled_numbers(detection=detection, seed=seed))
    assert raw.purity < 0.95
    assert stitched.purity > 0.99
    assert stitched.labels_per_ship < min(labels, raw.labels_per_ship)
    assert links.cut_recall > 0.95
    assert links.join_precision > 0.95


@pytest.mark.parametrize("within_m", [300.0, 1e6])
def test_swapped_numbers_are_mostly_undone(within_m: float) -> None:
    """Numbers that change over where ships pass, and anywhere."""
    wrong_before = wrong_after = 0.0
    for seed in (1, 2):
        clean = recycled_numbers(detection=0.97, seed=seed)
        swapped, swaps = with_swaps(clean, within_m=within_m, seed=seed)
        assert swaps >= 4
        raw, stitched, links, _ = before_and_after(swapped)
        wrong_before += 1.0 - raw.purity
        wrong_after += 1.0 - stitched.purity
        assert links.join_precision > 0.9
    assert wrong_after < 0.3 * wrong_before


def test_traffic_without_swaps_shows_none() -> None:
    for seed in (1, 2):
        _, stitched, _, swaps = before_and_after(recycled_numbers(detection=0.97, seed=seed))
        assert swaps == 0
        assert stitched.purity == 1.0


@pytest.mark.parametrize(
    ("name", "raw_purity", "purity"),
    [("coastal_hakefjord", 0.985, 0.999), ("moored_harlingen_atons", 0.995, 0.999), ("dense_sf", 0.92, 0.995)],
)
def test_recorded_traffic_with_recycled_numbers(shared_data: Path, name: str, raw_purity: float, purity: float) -> None:
    folder = shared_data / "semi_real"
    reports = read_log(folder / f"{name}.nmea", report=False).of(TargetReport)
    with (folder / f"{name}_assoc.csv").open() as lines:
        rows = [(float(row["unix"]), int(row["target_no"]), int(row["mmsi"])) for row in csv.DictReader(lines)]
    truth = {(round(2.0 * time_s), number): mmsi for time_s, number, mmsi in rows}
    known = Counter[bool]()
    labelled = []
    for report in reports:  # the TAG block's time lacks the half second of the table
        key = round(2.0 * (report.time_s or 0.0))
        mmsi = truth.get((key, report.number), truth.get((key + 1, report.number)))
        known[mmsi is not None] += 1
        labelled.append((report, mmsi or 0))
    assert known[False] == 0
    raw, stitched, links, _ = before_and_after(labelled)
    assert raw.purity < raw_purity
    assert stitched.purity > purity
    assert stitched.labels_per_ship < raw.labels_per_ship + 0.1
    assert links.cut_recall > 0.9
