"""GM(1,1): its two forms, its traps, and what it is good for (source: AARFS system level design, eq. 1.3 to 1.17)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navfix.errors import InputError
from navfix.picture.motion.grey_model import (
    accumulate,
    admissible,
    at_times,
    class_ratios,
    closed_form,
    fit,
    fit_by_matrix,
    lifted,
    lifted_angles,
    longest_admissible,
    means,
)


def test_accumulated_series_and_means_by_hand():
    assert accumulate([1.0, 2.0, 3.0]).tolist() == [1.0, 3.0, 6.0]
    assert means([1.0, 2.0, 3.0]).tolist() == [2.0, 4.5]
    assert class_ratios([1.0, 2.0, 8.0]).tolist() == [0.5, 0.25]


@given(st.lists(st.floats(5.0, 20.0), min_size=5, max_size=12))
def test_the_closed_and_the_matrix_form_agree(values: list[float]):
    closed, matrix = fit(values), fit_by_matrix(values)
    scale = max(abs(matrix.a), abs(matrix.b), 1.0)
    assert abs(closed.a - matrix.a) < 1e-9 * scale
    assert abs(closed.b - matrix.b) < 1e-9 * scale


def test_the_closed_form_is_that_of_a_solver() -> None:
    values = np.array([2.0, 2.2, 2.5, 2.6, 3.0, 3.1])
    total = np.cumsum(values)
    B = np.stack([-0.5 * (total[1:] + total[:-1]), np.ones(5)], axis=1)
    model = closed_form(values)
    assert (model.a, model.b) == pytest.approx(np.linalg.lstsq(B, values[1:], rcond=None)[0], abs=1e-9)


@given(st.floats(0.1, 1e5))
def test_any_constant_series_stays_constant(value: float) -> None:
    assert closed_form(np.full(7, value)).value([0.0, 0.5, 3.0, 6.5]) == pytest.approx(np.full(4, value), rel=1e-6)


def test_an_exponential_is_followed_between_its_points() -> None:
    values = 1000.0 * 1.01 ** np.arange(10)
    steps = np.array([2.5, 4.0, 8.5])
    assert closed_form(values).value(steps) == pytest.approx(1000.0 * 1.01**steps, rel=1e-4)


@pytest.mark.parametrize(
    ("values", "level"), [([3.0], 3.0), ([3.0, 5.0], 5.0), ([1e12, 2.0, 3.0, 4.0], 3.0)], ids=["one", "two", "jump"]
)
def test_a_series_without_a_single_answer_is_level_after_its_first_value(values: list[float], level: float) -> None:
    model = closed_form(values)
    assert (model.a, model.b, model.first) == (0.0, level, values[0])
    assert model.value([0.0, 1.0, 2.5]) == pytest.approx([values[0], level, level])


@pytest.mark.parametrize("value", [7.2, 1e-3, 1e6])
def test_a_constant_series_stays_constant(value: float):
    """b/a diverges there: programs that divide print 8.0 or 0 for 7.2."""
    model = fit([value] * 7)
    assert model.a == pytest.approx(0.0, abs=1e-12)
    assert model.value([0, 1, 2.5, 6, 9]) == pytest.approx([value] * 5, rel=1e-9)


@pytest.mark.parametrize(("growth", "share"), [(1.05, 0.0005), (1.2, 0.0055)])
def test_an_exponential_fits_the_difference_equation_and_nearly_the_response(growth: float, share: float):
    values = 3.0 * growth ** np.arange(6)
    model = fit(values)
    assert values[1:] + model.a * means(values) == pytest.approx(np.full(5, model.b), rel=1e-9)  # eq. (1.8), exact
    assert model.value(np.arange(6)) == pytest.approx(values, rel=share)  # eq. (1.15), by the borrowed equation


def test_the_limit_towards_a_constant_series_is_smooth():
    nearly = fit(5.0 + 1e-9 * np.arange(6))
    assert nearly.value(np.arange(6)) == pytest.approx(np.full(6, 5.0), rel=1e-8)


def test_the_class_ratio_test_bounds_the_ratios():
    limit = math.exp(2.0 / 7.0)
    assert admissible([1.0 * (0.99 * limit) ** k for k in range(6)])
    assert not admissible([1.0 * (1.01 * limit) ** k for k in range(6)])
    assert not admissible([1.0, 1.0, 0.0, 1.0, 1.0, 1.0])
    assert not admissible([1.0, 1.0, -1.0, 1.0, 1.0, 1.0])


def test_the_longest_piece_passes_for_range_bearing_and_speed_together():
    smooth = [100.0 + k for k in range(12)]
    jump = [10.0] * 8 + [30.0] * 4
    assert longest_admissible([smooth, smooth]) == 12
    assert longest_admissible([smooth, jump]) == 8
    assert longest_admissible([smooth, [1.0, 9.0] * 6]) == 0


def test_bearings_across_north_and_values_about_zero_are_lifted_first():
    bearing = np.radians([358.0, 359.0, 0.0, 1.0, 2.0, 3.0])
    assert not admissible(bearing)
    up, shift = lifted_angles(bearing)
    assert admissible(up)
    assert np.degrees(up - shift) == pytest.approx([358.0, 359.0, 360.0, 361.0, 362.0, 363.0])
    assert admissible(lifted([-2.0, -1.0, 0.0, 1.0, 2.0])[0])
    assert lifted([5000.0, 5001.0, 5002.0])[1] == 0.0


def test_one_model_brings_even_scans_onto_the_instants_of_ais():
    """Radar each 3 s, range by a straight run past own ship: within a metre at any time between."""
    scans = 3.0 * np.arange(8)

    def range_m(t: np.ndarray) -> np.ndarray:
        return np.hypot(4000.0 - 8.0 * t, 1500.0)

    wanted = np.array([4.1, 9.7, 16.4, 20.0])
    assert at_times(range_m(scans), 0.0, 3.0, wanted) == pytest.approx(range_m(wanted), abs=1.0)


@pytest.mark.parametrize("values", [[1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0, -1.0], [[1.0] * 5] * 2])
def test_a_series_that_is_too_short_or_not_positive_is_refused(values: list[float]):
    with pytest.raises(InputError, match="at least 5 positive values"):
        fit(values)
