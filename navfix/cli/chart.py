"""``navfix chart``: the marks that radar may see in chart files: CSV, GeoJSON, S-57 cells with their updates."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from navfix.cli import options, outputs
from navfix.cli.errors import OK

SUFFIXES = (".txt", ".json", ".csv", ".geojson")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser("chart", help="the marks found in chart files", description=__doc__)
    parser.add_argument("chart", metavar="FILE", nargs="+", type=Path, help=".csv, .geojson or an S-57 cell .000")
    parser.add_argument(
        "--near",
        metavar="LAT,LON,RADIUS",
        type=_near,
        help="only the marks within RADIUS of a place, the nearest first; RADIUS in nautical miles, or in metres with "
        "an m: 54.2,7.5,6 or 54.2,7.5,800m (south: --near=-33.9,18.4,6)",
    )
    parser.add_argument("--land", action="store_true", help="also conspicuous objects ashore")
    options.add_output(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Read the files, print the list, write it."""
    from navfix.chart import read_charts
    from navfix.report import chart_list
    from navfix.types import Position

    chart = read_charts(args.chart)
    near, radius_m = None, 0.0
    if args.near is not None:
        lat_deg, lon_deg, radius_m = args.near
        near = Position(lat_deg, lon_deg)
    rows = chart_list.listed(chart, land=args.land, near=near, radius_m=radius_m)
    text, as_json = chart_list.chart_text(chart, rows), chart_list.chart_json(chart, rows)
    print(as_json if args.json else text)
    outputs.write_outputs(
        args.out,
        {
            ".txt": lambda: text + "\n",
            ".json": lambda: as_json + "\n",
            ".csv": lambda: chart_list.chart_csv(rows),
            ".geojson": lambda: chart_list.chart_geojson(rows),
        },
    )
    return OK


def _near(text: str) -> tuple[float, float, float]:
    """Return latitude, longitude [deg] and radius [m] of a text like 54.2,7.5,6 (NM) or 54.2,7.5,800m."""
    from navfix.units import NM_M

    parts = [part.strip().lower() for part in text.split(",")]
    wrong = argparse.ArgumentTypeError(f"must be like 54.2,7.5,6 (NM) or 54.2,7.5,800m, got {text!r}")
    if len(parts) != 3:
        raise wrong
    unit = next((unit for unit in ("nm", "m") if parts[2].endswith(unit)), "nm")
    try:
        lat_deg, lon_deg, radius = float(parts[0]), float(parts[1]), float(parts[2].removesuffix(unit))
    except ValueError:
        raise wrong from None
    if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 360.0 and math.isfinite(radius) and radius > 0.0):
        raise wrong
    return lat_deg, lon_deg, radius * (NM_M if unit == "nm" else 1.0)
