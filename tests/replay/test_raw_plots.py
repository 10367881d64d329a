"""Raw radar plots of recordings: tracks on two boats with known positions, and fixes beside those of a radar's own."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from navfix import pipeline
from navfix.catalog import RadarModel, radar_model
from navfix.nmea import read_log
from navfix.nmea.plots import RadarPlot, read_plots
from navfix.nmea.records import Record, TargetReport
from navfix.picture import epochs
from navfix.picture.tracking import track_plots, turn_length_s, with_tracked_plots
from navfix.report.truth import TruthTrack, with_truth

RADAR_SENSOR = 2
ON_THE_BOAT_M = 20.0


@dataclass(frozen=True, slots=True, eq=False)
class BoatScene:
    """Radar plots about own ship, and the way of each boat relative to her: times (n,) [s], places (n, 2) [m]."""

    plots: list[RadarPlot]
    boats: dict[int, tuple[np.ndarray, np.ndarray]]

    def boat(self, key: int, time_s: float) -> np.ndarray:
        times, places = self.boats[key]
        return np.array([np.interp(time_s, times, places[:, axis]) for axis in (0, 1)])


def boat_scene(folder: Path, number: int) -> BoatScene:
    """Read one scenario: radar detections as plane coordinates about own ship, two boats with GNSS."""
    detections = json.loads((folder / f"scenario{number}_detections.json").read_text())
    truth = json.loads((folder / f"scenario{number}_groundTruth.json").read_text())
    plots, boats = [], {1: [], 2: []}  # type: tuple[list[RadarPlot], dict[int, list[tuple[float, float, float]]]]
    for seen, places in zip(detections, truth, strict=True):
        own = seen["ownshipPosition"]
        for boat in places:
            x, y = boat["position"][:2]
            boats[boat["targetID"]].append((seen["time"], x - own[0], y - own[1]))
        columns = np.array(seen["measurement"], dtype=float)
        if seen["sensorID"] == RADAR_SENSOR and columns.size:
            for x, y in np.atleast_2d(columns.T if columns.ndim == 2 else columns):
                plots.append(RadarPlot(seen["time"], math.hypot(x, y), math.degrees(math.atan2(y, x)) % 360.0))
    ways = {key: np.array(sorted(set(rows))) for key, rows in boats.items()}
    return BoatScene(plots, {key: (way[:, 0], way[:, 1:]) for key, way in ways.items()})


def harbour_radar() -> RadarModel:
    """Return a radar of cells of a few metres, as those of small boats are."""
    return replace(
        radar_model("imo_plot"), range_sigma_m=3.0, range_sigma_fraction=0.005, bearing_sigma_deg=2.0, name="harbour"
    )


@dataclass(frozen=True, slots=True)
class BoatFigures:
    """Share of the turns in which the boat's main track reports it, its purity, and the RMSE of its reports [m]."""

    continuity: float
    purity: float
    rmse_m: float


def boat_figures(scene: BoatScene, reports: tuple[TargetReport, ...], key: int) -> BoatFigures:
    """Return how well the reports follow one boat."""
    turns = len({plot.time_s for plot in scene.plots})
    on_boat: Counter[int] = Counter()
    errors_m: dict[int, list[float]] = {}
    for report in reports:
        bearing = math.radians(report.bearing_deg)
        place = report.range_m * np.array([math.cos(bearing), math.sin(bearing)])
        off_m = float(np.hypot(*(place - scene.boat(key, report.time_s or 0.0))))
        if off_m <= ON_THE_BOAT_M:
            on_boat[report.number] += 1
            errors_m.setdefault(report.number, []).append(off_m)
    number, count = on_boat.most_common(1)[0]
    purity = count / sum(report.number == number for report in reports)
    return BoatFigures(count / turns, purity, float(np.sqrt(np.mean(np.square(errors_m[number])))))


@pytest.mark.parametrize(
    ("number", "continuity", "rmse_m"),
    [(2, (0.85, 0.85), (7.0, 10.0)), (13, (0.7, 0.55), (7.0, 8.0)), (16, (0.85, 0.8), (9.0, 5.0))],
)
def test_one_track_forms_on_each_of_two_boats(
    shared_data: Path, number: int, continuity: tuple[float, float], rmse_m: tuple[float, float]
) -> None:
    scene = boat_scene(shared_data / "autoferry", number)
    assert turn_length_s(scene.plots, 9.0) == pytest.approx(1.68, abs=0.02)
    reports = track_plots(scene.plots, reference="true", radar=harbour_radar(), model="short_range")
    for key, least, most_m in zip((1, 2), continuity, rmse_m, strict=True):
        found = boat_figures(scene, reports, key)
        assert found.continuity >= least, (key, found)
        assert found.purity >= 0.95, (key, found)
        assert found.rmse_m <= most_m, (key, found)


def solved(records: tuple[Record, ...], track: TruthTrack, every: int) -> tuple[int, np.ndarray]:
    """Return how many scans were solved alone, and the errors of those accepted [m]."""
    answers = [with_truth(pipeline.answer(epoch), track) for epoch in epochs(records, every=every)]
    return len(answers), np.array([a.truth.error_m for a in answers if a.fix is not None and a.truth is not None])


@pytest.mark.parametrize(("name", "every", "least"), [("marce_01_004", 6, 0), ("marce_01_010", 20, 2)])
def test_raw_plots_of_a_sea_trial_give_no_wrong_fix(shared_data: Path, name: str, every: int, least: int) -> None:
    folder = shared_data / "marce"
    log = read_log(folder / f"{name}.nmea", report=False)
    found = read_plots(folder / f"{name}_plots.csv")
    assert (found.reference, found.bad_rows) == ("true", ())
    with (folder / f"{name}_truth.csv").open() as lines:
        track = TruthTrack.parse(lines)
    # The compass that turned these bearings is 3 to 4 deg off: taken as relative, that is only a heading.
    reports = track_plots(found.plots, reference="relative")
    scans, errors_m = solved(tuple(with_tracked_plots(log.records, reports)), track, every)
    assert scans >= 20
    assert len(errors_m) >= least
    assert (errors_m < 250.0).all()
