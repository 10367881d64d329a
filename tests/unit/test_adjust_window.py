"""A window of epochs as one network: exact on exact data, two roads to one answer, tracks kept apart, refusals."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment import graph
from navfix.adjustment.graph import window as window_graph
from navfix.adjustment.window import KnownPose, adjust_window, solve_window
from navfix.adjustment.window.components import expected_components
from navfix.adjustment.window.reading import sightings_of, window_of
from navfix.adjustment.window.rows import COMPONENTS, NEW_BEARING, NEW_RANGE, STEADY_BEARING, STEADY_RANGE, Plan
from navfix.adjustment.window.start import initial_state
from navfix.errors import InputError, NoFix, TooFewPairs
from navfix.geodesy import LocalPlane, inverse
from navfix.integrity import with_integrity
from navfix.types import Association, Epoch, HeadingHint, Mark, Position
from navfix.units import wrap_180
from tests.window_scenes import OWN, Errors, Passage, passage, without_sensors

needs_gtsam = pytest.mark.skipif(not graph.available(), reason="GTSAM is not installed")
EXACT = Errors(
    range_m=1e-3, bearing_deg=1e-5, mark_m=1e-3, range_bias_m=0.0, gyro_deg=1e-4, gyro_bias_deg=3.0, log_mps=1e-4
)


def scene(seed: int = 0, **options: object) -> Passage:
    return passage(np.random.default_rng(seed), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(6))
def test_exact_data_are_solved_exactly_at_any_heading_and_in_a_turn(seed: int) -> None:
    p = scene(seed, errors=EXACT, epochs=8, targets=6, turn_deg_per_min=40.0 if seed % 2 else 0.0)
    fix = adjust_window(p.epochs, p.pairs)
    assert np.hypot(*p.error(fix.position)) < 0.01
    assert abs(p.heading_error_deg(fix.heading_deg)) < 1e-3


@pytest.mark.parametrize("own", [Position(0.0, 179.999), Position(84.0, 20.0), Position(-54.0, -180.0)])
def test_a_window_is_solved_across_the_date_line_and_at_high_latitude(own: Position) -> None:
    p = scene(3, errors=EXACT, epochs=6, targets=6, own=own)
    assert np.hypot(*p.error(adjust_window(p.epochs, p.pairs).position)) < 0.05


@needs_gtsam
@pytest.mark.parametrize("sensors", [True, False])
def test_the_factor_graph_and_the_normal_equations_agree(sensors: bool) -> None:
    p = scene(1, epochs=10, targets=12, wrong=2, sensors=sensors, mates=0.5)
    by_graph = adjust_window(p.epochs, p.pairs, solver="gtsam")
    dense = adjust_window(p.epochs, p.pairs, solver="dense")
    assert "solved by GTSAM" in by_graph.notes[0]
    assert "solved by dense" in dense.notes[0]
    assert isinstance(by_graph.position, Position)
    assert isinstance(dense.position, Position)
    assert inverse(by_graph.position, dense.position)[0] < 1e-3
    scale = np.sqrt(np.outer(np.diagonal(dense.covariance), np.diagonal(dense.covariance)))
    assert np.max(np.abs(by_graph.covariance - dense.covariance) / scale) < 1e-6


@needs_gtsam
def test_the_factor_graph_goes_on_from_a_state_that_is_no_solution() -> None:
    p = scene(1, epochs=10, targets=12)
    solved = solve_window(
        p.epochs, p.pairs, start=None, radar=catalog.radar_model("imo"), kernel=catalog.kernel("none"), solver="dense"
    )
    damper, newest = solved.found.damper, solved.found.damper.plan.layout.newest()
    off = solved.state.copy()
    off[newest] += [40.0, -30.0, 0.02]
    for start in (solved.state, off):
        found, state = window_graph.solve(damper, start)
        step = state[newest] - solved.state[newest]
        assert step @ np.linalg.solve(solved.cofactor, step) < 1e-8
        assert found.cofactor == pytest.approx(solved.cofactor, rel=1e-4, abs=1e-9)


@pytest.mark.parametrize("reference", ["relative", "true"])
def test_derivatives_are_those_of_the_residuals(reference: str) -> None:
    p = scene(2, epochs=4, targets=4, mates=1.0, bearing_reference=reference, turn_deg_per_min=30.0)
    epochs = (*p.epochs[:3], without_sensors(p.epochs[3]))
    sightings = sightings_of(epochs, p.pairs)
    window = window_of(
        epochs, sightings, p.plane, radar=catalog.radar_model("imo"), model=catalog.adjustment_model(),
        compass_sigma_deg=1.5, prior=known(p, 20.0, 2.0, (30.0, -10.0)),
    )  # fmt: skip
    plan = Plan.of(window)
    rng = np.random.default_rng(5)
    state = initial_state(window, plan.layout, p.truth) + 0.3 * rng.normal(size=plan.layout.size) * 0.1
    rows = plan.rows(state, np.ones(COMPONENTS))
    dense = np.zeros((len(rows.residual), plan.layout.size))
    np.add.at(dense, (np.arange(len(dense))[:, None], rows.columns), rows.values)
    for column in range(plan.layout.size):
        step = np.zeros(plan.layout.size)
        step[column] = 1e-5
        up, down = (plan.rows(state + sign * step, np.ones(COMPONENTS)).residual for sign in (1.0, -1.0))
        assert np.allclose((up - down) / 2e-5, dense[:, column], rtol=2e-5, atol=2e-5)


def test_of_the_stated_total_what_is_not_new_in_every_scan_is_expected_to_stay() -> None:
    model = replace(catalog.adjustment_model(), steady_share=0.5, least_steady_share=0.1)
    components = np.ones(COMPONENTS)
    components[NEW_RANGE], components[NEW_BEARING] = 2.0, 0.4  # all of the variance is new; a fifth of it is
    expected = expected_components(components, model)
    assert expected[STEADY_RANGE] == pytest.approx(0.2)
    assert expected[STEADY_BEARING] == pytest.approx(1.6)
    components[NEW_RANGE] = 8.0  # twice the sigma that is stated, and all of it new
    assert expected_components(components, model)[STEADY_RANGE] == pytest.approx(0.8)
    assert np.all(expected_components(components, replace(model, steady_share=0.0)) == 1.0)


def test_the_ellipse_follows_how_much_of_the_error_stays() -> None:
    inside: dict[float, list[float]] = {0.0: [], 0.8: []}
    for steady, squared in inside.items():
        for seed in range(12):
            p = scene(200 + seed, targets=10, errors=Errors(bearing_deg=1.0, steady=steady), reach_m=(2e3, 15e3))
            fix = adjust_window(p.epochs, p.pairs, solver="dense")
            error = p.error(fix.position)
            squared.append(float(error @ np.linalg.solve(fix.covariance[:2, :2], error)))
    assert 0.8 < np.mean(inside[0.0]) < 4.0, "2 where the covariance is right"
    assert 0.8 < np.mean(inside[0.8]) < 4.0


def known(p: Passage, sigma_m: float, sigma_deg: float, off_m: tuple[float, float] = (0.0, 0.0)) -> KnownPose:
    north_m, east_m, heading_rad = p.truth[0].tolist()
    place = p.plane.to_position(north_m + off_m[0], east_m + off_m[1])
    covariance = np.diag([sigma_m**2, sigma_m**2, math.radians(sigma_deg) ** 2])
    return KnownPose(place, math.degrees(heading_rad) + p.plane.convergence_deg(place), covariance)


@pytest.mark.parametrize("solver", ["dense", pytest.param("gtsam", marks=needs_gtsam)])
def test_a_pose_known_beforehand_is_one_factor_of_the_network(solver: str) -> None:
    p = scene(21, targets=3, epochs=3)
    free = adjust_window(p.epochs, p.pairs, solver=solver)
    loose = adjust_window(p.epochs, p.pairs, prior=known(p, 1e6, 170.0), solver=solver)
    tight = adjust_window(p.epochs, p.pairs, prior=known(p, 1.0, 0.1), solver=solver)
    assert isinstance(free.position, Position)
    assert isinstance(loose.position, Position)
    assert inverse(free.position, loose.position)[0] < 0.1, "what says nothing changes nothing"
    error = p.error(tight.position)
    assert error @ np.linalg.solve(tight.covariance[:2, :2], error) < 16.0
    assert np.trace(tight.covariance[:2, :2]) < 0.5 * np.trace(free.covariance[:2, :2])


def test_a_prior_and_the_data_meet_by_their_weights() -> None:
    p = scene(22, targets=8, epochs=1, errors=Errors(mark_m=5.0))
    free = adjust_window(p.epochs, p.pairs, solver="dense")
    sigma_m = math.sqrt(0.5 * np.trace(free.cofactor_matrix[:2, :2]))
    pulled = adjust_window(p.epochs, p.pairs, prior=known(p, sigma_m, 30.0, (3.0 * sigma_m, 0.0)), solver="dense")
    moved = (p.error(pulled.position) - p.error(free.position))[0] / (3.0 * sigma_m - p.error(free.position)[0])
    assert 0.3 < moved < 0.7, "half of the way where both are as sure"


def test_where_bearings_are_true_the_known_angle_is_the_compass_error() -> None:
    p = scene(23, targets=4, epochs=4, bearing_reference="true", errors=Errors(gyro_bias_deg=0.0))
    prior = KnownPose(OWN, 1.25, np.diag([1e8, 1e8, math.radians(0.001) ** 2]))
    fix = adjust_window(p.epochs, p.pairs, prior=prior)
    assert fix.heading_deg is None
    assert fix.compass_error_deg == pytest.approx(1.25, abs=0.01)


def test_wrong_marks_are_named_and_do_not_move_the_fix() -> None:
    p = scene(4, epochs=12, targets=12, wrong=4)
    fix = adjust_window(p.epochs, p.pairs)
    assert {o.mark for o in fix.outliers} == {"m0", "m1", "m2", "m3"}
    assert np.hypot(*p.error(fix.position)) < 25.0
    assert len(fix.observations) == 24


def test_the_window_is_better_than_its_newest_scan_and_says_what_it_estimated() -> None:
    p = scene(0, epochs=40, targets=20, wrong=2, errors=Errors(bearing_deg=1.0))
    fix = adjust_window(p.epochs, p.pairs)
    said = " ".join(fix.notes)
    told = re.search(r"current (\d\.\d+) m/s towards (\d+)°", said)
    assert told is not None
    assert abs(float(told[1]) - math.hypot(0.5, 0.33)) < 0.2
    assert abs(wrap_180(float(told[2]) - math.degrees(math.atan2(-0.33, 0.5)))) < 25.0
    assert "clock offset" in said
    assert "stand off" not in said, "offsets that the marks' own sigmas explain are no news"
    assert fix.epoch is not None
    assert fix.epoch.time_utc == p.epochs[-1].time_utc
    assert fix.ellipse().semi_major_m < 20.0
    assert with_integrity(fix).integrity is not None


def test_a_mark_that_stands_off_is_named_and_no_other() -> None:
    p = scene(24, epochs=20, targets=14, errors=Errors(mark_m=5.0))
    moved = [
        replace(e, marks=tuple(_beside(m, p.plane, 120.0) if m.label == "m3" else m for m in e.marks)) for e in p.epochs
    ]
    said = [note for note in adjust_window(moved, p.pairs, kernel="none").notes if "stand off" in note]
    assert len(said) == 1
    assert re.findall(r"m\d+(?= [+-])", said[0]) == ["m3"]


def _beside(mark: Mark, plane: LocalPlane, off_m: float) -> Mark:
    north_m, east_m = plane.to_plane(mark.position).tolist()
    return replace(mark, position=plane.to_position(north_m + off_m, east_m))


def test_a_number_that_is_given_to_another_ship_is_another_track() -> None:
    p = scene(5, epochs=24, targets=8, errors=Errors(steady=0.5))
    first = dict(p.pairs)
    later = first | {"t0": "m7", "t7": "m0"}
    swapped = [
        e if i < 12 else replace(e, targets=tuple(_renamed(t, {"t0": "t7", "t7": "t0"}) for t in e.targets))
        for i, e in enumerate(p.epochs)
    ]
    fix = adjust_window(swapped, [first] * 12 + [later] * 12)
    assert sorted(o.target for o in fix.observations if o.mark == "m0" and o.kind == "range") == ["t0", "t7"]
    assert not fix.outliers
    assert np.hypot(*p.error(fix.position)) < 40.0


def _renamed(target: object, names: dict[str, str]) -> object:
    return replace(target, label=names.get(target.label, target.label))  # type: ignore[attr-defined,type-var]


def test_a_track_that_the_newest_scan_does_not_show_stays_in_the_report() -> None:
    p = scene(6, epochs=10, targets=6)
    last = replace(p.epochs[-1], targets=p.epochs[-1].targets[1:], marks=p.epochs[-1].marks[1:])
    fix = adjust_window([*p.epochs[:-1], last], p.pairs)
    assert "t0" in {o.target for o in fix.observations}
    assert fix.association is not None
    assert len(fix.association.pairs) == 5
    assert with_integrity(fix).integrity is not None, "the record carries all of its marks"


def test_scans_without_any_target_are_bridged_and_the_ellipse_grows() -> None:
    p = scene(7, epochs=20, targets=8)
    blind = [replace(e, targets=()) for e in p.epochs[-8:]]
    whole, bridged = adjust_window(p.epochs, p.pairs), adjust_window([*p.epochs[:-8], *blind], p.pairs)
    assert np.trace(bridged.covariance[:2, :2]) > np.trace(whole.covariance[:2, :2])
    error = p.error(bridged.position)
    assert error @ np.linalg.solve(bridged.covariance[:2, :2], error) < 16.0
    assert any("no track was seen for the last 24 s" in note for note in bridged.notes)


def test_a_gyro_90_degrees_off_changes_nothing() -> None:
    p = scene(8, epochs=10, targets=10)
    turned = [
        replace(e, heading_hint=HeadingHint(e.heading_hint.heading_deg + 90.0, 1.5)) for e in p.epochs if e.heading_hint
    ]
    fix, other = adjust_window(p.epochs, p.pairs), adjust_window(turned, p.pairs)
    assert isinstance(fix.position, Position)
    assert isinstance(other.position, Position)
    assert inverse(fix.position, other.position)[0] < 1e-3


def test_a_frozen_gyro_in_a_turn_is_noticed() -> None:
    p = scene(9, epochs=20, targets=16, turn_deg_per_min=60.0)
    frozen = [replace(e, heading_hint=HeadingHint(10.0, 1.5)) for e in p.epochs]
    fix = adjust_window(frozen, p.pairs)
    assert any("gyro do not fit" in note for note in fix.notes)
    assert abs(p.heading_error_deg(fix.heading_deg)) < 1.5


def test_true_bearings_give_a_position_and_the_error_of_the_compass() -> None:
    p = scene(10, epochs=12, targets=10, bearing_reference="true", errors=Errors(gyro_bias_deg=0.0))
    fix = adjust_window(p.epochs, p.pairs)
    assert fix.heading_deg is None
    assert fix.covariance.shape == (2, 2)
    error = p.error(fix.position)
    assert error @ np.linalg.solve(fix.covariance, error) < 16.0
    assert fix.compass_error_deg is not None
    assert fix.compass_error_sigma_deg is not None
    assert abs(fix.compass_error_deg) < 4.0 * fix.compass_error_sigma_deg
    assert any("compass error" in note for note in fix.notes)


def test_a_start_is_taken_for_the_newest_epoch_or_for_all() -> None:
    p = scene(11, epochs=6, targets=6)
    poses = [(p.plane.to_position(*row[:2].tolist()), math.degrees(row[2])) for row in p.truth]
    free = adjust_window(p.epochs, p.pairs)
    for start in (poses[-1], poses):
        fix = adjust_window(p.epochs, p.pairs, start=start)
        assert isinstance(fix.position, Position)
        assert isinstance(free.position, Position)
        assert inverse(fix.position, free.position)[0] < 0.01
    with pytest.raises(InputError, match="one for each of 6 epochs, got 2"):
        adjust_window(p.epochs, p.pairs, start=poses[:2])


def test_the_pairs_may_come_as_an_association_of_the_newest_epoch() -> None:
    p = scene(12, epochs=5, targets=5)
    given = Association.from_pairs(p.epochs[-1], list(p.pairs.items()))
    first, second = adjust_window(p.epochs, given), adjust_window(p.epochs, p.pairs)
    assert first.position == second.position


def test_a_window_of_one_epoch_is_a_fix_too() -> None:
    p = scene(13, epochs=1, targets=8)
    fix = adjust_window(p.epochs, p.pairs)
    assert np.hypot(*p.error(fix.position)) < 60.0


def test_what_cannot_be_solved_says_why() -> None:
    p = scene(14, epochs=4, targets=4)
    with pytest.raises(InputError, match="at least one epoch"):
        adjust_window([], p.pairs)
    with pytest.raises(InputError, match="earlier than the one before"):
        adjust_window(p.epochs[::-1], p.pairs)
    with pytest.raises(InputError, match="has no time"):
        adjust_window([Epoch(None, p.epochs[0].targets, p.epochs[0].marks)], p.pairs)
    with pytest.raises(InputError, match="as many sets of pairs"):
        adjust_window(p.epochs, [p.pairs])
    with pytest.raises(TooFewPairs):
        adjust_window(p.epochs, {"t0": "nobody"})
    with pytest.raises(TooFewPairs):
        adjust_window(p.epochs, {"t0": "m0"})


def test_tracks_that_contradict_each_other_are_no_fix() -> None:
    p = scene(15, epochs=6, targets=4)
    crossed = {"t0": "m1", "t1": "m2", "t2": "m3", "t3": "m0"}
    start = (LocalPlane(p.epochs[0].marks[0].position).to_position(500.0, 500.0), 77.0)
    with pytest.raises(NoFix):
        adjust_window(p.epochs, crossed, start=start)


def test_two_scans_of_one_instant_are_both_used() -> None:
    p = scene(17, epochs=6, targets=6)
    twice = [*p.epochs, replace(p.epochs[-1], targets=p.epochs[-1].targets[::-1])]
    assert np.hypot(*p.error(adjust_window(twice, p.pairs).position)) < 60.0


def test_the_state_of_all_epochs_can_be_had() -> None:
    p = scene(16, epochs=8, targets=8, errors=EXACT)
    solved = solve_window(
        p.epochs, p.pairs, start=None, radar=catalog.radar_model("imo"), kernel=catalog.kernel("hampel")
    )
    poses = solved.found.damper.plan.layout.poses(solved.state)
    places = [solved.window.plane.to_position(*pose[:2].tolist()) for pose in poses]
    assert max(np.hypot(*p.error(place, e)) for e, place in enumerate(places)) < 0.05
