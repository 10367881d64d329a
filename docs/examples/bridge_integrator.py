"""A bridge integrator's program: sentences in as they come, a line out for some radar turns: fix or no fix, verdict.

Run it on a log, or let a serial line or a socket feed it:

    python bridge_integrator.py LOG        # or: nc -u -l 10110 | python bridge_integrator.py -
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from navfix.nmea import Reader
from navfix.picture import Picture
from navfix.pipeline import answer

EVERY = 10  # solve one radar turn in so many


def bridge(lines: Iterable[bytes]) -> Iterator[str]:
    """Turn sentences into one line of text for each radar turn that is solved."""
    reader, picture = Reader(), Picture(radar="imo")
    scans = 0
    for line in lines:
        for record in reader.feed(line):
            scan = picture.feed(record)
            if scan is None:
                continue
            scans += 1
            if scans % EVERY == 0:
                yield one_line(answer(picture.epoch(scan)))
    for problem in reader.problems:
        print(f"unreadable: {problem}", file=sys.stderr)


def one_line(result) -> str:
    """Say what the officer of the watch needs: where, how sure, and whether the GNSS may be believed."""
    when = f"{result.time_utc:%H:%M:%S}"
    if result.fix is None:
        return f"{when} NO FIX  {result.error.reason}: {result.error}"
    fix, ellipse = result.fix, result.fix.ellipse(0.95)
    gnss = (
        "no GNSS to check" if result.gnss is None else f"GNSS {result.gnss.verdict}, {result.gnss.distance_m:.0f} m off"
    )
    return (
        f"{when} FIX  {fix.position.lat_deg:.5f} {fix.position.lon_deg:.5f}  heading {fix.heading_deg:05.1f}  "
        f"95 % within {ellipse.semi_major_m:.0f} x {ellipse.semi_minor_m:.0f} m  {gnss}"
    )


if __name__ == "__main__":
    from_pipe = sys.argv[1:] in ([], ["-"])
    with sys.stdin.buffer if from_pipe else Path(sys.argv[1]).open("rb") as source:
        for text in bridge(source):
            print(text, flush=True)
