"""Title and legend of the picture: what was found, how sure it is, and what each symbol stands for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from xml.etree import ElementTree as ET

from navfix.report import words
from navfix.report.answer import Answer
from navfix.report.drawing import symbols
from navfix.report.drawing.view import ECHO, ELLIPSE, MARK, MUTED, OUTLIER, add
from navfix.report.json_parts import ELLIPSE_PROBABILITIES
from navfix.report.scene import Scene
from navfix.report.tables import clipped
from navfix.types import Fix

_VERDICT_COLOUR = {"ok": MARK, "caution": ECHO, "unsafe": OUTLIER, "not_available": MUTED}

Entry = tuple[str, Callable[[ET.Element, float, float], object]]


def lines(answer: Answer) -> list[str]:
    """Return the lines of the title: the fix or why there is none, its time and ellipse, how sure it is."""
    fix, time = answer.fix, words.utc(answer.time_utc)
    if fix is None:
        reason = "" if answer.error is None else words.REASONS.get(answer.error.reason, answer.error.reason)
        message = "" if answer.error is None else str(answer.error)
        return [f"NO FIX · {reason}", clipped(f"{time} · {message}", 110), "the radar's picture, as it shows it"]
    heading = "" if fix.heading_deg is None else f" · heading {words.bearing(fix.heading_deg)}"
    ellipse = fix.ellipse(ELLIPSE_PROBABILITIES[0])
    size = f"{ellipse.semi_major_m:.1f} x {ellipse.semi_minor_m:.1f} m"
    return [
        f"FIX · {words.place(fix.position)}{heading}",
        f"{time} · ellipse 95 %: {size} · {_counts(answer)}",
        _sure(fix),
    ]


def _counts(answer: Answer) -> str:
    assert answer.fix is not None
    pairs = len({(observation.target, observation.mark) for observation in answer.fix.observations})
    if answer.epoch is None:
        return words.plural(pairs, "pair")
    targets, marks = len(answer.epoch.targets), len(answer.epoch.marks)
    return f"{words.plural(pairs, 'pair')} of {words.plural(targets, 'target')} and {words.plural(marks, 'mark')}"


def _sure(fix: Fix) -> str:
    if fix.association is None or fix.association.probability_wrong is None:
        return f"sigma0 {fix.sigma0:.2f} · redundancy {fix.redundancy} · kernel {fix.kernel}"
    return f"{words.odds(fix.association.probability_wrong)} that this is another place · sigma0 {fix.sigma0:.2f}"


def right(answer: Answer) -> list[tuple[str, str]]:
    """Return lines with their colour for the right of the title: the GNSS verdict, the error against a truth."""
    lines: list[tuple[str, str]] = []
    if answer.gnss is not None:
        gnss = answer.gnss
        apart = "" if gnss.verdict == "not_available" else f", {words.short_distance(gnss.distance_m)} off"
        lines.append((f"GNSS {gnss.verdict.replace('_', ' ').upper()}{apart}", _VERDICT_COLOUR[gnss.verdict]))
    if answer.truth is not None and answer.truth.error_m is not None:
        lines.append((f"error {words.short_distance(answer.truth.error_m)}", MARK))
    return lines


def legend(answer: Answer, scene: Scene, factor: float) -> Iterator[Entry]:
    """Yield caption and symbol of what the picture shows."""
    if scene.targets:
        yield "radar target", lambda g, x, y: symbols.echo_at(g, x, y, 9.0, 0.0)
    matched = {mark.kind for mark in scene.marks if mark.status != "unmatched"}
    if "ship" in matched:
        yield "AIS ship", lambda g, x, y: symbols.mark(g, x, y, "ship", "matched")
    if "aton" in matched:
        yield "aid to navigation", lambda g, x, y: symbols.mark(g, x, y, "aton", "matched")
    if "charted" in matched:
        yield "charted mark", lambda g, x, y: symbols.mark(g, x, y, "charted", "matched")
    if any(mark.status == "unmatched" for mark in scene.marks):
        yield "mark without a target", lambda g, x, y: symbols.mark(g, x, y, "ship", "unmatched")
    if any(not stick.row.outlier for stick in scene.sticks):
        caption = "residual, to scale" if factor == 1.0 else f"residual × {factor:g}"
        yield caption, lambda g, x, y: symbols.residual_at(g, (x - 12.0, y), (x + 10.0, y), outlier=False)
    if any(stick.row.outlier for stick in scene.sticks):
        yield "outlier, to scale", lambda g, x, y: symbols.residual_at(g, (x - 12.0, y), (x + 12.0, y), outlier=True)
    if answer.fix is not None:
        yield "ellipse 95 %, 99 %", _ellipse_sample
    names = {"plain_mean": "plain mean", "truth": "truth", "gnss": "GNSS", "alternative": "other place"}
    for kind in dict.fromkeys(place.kind for place in scene.places):
        yield names[kind], lambda g, x, y, kind=kind: symbols.place(g, x, y, kind)  # type: ignore[misc]


def _ellipse_sample(parent: ET.Element, x: float, y: float) -> None:
    add(parent, "ellipse", cx=x, cy=y, rx=8, ry=4.5, fill=ELLIPSE, fill_opacity=0.12, stroke=ELLIPSE)
    add(parent, "ellipse", cx=x, cy=y, rx=12, ry=7, fill="none", stroke=ELLIPSE, stroke_dasharray="4 2")
