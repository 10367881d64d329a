"""``navfix compare``: the robust fix beside least squares, plain mean and mean after rejection, in one table."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING, Any

from navfix.cli import inputs, options, outputs, solving
from navfix.cli.errors import OK

if TYPE_CHECKING:
    from navfix.comparison import Row
    from navfix.report.answer import Truth
    from navfix.types import Epoch

SUFFIXES = (".txt", ".json", ".csv")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command to the parser."""
    parser = subparsers.add_parser(
        "compare", help="robust fix beside least squares and the plain mean, for one radar scan", description=__doc__
    )
    options.add_one_scan(parser, SUFFIXES)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Associate once, fix by every method, print the table."""
    from navfix.association import associate
    from navfix.comparison import compare

    track, charted = inputs.truth_track(args), inputs.charted_marks(args)
    log = inputs.read(args.log, charted=bool(charted))
    epoch = solving.one_epoch(log, args, charted)
    radar = options.radar(args)
    truth = track.at(epoch.time_utc.timestamp()) if track and epoch.time_utc else None
    by_hand = solving.pairs_by_hand(epoch, args)
    association = by_hand or associate(epoch, radar=radar, method=solving.method(args), prove=args.prove)
    place = truth.position if truth else None
    rows = compare(epoch, association, radar=radar, kernel=args.kernel, truth=place)
    text, as_json = table(rows, epoch, len(association.pairs)), to_json(rows, epoch, truth)
    print(as_json if args.json else text)
    if track is not None and truth is None:
        print(f"navfix: {args.truth}: nothing about the time of this scan: no error can be told", file=sys.stderr)
    outputs.write_outputs(
        args.out, {".txt": lambda: text + "\n", ".json": lambda: as_json + "\n", ".csv": lambda: to_csv(rows)}
    )
    return OK


def table(rows: tuple[Row, ...], epoch: Epoch, pairs: int) -> str:
    """Return the comparison as text, at most 100 columns."""
    from navfix.report.words import place, utc

    with_truth = any(row.error_m is not None for row in rows)
    lines = [
        f"COMPARISON  {utc(epoch.time_utc)}  {pairs} pairs",
        "",
        f"{'method':<26}{'position':<28}{'off robust m':>13}{'95 % ellipse m':>16}"
        + ("   error m" if with_truth else ""),
    ]
    for row in rows:
        if row.position is None:
            lines.append(f"{row.method:<26}none: {row.reason}"[:100])
            continue
        ellipse = "" if row.ellipse is None else f"{row.ellipse.semi_major_m:.0f} x {row.ellipse.semi_minor_m:.0f}"
        line = f"{row.method:<26}{place(row.position):<28}{row.from_robust_m:>13.1f}{ellipse:>16}"
        lines.append(line + (f"{row.error_m:>10.1f}" if row.error_m is not None else ""))
    lines += ["", "The ellipse of a mean is the spread of its single places, as its source draws it."]
    return "\n".join(lines)


def to_json(rows: tuple[Row, ...], epoch: Epoch, truth: Truth | None) -> str:
    """Return the comparison as one JSON object (``navfix.compare/1``)."""
    from navfix.report.numbers import iso_utc, plain

    def as_dict(row: Row) -> dict[str, Any]:
        ellipse = row.ellipse
        return {
            "method": row.method,
            "position": row.position
            and {"lat_deg": plain(row.position.lat_deg, 8), "lon_deg": plain(row.position.lon_deg, 8)},
            "from_robust_m": plain(row.from_robust_m, 3),
            "ellipse": ellipse
            and {
                "probability": ellipse.probability,
                "semi_major_m": plain(ellipse.semi_major_m, 3),
                "semi_minor_m": plain(ellipse.semi_minor_m, 3),
                "azimuth_deg": plain(ellipse.azimuth_deg, 3),
            },
            "error_m": plain(row.error_m, 3),
            "reason": row.reason,
        }

    return json.dumps(
        {
            "schema": "navfix.compare/1",
            "time_utc": iso_utc(epoch.time_utc),
            "truth": truth and {"lat_deg": truth.position.lat_deg, "lon_deg": truth.position.lon_deg},
            "methods": [as_dict(row) for row in rows],
        }
    )


def to_csv(rows: tuple[Row, ...]) -> str:
    """Return the comparison as CSV."""
    lines = ["method,lat_deg,lon_deg,from_robust_m,semi_major_95_m,semi_minor_95_m,error_m"]
    for row in rows:
        place = ("", "") if row.position is None else (f"{row.position.lat_deg:.8f}", f"{row.position.lon_deg:.8f}")
        axes = (
            ("", "") if row.ellipse is None else (f"{row.ellipse.semi_major_m:.2f}", f"{row.ellipse.semi_minor_m:.2f}")
        )
        numbers = ["" if value is None else f"{value:.2f}" for value in (row.from_robust_m, row.error_m)]
        lines.append(",".join([f'"{row.method}"', *place, numbers[0], *axes, numbers[1]]))
    return "\n".join(lines) + "\n"
