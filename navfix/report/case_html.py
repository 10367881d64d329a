"""The textbook report of an adjusted case as one self-contained page: tables of every matrix, nothing to load."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

import numpy as np

from navfix.adjustment.case import Case
from navfix.adjustment.textbook import LinearStep
from navfix.errors import NoFix
from navfix.report import words
from navfix.report.case_text import (
    KERNEL_NAMES,
    KIND_NAMES,
    damping_text,
    grid_lines,
    mean_position_error_m,
    place_text,
)
from navfix.types import AdjustedObservation, Fix, FloatArray, PlanePosition

_STYLE = """
body { margin: 1.2rem; color: #1d2733; background: #ffffff; font-family: sans-serif; max-width: 75rem; }
h1 { font-size: 1.3rem; } h2 { font-size: 1.05rem; margin: 1.6rem 0 0.4rem; } section { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.85rem; } p { margin: 0.3rem 0; }
th, td { padding: 0.15rem 0.6rem; border-bottom: 1px solid #c9d3dc; text-align: right; white-space: nowrap; }
th { background: #eef3f7; } th:first-child, td:first-child { text-align: left; }
tr.damped td { background: #fdeee2; } tr.out td { color: #8a949e; }
@media (prefers-color-scheme: dark) {
  body { color: #dbe3ea; background: #0d1117; } th { background: #1c2530; } th, td { border-color: #39434f; }
  tr.damped td { background: #3b2a1c; }
}
"""
Row = tuple[str, Sequence[str]]  # class of the row, cells


def cases_html(sections: Iterable[str], title: str) -> str:
    """Return one page of the sections of all cases."""
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n{''.join(sections)}</body>\n</html>\n"
    )


def refused_html(name: str, message: str) -> str:
    """Return the section of a case without a fix."""
    return f"<h1>{escape(name)}</h1>\n<p>no fix: {escape(message)}</p>\n"


def case_html(case: Case, step: LinearStep | None, fix: Fix, others: Mapping[str, Fix | NoFix]) -> str:
    """Return the section of one case; the parameters are those of `case_text.case_report`."""
    parts = [f"<h1>{escape(case.name)}</h1>\n", *_given(case)]
    if step is not None:
        parts += _first_step(case, step)
    parts += [*_result(case, fix), *_residuals(case, fix), *_side_by_side(others), *_other_minima(fix)]
    parts += [f"<p>Note: {escape(note)}</p>\n" for note in fix.notes]
    return "".join(parts)


def _given(case: Case) -> Iterator[str]:
    yield _heading("Given")
    first, second = ("north m", "east m") if case.frame == "plane" else ("latitude", "longitude")
    rows = []
    for mark in case.marks:
        p = mark.position
        pair = (p.north_m, p.east_m) if isinstance(p, PlanePosition) else (p.lat_deg, p.lon_deg)
        rows.append(("", (mark.label, *(f"{value:.10g}" for value in pair), f"{mark.sigma_m:g}")))
    yield _table(("mark", first, second, "sigma m"), rows)
    if case.start is not None:
        yield f"<p>start: {escape(place_text(case.start))}</p>\n"
    yield _heading("Decision matrix: which observations take part")
    kinds = list(dict.fromkeys(o.kind for o in case.observations))
    rows = []
    for mark in case.marks:
        cells = [_takes_part(case, mark.label, kind) for kind in kinds]
        rows.append(("", (mark.label, *cells)))
    yield _table(("mark", *(KIND_NAMES[kind] for kind in kinds)), rows)


def _takes_part(case: Case, label: str, kind: str) -> str:
    return " ".join("1" if o.use else "0" for o in case.observations if (o.mark, o.kind) == (label, kind)) or "-"


# -------------------------------------------------------------------------------------------------- the first step


def _first_step(case: Case, step: LinearStep) -> Iterator[str]:
    yield _heading("First step: V = A dx + L, dx = -(A'PA)⁻¹ A'PL, P = 1 / sigma²")
    unknowns = ("north", "east", "heading")[: step.design_matrix.shape[1]]
    rows = []
    for index, observation in enumerate(case.observations):
        numbers = (
            *step.design_matrix[index],
            *(float(column[index]) for column in (step.free_terms, step.weights, step.residuals, step.adjusted_sigma)),
        )
        kind = KIND_NAMES[observation.kind]
        rows.append(
            ("" if observation.use else "out", (f"{index + 1} {observation.mark}", kind, *map(_number, numbers)))
        )
    names = ("observation", "kind", *(f"A {name}" for name in unknowns), "L", "P", "V", "s(adj)")
    yield _table(names, rows)
    sigma0 = "not known" if step.sigma0 is None else f"{step.sigma0:.5f}"
    increments = ", ".join(f"{name} {value:+.6g}" for name, value in zip(unknowns, step.increments, strict=True))
    yield f"<p>dx: {increments} (m, rad); sigma0 {sigma0}; mean position error {step.position_sigma_m:.3f} m</p>\n"
    yield _heading("Cofactors of the unknowns, (A'PA)⁻¹") + _matrix(step.cofactors, unknowns)
    labels = [f"{index + 1}" for index in range(len(case.observations))]
    yield _heading("Cofactors of the adjusted observations, A (A'PA)⁻¹ A'") + _matrix(
        step.observation_cofactors, labels
    )
    yield _heading("Cofactors of the residuals, P⁻¹ - A (A'PA)⁻¹ A'") + _matrix(step.residual_cofactors, labels)


# -------------------------------------------------------------------------------------------------------- the result


def _result(case: Case, fix: Fix) -> Iterator[str]:
    yield _heading(f"Adjusted with kernel {fix.kernel}")
    yield f"<p>{escape(damping_text(fix))}</p>\n"
    yield f"<p>{escape(place_text(fix.position))}</p>\n"
    yield from (f"<p>{escape(line)}</p>\n" for line in grid_lines(case, fix.position))
    if fix.heading_deg is not None:
        sigma_deg = math.degrees(math.sqrt(fix.covariance[2, 2]))
        yield f"<p>heading {fix.heading_deg:.4f}° ± {sigma_deg:.4f}° (1 sigma)</p>\n"
    ellipse = fix.ellipse(0.95)
    yield (
        f"<p>ellipse 95 %: {ellipse.semi_major_m:.3f} m x {ellipse.semi_minor_m:.3f} m (semi axes), "
        f"{ellipse.azimuth_deg:.1f}°; m<sub>P</sub> {mean_position_error_m(fix):.3f} m</p>\n"
    )
    scaling = "scaled by sigma0" if fix.covariance_scaling == "a_posteriori" else "from the sigmas given"
    yield f"<p>sigma0 {fix.sigma0:.5f}; redundancy {fix.redundancy}; covariance {scaling}</p>\n"
    if (test := fix.global_test) is not None:
        verdict = "passed" if test.passed else "FAILED"
        yield f"<p>global test {test.statistic:.3f}, limit {test.threshold:.3f} at {test.dof:.1f} dof: {verdict}</p>\n"


def _residuals(case: Case, fix: Fix) -> Iterator[str]:
    names = (
        "observation", "kind", "observed", "adjusted", "v", "sigma", "q(v)", "w", "r", "weight", "mdb", "external m",
    )  # fmt: skip
    yield _heading("Observations")
    rows = []
    for index, (given, row) in enumerate(zip(case.observations, fix.observations, strict=True)):
        state = "out" if not given.use else "damped" if row.weight < 0.5 else ""
        rows.append((state, (f"{index + 1} {row.mark}", KIND_NAMES[row.kind], *_numbers(row))))
    yield _table(names, rows)
    yield (
        "<p>m or deg; v = adjusted - observed; q(v) = sigma² r, cofactor of the residual; w = v / (sigma √r); "
        "r redundancy number; mdb minimal detectable bias; external m: how far an error of that size moves the position"
        "</p>\n"
    )


def _numbers(row: AdjustedObservation) -> Iterator[str]:
    cofactor = row.sigma**2 * row.redundancy_number
    for value in (row.observed, row.adjusted, row.residual, row.sigma, cofactor, row.standardized):
        yield _number(value)
    for value in (row.redundancy_number, row.weight):
        yield f"{value:.3f}"
    for value in (row.mdb, row.external_m):
        yield _number(value)


def _side_by_side(others: Mapping[str, Fix | NoFix]) -> Iterator[str]:
    yield _heading("Side by side")
    rows = []
    for kernel, result in others.items():
        name = KERNEL_NAMES.get(kernel, kernel)
        if isinstance(result, NoFix):
            rows.append(("out", (name, f"no fix: {result}", "", "", "", "")))
            continue
        heading = "-" if result.heading_deg is None else f"{result.heading_deg:.4f}°"
        damped = ", ".join(f"{i + 1} ({o.weight:.2f})" for i, o in enumerate(result.observations) if o.weight < 0.995)
        numbers = (f"{result.sigma0:.5f}", f"{mean_position_error_m(result):.3f}")
        rows.append(("", (name, place_text(result.position), heading, *numbers, damped or "-")))
    yield _table(("kernel", "position", "heading", "sigma0", "m_P m", "damped (weight)"), rows)


def _other_minima(fix: Fix) -> Iterator[str]:
    if fix.alternatives:
        yield _heading("Other minima")
        rows = [
            (
                "",
                (
                    place_text(o.position),
                    "-" if o.heading_deg is None else words.bearing(o.heading_deg),
                    f"{o.score:.2f}",
                ),
            )
            for o in fix.alternatives
        ]
        yield _table(("position", "heading", "score"), rows)


# ------------------------------------------------------------------------------------------------------------ pieces


def _heading(text: str) -> str:
    return f"<h2>{escape(text)}</h2>\n"


def _number(value: float | None) -> str:
    return "-" if value is None or not np.isfinite(value) else f"{value:.7g}"


def _matrix(matrix: FloatArray, labels: Sequence[str]) -> str:
    rows = [
        ("", (label, *(_number(float(value)) for value in line))) for label, line in zip(labels, matrix, strict=True)
    ]
    return _table(("", *labels), rows)


def _table(names: Sequence[str], rows: Iterable[Row]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "\n".join(
        f'<tr class="{state}">' + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
        for state, cells in rows
    )
    return f"<section><table>\n<tr>{head}</tr>\n{body}\n</table></section>\n"
