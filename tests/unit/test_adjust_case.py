"""Cases adjusted: either frame, with and without start and heading, robust and classical, and what has no fix."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from navfix.adjustment.adjust_case import adjust_case, first_step
from navfix.adjustment.case import Case, case_of
from navfix.errors import Ambiguous, NoAgreement, TooFewPairs, Unobservable
from navfix.geodesy import direct, inverse
from navfix.types import PlanePosition, Position

OWN = (1000.0, -500.0)
MARKS = {"A": (6000.0, -300.0), "B": (2500.0, 4000.0), "C": (-3000.0, 1500.0), "D": (-1000.0, -5000.0)}
SIGMA = {"range": 20.0, "true_bearing": 0.5, "relative_bearing": 0.5}


def observed(label: str, kind: str, heading_deg: float = 0.0, error: float = 0.0) -> dict[str, Any]:
    north_m, east_m = MARKS[label][0] - OWN[0], MARKS[label][1] - OWN[1]
    value = math.hypot(north_m, east_m) if kind == "range" else math.degrees(math.atan2(east_m, north_m))
    turn = heading_deg if kind == "relative_bearing" else 0.0
    return {"mark": label, "kind": kind, "value": value - turn + error, "sigma": SIGMA[kind]}


def plane_case(observations: list[dict[str, Any]], **more: Any) -> Case:
    marks = [{"label": label, "north_m": north, "east_m": east} for label, (north, east) in MARKS.items()]
    return case_of({"frame": "plane", "marks": marks, "observations": observations, **more})


def off_m(position: object) -> float:
    assert isinstance(position, PlanePosition)
    return math.hypot(position.north_m - OWN[0], position.east_m - OWN[1])


def everything(heading_deg: float = 0.0, bearing: str = "relative_bearing") -> list[dict[str, Any]]:
    return [observed(label, kind, heading_deg) for label in MARKS for kind in ("range", bearing)]


@pytest.mark.parametrize("kernel", ["none", "huber", "hampel", "danish", "tukey"])
@pytest.mark.parametrize("start", [None, {"north_m": 1500.0, "east_m": 100.0, "heading_deg": 330.0}])
@pytest.mark.parametrize("solver", ["gtsam", "dense"])
def test_exact_data_give_position_and_heading(kernel: str, start: dict[str, float] | None, solver: Any) -> None:
    case = plane_case(everything(350.0), **({"start": start} if start else {}))
    fix = adjust_case(case, kernel=kernel, solver=solver)
    assert off_m(fix.position) < 1e-5
    assert fix.heading_deg == pytest.approx(350.0, abs=1e-6)
    assert fix.covariance.shape == fix.cofactor_matrix.shape == (3, 3)
    assert fix.redundancy == 8 - 3


@pytest.mark.parametrize("kinds", [("range",), ("true_bearing",), ("range", "true_bearing")])
def test_without_relative_bearings_the_heading_is_no_unknown(kinds: tuple[str, ...]) -> None:
    case = plane_case([observed(label, kind) for label in MARKS for kind in kinds])
    fix = adjust_case(case)
    assert off_m(fix.position) < 1e-5
    assert fix.heading_deg is None
    assert fix.covariance.shape == (2, 2)


def test_relative_bearings_alone_are_enough_from_four_marks() -> None:
    case = plane_case(
        [observed(label, "relative_bearing", 77.0) for label in MARKS],
        start={"north_m": 500.0, "east_m": 0.0, "heading_deg": 70.0},
    )
    fix = adjust_case(case)
    assert off_m(fix.position) < 1e-4
    assert fix.heading_deg == pytest.approx(77.0, abs=1e-6)


def test_observations_keep_their_order_and_add_up() -> None:
    rows = [observed("C", "range", error=15.0), *everything(20.0), observed("A", "true_bearing", error=0.3)]
    fix = adjust_case(plane_case(rows), kernel="none")
    assert [(o.mark, o.kind) for o in fix.observations] == [(row["mark"], row["kind"]) for row in rows]
    for row, o in zip(rows, fix.observations, strict=True):
        assert o.observed == pytest.approx(row["value"] if o.kind == "range" else row["value"] % 360.0)
        assert (o.adjusted - o.observed - o.residual + 180.0) % 360.0 == pytest.approx(180.0, abs=1e-6)
    assert sum(o.redundancy_number for o in fix.observations) == pytest.approx(fix.redundancy)


def test_with_a_start_the_minimum_on_its_side_is_the_fix_and_the_other_an_alternative() -> None:
    """Two ranges cross in two places."""
    rows = [observed("A", "range"), observed("C", "range")]
    found = []
    for start in ({"north_m": 900.0, "east_m": -900.0}, {"north_m": 2000.0, "east_m": 3000.0}):
        fix = adjust_case(plane_case(rows, start=start), kernel="none")
        assert len(fix.alternatives) == 1
        found.append((fix.position, fix.alternatives[0].position))
    assert off_m(found[0][0]) < 1e-3
    assert off_m(found[1][1]) < 1e-3
    for one, other in zip(found[0], reversed(found[1]), strict=True):
        assert isinstance(one, PlanePosition)
        assert isinstance(other, PlanePosition)
        assert math.dist((one.north_m, one.east_m), (other.north_m, other.east_m)) < 1e-3


def test_without_a_start_two_places_that_fit_alike_are_ambiguous() -> None:
    with pytest.raises(Ambiguous) as caught:
        adjust_case(plane_case([observed("A", "range"), observed("C", "range")]))
    first, second = caught.value.alternatives[:2]
    assert min(off_m(first.position), off_m(second.position)) < 1e-3
    assert first.score == pytest.approx(second.score, abs=1e-6)


def test_a_start_far_off_does_not_hold_a_redescending_kernel() -> None:
    """4 km off every observation is an outlier: the start itself would look like a minimum."""
    far = {"north_m": 5000.0, "east_m": -1500.0, "heading_deg": 10.0}
    fix = adjust_case(plane_case(everything(20.0), start=far), kernel="tukey")
    assert off_m(fix.position) < 1e-4


def test_one_wrong_identity_bends_least_squares_and_not_the_robust_fix() -> None:
    rows = [*everything(20.0), observed("A", "range", 20.0), observed("A", "relative_bearing", 20.0)]
    rows[-2] |= {"mark": "B", "target": "wrong"}
    rows[-1] |= {"mark": "B", "target": "wrong"}
    case = plane_case(rows)
    classical, robust = adjust_case(case, kernel="none"), adjust_case(case, kernel="hampel")
    assert off_m(robust.position) < 1.0 < 200.0 < off_m(classical.position)
    assert [o.target for o in robust.outliers] == ["wrong", "wrong"]


def test_an_observation_left_out_takes_no_part() -> None:
    rows = everything(20.0)
    rows[0] |= {"value": 9999.0, "use": False}
    fix = adjust_case(plane_case(rows), kernel="none")
    assert off_m(fix.position) < 1e-4
    assert fix.redundancy == 7 - 3
    assert fix.observations[0].weight == 0.0


def test_an_uncertain_mark_counts_less() -> None:
    rows = [observed(label, "range", error=30.0 if label == "A" else 0.0) for label in MARKS]
    marks = [{"label": label, "north_m": n, "east_m": e} for label, (n, e) in MARKS.items()]
    near = adjust_case(case_of({"frame": "plane", "marks": marks, "observations": rows}), kernel="none")
    marks[0]["sigma_m"] = 500.0
    loose = adjust_case(case_of({"frame": "plane", "marks": marks, "observations": rows}), kernel="none")
    assert off_m(loose.position) < 0.1 * off_m(near.position)
    assert loose.observations[0].sigma == pytest.approx(math.hypot(20.0, 500.0))


@pytest.mark.parametrize(("lat_deg", "lon_deg"), [(0.0, 0.0), (54.0, 180.0), (-70.0, -179.95)])
@pytest.mark.parametrize("with_start", [True, False])
def test_on_the_ellipsoid_exact_geodesics_give_own_ship(lat_deg: float, lon_deg: float, with_start: bool) -> None:
    own, heading_deg = Position(lat_deg, lon_deg), 250.0
    polar = {"A": (20_000.0, 10.0), "B": (15_000.0, 130.0), "C": (30_000.0, 215.0), "D": (9_000.0, 300.0)}
    places = {label: direct(own, bearing, reach) for label, (reach, bearing) in polar.items()}
    start = direct(own, 33.0, 2000.0)
    more = {"start": {"lat_deg": start.lat_deg, "lon_deg": start.lon_deg, "heading_deg": 245.0}} if with_start else {}
    case = case_of(
        {
            "frame": "wgs84",
            "marks": [{"label": k, "lat_deg": p.lat_deg, "lon_deg": p.lon_deg} for k, p in places.items()],
            "observations": [
                {"mark": k, "kind": kind, "value": value, "sigma": SIGMA[kind]}
                for k, (reach, bearing) in polar.items()
                for kind, value in (("range", reach), ("relative_bearing", bearing - heading_deg))
            ],
            **more,
        }
    )
    fix = adjust_case(case)
    assert isinstance(fix.position, Position)
    assert inverse(fix.position, own)[0] < 1e-3
    assert fix.heading_deg == pytest.approx(heading_deg, abs=1e-6)


def test_the_first_step_is_classical_and_goes_from_start_to_fix() -> None:
    """10 m beside the fix one step does nearly all of the way, whatever the kernel."""
    case = plane_case(everything(20.0), start={"north_m": OWN[0] + 10.0, "east_m": OWN[1], "heading_deg": 20.0})
    step = first_step(case, adjust_case(case, kernel="tukey"))
    assert step is not None
    assert step.increments == pytest.approx([-10.0, 0.0, 0.0], abs=0.05)
    assert step.weights == pytest.approx([1.0 / SIGMA[o.kind] ** 2 for o in case.observations])
    A, P, L = step.design_matrix, np.diag(step.weights), step.free_terms
    assert step.increments == pytest.approx(-np.linalg.solve(A.T @ P @ A, A.T @ P @ L))


def test_a_start_in_line_with_the_marks_has_no_first_step() -> None:
    rows = [observed("A", "true_bearing"), observed("B", "true_bearing")]
    middle = {"north_m": (MARKS["A"][0] + MARKS["B"][0]) / 2, "east_m": (MARKS["A"][1] + MARKS["B"][1]) / 2}
    case = plane_case(rows, start=middle)
    assert first_step(case, adjust_case(plane_case(rows))) is None


def test_too_few_observations_have_no_fix() -> None:
    with pytest.raises(TooFewPairs, match="1 observations cannot determine 2 unknowns"):
        adjust_case(plane_case([observed("A", "range")]))
    with pytest.raises(TooFewPairs, match="2 observations cannot determine 3 unknowns"):
        adjust_case(plane_case([observed(label, "relative_bearing") for label in "AB"]))


def test_one_mark_seen_twice_leaves_a_direction_free() -> None:
    with pytest.raises(Unobservable):
        adjust_case(plane_case([observed("A", "true_bearing"), observed("A", "true_bearing")]))


def test_observations_that_contradict_each_other_have_no_robust_fix() -> None:
    rows = [observed(label, "range", error=error) for label, error in zip("ABCD", (0, 3000, -2500, 4000), strict=True)]
    with pytest.raises((NoAgreement, Ambiguous)):
        adjust_case(plane_case(rows), kernel="hampel")


@pytest.mark.parametrize(
    ("lat_deg", "bearing"),
    [(75.0, "true_bearing"), (89.0, "true_bearing"), (89.0, "relative_bearing"), (89.99, "relative_bearing")],
)
def test_near_the_pole_the_heading_turns_with_the_meridians(lat_deg: float, bearing: str) -> None:
    """At 89.99 N, 1.1 km from the pole, north in the middle of the marks is another direction altogether."""
    own, marks, seen = Position(lat_deg, 10.0), [], []
    for index in range(8):
        azimuth_deg, range_m = 45.0 * index + 3.0, 2000.0 + 700.0 * index
        place, label = direct(own, azimuth_deg, range_m), f"M{index}"
        turn_deg = 90.0 if bearing == "relative_bearing" else 0.0
        marks.append({"label": label, "lat_deg": place.lat_deg, "lon_deg": place.lon_deg, "sigma_m": 5.0})
        seen.append({"mark": label, "kind": "range", "value": range_m, "sigma": 30.0})
        seen.append({"mark": label, "kind": bearing, "value": azimuth_deg - turn_deg, "sigma": 1.0})
    fix = adjust_case(case_of({"frame": "wgs84", "marks": marks, "observations": seen}))
    assert isinstance(fix.position, Position)
    assert inverse(fix.position, own)[0] < 1e-3
    if bearing == "relative_bearing":
        assert fix.heading_deg == pytest.approx(90.0, abs=1e-4)
