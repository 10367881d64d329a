"""The compass in true bearings: its error is an unknown with a prior, and the position's covariance contains it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from navfix.adjustment import adjust, graph
from navfix.adjustment.compass import failure_cost
from navfix.errors import InputError, NoFix
from navfix.geodesy import LocalPlane, direct, inverse
from navfix.types import Association, Epoch, Fix, confidence_radius
from tests.adjustment_scenes import GDYNIA_BAY as OWN
from tests.adjustment_scenes import epoch_scene

Scene = tuple[Epoch, Association]


def true_scene(seed: int, *, error_deg: float = 0.0, **scene: object) -> Scene:
    """Return a scene of true bearings shown by a compass that is ``error_deg`` off: true = shown + error."""
    epoch, association = epoch_scene(np.random.default_rng(seed), bearing_reference="true", **scene)  # type: ignore[arg-type]
    return turned(epoch, error_deg), association


def turned(epoch: Epoch, error_deg: float) -> Epoch:
    targets = tuple(
        replace(t, bearing_deg=t.bearing_deg - error_deg) if t.bearing_reference == "true" else t for t in epoch.targets
    )
    return replace(epoch, targets=targets)


def mixed_scene(seed: int, *, error_deg: float, marks: int = 12, noise: float = 1.0) -> Scene:
    """Every second bearing true, shown by a compass that is off; the others relative at heading 123.4."""
    epoch, association = epoch_scene(np.random.default_rng(seed), marks=marks, noise=noise)
    targets = tuple(
        replace(t, bearing_reference="true", bearing_deg=t.bearing_deg + 123.4) if i % 2 else t
        for i, t in enumerate(epoch.targets)
    )
    return turned(replace(epoch, targets=targets), error_deg), association


def distance(fix: Fix) -> float:
    """Return the Mahalanobis distance of the truth from the fix."""
    assert not isinstance(fix.position, tuple)
    offset = LocalPlane(fix.position).to_plane(OWN)  # type: ignore[arg-type]
    return math.sqrt(offset @ np.linalg.solve(fix.covariance[:2, :2], offset))


def radius_of(fix: Fix, probability: float = 0.95) -> float:
    return confidence_radius(probability, dof=fix.dof if fix.covariance_scaling == "a_posteriori" else None)


def test_exact_bearings_of_a_compass_that_is_off_give_its_error() -> None:
    epoch, association = true_scene(1, error_deg=2.0, noise=0.0, marks=12)
    fix = adjust(epoch, association, compass_sigma_deg=1.5)
    assert fix.compass_error_deg == pytest.approx(2.0, abs=0.1)  # the prior pulls a little
    assert fix.compass_error_sigma_deg is not None
    assert inverse(OWN, fix.position)[0] < 5.0
    assert fix.heading_deg is None
    assert fix.covariance.shape == fix.cofactor_matrix.shape == (2, 2)
    assert any("compass error +" in note for note in fix.notes)


def test_adjusted_true_bearings_are_those_that_the_compass_shows() -> None:
    epoch, association = true_scene(2, error_deg=2.0)
    fix = adjust(epoch, association)
    assert {o.kind for o in fix.observations} == {"range", "true_bearing"}
    bearing, mark = fix.observations[1], epoch.marks[0]
    azimuth = inverse(fix.position, mark.position)[1]
    true_deg = bearing.adjusted + (fix.compass_error_deg or 0.0)
    assert (true_deg - azimuth + 180.0) % 360.0 == pytest.approx(180.0, abs=1e-5)
    assert bearing.observed == pytest.approx(epoch.targets[0].bearing_deg)


@pytest.mark.parametrize("error_deg", [0.0, 3.0, -3.0])
def test_a_compass_a_few_degrees_off_does_not_give_a_confident_wrong_fix(error_deg: float) -> None:
    """60 fixes from four marks in a sector of 60 deg: the 95 % ellipse holds what the held compass loses."""
    inside = held_inside = refused = 0
    for seed in range(60):
        epoch, association = true_scene(100 + seed, error_deg=error_deg, marks=4, sector_deg=60.0)
        held = adjust(epoch, association, compass_sigma_deg=0.0, kernel="none")
        held_inside += distance(held) < radius_of(held)
        try:
            fix = adjust(epoch, association)
        except NoFix:
            refused += 1
            continue
        inside += distance(fix) < radius_of(fix)
    assert refused <= 3
    assert inside >= 0.88 * (60 - refused)
    if error_deg:
        assert held_inside < 0.7 * inside


def test_the_ellipse_contains_the_compass() -> None:
    """Marks in one direction: across it the sigma is at least distance x compass sigma where nothing else tells it."""
    epoch, association = true_scene(4, marks=1, noise=0.0)
    reach_m = epoch.targets[0].range_m
    fix = adjust(epoch, association, compass_sigma_deg=1.5)
    assert fix.ellipse(0.95).semi_major_m >= confidence_radius(0.95) * math.radians(1.5) * reach_m
    held = adjust(epoch, association, compass_sigma_deg=0.0)
    assert held.compass_error_deg is None
    assert held.ellipse(0.95).semi_major_m < 0.5 * fix.ellipse(0.95).semi_major_m


@pytest.mark.parametrize("told", [True, False])
def test_a_compass_twenty_degrees_off_is_found_out(told: bool) -> None:
    """Its error is estimated from the data, whether the association says so (its heading is the turn) or not."""
    epoch, association = true_scene(5, error_deg=20.0, marks=10, wrong=1)
    if told:
        association = replace(association, position=direct(OWN, 30.0, 100.0), heading_deg=19.5)
    fix = adjust(epoch, association)
    assert inverse(OWN, fix.position)[0] < 60.0
    assert fix.compass_error_deg == pytest.approx(20.0, abs=1.0)
    assert any("CHECK THE COMPASS" in note for note in fix.notes)
    assert distance(fix) < 3.5


def test_a_compass_twenty_degrees_off_with_few_marks_is_no_confident_wrong_fix() -> None:
    """Two to four marks: either no fix, or one whose ellipse holds."""
    outcomes = []
    for seed in range(60):
        epoch, association = true_scene(300 + seed, error_deg=20.0, marks=2 + seed % 3)
        try:
            fix = adjust(epoch, association)
        except NoFix as reason:
            outcomes.append(reason.reason)
            continue
        outcomes.append("inside" if distance(fix) < radius_of(fix, 0.999) else "wrong")
    assert outcomes.count("wrong") <= 2


@pytest.mark.parametrize("error_deg", [0.0, 2.0, 25.0])
def test_relative_and_true_bearings_give_heading_and_compass_error(error_deg: float) -> None:
    epoch, association = mixed_scene(6, error_deg=error_deg)
    fix = adjust(epoch, association)
    assert inverse(OWN, fix.position)[0] < 40.0
    assert fix.heading_deg == pytest.approx(123.4, abs=0.8)
    assert fix.compass_error_deg == pytest.approx(error_deg, abs=0.8)
    assert fix.covariance.shape == (3, 3)
    assert any("CHECK THE COMPASS" in note for note in fix.notes) == (error_deg == 25.0)
    assert {o.kind for o in fix.observations} == {"range", "relative_bearing", "true_bearing"}


def test_the_eliminated_compass_error_is_that_of_four_unknowns() -> None:
    """Least squares with mixed bearings against a design matrix with four columns, by numpy alone."""
    epoch, association = mixed_scene(7, error_deg=1.0)
    fix = adjust(epoch, association, kernel="none", compass_sigma_deg=1.5)
    rows, values = [], []
    for o, mark in zip(fix.observations, [m for m in epoch.marks for _ in range(2)], strict=True):
        north, east = LocalPlane(fix.position).to_plane(mark.position)  # type: ignore[arg-type]
        d = math.hypot(north, east)
        if o.kind == "range":
            row = [-north / d, -east / d, 0.0, 0.0]
        else:
            row = [east / d**2, -north / d**2, -1.0 * (o.kind == "relative_bearing"), -1.0 * (o.kind == "true_bearing")]
        unit = 1.0 if o.kind == "range" else math.radians(1.0)
        rows.append(np.array(row) / (o.sigma * unit))
        values.append(o.residual / o.sigma)
    prior = math.radians(1.5)
    rows.append(np.array([0.0, 0.0, 0.0, 1.0 / prior]))
    values.append(math.radians(fix.compass_error_deg or 0.0) / prior)
    A, v = np.array(rows), np.array(values)
    Q = np.linalg.inv(A.T @ A)
    assert np.abs(Q @ A.T @ v) == pytest.approx(0.0, abs=1e-4)  # nothing left to gain
    np.testing.assert_allclose(fix.cofactor_matrix, Q[:3, :3], rtol=1e-5, atol=1e-12)
    assert fix.sigma0 == pytest.approx(math.sqrt(v @ v / (len(v) - 4)), rel=1e-9)
    redundancy = 1.0 - np.sum((A @ Q) * A, axis=1)
    assert [o.redundancy_number for o in fix.observations] == pytest.approx(redundancy[:-1], abs=1e-6)


@pytest.mark.parametrize("mixed", [False, True])
def test_both_roads_agree_on_the_compass(mixed: bool) -> None:
    if not graph.available():
        pytest.skip("GTSAM is not installed")
    epoch, association = mixed_scene(8, error_deg=2.0) if mixed else true_scene(8, error_deg=2.0, wrong=3)
    one, other = (adjust(epoch, association, solver=solver) for solver in ("gtsam", "dense"))  # type: ignore[arg-type]
    assert inverse(one.position, other.position)[0] < 1e-4
    assert one.compass_error_deg == pytest.approx(other.compass_error_deg, abs=1e-6)
    np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-5, atol=1e-12)


def test_the_sigma_comes_from_the_option_then_the_radar() -> None:
    epoch, association = true_scene(9, marks=1, noise=0.0)
    assert adjust(epoch, association).compass_error_sigma_deg == pytest.approx(1.5)
    assert adjust(epoch, association, compass_sigma_deg=0.7).compass_error_sigma_deg == pytest.approx(0.7)
    with pytest.raises(InputError, match="compass_sigma_deg"):
        adjust(epoch, association, compass_sigma_deg=-1.0)


def test_a_failed_compass_is_about_four_sigma_away() -> None:
    assert math.sqrt(2.0 * failure_cost(math.radians(1.5))) == pytest.approx(4.28, abs=0.01)
