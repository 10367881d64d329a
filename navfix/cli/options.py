"""The options that commands share, each written once, and what they mean to the library.

Every ``add_...`` takes a parser; every other function takes the parsed arguments. Nothing here imports numpy before a
command runs: ``navfix --help`` stays quick.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from navfix.cli.errors import CommandError

if TYPE_CHECKING:
    from navfix.catalog import RadarModel
    from navfix.kernels import Kernel

STDIN = "-"
OUT_SUFFIXES = (".txt", ".json", ".svg", ".geojson", ".html", ".nmea", ".gpx", ".csv")
KERNELS = "none, huber, hampel, danish, tukey, igg3, gnc"
_INPUTS = ("log", "case", "truth", "chart", "outlines", "kernel", "plots")


# ------------------------------------------------------------------------------------------------ values of options


def positive(text: str) -> float:
    """Return a finite number > 0."""
    number = _number(text)
    if not number > 0.0:
        raise argparse.ArgumentTypeError(f"must be > 0, got {text}")
    return number


def not_negative(text: str) -> float:
    """Return a finite number >= 0."""
    number = _number(text)
    if number < 0.0:
        raise argparse.ArgumentTypeError(f"must be >= 0, got {text}")
    return number


def two_numbers(text: str) -> tuple[float, float]:
    """Return two finite numbers separated by a comma."""
    parts = text.split(",")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"must be two numbers like 12.5,-3, got {text!r}")
    return _number(parts[0]), _number(parts[1])


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number, got {text!r}") from None
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"must be finite, got {text}")
    return number


def pairs(text: str) -> tuple[tuple[str, str], ...]:
    """Return ("target", "mark") pairs of a text like "03=AtoN 7,05=211234560"."""
    found = tuple(tuple(side.strip() for side in part.partition("=")[::2]) for part in text.split(","))
    if not all(target and mark for target, mark in found):
        raise argparse.ArgumentTypeError(f"must be like 03=AtoN7,05=211234560, got {text!r}")
    return tuple((target, mark) for target, mark in found)


def instant(text: str) -> datetime:
    """Return an ISO 8601 time as aware UTC; a time without a zone is UTC."""
    try:
        time = datetime.fromisoformat(text)
        return time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
    except (ValueError, OverflowError):  # overflow: a zone that leads out of the years 1 .. 9999
        raise argparse.ArgumentTypeError(f"must be a time like 2026-01-01T12:00:00Z, got {text!r}") from None


def output_file(text: str, suffixes: Sequence[str] = OUT_SUFFIXES) -> Path:
    """Return a path to write to: a suffix that the command can write, in a folder that exists."""
    path = Path(text)
    if path.suffix.lower() not in suffixes:
        raise argparse.ArgumentTypeError(
            f"{text}: the suffix chooses the format; here it is one of {' '.join(suffixes)}"
        )
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: is a directory")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: there is no folder {path.parent}")
    return path


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
        "--range-sigma", metavar="M", type=positive, help="1 sigma of a radar range [m], replaces the model's"
    )
    group.add_argument(
        "--bearing-sigma", metavar="DEG", type=positive, help="1 sigma of a radar bearing [deg], replaces the model's"
    )
    _add_mounting(parser)


def _add_mounting(parser: argparse.ArgumentParser) -> None:
    """Add --compass-sigma, --radar-antenna, --gnss-antenna, --alignment: how the instruments stand on the ship."""
    group = parser.add_argument_group("installation")
    group.add_argument(
        "--compass-sigma",
        metavar="DEG",
        type=not_negative,
        help="1 sigma of the error common to all true bearings [deg]; 0 holds it at zero (default: 1.5)",
    )
    for name, antenna in (("radar", "radar antenna"), ("gnss", "antenna of own GNSS")):
        group.add_argument(
            f"--{name}-antenna",
            metavar="F,S",
            type=two_numbers,
            help=f"{antenna} forward,starboard of the ship's reference point [m] (aft: --{name}-antenna=-12,3)",
        )
    group.add_argument(
        "--alignment",
        metavar="DEG,SIGMA",
        type=two_numbers,
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


def add_one_scan(parser: argparse.ArgumentParser, suffixes: Sequence[str] = OUT_SUFFIXES) -> None:
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
        "--pairs", metavar="T=M,...", type=pairs, help="pairs by hand: target=mark by number, label, MMSI or name"
    )
    group.add_argument("--method", metavar="NAME", default="seeded", help="seeded (default), or cpd: the plain one")
    group.add_argument(
        "--accept", metavar="P", type=positive, help="accept an answer that is wrong with at most P (default: 0.001)"
    )
    group.add_argument("--prove", action="store_true", help="exclude every other place by an exhaustive search")


def add_at(parser: argparse.ArgumentParser) -> None:
    """Add --at."""
    parser.add_argument(
        "--at",
        metavar="ISO8601",
        type=instant,
        help="solve the radar scan of this time (default: the last complete one)",
    )


def add_window(parser: argparse.ArgumentParser) -> None:
    """Add --window."""
    parser.add_argument(
        "--window", metavar="S", type=positive, help="join the scans of so many seconds into one answer"
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


def add_out(parser: argparse.ArgumentParser, suffixes: Sequence[str] = OUT_SUFFIXES) -> None:
    """Add --out for the formats that the command can write."""
    parser.add_argument(
        "--out",
        metavar="FILE",
        action="append",
        default=[],
        type=partial(output_file, suffixes=suffixes),
        help=f"also write FILE (repeatable); the suffix chooses the format: {' '.join(suffixes)}",
    )


def add_output(parser: argparse.ArgumentParser, suffixes: Sequence[str] = OUT_SUFFIXES) -> None:
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


def inputs(args: argparse.Namespace) -> Iterator[Path]:
    """Yield every file that the arguments name as input."""
    for name in _INPUTS:
        value = getattr(args, name, None)
        for item in value if isinstance(value, list) else [value]:
            if item not in (None, STDIN):
                yield Path(item)


def protect_inputs(args: argparse.Namespace) -> None:
    """Refuse an output that is one of the inputs (also through links or as standard input), or that is named twice.

    Raises
    ------
    CommandError : the same file is read and written, or written twice
    """
    read = list(inputs(args))
    written: list[Path] = []
    for out in getattr(args, "out", None) or ():
        if any(_same(out, path) for path in read) or (_reads_stdin(args) and _is_stdin(out)):
            raise CommandError(f"--out {out} is an input file; an input is never overwritten")
        if any(_same(out, path) for path in written):
            raise CommandError(f"--out {out} is named twice")
        written.append(out)


def _reads_stdin(args: argparse.Namespace) -> bool:
    case = getattr(args, "case", None) or ()
    return getattr(args, "log", None) == STDIN or STDIN in case


def _is_stdin(path: Path) -> bool:
    """Tell whether standard input comes from this file (``navfix fix - < LOG``)."""
    try:
        return path.exists() and os.path.samestat(path.stat(), os.fstat(sys.stdin.fileno()))
    except (OSError, ValueError, AttributeError):  # no such thing as a file behind standard input
        return False


def _same(one: Path, other: Path) -> bool:
    if one.exists() and other.exists():
        return one.samefile(other)
    return one.resolve() == other.resolve()


def write_outputs(paths: Sequence[Path], writers: Mapping[str, Callable[[], str]]) -> None:
    """Write each path with the writer of its suffix; a writer returns the whole text and runs only when asked for.

    Raises
    ------
    CommandError : no writer for a suffix (before anything is written), or a file cannot be written
    """
    for path in paths:
        if path.suffix.lower() not in writers:
            raise CommandError(f"--out {path}: this command cannot write {path.suffix}; it writes {' '.join(writers)}")
    for path in paths:
        text = writers[path.suffix.lower()]()
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise CommandError(f"--out {path}: cannot be written: {error.strerror}") from error
