"""Errors of many answers in one line, and the ellipse that holds a point or not."""

from __future__ import annotations

import math

import numpy as np

from navfix.report.answer import Truth
from navfix.report.error_summary import ErrorSummary
from navfix.types import Ellipse, Position, confidence_radius

PLACE = Position(54.0, 8.0)


def test_an_ellipse_holds_what_lies_within_its_mahalanobis_radius() -> None:
    covariance = np.array([[400.0, 150.0], [150.0, 100.0]])
    ellipse = Ellipse.from_covariance(covariance, 0.95, dof=5.0)
    rng = np.random.default_rng(1)
    points = rng.multivariate_normal(np.zeros(2), 9.0 * covariance, 500)
    within = np.sqrt(np.sum(points * np.linalg.solve(covariance, points.T).T, axis=1)) <= confidence_radius(
        0.95, dof=5.0
    )
    assert 100 < within.sum() < 400
    assert [ellipse.holds(*point) for point in points.tolist()] == within.tolist()


def test_a_flat_ellipse_holds_its_axis_alone() -> None:
    flat = Ellipse(10.0, 0.0, 90.0, 0.95)
    assert flat.holds(0.0, 0.0)
    assert not flat.holds(1.0, 0.0)
    assert not Ellipse(0.0, 0.0, 0.0, 0.95).holds(0.1, 0.0)


def test_the_summary_counts_fixes_and_truths_apart() -> None:
    summary = ErrorSummary()
    assert summary.words() == "0 of them with a truth"
    summary.feed(None)
    summary.feed(Truth(PLACE))
    assert summary.words() == "1 of them with a truth"
    for error_m in range(1, 22):
        summary.feed(Truth(PLACE, error_m=float(error_m), in_ellipse=error_m <= 20))
    assert summary.words() == (
        "22 of them with a truth: off 11 m in the median, 20 m at 95 %, 21 m at worst; 95 % inside the 95 % ellipse"
    )


def test_a_point_on_the_axes() -> None:
    ellipse = Ellipse(20.0, 5.0, 30.0, 0.95)
    azimuth = math.radians(30.0)
    assert ellipse.holds(19.9 * math.cos(azimuth), 19.9 * math.sin(azimuth))
    assert not ellipse.holds(5.1 * math.cos(azimuth + math.pi / 2), 5.1 * math.sin(azimuth + math.pi / 2))
    assert ellipse.holds(4.9 * math.cos(azimuth + math.pi / 2), 4.9 * math.sin(azimuth + math.pi / 2))
