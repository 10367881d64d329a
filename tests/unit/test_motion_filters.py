"""Kalman filters of a track: the unscented transform and its trap, both filters against each other, gaps smoothed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from navfix.catalog import ais_model, filter_model
from navfix.errors import InputError
from navfix.geodesy import cloud_to_plane
from navfix.picture.motion import MODELS, Point, ekf, history, ukf
from navfix.picture.motion.geodetic_turn import LAT, jacobian, metres_per_degree, propagate
from navfix.picture.motion.smoother import Moment, correct, noise, predict, smoothed, transition
from navfix.picture.motion.turn_filter import State
from navfix.picture.motion.unscented import Scaling, transform, transform_as_printed
from navfix.simulation.manoeuvres import SOURCE_LEGS, run

ARC = np.array([100.0, 40.0, 8.0, 0.7, 0.01])


def _covariance(n: int, seed: int) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(n, n))
    return root @ root.T


@pytest.mark.parametrize("scaling", [Scaling(), Scaling(alpha=0.5), Scaling(kappa=-2.0)])
def test_the_transform_is_exact_for_a_linear_function(scaling: Scaling):
    mean, P, A = np.arange(5.0), _covariance(5, 1), np.random.default_rng(2).normal(size=(3, 5))
    found = transform(mean, P, lambda x: x @ A.T, scaling)
    assert found.mean == pytest.approx(A @ mean)
    assert found.covariance == pytest.approx(A @ P @ A.T)
    assert found.cross == pytest.approx(P @ A.T)


def test_the_mean_of_a_quadratic_is_exact_to_second_order():
    mean, P = np.array([1.0, -2.0]), _covariance(2, 3)
    found = transform(mean, P, lambda x: x[:, :1] ** 2 + x[:, :1] * x[:, 1:], Scaling())
    assert found.mean[0] == pytest.approx(mean[0] ** 2 + P[0, 0] + mean[0] * mean[1] + P[0, 1])


def test_the_weights_are_those_of_the_source_and_their_centre_is_a_trap():
    for n in (2, 5, 12):
        weight_m, weight_c = Scaling(alpha=0.01, beta=2.0, kappa=0.0).weights(n)
        assert weight_m.sum() == pytest.approx(1.0)
        assert weight_m[0] == pytest.approx(-9999.0)
        assert weight_c[0] == pytest.approx(-9999.0 + 3.0 - 1e-4)
    assert Scaling(0.01, 2.0, 3.0 - 5.0).weights(5)[0][0] == pytest.approx(-16665.7, abs=0.1)
    assert Scaling(0.01, 2.0, 3.0 - 12.0).weights(12)[0][0] == pytest.approx(-39999.0)


def test_the_centred_sums_are_the_printed_ones_and_survive_a_tiny_alpha():
    mean, P = np.array([100.0, 40.0, 8.0, 0.7, 0.01]), np.diag([1e-8, 1e-8, 0.1, 0.01, 1e-5])

    def move(x: np.ndarray) -> np.ndarray:
        return propagate(x, 30.0)

    plain, printed = transform(mean, P, move, Scaling()), transform_as_printed(mean, P, move, Scaling())
    assert plain.mean == pytest.approx(printed.mean, rel=1e-12)
    assert plain.covariance == pytest.approx(printed.covariance, rel=1e-6, abs=1e-16)
    tiny = Scaling(alpha=1e-4)
    assert np.all(np.linalg.eigvalsh(transform(mean, P, move, tiny).covariance) > -1e-16)
    lost = np.abs(transform_as_printed(mean, P, move, tiny).covariance - transform(mean, P, move, tiny).covariance)
    assert lost[LAT, LAT] > 0.0


def test_the_augmented_filter_is_the_additive_one_where_everything_is_linear():
    rng = np.random.default_rng(5)
    mean, P, F, H = rng.normal(size=4), _covariance(4, 6), rng.normal(size=(4, 4)), rng.normal(size=(2, 4))
    Q, R, z, by = _covariance(4, 7), _covariance(2, 8), rng.normal(size=2), Scaling()
    moved = transform(mean, P, lambda x: x @ F.T, by)
    augmented = ukf.predict_augmented(mean, P, lambda x, w: x @ F.T + w, Q, by)
    assert augmented[0] == pytest.approx(moved.mean)
    assert augmented[1] == pytest.approx(moved.covariance + Q)
    additive = ukf.update(mean, P, z, lambda x: x @ H.T, R, by)
    joined = ukf.update_augmented(mean, P, z, lambda x, v: x @ H.T + v, R, by)
    gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)  # the linear filter, eq. (1) and (2) of the source
    assert additive[0] == pytest.approx(mean + gain @ (z - H @ mean))
    assert additive[1] == pytest.approx(P - gain @ H @ P)
    for one, other in zip(joined, additive, strict=True):
        assert one == pytest.approx(other)


@pytest.mark.parametrize("rate", [0.0, 1e-6, 0.01, -0.03])
def test_the_derivative_of_the_motion_is_its_difference_quotient(rate: float):
    state = np.array([100.0, 40.0, 8.0, 0.7, rate])
    scale = np.array([1e-4, 1e-4, 1e-2, 1e-4, 1e-5])
    quotient = np.column_stack(
        [
            (propagate(state + step, 20.0, 60.0) - propagate(state - step, 20.0, 60.0)) / (2.0 * step[i])
            for i, step in enumerate(np.diag(scale))
        ]
    )
    metres = np.array([*(float(m) for m in reversed(metres_per_degree(40.0))), 1.0, 1.0, 1.0])[:, None]
    assert metres * jacobian(state, 20.0, 60.0) * scale == pytest.approx(metres * quotient * scale, rel=1e-4, abs=1e-3)


def test_both_filters_agree_where_the_state_is_well_known():
    state = State(0.0, ARC, np.diag([1e-12, 1e-12, 1e-4, 1e-6, 1e-8]))
    one, other = (f.predict(state, 10.0, filter_model()) for f in (ukf, ekf))
    assert one.mean == pytest.approx(other.mean, rel=1e-6)
    assert one.covariance == pytest.approx(other.covariance, rel=0.02, abs=1e-14)


def test_a_filter_runs_backward_in_time_too():
    state = State(100.0, ARC, np.diag([1e-12, 1e-12, 1e-4, 1e-6, 1e-8]))
    lasting = replace(filter_model(), turn_persist_s=1e9)
    there = ekf.predict(state, 70.0, lasting)
    assert ekf.predict(there, 100.0, lasting).mean == pytest.approx(ARC)
    assert np.all(np.diag(there.covariance) > np.diag(state.covariance))


def test_the_source_s_scenario_has_its_speeds_and_keeps_the_limits():
    truth = run(SOURCE_LEGS, period_s=10.0)
    assert len(truth.time_s) == 181
    assert [round(float(truth.speed_mps[k]), 9) for k in (0, 35, 45, 60, 90, 120, 130, 180)] == [
        10,
        10,
        20,
        5,
        5,
        5,
        15,
        15,
    ]
    turned = np.degrees(truth.course_rad)
    assert [round(float(turned[k]), 9) for k in (0, 60, 90, 120, 180)] == [45, 45, 135, 45, 45]


def _history(truth, *, every: int, without: tuple[float, float], sigma_m: float, seed: int):
    """Return the reports of a run with noise, none within a gap."""
    rng = np.random.default_rng(seed)
    lat_m, lon_m = (float(m) for m in metres_per_degree(40.0))
    points = []
    for k in range(0, len(truth.time_s), every):
        north, east, speed, course = rng.normal(size=4) * [sigma_m, sigma_m, 0.1, 1.0]
        if not without[0] < truth.time_s[k] < without[1]:
            lat, lon = float(truth.lat_deg[k] + north / lat_m), float(truth.lon_deg[k] + east / lon_m)
            told = float(truth.speed_mps[k] + speed), float(np.degrees(truth.course_rad[k]) + course)
            points.append(Point(float(truth.time_s[k]), lat, lon, *told))
    return history(points)


def _errors_m(truth, past, moments) -> np.ndarray:
    known = {float(t): k for k, t in enumerate(truth.time_s)}
    index = [known[m.time_s] for m in moments]
    place = cloud_to_plane(past.origin, truth.lat_deg[index], truth.lon_deg[index])
    return np.hypot(*(place - np.array([m.mean[:2] for m in moments])).T)


@pytest.mark.parametrize("gap", [(640.0, 940.0), (900.0, 1500.0)], ids=["5 min", "10 min"])
def test_smoothing_bridges_a_gap_in_which_the_ship_turned(gap: tuple[float, float]):
    """The source's gaps of 5 and 10 min: reports on both sides against the report before alone."""
    truth = run(SOURCE_LEGS, period_s=10.0)
    past = _history(truth, every=1, without=gap, sigma_m=5.0, seed=4)
    asked = [float(t) for t in truth.time_s if gap[0] < t < gap[1]]
    found = smoothed(past, asked)
    errors = _errors_m(truth, past, found)
    before = history([Point(*row) for row in _rows(past) if row[0] <= gap[0]])
    lone = [MODELS["constant_velocity"](before, t, ais_model("class_a")) for t in asked]
    index = [k for k, t in enumerate(truth.time_s) if gap[0] < t < gap[1]]
    place = cloud_to_plane(before.origin, truth.lat_deg[index], truth.lon_deg[index])
    ahead = np.hypot(*(place - np.array([(c.north_m, c.east_m) for c in lone])).T)
    assert errors.max() < 0.25 * ahead.max()
    bound = np.array([np.sqrt(5.991 * np.linalg.eigvalsh(m.covariance[:2, :2])[-1]) for m in found])
    assert np.mean(errors < bound) > 0.9


