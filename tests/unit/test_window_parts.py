"""Parts of the window association and adjustment that are quick because they are clever, each against the plain way."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from navfix import catalog
from navfix.adjustment.window.components import judged
from navfix.adjustment.window.descent import Damper, inverse_of, normal_of, solve_normal
from navfix.adjustment.window.reading import sightings_of, window_of
from navfix.adjustment.window.rows import COMPONENTS, Plan
from navfix.adjustment.window.start import first_pose, initial_state, plane_pose, poses_from
from navfix.association.pair_index import PairIndex
from navfix.association.window import joint, null, votes
from navfix.association.window.associate import solve_jointly
from navfix.association.window.em import expect
from navfix.association.window.fit import lay_over, paths_over_ground
from navfix.association.window.jackknife import left_out
from navfix.association.window.joint import Joint
from navfix.association.window.knots import Knots
from navfix.association.window.normal import clutter_equations, normal_equations
from navfix.geodesy import LocalPlane
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.types import Epoch, FloatArray

LOGS = Path(__file__).resolve().parents[2] / "data" / "logs"


@cache
def recorded() -> tuple[Epoch, ...]:
    return tuple(epochs(read_log(LOGS / "approach.nmea").records))[:24]


@cache
def found() -> Joint:
    return joint.cold(joint.prepare(recorded()))


# ------------------------------------------------------------------------------------------------ votes


@pytest.mark.parametrize("cells", [1, 3, 1000, 200_000, 10**12])
@pytest.mark.parametrize("count", [1, 159, 5000, 60_000])
def test_the_fullest_cells_are_those_of_plain_counting(count: int, cells: int) -> None:
    rng = np.random.default_rng(count)
    cell = rng.integers(0, cells, count)
    cell[: count // 3] = np.sort(rng.integers(0, cells, count // 3)) // 7  # some cells are much fuller
    _, which, size = np.unique(cell, return_inverse=True, return_counts=True)
    top = np.argsort(-size, kind="stable")[:160]
    chosen, sizes = votes._in_fullest(cell, 160)
    assert sizes.tolist() == size[top].tolist()
    assert chosen.tolist() == np.concatenate([np.flatnonzero(which == t) for t in top]).tolist()


def test_pairs_at_one_distance_stay_in_their_order() -> None:
    z = np.array([0.0, 3.0, 3.0j, 3.0 + 3.0j, 7.0 - 1.0j])
    index = PairIndex.of(z, 100.0)
    order = np.lexsort((np.arange(len(index.first)), index.distance_m))
    assert order.tolist() == list(range(len(index.first)))
    assert np.abs(z[index.first] - z[index.second]) == pytest.approx(index.distance_m)
    assert len(index.first) == 10


# ------------------------------------------------------------------------------------------------ normal equations


def coordinates(knots: Knots, step: FloatArray, mark: np.ndarray) -> tuple[FloatArray, FloatArray]:
    """Return misfit to the given marks and path over ground of moved motions, in the axes of those not moved."""
    field = found().window.field
    scene, moved = field.scene, knots.moved(step)
    turned = paths_over_ground(field, moved)[1] * np.conj(paths_over_ground(field, knots)[1])
    path = paths_over_ground(field, moved)[0].view(complex)[..., 0] * turned[:, :, None]
    z = (scene.paths.z[mark] + scene.paths.v[mark] * moved.clock_s[:, None, None, None])[:, :, :, None, :]
    on_mark = (z * scene.basis[None, :, None]).sum(axis=-1)
    back = np.conj(paths_over_ground(field, knots)[1])[:, :, None, None]
    misfit = on_mark * back + path[:, :, None]
    return (np.stack([part.real, part.imag], axis=-1) for part in (misfit, path))  # type: ignore[return-value]


def derivatives(knots: Knots, mark: np.ndarray) -> tuple[FloatArray, FloatArray]:
    """Return what each unknown does to misfits (k, m, q, s, 2, d) and paths (k, m, s, 2, d), by differences."""
    d = knots.vector().shape[1]
    columns = []
    for unknown in range(d):
        step = np.zeros((len(knots), d))
        step[:, unknown] = 1e-4
        ahead, behind = coordinates(knots, step, mark), coordinates(knots, -step, mark)
        columns.append([(a - b) / 2e-4 for a, b in zip(ahead, behind, strict=True)])
    return tuple(np.stack(part, axis=-1) for part in zip(*columns, strict=True))  # type: ignore[return-value]


def every(weight: FloatArray) -> FloatArray:
    """Return weights of mean, line and scatter (..., 3, 2) as one for each coordinate (..., s, 2)."""
    return np.repeat(weight, found().window.field.coordinates, axis=-2)


def test_the_normal_equations_are_those_of_all_derivatives_by_differences() -> None:
    field, knots = found().window.field, found().answers.knots.take(np.arange(3))
    widening, fit = 1.2, lay_over(field, knots)
    expected = expect(field, fit, widening)
    information, gradient = normal_equations(field, knots, fit, expected, widening)
    of_misfit, of_path = derivatives(knots, fit.mark)

    weight = expected.on_mark[..., None, None] / fit.variance_m2
    weight[..., :2, :] /= widening**2
    weight[..., 2, :] *= expected.scatter_weight[..., None]
    clutter = np.zeros((*expected.on_clutter.shape, 3, 2))
    clutter[..., 1, :] = (expected.clutter.kind[..., None] / field.line_m2[:, None]).sum(axis=0)
    clutter[..., 2, :] = expected.clutter.scatter_weight[..., None] / field.scene.white_m2
    clutter *= expected.on_clutter[..., None, None]
    plain = np.einsum("kmqsad,kmqsa,kmqsae->kde", of_misfit, every(weight), of_misfit)
    plain += np.einsum("kmsad,kmsa,kmsae->kde", of_path, every(clutter), of_path)
    pull = np.einsum("kmqsad,kmqsa,kmqsa->kd", of_misfit, every(weight), fit.misfit)
    pull += np.einsum("kmsad,kmsa,kmsa->kd", of_path, every(clutter), fit.path)
    scale = np.sqrt(np.einsum("kdd->kd", plain))
    assert information / (scale[:, :, None] * scale[:, None]) == pytest.approx(
        plain / (scale[:, :, None] * scale[:, None]), abs=1e-6
    )
    assert gradient == pytest.approx(-pull, abs=1e-5 * float(np.abs(pull).max()))


def test_one_motion_with_many_sets_of_barred_tracks_is_many_motions() -> None:
    window, one = found().window, found().answers.knots.take(np.array([0]))
    barred = np.eye(len(window.field.scene.bins), dtype=bool)
    together = replace(one, barred=barred)
    fit = lay_over(window.field, together)
    at_once = normal_equations(window.field, together, fit, expect(window.field, fit))
    for row in range(0, len(barred), 3):
        alone = replace(one, barred=barred[[row]])
        fit = lay_over(window.field, alone)
        for both, single in zip(
            at_once, normal_equations(window.field, alone, fit, expect(window.field, fit)), strict=True
        ):
            assert both[row] == pytest.approx(single[0], rel=1e-9, abs=1e-9)
    assert len(left_out(window.field, one, window.prior)) > 2


def test_where_no_track_is_a_mark_the_equations_are_those_of_clutter() -> None:
    window = found().window
    field, knots = window.field, window.null.shape
    fit = lay_over(field, knots)
    expected = expect(field, fit)
    bare = replace(expected, on_mark=np.zeros_like(expected.on_mark), on_clutter=np.ones_like(expected.on_clutter))
    path, axis = paths_over_ground(field, knots)
    whole = normal_equations(field, knots, fit, bare)
    for one, other in zip(whole, clutter_equations(field, knots, axis, path, expected.clutter), strict=True):
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12)
    assert null.fit_null(field, window.prior).log_evidence == window.null.log_evidence


# ------------------------------------------------------------------------------------------------ adjustment


def test_half_of_the_normal_matrix_is_as_good_as_the_whole() -> None:
    scans, radar, kernel = recorded(), catalog.radar_model("imo"), catalog.kernel("huber")
    sightings = sightings_of(scans, solve_jointly(scans).labels)
    anchor, pose = first_pose(scans, sightings, radar, kernel)
    window = window_of(
        scans, sightings, LocalPlane(pose[0]), radar=radar, model=catalog.adjustment_model("window"),
        compass_sigma_deg=radar.compass_sigma_deg,
    )  # fmt: skip
    plan = Plan.of(window)
    state = initial_state(window, plan.layout, poses_from(window, anchor, plane_pose(window.plane, pose)))
    damper = Damper(plan, kernel, "joint", np.ones(COMPONENTS), np.ones(plan.layout.marks, bool))
    here = damper.at(state)
    rows, w = here.rows, here.weights.row
    whole = np.zeros((len(w), plan.layout.size))
    np.add.at(whole, (np.arange(len(w))[:, None], rows.columns), rows.values)
    expected, right = whole.T @ (w[:, None] * whole), whole.T @ (w * rows.residual)

    matrix, gradient = normal_of(damper, rows, here.weights)
    assert np.tril(matrix) == pytest.approx(np.tril(expected), rel=1e-9, abs=1e-9)
    assert gradient == pytest.approx(right, rel=1e-9, abs=1e-9)
    inverse = np.linalg.inv(expected)
    assert inverse_of(matrix) == pytest.approx(inverse, rel=1e-6, abs=1e-9)
    assert solve_normal(matrix, gradient) == pytest.approx(inverse @ right, rel=1e-6, abs=1e-6)
    lever = np.einsum("ri,ij,rj->r", whole, inverse, whole)
    redundancy = np.bincount(rows.component, w * np.clip(1.0 - w * lever, 0.0, 1.0), COMPONENTS)
    assert judged(damper, here).redundancy == pytest.approx(redundancy, rel=1e-6, abs=1e-6)
