"""The report that a navigator reads: what is needed first stands first, the residuals below; 100 columns, no colour."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from scipy.special import stdtrit

from navfix.errors import NoFix
from navfix.geodesy import inverse
from navfix.report import words
from navfix.report.answer import Answer
from navfix.report.data_used import data_entries
from navfix.report.entries import LABEL, LISTED, entry, in_metres, wrapped
from navfix.report.other_positions import beside_lines, gnss_lines, three_positions
from navfix.report.outliers import named_outliers
from navfix.report.rows import pair_rows, unmatched_indices
from navfix.report.tables import printable, residual_table
from navfix.report.track_text import track_lines
from navfix.types import Alternative, Epoch, Fix, PlanePosition, Position, RadarTarget
from navfix.units import NM_M


def report_text(answer: Answer) -> str:
    """Return the whole report, at most 100 columns wide, ending in a line feed."""
    lines = fix_lines(answer, answer.fix) if answer.fix is not None else no_fix_lines(answer)
    return "\n".join(printable(line).rstrip() for line in lines) + "\n"


# ------------------------------------------------------------------------------------------------------------- a fix


def fix_lines(answer: Answer, fix: Fix) -> Iterator[str]:
    """Yield the lines of a report with a fix."""
    rows = pair_rows(fix)
    yield _title("FIX", answer, _counts(answer.epoch, len(rows)))
    yield ""
    yield from _pose(fix)
    yield from _cautions(answer)
    yield from _certainty(fix)
    yield from track_lines(answer.track)
    yield from _data(answer)
    yield from beside_lines(answer, fix)
    yield from named_outliers(fix, rows)
    yield ""
    yield from _quality(fix)
    yield ""
    yield from residual_table(rows, heading_known=fix.heading_deg is not None)
    yield from _unmatched(fix)
    yield from _notes(answer, fix)


def _pose(fix: Fix) -> Iterator[str]:
    yield from entry("Position", words.place(fix.position))
    if isinstance(fix.position, Position):
        yield from entry("", f"{fix.position.lat_deg:.8f}   {fix.position.lon_deg:.8f}")
    if fix.heading_deg is not None:
        yield from entry("Heading", f"{words.bearing(fix.heading_deg)}{_heading_spread(fix)}   {_reference(fix)}")
    ellipse = fix.ellipse(0.95)
    axis = ellipse.azimuth_deg % 180.0
    yield from entry(
        "Ellipse 95 %",
        f"{in_metres(ellipse.semi_major_m)} x {in_metres(ellipse.semi_minor_m)} (semi axes), "
        f"the longer along {words.direction(axis)} - {words.direction(axis + 180.0)}",
    )
    if fix.integrity is not None:
        level = fix.integrity.protection_level_m
        beyond = "" if level is None else f"   protection level {in_metres(level)}{_false_alarm(fix)}"
        yield from entry("R95", in_metres(fix.integrity.r95_m) + beyond)
        if level is None and fix.integrity.reason:
            yield from entry("", f"protection level not available: {fix.integrity.reason}")


def _cautions(answer: Answer) -> Iterator[str]:
    for caution in answer.cautions:
        yield from entry("CAUTION", caution)


def _data(answer: Answer) -> Iterator[str]:
    for label, text in data_entries(answer.epoch):
        yield from entry(label, text)


def _heading_spread(fix: Fix) -> str:
    if len(fix.covariance) < 3:
        return ""
    dof = fix.dof if fix.covariance_scaling == "a_posteriori" and math.isfinite(fix.dof) else None
    quantile = 1.959964 if dof is None else float(stdtrit(dof, 0.975))
    return f" +- {math.degrees(math.sqrt(fix.covariance[2, 2])) * quantile:.2f}° (95 %)"


def _reference(fix: Fix) -> str:
    return "of the bow" if fix.heading_reference == "bow" else "of the radar's zero mark"


def _false_alarm(fix: Fix) -> str:
    assert fix.integrity is not None
    alarm, missed = fix.integrity.probability_of_false_alarm, fix.integrity.probability_of_missed_detection
    if alarm is None or missed is None:
        return ""
    return f" (false alarm {alarm:.0e}, missed detection {missed:.0e})"


def _certainty(fix: Fix) -> Iterator[str]:
    found = fix.association
    others = (*(() if found is None else found.alternatives), *fix.alternatives)
    if found is not None and found.probability_wrong is not None:
        margin = (
            "" if found.margin is None else f" (evidence {found.evidence or 0.0:.1f}, {words.margin(found.margin)})"
        )
        odds = words.odds(found.probability_wrong)
        yield from entry("How sure", f"{odds} that this is another place{margin}")
    elif found is not None and found.method == "by_hand":
        yield from entry("How sure", "the pairs were given by hand: another place was not looked for")
    if others:
        yield from entry("Other places", "less likely, the best first:")
        yield from _alternatives(others, fix.position)
    if found is not None and found.second_group is not None:
        group = found.second_group
        yield from entry(
            "Second group",
            f"{words.plural(len(group.targets), 'target')} ({', '.join(group.targets)}) agree on AIS positions shifted "
            f"by {words.distance(group.offset_m)} along {words.direction(group.azimuth_deg)} from those of the fix: "
            "one of the two groups may be spoofed. If it is that of the fix, own ship lies as far off, the same way",
        )


def _quality(fix: Fix) -> Iterator[str]:
    scaling = "from the residuals" if fix.covariance_scaling == "a_posteriori" else "from the sigmas given"
    sigma0 = f"sigma0 {fix.sigma0:.3f}   redundancy {fix.redundancy}"
    yield from wrapped(f"{sigma0}   kernel {fix.kernel}   covariance {scaling}", indent=2)
    test = fix.global_test
    if test is not None:
        word = "passed" if test.passed else "FAILED: the sigmas are too small or errors remain"
        limit = f"limit {test.threshold:.1f} at {test.dof:.1f} degrees of freedom"
        yield from wrapped(f"global test: {test.statistic:.1f}, {limit}: {word}", indent=2)


def _unmatched(fix: Fix) -> Iterator[str]:
    if fix.epoch is None or fix.association is None:
        return
    alone = [fix.epoch.targets[index] for index in unmatched_indices(fix)]
    if alone:
        yield ""
        yield from _target_list(f"Targets without a mark ({len(alone)}):", alone)
    yield ""
    yield f"Marks without a target: {len(fix.epoch.marks) - len(fix.association.pairs)}"


def _target_list(title: str, targets: Sequence[RadarTarget]) -> Iterator[str]:
    """Yield the targets side by side; a line never breaks inside one of them."""
    tied = ", ".join(_target(target).replace(" ", "\u00a0") for target in targets)
    yield from (line.replace("\u00a0", " ") for line in wrapped(f"{title} {tied}", indent=2))


def _target(target: RadarTarget) -> str:
    reference = "T" if target.bearing_reference == "true" else "R"
    return f"{target.label} at {target.range_m / NM_M:.2f} NM {words.bearing(target.bearing_deg)} {reference}"


# ------------------------------------------------------------------------------------------------------------ no fix


def no_fix_lines(answer: Answer) -> Iterator[str]:
    """Yield the lines of a report without a fix: why, what else fits, what was seen, what would help."""
    error = answer.error
    assert error is not None
    yield _title("NO FIX", answer, _counts(answer.epoch, None))
    yield ""
    yield from entry("Because", words.REASONS.get(error.reason, error.reason.replace("_", " ")))
    yield from entry("", str(error))
    yield from _cautions(answer)
    yield from entry("What helps", words.ADVICE.get(error.reason, "Wait for the next scan."))
    yield from _evidence(error)
    yield from track_lines(answer.track)
    yield from _data(answer)
    if answer.gnss is not None:
        yield from gnss_lines(answer.gnss)
    elif answer.epoch is not None and answer.epoch.gnss is not None:
        yield from entry("GNSS", "present, but without a fix there is nothing to compare it with")
    yield from three_positions(answer, None)
    if answer.truth is not None:
        yield from entry("Truth", words.place(answer.truth.position))
    if answer.epoch is not None and answer.epoch.targets:
        yield ""
        yield from _target_list("Targets:", answer.epoch.targets)
    yield from _notes(answer, None)


def _evidence(error: NoFix) -> Iterator[str]:
    places: Sequence[Alternative] = getattr(error, "alternatives", ())
    evidence: float | None = getattr(error, "evidence", None)
    if evidence is not None:
        yield from entry("Evidence", f"{evidence:.1f} for the best place found")
    if places:
        fit = "places fit" if error.reason == "ambiguous" else "places were tried"
        yield from entry("Places", f"{len(places)} {fit}; the best first:")
        yield from _alternatives(places, places[0].position)


# ------------------------------------------------------------------------------------------------------------- parts


def _alternatives(places: Sequence[Alternative], centre: Position | PlanePosition) -> Iterator[str]:
    """Yield the first places with their distance from ``centre`` and count the rest."""
    for place in places[:LISTED]:
        heading = "" if place.heading_deg is None else f"   heading {words.bearing(place.heading_deg)}"
        apart = ""
        if isinstance(place.position, Position) and isinstance(centre, Position):
            distance_m, azimuth_deg = inverse(centre, place.position)
            if distance_m > 0.5:
                apart = f"   {words.short_distance(distance_m)} along {words.direction(azimuth_deg)}"
        yield from entry("", f"{words.place(place.position)}{heading}   score {place.score:.1f}{apart}")
    if len(places) > LISTED:
        yield from entry("", f"and {len(places) - LISTED} more (all of them stand in the JSON)")


def _notes(answer: Answer, fix: Fix | None) -> Iterator[str]:
    found = None if fix is None else fix.association
    said = (*(() if found is None else found.notes), *(() if fix is None else fix.notes), *answer.notes)
    notes = tuple(dict.fromkeys(said))
    if notes:
        yield ""
    for note in notes:
        yield from wrapped(f"Note: {note}", indent=6)
    spent = "   ".join(f"{step} {spent_ms:.1f} ms" for step, spent_ms in answer.timing_ms.items())
    if spent:
        yield ""
        yield from wrapped(f"Computed in: {spent}", indent=2)


def _title(verdict: str, answer: Answer, counts: str) -> str:
    return f"{verdict:<{LABEL}}{words.utc(answer.time_utc):<28}{counts}"


def _counts(epoch: Epoch | None, pairs: int | None) -> str:
    seen = (
        ""
        if epoch is None
        else f"{words.plural(len(epoch.targets), 'target')}, {words.plural(len(epoch.marks), 'mark')}"
    )
    matched = "" if pairs is None else words.plural(pairs, "pair")
    return ", ".join(part for part in (seen, matched) if part)
