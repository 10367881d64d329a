"""``navfix simulate``: a seeded scenario as an NMEA log, with own ship's truth and the true association beside it."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from navfix.cli import outputs, values
from navfix.cli.errors import OK, UNREADABLE, CommandError

if TYPE_CHECKING:
    from navfix.simulation.scenario import Recording

_DEFAULT = "approach"
SUFFIXES = (".nmea",)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser("simulate", help="a seeded scenario: NMEA log and truth", description=__doc__)
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        nargs="?",
        default=_DEFAULT,
        help=f"a shipped scenario (--list) or a TOML file (default: {_DEFAULT})",
    )
    parser.add_argument("--list", action="store_true", help="list the shipped scenarios")
    parser.add_argument(
        "--seed", metavar="N", type=_seed, default=1, help="the same seed gives the same log (default: 1)"
    )
    parser.add_argument("--duration", metavar="S", type=values.positive, help="length [s], replaces the scenario's")
    parser.add_argument(
        "--out",
        metavar="NAME.nmea",
        action="append",
        default=[],
        type=partial(outputs.output_file, suffixes=SUFFIXES),
        help="write the log to NAME.nmea, NAME_truth.csv and NAME_assoc.csv beside it (default: the log on stdout)",
    )
    for name, what in (
        ("truth", "own ship's truth"),
        ("assoc", "which target is which MMSI"),
        ("chart", "the aids to navigation as a chart"),
    ):
        parser.add_argument(
            f"--{name}-out",
            metavar="CSV",
            type=partial(outputs.output_file, suffixes=(".csv",)),
            help=f"write {what} to this file (needs --out)",
        )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Simulate, and write the files or print the log."""
    if args.list:
        print(listing())
        return OK
    _check_outputs(args)
    path = Path(args.scenario)
    if path.suffix == ".toml" and not path.is_file():
        raise CommandError(f"{path}: no such file", UNREADABLE)
    from navfix.simulation import files, scenario

    if args.duration is not None and args.duration > scenario.MAXIMUM_DURATION_S:
        raise CommandError(f"--duration: at most {scenario.MAXIMUM_DURATION_S:g} s, got {args.duration:g}")
    recording = scenario.simulate(scenario.load(args.scenario), args.seed, duration_s=args.duration)
    if not args.out:
        sys.stdout.write(files.log_text(recording))
        return OK
    try:
        paths = files.write_files(recording, args.out[0], args.truth_out, args.assoc_out)
        if args.chart_out is not None:
            args.chart_out.write_text(files.chart_csv(recording), encoding="ascii", newline="\n")
            paths.append(args.chart_out)
    except OSError as error:
        raise CommandError(f"{error.filename}: cannot be written: {error.strerror}") from error
    print(summary(recording, paths))
    return OK


def listing() -> str:
    """Return the shipped scenarios, one a line."""
    from navfix.simulation import scenario

    return "\n".join(f"{name:<16} {scenario.load(name).title}" for name in scenario.names())


def summary(recording: Recording, paths: list[Path]) -> str:
    """Return what was written and what is in it."""
    kinds = Counter(line.rsplit("\\", 1)[-1][1:].split(",", 1)[0] for line in recording.lines)
    targets = {row.target_number for row in recording.association}
    return "\n".join(
        [
            f"{recording.scenario.title}, seed {recording.seed}, {recording.scenario.duration_s:g} s",
            f"{len(recording.lines)} lines: {', '.join(f'{n} {kind}' for kind, n in sorted(kinds.items()))}",
            f"{len(targets)} target numbers, {len(recording.wrong)} stations with a wrong position",
            *(f"wrote {path}" for path in paths),
        ]
    )


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be a whole number >= 0, got {text!r}")
    return int(text)


def _check_outputs(args: argparse.Namespace) -> None:
    """Refuse outputs without a log, several logs, one file for two purposes, and the scenario file itself."""
    if len(args.out) > 1:
        raise CommandError(f"simulate writes one log, got {len(args.out)} times --out")
    if not args.out:
        if args.truth_out or args.assoc_out or args.chart_out:
            raise CommandError("--truth-out, --assoc-out and --chart-out need --out FILE.nmea")
        return
    from navfix.simulation.files import companions

    paths = companions(args.out[0], args.truth_out, args.assoc_out)
    paths += [args.chart_out] if args.chart_out else []
    scenario = Path(args.scenario).resolve()
    for index, path in enumerate(paths):
        if path.resolve() == scenario:
            raise CommandError(f"{path} is the scenario file; an input is never overwritten")
        if path.resolve() in {other.resolve() for other in paths[:index]}:
            raise CommandError(f"{path} is named for two of log, truth, association and chart")