def _rows(past):
    return zip(
        *(a.tolist() for a in (past.time_s, past.lat_deg, past.lon_deg, past.speed_mps, np.degrees(past.course_rad))),
        strict=True,
    )


def test_smoothing_leaves_reports_of_little_noise_where_they_are():
    truth = run(SOURCE_LEGS, period_s=10.0)
    past = _history(truth, every=3, without=(0.0, 0.0), sigma_m=1e-3, seed=1)
    exact = replace(filter_model(), position_sigma_m=0.01)
    assert _errors_m(truth, past, smoothed(past, past.time_s[3:9].tolist(), exact)).max() < 0.05


def test_the_linear_filter_is_the_one_of_the_textbook_and_of_filterpy():
    kalman = pytest.importorskip("filterpy.kalman")
    constants, rng = filter_model(), np.random.default_rng(8)
    moment = Moment(0.0, rng.normal(size=4), _covariance(4, 9))
    oracle = kalman.KalmanFilter(dim_x=4, dim_z=2)
    oracle.x, oracle.P, oracle.H, oracle.R = (
        moment.mean.copy(),
        moment.covariance.copy(),
        np.eye(4)[:2],
        9.0 * np.eye(2),
    )
    for k in range(1, 5):
        oracle.predict(F=transition(7.0), Q=noise(7.0, constants.acceleration_walk_mps))
        z = rng.normal(size=2)
        oracle.update(z)
        moment = correct(predict(moment, 7.0 * k, constants), np.eye(4)[:2], z, 9.0 * np.eye(2))
    assert moment.mean == pytest.approx(oracle.x)
    assert moment.covariance == pytest.approx(oracle.P)


def test_smoothing_beyond_the_reports_is_refused():
    past = _history(run(SOURCE_LEGS[:1], period_s=10.0), every=1, without=(0.0, 0.0), sigma_m=1.0, seed=1)
    with pytest.raises(InputError, match="between the first and the last"):
        smoothed(past, [-10.0])
