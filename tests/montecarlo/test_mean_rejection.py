"""What leave-one-out rejection at Mahalanobis 3 costs and finds: counted, and against its exact law."""

from __future__ import annotations

import numpy as np
import pytest

from navfix.adjustment.mean import REJECTION_DISTANCE, outlying


def rejected_when_all_are_good(places: int) -> float:
    """Return the probability that one good place of n is rejected.

    The squared distance of a normal place from the mean of m = n - 1 others, in their own covariance, is
    2 (m + 1)(m - 1) / (m (m - 2)) times F(2, m - 2) (Hotelling), whose tail is (1 + 2 f / nu)^(-nu / 2).
    """
    m = places - 1
    f = REJECTION_DISTANCE**2 * m * (m - 2) / (2.0 * (m + 1) * (m - 1))
    return float((1.0 + 2.0 * f / (m - 2)) ** (-(m - 2) / 2.0))


@pytest.mark.parametrize(("places", "by_law"), [(5, 0.294), (8, 0.123), (20, 0.0368), (60, 0.0175)])
def test_good_places_are_rejected_as_often_as_the_law_says(places: int, by_law: float) -> None:
    """With few places the price is high: 29 % of the good ones of five, where 1.1 % would be that of known sigmas."""
    expected = rejected_when_all_are_good(places)
    assert expected == pytest.approx(by_law, rel=0.005)
    random = np.random.default_rng(places)
    shape = np.array([[50.0, 0.0], [30.0, 20.0]])
    runs = 600
    rate = np.mean([outlying(random.normal(size=(places, 2)) @ shape.T).mean() for _ in range(runs)])
    assert rate == pytest.approx(expected, rel=0.12)


def test_one_wrong_place_is_found_and_many_hide_each_other() -> None:
    """Power of the rejection, 20 places of 50 m spread, wrong ones 300 m off in all directions."""
    random, found = np.random.default_rng(4), {}
    for wrong in (1, 6, 9):
        hits = []
        for _ in range(300):
            places = random.normal(scale=50.0, size=(20, 2))
            directions = random.uniform(0.0, 2.0 * np.pi, wrong)
            places[:wrong] += 300.0 * np.column_stack([np.cos(directions), np.sin(directions)])
            hits.append(outlying(places)[:wrong].mean())
        found[wrong] = float(np.mean(hits))
    assert found[1] > 0.98
    assert found[6] < 0.45
    assert found[9] < 0.13
