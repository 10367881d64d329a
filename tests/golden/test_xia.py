"""Source [11], ship positions of radar and AIS fused: the published weights and variances."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from navfix.picture.ellipse import antenna_step
from navfix.picture.fusion import fuse, fuse_angles
from navfix.picture.hull import Size, echo


def test_weights_and_fused_variances_of_the_published_example(repository: Path):
    case = tomllib.loads((repository / "data/golden/xia_fusion.toml").read_text(encoding="utf-8"))
    expected, tolerance = case["expected"], case["tolerance"]
    for sensor in ("ais", "radar"):
        for kind, unit in (("range", "m2"), ("bearing", "deg2")):
            weight = 1.0 / case[f"{sensor}_{kind}_variance_{unit}"]
            assert weight == pytest.approx(expected[f"{sensor}_{kind}_weight"], abs=tolerance["weight"])
    _, range_m2 = fuse(
        np.array([5657.0, 5600.0]), np.array([case["ais_range_variance_m2"], case["radar_range_variance_m2"]])
    )
    _, bearing_deg2 = fuse_angles(
        np.array([45.0, 44.0]), np.array([case["ais_bearing_variance_deg2"], case["radar_bearing_variance_deg2"]])
    )
    assert range_m2 == pytest.approx(expected["fused_range_variance_m2"], abs=tolerance["fused_range_variance_m2"])
    assert bearing_deg2 == pytest.approx(
        expected["fused_bearing_variance_deg2"], abs=tolerance["fused_bearing_variance_deg2"]
    )


def test_the_printed_bearing_variance_of_ais_is_a_hundred_metres_at_the_range_of_the_example():
    """1.2 deg2 at (4000, 4000) m; an AIS position good to 10 m has 0.01 deg2 there: ours come from metres."""
    across_m = np.hypot(4000.0, 4000.0) * np.radians(np.sqrt(1.2))
    assert across_m == pytest.approx(108.2, abs=0.1)


def test_bow_on_the_nearest_edge_is_186_m_before_an_antenna_a_quarter_of_the_length_aft():
    bow_m = echo(Size(249.0, 44.0), 0.0).depth_m
    assert bow_m == pytest.approx(124.5)
    assert bow_m - float(antenna_step(249.0, 0.0)[0]) == pytest.approx(186.75)
