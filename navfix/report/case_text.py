"""The textbook report of an adjusted case: matrices of the first step, the fix, and the kernels side by side."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Mapping, Sequence

from navfix.adjustment.case import Case, CaseObservation
from navfix.adjustment.textbook import LinearStep
from navfix.adjustment.utm import from_utm
from navfix.errors import NoFix
from navfix.report import words
from navfix.report.tables import clipped, number
from navfix.types import AdjustedObservation, Fix, PlanePosition, Position

KIND_NAMES = {"range": "range", "true_bearing": "true brg", "relative_bearing": "rel. brg"}
KERNEL_NAMES = {"none": "classical", "huber": "Huber", "hampel": "Hampel", "danish": "Danish"}


def case_report(case: Case, step: LinearStep | None, fix: Fix, others: Mapping[str, Fix | NoFix]) -> str:
    """Return the report of one case, at most 100 columns wide, ending in a line feed.

    Parameters
    ----------
    step : the first linear step from the start that was used, None where it is singular there
    fix : with the kernel asked for
    others : by kernel name, the same case with each kernel, or why there is no fix
    """
    lines = [*_head(case), ""]
    if step is not None:
        lines += [*_first_step(case, step), ""]
    lines += [*_adjusted(case, fix), "", *_side_by_side(others), *_alternatives(fix)]
    for note in fix.notes:
        lines += textwrap.wrap(f"Note: {note}", 100, subsequent_indent="      ")
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _head(case: Case) -> Iterator[str]:
    unknowns = "north, east, heading" if case.heading_unknown else "north, east"
    used = sum(observation.use for observation in case.observations)
    yield f"CASE  {clipped(case.name, 90)}"
    yield f"frame {case.frame}, {len(case.marks)} marks, {used} observations, unknowns {unknowns}"
    if case.start is not None:
        heading = "" if case.heading_deg is None else f"   heading {words.bearing(case.heading_deg)}"
        yield f"start {place_text(case.start)}{heading}"


# -------------------------------------------------------------------------------------------------- the first step


def _first_step(case: Case, step: LinearStep) -> Iterator[str]:
    heading = case.heading_unknown
    place = "the start" if case.start is not None else "the fix (the case has no start)"
    yield f"FIRST STEP, classical, from {place}: V = A dx + L, dx = -(A'PA)^-1 A'PL, P = 1 / sigma^2"
    titles = "".join(f"{title:>11}" for title in ("A north", "A east", *(["A heading"] if heading else [])))
    head = f"{'no mark':<12}{'kind':<9}{titles}{'L':>11}{'P':>11}{'V':>11}{'s(adj)':>9}"
    yield head
    yield "-" * len(head)
    for index, observation in enumerate(case.observations):
        values = (*step.design_matrix[index], step.free_terms[index], step.weights[index], step.residuals[index])
        row = "".join(f"{number(float(value), 10, 6):>11}" for value in values)
        sigma = number(float(step.adjusted_sigma[index]), 8, 3)
        yield f"{index + 1:>2} {clipped(observation.mark, 8):<9}{KIND_NAMES[observation.kind]:<9}{row}{sigma:>9}"
    turn = f"   heading {math.degrees(step.increments[2]):+.4f}°" if heading else ""
    yield f"increments dx   north {step.increments[0]:+.3f} m   east {step.increments[1]:+.3f} m{turn}"
    sigma0 = "not known, no redundancy" if step.sigma0 is None else f"{step.sigma0:.5f}"
    yield f"sigma0 {sigma0}   mean position error m_P {step.position_sigma_m:.3f} m"
    yield "cofactors (A'PA)^-1 of " + ("north m, east m, heading rad" if heading else "north m, east m")
    for line in step.cofactors:
        yield "".join(f"{value:>18.6g}" for value in line)
    yield "A and L in m or ° per m" + (" and rad" if heading else "") + ", s(adj) = sigma0 sqrt(AQA')"


# --------------------------------------------------------------------------------------------------------- the fix


def _adjusted(case: Case, fix: Fix) -> Iterator[str]:
    yield f"ADJUSTED with kernel {fix.kernel}, iterated to the end"
    yield f"kernel    {damping_text(fix)}"
    yield f"position  {place_text(fix.position)}"
    if isinstance(fix.position, Position):
        yield f"          {fix.position.lat_deg:.9f}   {fix.position.lon_deg:.9f}"
    yield from grid_lines(case, fix.position)
    if fix.heading_deg is not None:
        yield f"heading   {fix.heading_deg:.4f}° +- {math.degrees(math.sqrt(fix.covariance[2, 2])):.4f} (1 sigma)"
    scaling = "scaled by sigma0" if fix.covariance_scaling == "a_posteriori" else "from the sigmas given"
    yield f"sigma0    {fix.sigma0:.5f}   redundancy {fix.redundancy}   covariance {scaling}"
    yield f"m_P       {mean_position_error_m(fix):.3f} m   ellipse 95 %  {_ellipse(fix)}"
    test = fix.global_test
    if test is not None:
        verdict = "passed" if test.passed else "FAILED"
        yield f"global test {test.statistic:.2f}, limit {test.threshold:.2f} at {test.dof:.1f} dof: {verdict}"
    yield ""
    yield from _residuals(case.observations, fix.observations)


def _residuals(given: Sequence[CaseObservation], adjusted: Sequence[AdjustedObservation]) -> Iterator[str]:
    names = f"{'observed':>13}{'adjusted':>13}{'v':>11}{'sigma':>9}{'w':>7}{'r':>6}{'p':>6}{'mdb':>10}"
    head = f"{'no mark':<12}{'kind':<9}{names}"
    yield head
    yield "-" * len(head)
    for index, (observation, row) in enumerate(zip(given, adjusted, strict=True)):
        w = "-" if row.standardized is None else number(row.standardized, 6, 2, sign=True)
        mdb = "-" if row.mdb is None else number(row.mdb, 9, 3)
        left_out = "" if observation.use else "  not used"
        yield (
            f"{index + 1:>2} {clipped(row.mark, 8):<9}{KIND_NAMES[row.kind]:<9}{number(row.observed, 12, 4):>13}"
            f"{number(row.adjusted, 12, 4):>13}{number(row.residual, 10, 4, sign=True):>11}{number(row.sigma, 8, 4):>9}"
            f"{w:>7}{row.redundancy_number:>6.2f}{row.weight:>6.2f}{mdb:>10}{left_out}"
        )
    yield "m or °; v = adjusted - observed, w = v / (sigma sqrt(r)), r redundancy number, p kernel weight"
    yield ""
    yield from _reliability(adjusted)


def _reliability(adjusted: Sequence[AdjustedObservation]) -> Iterator[str]:
    head = f"{'no mark':<12}{'kind':<9}{'q(v)':>13}{'mdb':>13}{'external m':>13}"
    yield head
    yield "-" * len(head)
    for index, row in enumerate(adjusted):
        values = (row.sigma**2 * row.redundancy_number, row.mdb, row.external_m)
        cells = "".join(f"{'-' if value is None else number(value, 12, 5):>13}" for value in values)
        yield f"{index + 1:>2} {clipped(row.mark, 8):<9}{KIND_NAMES[row.kind]:<9}{cells}"
    yield "q(v) = sigma^2 r cofactor of the residual; external: how far an error of the mdb moves the position"


def grid_lines(case: Case, place: Position | PlanePosition) -> Iterator[str]:
    """Yield where a place of the plane is on earth, with convergence and scale, where the case says its UTM zone."""
    if case.utm_zone is None or not isinstance(place, PlanePosition):
        return
    found = from_utm(place, case.utm_zone)
    yield f"on WGS 84 {words.place(found.position)}   {found.position.lat_deg:.9f}   {found.position.lon_deg:.9f}"
    yield (
        f"          UTM {case.utm_zone}: convergence {found.convergence_deg:+.5f}° (grid = true - it), "
        f"scale {found.scale:.8f}"
    )


def damping_text(fix: Fix) -> str:
    """Return how the kernel was applied: what is damped together, and in which unit it takes a residual."""
    unit = "sigma of the residual (gdynia)" if fix.standardise == "gdynia" else "sigma of the observation"
    return f"{fix.damping} damping, in units of the {unit}"


def place_text(place: Position | PlanePosition) -> str:
    """Return a place as the report writes it."""
    if isinstance(place, PlanePosition):
        return f"N {place.north_m:.4f} m   E {place.east_m:.4f} m"
    return words.place(place)


def mean_position_error_m(fix: Fix) -> float:
    """Return sqrt(s_north^2 + s_east^2) [m] of a fix."""
    return math.sqrt(float(fix.covariance[0, 0] + fix.covariance[1, 1]))


def _ellipse(fix: Fix) -> str:
    ellipse = fix.ellipse(0.95)
    return f"{ellipse.semi_major_m:.3f} x {ellipse.semi_minor_m:.3f} m (semi axes), {ellipse.azimuth_deg:.1f}°"


# ---------------------------------------------------------------------------------------------------- side by side


def _side_by_side(others: Mapping[str, Fix | NoFix]) -> Iterator[str]:
    yield "SIDE BY SIDE"
    head = f"{'kernel':<11}{'position':<42}{'heading':>9}{'sigma0':>9}{'m_P m':>10}   damped (weight)"
    yield head
    yield "-" * len(head)
    for kernel, result in others.items():
        name = KERNEL_NAMES.get(kernel, kernel)
        if isinstance(result, NoFix):
            yield f"{clipped(name, 10):<11}no fix: {clipped(str(result), 80)}"
            continue
        heading = "-" if result.heading_deg is None else f"{result.heading_deg:.3f}"
        yield (
            f"{clipped(name, 10):<11}{clipped(place_text(result.position), 41):<42}{heading:>9}"
            f"{number(result.sigma0, 8, 4):>9}{number(mean_position_error_m(result), 9, 3):>10}   {_damped(result)}"
        )


def _damped(fix: Fix) -> str:
    rows = [f"{index + 1} ({row.weight:.2f})" for index, row in enumerate(fix.observations) if row.weight < 0.995]
    return clipped(", ".join(rows) or "-", 16)


def _alternatives(fix: Fix) -> Iterator[str]:
    if fix.alternatives:
        yield ""
        yield f"OTHER MINIMA ({len(fix.alternatives)})"
    for other in fix.alternatives:
        heading = "" if other.heading_deg is None else f"   heading {words.bearing(other.heading_deg)}"
        yield f"{place_text(other.position)}{heading}   score {other.score:.2f}{_apart(fix, other.position)}"


def _apart(fix: Fix, other: object) -> str:
    if isinstance(fix.position, PlanePosition) and isinstance(other, PlanePosition):
        apart_m = math.hypot(other.north_m - fix.position.north_m, other.east_m - fix.position.east_m)
        return f"   {words.distance(apart_m)} away"
    return ""
