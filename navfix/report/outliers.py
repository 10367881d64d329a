"""The sentences that name what does not fit: who, how far, in which direction."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from navfix.report import words
from navfix.report.entries import LISTED, about, in_metres, wrapped
from navfix.report.rows import PairRow
from navfix.types import Fix


def named_outliers(fix: Fix, rows: Sequence[PairRow]) -> Iterator[str]:
    """Yield a sentence for each outlier of a fix, the first of them if there are many."""
    outliers = [row for row in rows if row.outlier]
    if not outliers:
        return
    yield ""
    title = "SUSPECT: " if fix.kernel == "none" else "OUTLIER: "
    for row in outliers[: 2 * LISTED]:
        yield from wrapped(title + outlier_words(row), indent=len(title))
    if len(outliers) > 2 * LISTED:
        yield f"and {len(outliers) - 2 * LISTED} more, marked * in the table"


def outlier_words(row: PairRow) -> str:
    """Return a sentence that names an outlier: who, how far, in which direction."""
    mmsi = row.mark.mmsi if row.mark is not None else None
    who = f"{row.name} ({mmsi})" if mmsi is not None and row.name != str(mmsi) else row.name
    pair = f"target {row.target} / {who}" if row.target else who
    said = "charted" if row.mark is not None and row.mark.kind == "charted" else "AIS"
    if row.mark is None:
        said = "given"
    if not row.stands_off:
        return f"{pair}: left out or damped, its sightings contradict each other; their mean fits the {said} position"
    if row.offset_m is not None and row.offset_azimuth_deg is not None:
        metres = about(row.offset_m)
        return f"{pair}: {said} position about {metres} off along {words.direction(row.offset_azimuth_deg)}"
    if row.range is not None:
        side = "longer" if row.range.residual < 0.0 else "shorter"
        return f"{pair}: range {in_metres(abs(row.range.residual))} {side} than to the {said} position"
    assert row.bearing is not None
    side = "right" if row.bearing.residual < 0.0 else "left"
    return f"{pair}: bearing {abs(row.bearing.residual):.2f}° to the {side} of the {said} position"
