"""The other positions in the text report: plain mean, GNSS, dead reckoning, observed, truth, each against the fix."""

from __future__ import annotations

from collections.abc import Iterator

from navfix.geodesy import inverse
from navfix.report import words
from navfix.report.answer import Answer
from navfix.report.entries import entry, in_metres
from navfix.types import Fix, GnssVerdict, MeanFix, Position

_GNSS_WORDS = {"ok": "OK", "caution": "CAUTION", "unsafe": "UNSAFE", "not_available": "NOT AVAILABLE"}
_RECKONED_BY = {"log_and_gyro": "log and gyro", "log": "log along the last heading", "last_velocity": "last velocity"}


def beside_lines(answer: Answer, fix: Fix) -> Iterator[str]:
    """Yield the plain mean, the GNSS, the reckoned and observed position and the truth, each against the fix."""
    if answer.plain_mean is not None:
        yield from entry("Plain mean", _plain_mean(answer.plain_mean, fix))
    if answer.gnss is not None or answer.epoch is not None:
        yield from gnss_lines(answer.gnss)
    yield from three_positions(answer, fix)
    truth = answer.truth
    if truth is not None:
        error = "" if truth.error_m is None else f"the fix is {words.distance(truth.error_m)} off"
        turned = truth.heading_error_deg
        heading = "" if turned is None else f", its heading {turned:+.2f}°"
        yield from entry("Truth", f"{words.place(truth.position)}   {error}{heading}")


def three_positions(answer: Answer, fix: Fix | None) -> Iterator[str]:
    """Yield the reckoned and the observed position beside the adjusted one; nothing before there is dead reckoning."""
    reckoned = answer.dead_reckoning
    if reckoned is None:
        return
    ellipse = reckoned.ellipse(0.95)
    off = ""
    if fix is not None and isinstance(fix.position, Position):
        distance_m, azimuth_deg = inverse(fix.position, reckoned.position)
        off = f"   {words.distance(distance_m)} from the fix, {words.direction(azimuth_deg)}"
    yield from entry("Dead reckoning", words.place(reckoned.position) + off)
    yield from entry(
        "",
        f"{reckoned.age_s:.0f} s after the last fix, by {_RECKONED_BY[reckoned.source]}; ellipse 95 % "
        f"{in_metres(ellipse.semi_major_m)} x {in_metres(ellipse.semi_minor_m)}",
    )
    if reckoned.probability_wrong is not None:
        yield from entry("", f"{words.odds(reckoned.probability_wrong)} that the last fix was another place")
    if reckoned.doubt:
        yield from entry("", f"DOUBTFUL: {reckoned.doubt}")
    observed = None if fix is None or fix.association is None else fix.association.position
    if observed is not None and fix is not None and isinstance(fix.position, Position):
        distance_m, azimuth_deg = inverse(fix.position, observed)
        off = f"   {words.distance(distance_m)} from the fix, {words.direction(azimuth_deg)}"
        yield from entry("Observed", words.place(observed) + off)


def _plain_mean(mean: MeanFix, fix: Fix) -> str:
    apart = ""
    if isinstance(fix.position, Position):
        distance_m, azimuth_deg = inverse(fix.position, mean.position)
        apart = f"   {words.distance(distance_m)} from the fix along {words.direction(azimuth_deg)}"
    return f"{words.place(mean.position)}{apart}   (mean of {int(mean.used.sum())} of {len(mean.used)})"


def gnss_lines(gnss: GnssVerdict | None) -> Iterator[str]:
    """Yield the verdict on the GNSS with its reasons."""
    if gnss is None:
        yield from entry("GNSS", "none in the data to compare with")
        return
    if gnss.verdict == "not_available":
        yield from entry("GNSS", "; ".join(("NOT AVAILABLE", *gnss.reasons)))
        return
    yield from entry(
        "GNSS",
        f"{_GNSS_WORDS[gnss.verdict]}: {words.distance(gnss.distance_m)} from the fix "
        f"(limit {in_metres(gnss.threshold_m)}, "
        f"smallest error that would be seen {in_metres(gnss.smallest_detectable_m)})",
    )
    for reason in gnss.reasons:
        yield from entry("", f"- {reason}")
