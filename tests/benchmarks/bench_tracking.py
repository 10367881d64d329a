"""Tables of the tracker for raw plots and of the stitching of target numbers, on simulated traffic with known truth."""

from __future__ import annotations

import time

from navfix.catalog import radar_model
from navfix.picture.stitching import stitch
from navfix.picture.tracking import track_plots
from tests.number_scenes import Labelled, epochs_of, label_figures, link_figures, recycled_numbers, with_swaps
from tests.plot_scenes import figures, plot_scene


def tracker_table() -> None:
    """Print how well tracks keep to their ships, by detection and clutter."""
    print("detection clutter/turn | on a ship  pure  tracks/ship  coverage  false  range m  bearing deg | CPU ms/turn")
    for detection, clutter in ((0.9, 0.0), (0.9, 10.0), (0.7, 10.0), (0.9, 50.0), (0.7, 50.0)):
        for seed in (1, 2):
            scene = plot_scene(detection=detection, clutter=clutter, seed=seed)
            began_s = time.process_time()
            reports = track_plots(scene.plots)
            spent_ms = 1e3 * (time.process_time() - began_s) / (scene.scenario.duration_s / 2.5)
            f = figures(scene, reports)
            print(
                f"{detection:9.2f} {clutter:12.0f} | {100 * f.true_share:8.1f}% {100 * f.purity:5.1f}%"
                f"{f.tracks_per_body:13.2f} {100 * f.coverage:8.1f}% {f.false_tracks:6d} {f.range_rmse_m:8.1f}"
                f"{f.bearing_rmse_deg:13.2f} | {spent_ms:11.1f}"
            )


def stitching_table() -> None:
    """Print purity of numbers and of labels, precision and recall of cuts and joins."""
    print("numbers                  | pure: before  after | labels/ship  | cuts: prec. recall | joins: prec. recall")
    for detection in (0.95, 0.8, 0.65):
        for seed in (1, 2):
            _row(f"recycled, detection {detection}", recycled_numbers(detection=detection, seed=seed))
    for within_m, name in ((300.0, "passing"), (1e6, "anywhere")):
        for seed in (1, 2, 3):
            swapped, count = with_swaps(recycled_numbers(detection=0.97, seed=seed), within_m=within_m, seed=seed)
            _row(f"{count} swaps, {name}", swapped)


def _row(name: str, reports: list[Labelled]) -> None:
    epochs, mmsi = epochs_of(reports, radar_model("imo"))
    numbers = [[target.label for target in epoch.targets] for epoch in epochs]
    labels = [[target.label for target in epoch.targets] for epoch in stitch(epochs).epochs]
    raw, new, links = label_figures(numbers, mmsi), label_figures(labels, mmsi), link_figures(numbers, labels, mmsi)
    cuts = f"{100 * links.cut_precision:10.0f}% {100 * links.cut_recall:5.0f}%"
    joins = f"{100 * links.join_precision:11.0f}% {100 * links.join_recall:5.0f}%"
    print(
        f"{name:<24} | {100 * raw.purity:11.1f}% {100 * new.purity:5.1f}% |"
        f" {raw.labels_per_ship:4.2f} -> {new.labels_per_ship:4.2f} | {cuts} | {joins}"
    )


if __name__ == "__main__":
    tracker_table()
    print()
    stitching_table()
