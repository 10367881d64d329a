"""The options that commands share, each written once, and what they mean to the library.

Every ``add_...`` takes a parser; every other function takes the parsed arguments. Nothing here imports numpy before a
command runs: ``navfix --help`` stays quick.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from navfix.cli import outputs, values
from navfix.cli.errors import CommandError

if TYPE_CHECKING:
    from navfix.catalog import RadarModel
    from navfix.kernels import Kernel

KERNELS = "none, huber, hampel, danish, tukey, igg3, gnc"


# ------------------------------------------------------------------------------------------------ groups of options


def add_log(parser: argparse.ArgumentParser) -> None:
    """Add LOG: a file of NMEA sentences, or "-" for standard input."""
    parser.add_argument("log", metavar="LOG", help="NMEA log with radar targets (TTM) and AIS (VDM); - reads stdin")


def add_estimation(parser: argparse.ArgumentParser) -> None:
    """Add --kernel, --radar, --range-sigma, --bearing-sigma."""
    group = parser.add_argument_group("estimation")
    add_kernel(group)
    group.add_argument("--radar", metavar="NAME", default="imo", help="radar model of the catalogue (default: imo)")
    group.add_argument(
        "--range-sigma", metavar="M", type=values.positive, help="1 sigma of a radar range [m], replaces the model's"
    )
    group.add_argument(
        "--bearing-sigma",
        metavar="DEG",
        type=values.positive,
        help="1 sigma of a radar bearing [deg], replaces the model's",
    )
    _add_mounting(parser)


def _add_mounting(parser: argparse.ArgumentParser) -> None:
    """Add --compass-sigma, --radar-antenna, --gnss-antenna, --alignment: how the instruments stand on the ship."""
    group = parser.add_argument_group("installation")
    group.add_argument(
        "--compass-sigma",
        metavar="DEG",
        type=values.not_negative,
        help="1 sigma of the error common to all true bearings [deg]; 0 holds it at zero (default: 1.5)",
    )
    for name, antenna in (("radar", "radar antenna"), ("gnss", "antenna of own GNSS")):
        group.add_argument(
            f"--{name}-antenna",
            metavar="F,S",
            type=values.two_numbers,
            help=f"{antenna} forward,starboard of the ship's reference point [m] (aft: --{name}-antenna=-12,3)",
        )
    group.add_argument(
        "--alignment",
        metavar="DEG,SIGMA",
        type=values.two_numbers,
        help="direction of the radar's zero mark from the bow, clockwise, and its 1 sigma [deg]; "
        "the heading is then the bow's",
    )


def add_kernel(parser: argparse._ActionsContainer) -> None:
    """Add --kernel."""
    parser.add_argument(
        "--kernel",
        metavar="KERNEL",
        default="hampel",
        help=f"how outliers are damped: {KERNELS}, or a TOML file (default: hampel)",
    )


def add_one_scan(parser: argparse.ArgumentParser, suffixes: Sequence[str] = outputs.OUT_SUFFIXES) -> None:
    """Add LOG and all options of a command that solves one radar scan of it; it can write ``suffixes``."""
    add_log(parser)
    add_at(parser)
    add_estimation(parser)
    add_association(parser)
    add_evidence(parser)
    add_truth(parser)
    add_output(parser, suffixes)


def add_evidence(parser: argparse.ArgumentParser) -> None:
    """Add --chart, --chart-land, --choice, --heading-from, --no-prior: what may be used beside radar and AIS."""
    group = parser.add_argument_group("evidence")
    group.add_argument(
        "--chart",
        metavar="FILE",
        action="append",
        default=[],
        type=Path,
        help="chart with more marks: .csv, .geojson, or an S-57 cell .000 (repeatable)",
    )
    group.add_argument("--chart-land", action="store_true", help="also conspicuous charted objects ashore")
    group.add_argument(
        "--choice",
        choices=("all", "source"),
        default="all",
        help="use all data (default), or those that the decision table of the source picks",
    )
    group.add_argument(
        "--heading-from",
        choices=("auto", "none", "gyro"),
        default="auto",
        help="whether a heading in the log is used (default: auto)",
    )
    group.add_argument("--no-prior", action="store_true", help="ignore the hints in the log: cold start")


def add_association(parser: argparse.ArgumentParser) -> None:
    """Add --pairs, --method, --accept, --prove: which target is which mark."""
    group = parser.add_argument_group("association")
    group.add_argument(
        "--pairs",
        metavar="T=M,...",
        type=values.pairs,
        help="pairs by hand: target=mark by number, label, MMSI or name",
    )
    group.add_argument("--method", metavar="NAME", default="seeded", help="seeded (default), or cpd: the plain one")
    group.add_argument(
        "--accept",
        metavar="P",
        type=values.positive,
        help="accept an answer that is wrong with at most P (default: 0.001)",
    )
    group.add_argument("--prove", action="store_true", help="exclude every other place by an exhaustive search")


def add_at(parser: argparse.ArgumentParser) -> None:
    """Add --at."""
    parser.add_argument(
        "--at",
        metavar="ISO8601",
        type=values.instant,
        help="solve the radar scan of this time (default: the last complete one)",
    )


def add_window(parser: argparse.ArgumentParser, *, default: str = "one scan alone") -> None:
    """Add --window; ``default`` says in words what is solved without it."""
    parser.add_argument(
        "--window",
        metavar="S",
        type=values.positive,
        help=f"join the scans of so many seconds into one answer (default: {default})",
    )


def add_independent(parser: argparse.ArgumentParser) -> None:
    """Add --independent."""
    parser.add_argument("--independent", action="store_true", help="solve every scan or window alone")


def add_truth(parser: argparse.ArgumentParser) -> None:
    """Add --truth."""
    parser.add_argument(
        "--truth", metavar="CSV", type=Path, help="true track (unix,lat,lon,heading_deg): adds the error of each fix"
    )


def add_plots(parser: argparse.ArgumentParser) -> None:
    """Add --plots, --plots-reference: raw echoes in place of the targets of the log."""
    group = parser.add_argument_group("radar plots")
    group.add_argument(
        "--plots",
        metavar="CSV",
        type=Path,
        help="raw radar plots (time, range, bearing) beside LOG; tracked, in place of the targets of LOG",
    )
    group.add_argument(
        "--plots-reference",
        choices=("relative", "true"),
        help="what their bearings count from (default: as the header says, else relative)",
    )
    group.add_argument(
        "--tracking", metavar="NAME", help="tracking model of the catalogue: plots (default), short_range for boats"
    )


def add_outlines(parser: argparse.ArgumentParser) -> None:
    """Add --outlines."""
    parser.add_argument("--outlines", metavar="FILE", type=Path, help="echo outlines beside the log, JSON lines")


def add_out(parser: argparse.ArgumentParser, suffixes: Sequence[str] = outputs.OUT_SUFFIXES) -> None:
    """Add --out for the formats that the command can write."""
    parser.add_argument(
        "--out",
        metavar="FILE",
        action="append",
        default=[],
        type=partial(outputs.output_file, suffixes=suffixes),
        help=f"also write FILE (repeatable); the suffix chooses the format: {' '.join(suffixes)}",
    )


def add_output(parser: argparse.ArgumentParser, suffixes: Sequence[str] = outputs.OUT_SUFFIXES) -> None:
    """Add --json and --out for the formats that the command can write."""
    parser.add_argument("--json", action="store_true", help="print JSON in place of the text")
    add_out(parser, suffixes)


# ------------------------------------------------------------------------------------- what the arguments stand for


def radar(args: argparse.Namespace) -> RadarModel:
    """Return the radar model that --radar names, with --range-sigma and --bearing-sigma in place of its own.

    Raises
    ------
    CatalogError : no radar model has this name
    """
    from dataclasses import replace

    from navfix.catalog import radar_model

    model = radar_model(args.radar)
    if args.range_sigma is not None:
        model = replace(model, range_sigma_m=args.range_sigma, range_sigma_fraction=0.0)
    if args.bearing_sigma is not None:
        model = replace(model, bearing_sigma_deg=args.bearing_sigma)
    return _mounted(model, args)


def _mounted(model: RadarModel, args: argparse.Namespace) -> RadarModel:
    """Return the radar as --compass-sigma, --radar-antenna and --alignment say that it is mounted.

    Raises
    ------
    CommandError : an alignment with a negative sigma
    """
    from dataclasses import replace

    if args.compass_sigma is not None:
        model = replace(model, compass_sigma_deg=args.compass_sigma)
    if args.radar_antenna is not None:
        forward_m, starboard_m = args.radar_antenna
        model = replace(model, antenna_forward_m=forward_m, antenna_starboard_m=starboard_m)
    if args.alignment is not None:
        offset_deg, sigma_deg = args.alignment
        if sigma_deg < 0.0:
            raise CommandError(f"--alignment: its sigma must be >= 0, got {sigma_deg:g}")
        model = replace(model, alignment_deg=offset_deg, alignment_sigma_deg=sigma_deg)
    return model


def kernel(args: argparse.Namespace) -> Kernel:
    """Return the kernel that --kernel names: one of the catalogue, or a TOML file.

    Raises
    ------
    CatalogError : no kernel has this name, or the file is no kernel
    """
    from navfix import catalog

    return catalog.kernel(args.kernel)
