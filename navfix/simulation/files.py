"""A recording as files: the NMEA log, own ship's truth (CSV) and the association (CSV), as other programs read them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from navfix.errors import InputError
from navfix.nmea.write import angle
from navfix.simulation.scenario import Recording
from navfix.units import KNOT_MPS

TRUTH_HEADER = "unix,lat,lon,heading_deg,sog_kn,cog_deg,radar_zero_deg"
CHART_HEADER = "lat,lon,kind,type,sigma_m,name,mmsi"
CHART_SIGMA_M = 8.0  # of a buoy about its charted place, per axis
ASSOCIATION_HEADER = "unix,target_no,mmsi"


def log_text(recording: Recording) -> str:
    """Return the log, one sentence with its TAG block a line."""
    return "".join(f"{line}\n" for line in recording.lines)


def truth_csv(recording: Recording) -> str:
    """Return own ship's truth at 1 Hz: ``unix,lat,lon,heading_deg,sog_kn,cog_deg`` and the radar's zero mark."""
    rows = (
        f"{row.unix_s:.1f},{row.lat_deg:.8f},{row.lon_deg:.8f},{angle(row.heading_deg, 2)},"
        f"{row.speed_mps / KNOT_MPS:.2f},{angle(row.course_deg, 2)},{angle(row.radar_zero_deg, 2)}\n"
        for row in recording.truth
    )
    return f"{TRUTH_HEADER}\n{''.join(rows)}"


def association_csv(recording: Recording) -> str:
    """Return which target number is which MMSI at which time of the radar's clock (0: no AIS, or nothing)."""
    rows = (f"{row.unix_s:.2f},{row.target_number},{row.mmsi}\n" for row in recording.association)
    return f"{ASSOCIATION_HEADER}\n{''.join(rows)}"


def chart_csv(recording: Recording) -> str:
    """Return the aids of the world as a chart (CSV): each buoy floats a little off its charted place, on its chain."""
    world = recording.scenario.world(recording.seed)
    rng = np.random.default_rng([recording.seed, len("chart")])
    rows = []
    for body in world.bodies:
        if body.kind != "aton":
            continue
        swing_north_m, swing_east_m = rng.normal(0.0, CHART_SIGMA_M, 2)
        lat, lon = world.stage.places(body.motion.north_m - swing_north_m, body.motion.east_m - swing_east_m)
        kind = "BOYSPP" if body.aid_type == 30 else "BOYLAT"
        rows.append(f"{float(lat):.6f},{float(lon):.6f},floating,{kind},{CHART_SIGMA_M:g},{body.name},{body.mmsi}\n")
    return f"{CHART_HEADER}\n{''.join(rows)}"


def companions(log: Path, truth: Path | None = None, association: Path | None = None) -> list[Path]:
    """Return the paths of log, truth and association: ``x.nmea``, ``x_truth.csv``, ``x_assoc.csv`` unless told."""
    beside = [
        given or log.with_name(f"{log.stem}_{end}.csv") for given, end in ((truth, "truth"), (association, "assoc"))
    ]
    return [log, *beside]


def write_files(
    recording: Recording, log: Path, truth: Path | None = None, association: Path | None = None
) -> list[Path]:
    """Write log, truth and association (beside the log unless told) and return their paths.

    Raises
    ------
    InputError : two of the files are the same
    OSError : a file cannot be written
    """
    paths = companions(log, truth, association)
    if len({path.resolve() for path in paths}) < len(paths):
        raise InputError(f"log, truth and association need three files, got {', '.join(map(str, paths))}")
    texts = (log_text(recording), truth_csv(recording), association_csv(recording))
    for path, text in zip(paths, texts, strict=True):
        path.write_text(text, encoding="ascii", newline="\n")
    return paths
