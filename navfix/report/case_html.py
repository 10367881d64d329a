"""The textbook report of an adjusted case as one self-contained page: result, sketch, every matrix, nothing to load."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from html import escape

from navfix.adjustment.case import Case, CaseObservation
from navfix.adjustment.textbook import LinearStep
from navfix.errors import NoFix
from navfix.report import words
from navfix.report.case_sketch import sketch
from navfix.report.case_text import (
    KERNEL_NAMES,
    KIND_NAMES,
    damping_text,
    grid_lines,
    mean_position_error_m,
    place_text,
)
from navfix.report.html_table import Row, decimals, digits, facts, heading, matrix, page, remark, table
from navfix.types import AdjustedObservation, Fix, PlanePosition, Position

_CONSPICUOUS = 3.29  # |w| that chance exceeds once in a thousand
_DAMPED = 0.5


def cases_html(sections: Iterable[str], title: str) -> str:
    """Return one page of the sections of all cases."""
    return page(sections, title)


def refused_html(name: str, message: str) -> str:
    """Return the section of a case without a fix."""
    return f'<h1>{escape(name)}</h1>\n<p><b class="bad">no fix: {escape(message)}</b></p>\n'


def case_html(case: Case, step: LinearStep | None, fix: Fix, others: Mapping[str, Fix | NoFix]) -> str:
    """Return the section of one case; the parameters are those of `case_text.case_report`.

    The result comes first, then how it was found.
    """
    parts = [f"<h1>{escape(case.name)}</h1>\n", *_result(case, fix), sketch(case, fix, _states(case, fix))]
    parts += [*_residuals(case, fix), *_side_by_side(others), *_other_minima(fix), *_given(case)]
    if step is not None:
        parts += _first_step(case, step)
    return "".join(parts)


def _state(given: CaseObservation, row: AdjustedObservation) -> str:
    return "out" if not given.use else "damped" if row.weight < _DAMPED else ""


def _states(case: Case, fix: Fix) -> dict[str, str]:
    """Return for each mark the best state of its observations."""
    states: dict[str, str] = {}
    order = ("", "damped", "out")
    for given, row in zip(case.observations, fix.observations, strict=True):
        states[given.mark] = min(states.get(given.mark, "out"), _state(given, row), key=order.index)
    return states


# -------------------------------------------------------------------------------------------------------- the result


def _result(case: Case, fix: Fix) -> Iterator[str]:
    ellipse = fix.ellipse(0.95)
    size = f"{ellipse.semi_major_m:.3f} m x {ellipse.semi_minor_m:.3f} m (semi axes)"
    pairs = [("position", place_text(fix.position))]
    if isinstance(fix.position, Position):
        pairs.append(("", f"{fix.position.lat_deg:.9f}°, {fix.position.lon_deg:.9f}°"))
    pairs += [("", line.strip()) for line in grid_lines(case, fix.position)]
    if fix.heading_deg is not None:
        sigma_deg = math.degrees(math.sqrt(fix.covariance[2, 2]))
        pairs.append(("heading", f"{fix.heading_deg:.4f}° ± {sigma_deg:.4f}° (1 sigma)"))
    scaling = "scaled by sigma0" if fix.covariance_scaling == "a_posteriori" else "from the sigmas given"
    pairs += [
        ("ellipse 95 %", f"{size}, major axis {ellipse.azimuth_deg:.1f}°"),
        ("mean error m_P", f"{mean_position_error_m(fix):.3f} m"),
        ("sigma0", f"{fix.sigma0:.5f}, redundancy {fix.redundancy}; covariance {scaling}"),
    ]
    failed = fix.global_test is not None and not fix.global_test.passed
    if (test := fix.global_test) is not None:
        verdict = "passed" if test.passed else "FAILED"
        found = f"{test.statistic:.3f}, limit {test.threshold:.3f} at {test.dof:.1f} degrees of freedom: {verdict}"
        pairs.append(("global test", found))
    pairs.append(("kernel", f"{KERNEL_NAMES.get(fix.kernel, fix.kernel)}, {damping_text(fix)}"))
    pairs += [("note", note) for note in fix.notes]
    yield facts(pairs, bad=("global test",) if failed else ())


def _residuals(case: Case, fix: Fix) -> Iterator[str]:
    names = (
        "observation", "kind", "unit", "observed", "adjusted", "v", "sigma", "q(v)", "w", "r", "weight", "mdb",
        "external m",
    )  # fmt: skip
    yield heading("Observations")
    rows: list[Row] = []
    conspicuous = set()
    for index, (given, row) in enumerate(zip(case.observations, fix.observations, strict=True)):
        cells = (f"{index + 1} {row.mark}", KIND_NAMES[row.kind], *_numbers(row))
        rows.append((_state(given, row), cells))
        if row.standardized is not None and abs(row.standardized) > _CONSPICUOUS:
            conspicuous.add(decimals(row.standardized, 2, sign=True))
    yield table(names, rows, text=(0, 1, 2), bad=tuple(conspicuous))
    yield remark(
        "v = adjusted - observed; q(v) = sigma² r, cofactor of the residual; w = v / (sigma √r), red beyond "
        f"{_CONSPICUOUS}; r redundancy number; mdb minimal detectable bias; external m: how far an error of that size "
        "moves the position. Shaded: damped to less than half its weight. Grey: left out by the decision matrix."
    )


def _numbers(row: AdjustedObservation) -> Iterator[str]:
    metres = row.kind == "range"
    places = 3 if metres else 4
    yield "m" if metres else "°"
    yield from (decimals(value, places) for value in (row.observed, row.adjusted))
    yield decimals(row.residual, places, sign=True)
    yield decimals(row.sigma, places)
    yield digits(row.sigma**2 * row.redundancy_number, 5)
    yield decimals(row.standardized, 2, sign=True)
    yield from (decimals(value, 2) for value in (row.redundancy_number, row.weight))
    yield decimals(row.mdb, places)
    yield decimals(row.external_m, 2)


def _side_by_side(others: Mapping[str, Fix | NoFix]) -> Iterator[str]:
    yield heading("Side by side")
    rows: list[Row] = []
    for kernel, result in others.items():
        name = KERNEL_NAMES.get(kernel, kernel)
        if isinstance(result, NoFix):
            rows.append(("out", (name, f"no fix: {result}", "", "", "", "")))
            continue
        turned = "-" if result.heading_deg is None else f"{result.heading_deg:.4f}°"
        damped = ", ".join(f"{i + 1} ({o.weight:.2f})" for i, o in enumerate(result.observations) if o.weight < 0.995)
        numbers = (f"{result.sigma0:.5f}", f"{mean_position_error_m(result):.3f}")
        rows.append(("", (name, place_text(result.position), turned, *numbers, damped or "-")))
    yield table(("kernel", "position", "heading", "sigma0", "m_P m", "damped (weight)"), rows, text=(0, 1, 5))


def _other_minima(fix: Fix) -> Iterator[str]:
    if fix.alternatives:
        yield heading("Other minima")
        rows = []
        for other in fix.alternatives:
            turned = "-" if other.heading_deg is None else words.bearing(other.heading_deg)
            rows.append(("", (place_text(other.position), turned, f"{other.score:.2f}")))
        yield table(("position", "heading", "score"), rows)


# ------------------------------------------------------------------------------------------------------ what was given


def _given(case: Case) -> Iterator[str]:
    yield heading("Given")
    names = ("north m", "east m") if case.frame == "plane" else ("latitude °", "longitude °")
    rows = []
    for mark in case.marks:
        p = mark.position
        pair = (p.north_m, p.east_m) if isinstance(p, PlanePosition) else (p.lat_deg, p.lon_deg)
        places = 4 if isinstance(p, PlanePosition) else 9
        rows.append(("", (mark.label, *(f"{value:.{places}f}" for value in pair), f"{mark.sigma_m:g}")))
    yield table(("mark", *names, "sigma m"), rows)
    if case.start is not None:
        turned = "" if case.heading_deg is None else f", heading {words.bearing(case.heading_deg)}"
        yield f"<p>start: {escape(place_text(case.start) + turned)}</p>\n"
    yield heading("Decision matrix: which observations take part")
    kinds = list(dict.fromkeys(o.kind for o in case.observations))
    rows = [("", (mark.label, *(_takes_part(case, mark.label, kind) for kind in kinds))) for mark in case.marks]
    yield table(("mark", *(KIND_NAMES[kind] for kind in kinds)), rows)


def _takes_part(case: Case, label: str, kind: str) -> str:
    return " ".join("1" if o.use else "0" for o in case.observations if (o.mark, o.kind) == (label, kind)) or "-"


# -------------------------------------------------------------------------------------------------- the first step


def _first_step(case: Case, step: LinearStep) -> Iterator[str]:
    yield heading("First step: V = A dx + L, dx = -(A'PA)⁻¹ A'PL, P = 1 / sigma²")
    unknowns = ("north", "east", "heading")[: step.design_matrix.shape[1]]
    rows: list[Row] = []
    for index, given in enumerate(case.observations):
        places = 3 if given.kind == "range" else 4
        numbers = (
            *(decimals(float(value), 6) for value in step.design_matrix[index]),
            decimals(float(step.free_terms[index]), places, sign=True),
            digits(float(step.weights[index]), 6),
            decimals(float(step.residuals[index]), places, sign=True),
            decimals(float(step.adjusted_sigma[index]), places),
        )
        label = (f"{index + 1} {given.mark}", KIND_NAMES[given.kind], "m" if given.kind == "range" else "°")
        rows.append(("" if given.use else "out", (*label, *numbers)))
    names = ("observation", "kind", "unit", *(f"A {name}" for name in unknowns), "L", "P", "V", "s(adj)")
    yield table(names, rows, text=(0, 1, 2))
    yield remark("A in the row's unit per m, and per rad of heading; s(adj) = sigma0 √(AQA')")
    sigma0 = "not known" if step.sigma0 is None else f"{step.sigma0:.5f}"
    turn = f", heading {math.degrees(step.increments[2]):+.4f}°" if len(unknowns) > 2 else ""
    yield (
        f"<p>dx: north {step.increments[0]:+.3f} m, east {step.increments[1]:+.3f} m{turn}; sigma0 {sigma0}; "
        f"mean position error {step.position_sigma_m:.3f} m</p>\n"
    )
    units = [f"{name} {'rad' if name == 'heading' else 'm'}" for name in unknowns]
    yield heading("Cofactors of the unknowns, (A'PA)⁻¹") + matrix(step.cofactors, units)
    labels = [f"{index + 1}" for index in range(len(case.observations))]
    yield heading("Cofactors of the adjusted observations, A (A'PA)⁻¹ A'") + matrix(step.observation_cofactors, labels)
    yield heading("Cofactors of the residuals, P⁻¹ - A (A'PA)⁻¹ A'") + matrix(step.residual_cofactors, labels)
