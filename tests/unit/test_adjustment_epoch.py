"""From an epoch and pairs to a fix: the record, the options, the states without a fix."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from navfix.adjustment import adjust, graph
from navfix.catalog import radar_model
from navfix.errors import Ambiguous, CatalogError, InputError, TooFewPairs, Unobservable
from navfix.geodesy import LocalPlane, direct, inverse
from navfix.types import Association, Epoch, HeadingHint, Mark, Position, RadarTarget
from tests.adjustment_scenes import BEARING_SIGMA_RAD, MARK_SIGMA_M, RANGE_SIGMA_M, epoch_scene

OWN = Position(54.5, 18.8)
SIGMA_DEG = math.degrees(BEARING_SIGMA_RAD)


def test_a_fix_carries_what_the_record_promises() -> None:
    epoch, association = epoch_scene(np.random.default_rng(1), wrong=3)
    fix = adjust(epoch, association)
    assert inverse(OWN, fix.position)[0] < 40.0
    assert fix.heading_deg == pytest.approx(123.4, abs=0.6)
    assert fix.covariance.shape == fix.cofactor_matrix.shape == (3, 3)
    assert fix.covariance_scaling == "a_posteriori"
    np.testing.assert_allclose(fix.covariance, fix.sigma0**2 * fix.cofactor_matrix)
    assert fix.redundancy == 40 - 3
    assert fix.dof <= 34.0 - 3.0 + 1e-6
    assert fix.kernel == "hampel"
    assert fix.epoch is epoch
    assert fix.association is association
    assert fix.global_test is not None
    assert fix.integrity is not None
    ellipse = fix.ellipse(0.95)
    assert ellipse.semi_minor_m <= fix.integrity.r95_m <= ellipse.semi_major_m
    assert {o.target for o in fix.outliers} == {"t0", "t1", "t2"}
    assert any("GTSAM" in note for note in fix.notes)


def test_observations_are_reported_in_metres_and_degrees() -> None:
    epoch, association = epoch_scene(np.random.default_rng(2), marks=5)
    fix = adjust(epoch, association)
    assert [(o.target, o.kind) for o in fix.observations[:4]] == [
        ("t0", "range"), ("t0", "relative_bearing"), ("t1", "range"), ("t1", "relative_bearing"),
    ]  # fmt: skip
    for o in fix.observations:
        target = next(t for t in epoch.targets if t.label == o.target)
        assert o.observed == pytest.approx(target.range_m if o.unit == "m" else target.bearing_deg)
        assert (o.adjusted - o.observed - o.residual + 180.0) % 360.0 == pytest.approx(180.0, abs=1e-9)
        assert o.standardized == pytest.approx(o.residual / (o.sigma * math.sqrt(o.redundancy_number)))
        mark_m = MARK_SIGMA_M if o.unit == "m" else math.degrees(MARK_SIGMA_M / target.range_m)
        own = RANGE_SIGMA_M if o.unit == "m" else SIGMA_DEG
        assert o.sigma == pytest.approx(math.hypot(own, mark_m), rel=0.01)


def test_residuals_are_against_exact_geodesics_from_the_fix() -> None:
    epoch, association = epoch_scene(np.random.default_rng(3), Position(72.0, 25.0), marks=6)
    fix = adjust(epoch, association)
    assert fix.heading_deg is not None
    for o, mark in zip(fix.observations[::2], epoch.marks, strict=True):
        assert o.adjusted == pytest.approx(inverse(fix.position, mark.position)[0], abs=2e-3)
    for o, mark in zip(fix.observations[1::2], epoch.marks, strict=True):
        azimuth = inverse(fix.position, mark.position)[1]
        assert (o.adjusted + fix.heading_deg - azimuth + 180.0) % 360.0 == pytest.approx(180.0, abs=1e-5)


def test_sigmas_come_from_options_then_target_then_radar() -> None:
    epoch, _ = epoch_scene(np.random.default_rng(4), marks=4)
    targets = [replace(t, range_sigma_m=None, bearing_sigma_deg=None) for t in epoch.targets]
    targets[0] = replace(targets[0], range_sigma_m=7.0, bearing_sigma_deg=0.2)
    epoch = Epoch(None, tuple(targets), tuple(replace(m, sigma_m=0.0) for m in epoch.marks))
    pairs = Association.from_pairs(epoch, [(i, i) for i in range(4)])
    by_radar = adjust(epoch, pairs, radar="imo", kernel="none").observations
    assert (by_radar[0].sigma, by_radar[1].sigma) == pytest.approx((7.0, 0.2))
    imo = radar_model("imo")
    assert by_radar[2].sigma == pytest.approx(imo.sigma_of_range_m(np.array([targets[1].range_m]))[0])
    assert by_radar[3].sigma == pytest.approx(imo.bearing_sigma_deg)
    by_option = adjust(epoch, pairs, range_sigma_m=50.0, bearing_sigma_deg=2.0, kernel="none").observations
    assert {round(o.sigma, 9) for o in by_option} == {50.0, 2.0}


def test_true_bearings_alone_leave_no_heading_to_find() -> None:
    epoch, association = epoch_scene(np.random.default_rng(5), bearing_reference="true")
    fix = adjust(epoch, association)
    assert fix.heading_deg is None
    assert fix.covariance.shape == (2, 2)
    assert fix.observations[1].kind == "true_bearing"
    assert inverse(OWN, fix.position)[0] < 30.0


def test_true_and_relative_bearings_go_together() -> None:
    epoch, _ = epoch_scene(np.random.default_rng(6), marks=8, noise=0.0)
    mixed = tuple(
        replace(t, bearing_reference="true", bearing_deg=t.bearing_deg + 123.4) if i % 2 else t
        for i, t in enumerate(epoch.targets)
    )
    epoch = replace(epoch, targets=mixed)
    fix = adjust(epoch, Association.from_pairs(epoch, [(i, i) for i in range(8)]))
    assert inverse(OWN, fix.position)[0] < 1e-3
    assert fix.heading_deg == pytest.approx(123.4, abs=1e-6)
    assert fix.covariance.shape == (3, 3)


def test_a_heading_prior_is_evidence_and_the_hint_of_the_epoch_is_not() -> None:
    epoch, association = epoch_scene(np.random.default_rng(7), marks=6)
    hinted = replace(epoch, heading_hint=HeadingHint(10.0, 0.01))
    plain, with_hint = adjust(epoch, association), adjust(hinted, association)
    assert with_hint.heading_deg == pytest.approx(plain.heading_deg)
    helped = adjust(epoch, association, heading_prior=HeadingHint(123.4, 0.05))
    assert helped.cofactor_matrix[2, 2] < 0.1 * plain.cofactor_matrix[2, 2]
    assert helped.redundancy == plain.redundancy + 1


def test_a_wrong_heading_prior_is_called_out() -> None:
    epoch, association = epoch_scene(np.random.default_rng(8), marks=10)
    fix = adjust(epoch, association, heading_prior=HeadingHint(133.4, 1.0))
    assert any("heading prior disagrees" in note for note in fix.notes)


def test_one_pair_and_a_heading_prior_are_a_fix_without_redundancy() -> None:
    epoch, association = epoch_scene(np.random.default_rng(9), marks=1, noise=0.0)
    fix = adjust(epoch, association, heading_prior=HeadingHint(123.4, 1.0))
    assert inverse(OWN, fix.position)[0] < 1e-2
    assert fix.redundancy == 0
    assert fix.covariance_scaling == "a_priori"
    assert all(o.standardized is None and o.mdb is None for o in fix.observations)


def test_too_few_pairs_are_counted() -> None:
    epoch, association = epoch_scene(np.random.default_rng(10), marks=1)
    with pytest.raises(TooFewPairs) as failure:
        adjust(epoch, association)
    assert (failure.value.observations, failure.value.unknowns) == (2, 3)
    with pytest.raises(TooFewPairs, match="no pairs"):
        adjust(epoch, Association.from_pairs(epoch, []))


def test_marks_in_one_point_are_unobservable() -> None:
    epoch, _ = epoch_scene(np.random.default_rng(11), marks=2, noise=0.0)
    same = replace(
        epoch, targets=(epoch.targets[0], replace(epoch.targets[0], label="t1")), marks=(epoch.marks[0],) * 2
    )
    same = replace(same, marks=(same.marks[0], replace(same.marks[1], label="m1")))
    with pytest.raises(Unobservable) as failure:
        adjust(same, Association.from_pairs(same, [(0, 0), (1, 1)]))
    assert len(failure.value.direction) == 3


def test_ambiguous_places_are_positions() -> None:
    """Half of the marks shifted by 3 km to the east: two places."""
    epoch, association = epoch_scene(np.random.default_rng(12), marks=8, noise=0.1)
    shifted = tuple(
        replace(m, position=direct(m.position, 90.0, 3000.0)) if i < 4 else m for i, m in enumerate(epoch.marks)
    )
    with pytest.raises(Ambiguous) as failure:
        adjust(replace(epoch, marks=shifted), association)
    places = [a.position for a in failure.value.alternatives[:2]]
    assert all(isinstance(place, Position) for place in places)
    assert inverse(*places)[0] == pytest.approx(3000.0, abs=60.0)
    assert all(a.heading_deg == pytest.approx(123.4, abs=1.0) for a in failure.value.alternatives[:2])


def test_a_given_start_chooses_among_places() -> None:
    epoch, association = epoch_scene(np.random.default_rng(12), marks=8, noise=0.1)
    shifted = tuple(
        replace(m, position=direct(m.position, 90.0, 3000.0)) if i < 4 else m for i, m in enumerate(epoch.marks)
    )
    epoch = replace(epoch, marks=shifted)
    there = direct(OWN, 90.0, 3000.0)
    for start in (OWN, there):
        fix = adjust(epoch, association, start=(direct(start, 10.0, 40.0), 123.0))
        assert inverse(start, fix.position)[0] < 60.0
        assert len(fix.alternatives) >= 1
        assert fix.start == "given"


def test_a_start_without_a_heading_finds_one_there() -> None:
    epoch, association = epoch_scene(np.random.default_rng(19), marks=6)
    fix = adjust(epoch, association, start=(direct(OWN, 80.0, 500.0), None))
    assert inverse(OWN, fix.position)[0] < 40.0
    assert fix.heading_deg == pytest.approx(123.4, abs=1.0)


def test_the_pose_of_the_association_is_one_of_the_starts() -> None:
    epoch, by_hand = epoch_scene(np.random.default_rng(13), marks=6, wrong=1)
    posed = replace(by_hand, position=direct(OWN, 200.0, 5000.0), heading_deg=300.0)
    assert inverse(adjust(epoch, posed).position, adjust(epoch, by_hand).position)[0] < 1e-3


def test_mask_leaves_observations_out() -> None:
    epoch, association = epoch_scene(np.random.default_rng(14), marks=6, wrong=1)
    mask = np.ones((6, 2), bool)
    mask[0] = False
    fix = adjust(epoch, association, kernel="none", mask=mask)
    assert fix.redundancy == 10 - 3
    assert fix.observations[0].weight == fix.observations[1].weight == 0.0
    assert abs(fix.observations[0].residual) > 100.0 or abs(fix.observations[1].residual) > 2.0
    assert inverse(OWN, fix.position)[0] < 60.0
    by_pair = adjust(epoch, association, kernel="none", mask=[False] + [True] * 5)
    assert inverse(fix.position, by_pair.position)[0] < 1e-3
    with pytest.raises(InputError, match="mask must have shape"):
        adjust(epoch, association, mask=[True, False])


@pytest.mark.parametrize("damping", ["joint", "separate"])
@pytest.mark.parametrize("kernel", ["none", "huber", "hampel", "danish", "tukey"])
def test_solvers_agree_on_the_globe(kernel: str, damping: str) -> None:
    if not graph.available():
        pytest.skip("GTSAM is not installed")
    epoch, association = epoch_scene(np.random.default_rng(15), wrong=2)
    by_graph = adjust(epoch, association, kernel=kernel, damping=damping, solver="gtsam")  # type: ignore[arg-type]
    by_dense = adjust(epoch, association, kernel=kernel, damping=damping, solver="dense")  # type: ignore[arg-type]
    assert inverse(by_graph.position, by_dense.position)[0] < 1e-5
    assert by_graph.heading_deg == pytest.approx(by_dense.heading_deg, abs=1e-8)
    np.testing.assert_allclose(by_graph.covariance, by_dense.covariance, rtol=1e-5, atol=1e-12)
    assert any("dense" in note for note in by_dense.notes)


def test_without_gtsam_the_dense_road_stands_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graph, "available", lambda: False)
    epoch, association = epoch_scene(np.random.default_rng(16), marks=6)
    assert "solved by dense normal equations" in adjust(epoch, association).notes


def test_unknown_names_and_impossible_sigmas_are_refused() -> None:
    epoch, association = epoch_scene(np.random.default_rng(17), marks=4)
    with pytest.raises(CatalogError):
        adjust(epoch, association, kernel="hampl")
    with pytest.raises(CatalogError):
        adjust(epoch, association, radar="sonar")
    with pytest.raises(InputError, match="range_sigma_m"):
        adjust(epoch, association, range_sigma_m=-1.0)


def test_a_mark_at_own_ship_does_not_stop_the_adjustment() -> None:
    epoch, _ = epoch_scene(np.random.default_rng(18), marks=5, noise=0.0)
    near = RadarTarget("near", 0.5, 20.0, range_sigma_m=30.0, bearing_sigma_deg=0.5)
    epoch = replace(epoch, targets=(*epoch.targets, near), marks=(*epoch.marks, Mark("own", OWN, 10.0)))
    fix = adjust(epoch, Association.from_pairs(epoch, [(i, i) for i in range(6)]))
    assert inverse(OWN, fix.position)[0] < 1.0


def test_many_marks_on_the_plane_are_where_each_alone_is() -> None:
    plane = LocalPlane(Position(68.0, 179.9))
    places = [direct(plane.origin, 17.0 * i, 10.0**k) for i in range(20) for k in (0, 3, 5)] + [plane.origin]
    together = plane.all_to_plane([p.lat_deg for p in places], [p.lon_deg for p in places])
    np.testing.assert_allclose(together, [plane.to_plane(p) for p in places], atol=1e-6)
    far = [Position(-68.0, 0.0), Position(10.0, -60.0)]
    np.testing.assert_allclose(
        plane.all_to_plane([p.lat_deg for p in far], [p.lon_deg for p in far]), [plane.to_plane(p) for p in far]
    )


def test_gtsam_is_imported_only_when_it_is_used() -> None:
    code = "import sys, navfix.adjustment as a; a.adjust; print(*{'gtsam', 'scipy.stats'}.intersection(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not done.stdout.strip()
