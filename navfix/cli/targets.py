"""``navfix targets``: radar targets and AIS ships of one instant, fused where they are the same ship."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from navfix.cli import inputs, options, outputs, solving, values
from navfix.cli.errors import NO_FIX, OK, CommandError, one_line

if TYPE_CHECKING:
    from navfix.nmea import Log
    from navfix.types import Epoch, Mark, TargetList

LEAST_GREY_S = 20.0
SUFFIXES = (".txt", ".json", ".csv", ".geojson")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser(
        "targets", help="fused list of radar targets and AIS ships of one instant", description=__doc__
    )
    options.add_log(parser)
    options.add_at(parser)
    parser.add_argument("--find", metavar="KEY", help="only the ships with this target number, MMSI or part of a name")
    parser.add_argument(
        "--filter",
        metavar="S",
        type=values.not_negative,
        default=60.0,
        help="seconds before it that each sensor is filtered over; 0: the scan alone (default: 60)",
    )
    parser.add_argument(
        "--pairing",
        choices=("fix", "grey"),
        default="fix",
        help="which target is which ship: the pairs of the fix (default), or the grey relation of the tracks over "
        "--filter seconds about own places that are fixed meanwhile: the source's method, for comparison",
    )
    options.add_estimation(parser)
    options.add_evidence(parser)
    options.add_outlines(parser)
    options.add_output(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Fuse, print the list, write the files."""
    from navfix import pipeline
    from navfix.report.targets import WRITERS

    charted = inputs.charted_marks(args)
    log = inputs.read(args.log, charted=bool(charted))
    newest = solving.one_epoch(log, args, charted)
    if args.pairing == "grey" and args.filter < LEAST_GREY_S:
        raise CommandError(f"--pairing grey compares tracks: --filter must be {LEAST_GREY_S:.0f} s at least")
    history = _history(log, newest, args, charted)
    ships = pipeline.targets(history, radar=options.radar(args), kernel=args.kernel, pairing=args.pairing)
    shown = ships if args.find is None else _found(ships, args.find)
    print(WRITERS[".json" if args.json else ".txt"](shown).rstrip("\n"))
    outputs.write_outputs(args.out, {suffix: partial(WRITERS[suffix], shown) for suffix in SUFFIXES})
    if ships.own_position is None:
        print(f"navfix: no fix ({ships.reason}), nothing fused: {one_line(Exception(ships.message))}", file=sys.stderr)
        return NO_FIX
    return OK


def _history(log: Log, newest: Epoch, args: argparse.Namespace, charted: Sequence[Mark]) -> Iterator[Epoch]:
    """Yield the epochs that each sensor is filtered over, the one that was asked for at the end."""
    from navfix.picture import Picture
    from navfix.picture.sensor_tracks import recent_epochs

    if newest.time_utc is not None and args.filter > 0.0:
        outlines, until_s = inputs.outlines(args), newest.time_utc.timestamp()
        picture = Picture(radar=options.radar(args), charted=charted)
        for epoch in recent_epochs(log.records, picture, until_s=until_s, seconds=args.filter):
            if epoch.time_utc is not None and epoch.time_utc < newest.time_utc:
                yield solving.outlined(epoch, outlines)
    yield newest


def _found(ships: TargetList, key: str) -> TargetList:
    """Return the list with what --find asks for.

    Raises
    ------
    CommandError : nothing answers to the key
    """
    from navfix.picture.board import TargetBoard

    board = TargetBoard()
    board.update(ships)
    found = board.find(key)
    if not found:
        raise CommandError(f"--find {key}: no target, MMSI or name like this among {len(ships.ships)} ships")
    return replace(ships, ships=found)
