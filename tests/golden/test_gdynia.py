"""The check test of the Gdynia stand: its matrices, its errors, and its position with the right sign."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Proj, Transformer

from navfix.adjustment.case import Case, case_of
from navfix.adjustment.case_frame import network_about
from navfix.adjustment.network import Network
from navfix.adjustment.sights import jacobian
from navfix.adjustment.textbook import LinearStep, linear_step
from navfix.types import FloatArray, PlanePosition

GOLDEN = Path(__file__).resolve().parents[2] / "data" / "golden"


def read(name: str) -> dict[str, Any]:
    return tomllib.loads((GOLDEN / f"{name}.toml").read_text(encoding="utf-8"))


GDYNIA, ELLIPSOID = read("gdynia"), read("gdynia_ellipsoid")
EXPECTED = GDYNIA["expected"]


def tolerance(name: str) -> float:
    return float(GDYNIA["tolerance"][name]["value"])


@pytest.fixture(scope="module")
def case() -> Case:
    return case_of(GDYNIA)


@pytest.fixture(scope="module")
def step(case: Case) -> LinearStep:
    assert case.start is not None
    return linear_step(network_about(case, case.start), np.zeros(3))


def x_y(north_east: FloatArray) -> FloatArray:
    """Return columns in the paper's order: X is east, Y is north."""
    return north_east[..., ::-1]


def test_the_printed_design_matrix_has_the_opposite_sign_of_its_derivative(step: LinearStep) -> None:
    assert x_y(step.design_matrix) == pytest.approx(
        -np.array(EXPECTED["design_matrix_x_y"]), abs=tolerance("design_matrix")
    )


def test_a_step_east_turns_a_mark_in_the_north_to_the_left() -> None:
    """The sign of the derivative, seen by hand: mark 10 km north, 100 m east bring it 0.573 deg to the left."""
    north = Network.build([2], [0], [0.0], math.radians(1.0), [[10_000.0, 0.0]])
    assert math.degrees(jacobian(north, np.zeros(3))[0, 1] * 100.0) == pytest.approx(-0.573, abs=1e-3)


def test_free_terms_are_computed_minus_observed(step: LinearStep) -> None:
    assert step.free_terms == pytest.approx(EXPECTED["free_terms_deg"], abs=tolerance("free_terms_deg"))


def test_increments_have_the_printed_size_and_the_other_sign(step: LinearStep) -> None:
    assert x_y(step.increments) == pytest.approx(-np.array(EXPECTED["increments_x_y_m"]), abs=tolerance("increments_m"))


def test_residuals_are_the_printed_ones(step: LinearStep) -> None:
    assert step.residuals == pytest.approx(EXPECTED["residuals_deg"], abs=tolerance("residuals_deg"))


def test_adjusted_bearings_are_the_printed_ones(step: LinearStep) -> None:
    adjusted = np.round(EXPECTED["table_bearings_deg"] + step.residuals, 2)
    assert adjusted == pytest.approx(EXPECTED["adjusted_bearings_deg"], abs=tolerance("adjusted_bearings_deg"))


def test_sigma0_and_the_errors_that_it_scales_are_the_printed_ones(step: LinearStep) -> None:
    assert step.sigma0 == pytest.approx(EXPECTED["sigma0"], abs=tolerance("sigma0"))
    assert step.adjusted_sigma == pytest.approx(EXPECTED["adjusted_sigma_deg"], abs=tolerance("adjusted_sigma_deg"))
    assert step.position_sigma_m == pytest.approx(EXPECTED["position_sigma_m"], abs=tolerance("position_sigma_m"))


def test_the_printed_position_is_the_mirror_image_of_the_right_one(case: Case, step: LinearStep) -> None:
    assert isinstance(case.start, PlanePosition)
    start = np.array([case.start.east_m, case.start.north_m])
    right, printed = start + x_y(step.increments), start - x_y(step.increments)
    assert right == pytest.approx(EXPECTED["linear_position_x_y_m"], abs=tolerance("position_m"))
    # the printed Y has a misprinted increment (13529 for 352.9): the position is that of 352.9
    assert printed == pytest.approx(EXPECTED["printed_position_x_y_m"], abs=0.05)


def test_the_right_sign_makes_the_bearings_fit_and_the_printed_one_does_not(case: Case, step: LinearStep) -> None:
    def misfit(sign: float) -> float:
        assert isinstance(case.start, PlanePosition)
        north_m, east_m = sign * step.increments
        place = PlanePosition(case.start.north_m + north_m, case.start.east_m + east_m)
        return float(np.sum(linear_step(network_about(case, place), np.zeros(3)).free_terms ** 2))

    at_start = float(np.sum(step.free_terms**2))
    assert misfit(+1.0) < 0.2 * at_start
    assert misfit(-1.0) > 2.0 * at_start


def test_mark_5_is_the_outlier(step: LinearStep) -> None:
    """|v| / sigma_v, sigma_v = sqrt(1 - AQA'): 3.30 for mark 5."""
    w = np.abs(step.residuals) / np.sqrt(1.0 - np.diag(step.observation_cofactors))
    assert int(np.argmax(w)) + 1 == int(EXPECTED["outlier"])
    assert w[4] == pytest.approx(3.30, abs=0.005)


def test_the_range_matrix_of_the_figure_is_made_of_unit_vectors_of_the_same_sign() -> None:
    table = read("gdynia_range_matrix")
    rows, allowed = np.array(table["rows"]), table["tolerance"]["value"]
    assert np.hypot(*rows.T) == pytest.approx(np.ones(len(rows)), abs=allowed)
    ranges = Network.build(np.zeros(8, int), np.arange(8), np.full(8, 5000.0), 50.0, 5000.0 * rows)
    assert jacobian(ranges, np.zeros(3))[:, :2] == pytest.approx(-rows, abs=allowed)


def test_grid_coordinates_and_places_on_the_ellipsoid_are_the_same_marks() -> None:
    to_utm = Transformer.from_crs("EPSG:4326", "EPSG:32634", always_xy=True)
    places = {mark["label"]: mark for mark in ELLIPSOID["marks"]} | {"start": ELLIPSOID["start"]}
    for label, expected in ELLIPSOID["expected"]["utm_x_y_m"].items():
        ours = to_utm.transform(places[label]["lon_deg"], places[label]["lat_deg"])
        assert ours == pytest.approx(expected, abs=ELLIPSOID["tolerance"]["utm_m"]["value"])
    start = places["start"]
    factors = Proj("EPSG:32634").get_factors(start["lon_deg"], start["lat_deg"])
    assert factors.meridian_convergence == pytest.approx(ELLIPSOID["expected"]["convergence_at_start_deg"], abs=0.0005)
