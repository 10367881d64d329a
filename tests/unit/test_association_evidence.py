"""The formulas of the association against brute force: every matching summed, every integral done numerically."""

import math
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

import navfix
from navfix.association import em, evidence, prior, proof
from navfix.association import scene as scenes
from navfix.association.pair_index import PairIndex
from navfix.association.pairs import association_marginals
from navfix.association.prior import Prior
from navfix.association.proof_cells import Cells, bound
from navfix.association.seeds import Poses
from navfix.catalog import association_model, radar_model
from navfix.errors import NoFix
from navfix.geodesy import LocalPlane, inverse
from navfix.simulation.scenes import SceneRecipe, make_scene
from navfix.types import Epoch, Mark, Position, RadarTarget

MODEL = association_model()
PLANE = LocalPlane(Position(54.0, 8.0))


def tiny_field(seed: int, targets: int = 4, marks: int = 5) -> tuple[em.Field, Poses]:
    """Return a field of few targets and marks, at a pose near which several matchings are likely."""
    random = np.random.default_rng(seed)
    places = random.uniform(-900.0, 900.0, (marks, 2))
    epoch = Epoch(
        None,
        tuple(
            RadarTarget(
                f"{i}",
                float(np.hypot(*(places[i % marks] + 20.0 * random.normal(size=2)))),
                math.degrees(math.atan2(places[i % marks][1], places[i % marks][0])),
                range_sigma_m=60.0,
                bearing_sigma_deg=4.0,
            )
            for i in range(targets)
        ),
        tuple(Mark(f"{j}", PLANE.to_position(n, e), 30.0, kind="aton") for j, (n, e) in enumerate(places)),
    )
    every_mark = replace(MODEL, neighbours=marks)
    scene = scenes.build(epoch, radar_model("imo"), every_mark)
    own = PLANE.to_position(0.0, 0.0)
    offset = scenes.cloud_to_plane(scene.origin, [own.lat_deg], [own.lon_deg])[0]
    return em.Field(scene, every_mark), Poses(np.array([complex(*offset)]), np.zeros(1))


def ratios(field: em.Field, pose: Poses, level: float) -> np.ndarray:
    """Return eq. (6.4) as a dense table (m, n), straight from its definition."""
    scene, table = field.scene, np.zeros((len(field.scene.rho), len(field.scene.z)))
    for i, rho in enumerate(scene.rho):
        for j, z in enumerate(scene.z):
            axis = np.exp(1j * (pose.heading_rad[0] + scene.bearing_rad[i]))
            misfit = (z - pose.p[0] - np.exp(1j * pose.heading_rad[0]) * rho) / axis
            radial_m = math.hypot(scene.range_sigma_m[i], scene.mark_sigma_m[j])
            tangential_m = math.hypot(scene.range_m[i] * scene.bearing_sigma_rad[i], scene.mark_sigma_m[j])
            density = math.exp(-0.5 * ((misfit.real / radial_m) ** 2 + (misfit.imag / tangential_m) ** 2))
            pd = level * float(field.detection(scene.range_m[i], scene.conspicuity[j]))
            table[i, j] = pd / (1 - pd) * density / (2 * math.pi * radial_m * tangential_m) / field.clutter_per_m2[i]
    return table


def sum_over_matchings(table: np.ndarray) -> float:
    """Return the sum over all one-to-one matchings of the product of their entries: 1 for the empty one."""
    if not len(table):
        return 1.0
    rest = sum_over_matchings(table[1:])
    for j in range(table.shape[1]):
        rest += table[0, j] * sum_over_matchings(np.delete(table[1:], j, axis=1))
    return rest


def exact_log_ratio(field: em.Field, pose: Poses) -> float:
    """Return eq. (6.7) averaged over shares and levels with the matchings summed one by one."""
    scene, terms = field.scene, []
    distance_m = np.abs(scene.z - pose.p[0])
    for level in MODEL.detection_level:
        missed = np.log1p(-level * field.detection(distance_m, scene.conspicuity))[distance_m <= scene.radar_range_m]
        for share in MODEL.clutter_share:
            matchings = math.log(sum_over_matchings(ratios(field, pose, level) / share))
            terms.append(len(scene.rho) * (1 - share + math.log(share)) + missed.sum() + matchings)
    return float(np.logaddexp.reduce(terms) - math.log(len(terms)))


def test_a_sum_over_matchings_of_ones_counts_them():
    assert sum_over_matchings(np.ones((2, 2))) == 7.0  # empty, four single, two double


@pytest.mark.parametrize("seed", range(8))
def test_the_evidence_bounds_the_sum_over_all_matchings_closely(seed: int):
    field, pose = tiny_field(seed)
    found = evidence.log_likelihood_ratio(field, pose, em.lay_over(field, pose))[0]
    exact = exact_log_ratio(field, pose)
    assert exact - 1e-9 <= found <= exact + 1.0


def test_the_evidence_is_exact_where_every_echo_has_one_mark():
    field, pose = tiny_field(3, targets=3, marks=3)
    far_apart = replace(
        field.scene,
        range_sigma_m=np.full(3, 5.0),
        bearing_sigma_rad=np.full(3, 0.005),
        mark_sigma_m=np.full(3, 5.0),
    )
    sharp = em.Field(far_apart, field.model)
    found = evidence.log_likelihood_ratio(sharp, pose, em.lay_over(sharp, pose))[0]
    assert found == pytest.approx(exact_log_ratio(sharp, pose), abs=1e-6)


def test_likelihood_ratios_are_those_of_the_definition():
    field, pose = tiny_field(1)
    fit = em.lay_over(field, pose)
    dense = np.zeros((len(field.scene.rho), len(field.scene.z)))
    np.put_along_axis(dense, fit.mark[0], em.likelihood_ratio(field, fit, 0.55)[0], axis=1)
    np.testing.assert_allclose(dense, ratios(field, pose, 0.55), rtol=1e-9)


def test_marginals_by_belief_propagation_are_near_those_of_all_matchings():
    random = np.random.default_rng(2)
    for _ in range(20):
        table = np.exp(random.normal(0.0, 2.0, (3, 4)))
        total = sum_over_matchings(table)
        exact = np.array(
            [
                [
                    table[i, j] * sum_over_matchings(np.delete(np.delete(table, i, 0), j, 1)) / total
                    for j in range(table.shape[1])
                ]
                for i in range(table.shape[0])
            ]
        )
        found = association_marginals(table)
        assert np.abs(found - exact).max() < 0.1
        assert np.all(found.sum(axis=1) <= 1.0)
        assert np.all(found.sum(axis=0) <= 1.0 + 1e-6)


def test_marginals_are_exact_for_one_echo():
    table = np.array([[3.0, 0.5, 10.0]])
    np.testing.assert_allclose(association_marginals(table), table / 14.5)


def test_the_em_step_follows_the_gradient_of_its_own_likelihood():
    """Within the share that a misfit (tens of metres) has of a range (hundreds): eq. (6.5) leaves that turn out."""
    field, pose = tiny_field(5)
    moved, information, _ = em.em_step(field, pose, 1.0)
    step = np.array([(moved.p[0] - pose.p[0]).real, (moved.p[0] - pose.p[0]).imag, moved.heading_rad[0]])

    def gain(north_m: float, east_m: float, turn_rad: float) -> float:
        there = Poses(pose.p + complex(north_m, east_m), pose.heading_rad + turn_rad)
        table = em.likelihood_ratio(field, em.lay_over(field, there), em.NOMINAL_LEVEL)
        return float(np.log(em.NOMINAL_SHARE + table.sum(axis=2)).sum())

    size = (0.01, 0.01, 1e-5)
    gradient = np.array(
        [(gain(*(h * axis)) - gain(*(-h * axis))) / (2 * h) for h, axis in zip(size, np.eye(3), strict=True)]
    )
    np.testing.assert_allclose(information[0] @ step, gradient, rtol=0.05)


@pytest.mark.parametrize("hints", ["none", "position", "heading", "both"])
def test_the_mass_of_a_pose_is_the_integral_of_prior_times_peak(hints: str):
    place, heading_rad = hints in ("position", "both"), hints in ("heading", "both")
    known = Prior(
        log_area=math.log(1e8),
        wrong_share=0.05,
        place=complex(120.0, -40.0) if place else None,
        place_sigma_m=150.0 if place else math.inf,
        heading_rad=2.0 * math.pi + 0.03 if heading_rad else None,  # the other side of the wrap
        heading_sigma_rad=0.04 if heading_rad else math.inf,
    )
    root = np.array([[0.02, 0.004, 1.0], [0.0, 0.015, -0.7], [0.0, 0.0, 60.0]])
    information = root.T @ root
    pose = Poses(np.array([0.0 + 0.0j]), np.array([0.0]))
    sigma = np.sqrt(np.diag(np.linalg.inv(information)))
    axes = [np.linspace(-7.0 * s, 7.0 * s, 81) for s in sigma]
    d = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    peak = np.exp(-0.5 * np.einsum("...i,ij,...j", d, information, d))
    by_place, by_heading = np.full(d.shape[:3], 1e-8), np.full(d.shape[:3], 1.0 / (2.0 * math.pi))
    if place:
        off_sq = (d[..., 0] - 120.0) ** 2 + (d[..., 1] + 40.0) ** 2
        by_place = 0.05 * by_place + 0.95 * np.exp(-0.5 * off_sq / 150.0**2) / (2.0 * math.pi * 150.0**2)
    if heading_rad:
        normal = np.exp(-0.5 * ((d[..., 2] - 0.03) / 0.04) ** 2) / (math.sqrt(2.0 * math.pi) * 0.04)
        by_heading = 0.05 * by_heading + 0.95 * normal
    cell = math.prod(axis[1] - axis[0] for axis in axes)
    assert known.log_mass(pose, information[None])[0] == pytest.approx(
        math.log((peak * by_place * by_heading).sum() * cell), abs=1e-4
    )


def test_a_refuted_hint_costs_the_logarithm_of_how_rare_that_is_and_no_more():
    free = Prior(math.log(1e9), 0.05)
    gyro = replace(free, heading_rad=math.pi / 2.0, heading_sigma_rad=0.03)
    pose, information = Poses(np.zeros(1, dtype=complex), np.zeros(1)), np.diag([1e-3, 1e-3, 1e5])[None]
    cost = free.log_mass(pose, information)[0] - gyro.log_mass(pose, information)[0]
    assert cost == pytest.approx(math.log(1.0 / 0.05), abs=1e-6)
    assert gyro.hint_holds(pose, information)[0].tolist() == pytest.approx([0.0, 0.0], abs=1e-6)


def test_the_searched_area_is_the_union_of_the_discs():
    field, _ = tiny_field(0)
    one_place = replace(field.scene, z=np.zeros(len(field.scene.z), dtype=complex))
    disc_m2 = math.pi * field.scene.radar_range_m**2
    assert math.exp(prior.log_area(em.Field(one_place, MODEL))) == pytest.approx(disc_m2, rel=0.06)
    apart = replace(field.scene, z=1e6 * np.arange(len(field.scene.z)).astype(complex))
    assert math.exp(prior.log_area(em.Field(apart, MODEL))) == pytest.approx(len(apart.z) * disc_m2, rel=0.06)


@pytest.mark.parametrize("targets", [5, 8, 30])
def test_clutter_is_denser_in_a_cluster_and_never_below_the_mean(targets: int):
    made = make_scene(SceneRecipe(targets, 60), 1)
    scene = scenes.build(made.epoch, radar_model("imo"), MODEL)
    mean = len(scene.rho) / (math.pi * scene.radar_range_m**2)
    density = em.clutter_density(scene, MODEL)
    for i, rho in enumerate(scene.rho):
        others = np.delete(scene.rho, i)
        kernels = [
            sum(math.exp(-0.5 * abs(rho - o) ** 2 / b**2) / (2 * math.pi * b**2) for o in others)
            for b in MODEL.clutter_kernels_m
        ]
        round_only = max(mean, 0.5 * mean + 0.5 * max(kernels))
        nearest = others[np.argsort(np.abs(others - rho))[: MODEL.clutter_neighbours]] - rho
        points = np.column_stack([nearest.real, nearest.imag])
        own_m2 = (scene.range_sigma_m[i] ** 2 + (scene.range_m[i] * scene.bearing_sigma_rad[i]) ** 2) / 2.0
        covariance = np.cov(points.T) + np.eye(2) * (own_m2 + MODEL.clutter_floor_m**2)
        middle = points.mean(axis=0)
        along = len(points) * math.exp(-0.5 * middle @ np.linalg.solve(covariance, middle))
        along /= 2 * math.pi * math.sqrt(np.linalg.det(covariance))
        assert density[i] == pytest.approx(max(round_only, 0.5 * round_only + 0.5 * along))


def test_echoes_of_one_quay_are_not_taken_for_the_ships_at_another():
    """Ships moored in a line have much the same distances everywhere: 11 of 400 were accepted with round kernels."""
    plane = LocalPlane(Position(54.0, 8.0))
    accepted = 0
    for seed in range(60):
        random = np.random.default_rng(seed)
        quay = 1500.0 + np.cumsum(random.uniform(60.0, 220.0, 25)) + 1j * random.normal(0.0, 8.0, 25)
        elsewhere = 1500.0 + np.cumsum(random.uniform(60.0, 220.0, 12)) + 1j * random.normal(0.0, 8.0, 12)
        away = 9000.0 * np.sqrt(random.uniform(size=15)) * np.exp(2j * np.pi * random.uniform(size=15))
        marks = tuple(
            Mark(f"{k}", plane.to_position(z.real, z.imag), 15.0) for k, z in enumerate(np.concatenate([quay, away]))
        )
        targets = tuple(
            RadarTarget(f"{k}", abs(z) + 20.0 * random.normal(), math.degrees(np.angle(z)) + 0.5 * random.normal())
            for k, z in enumerate(elsewhere)
        )
        try:
            navfix.associate(Epoch(None, targets, marks))
            accepted += 1
        except NoFix:
            continue
    assert accepted == 0


@pytest.mark.parametrize("seed", [169, 522])
def test_seven_echoes_of_one_row_of_aids_are_not_taken_for_the_aids_of_another(seed: int):
    """Seeds that were accepted while fewer than nine echoes counted as spread evenly: one of them with all seven."""
    random, plane = np.random.default_rng(seed), LocalPlane(Position(54.0, 8.0))
    aids, echoes = (np.cumsum(random.uniform(600.0, 2200.0, n)) + 1j * random.normal(0.0, 8.0, n) for n in (12, 7))
    echoes += -echoes[3].real + 1j * random.uniform(-3000.0, 3000.0)
    targets = tuple(
        RadarTarget(f"{k}", abs(z) + 20.0 * random.normal(), math.degrees(np.angle(z)) + 0.5 * random.normal())
        for k, z in enumerate(echoes)
    )
    away = 12000.0 * np.sqrt(random.uniform(size=15)) * np.exp(2j * np.pi * random.uniform(size=15))
    marks = tuple(
        Mark(f"{k}", plane.to_position(z.real, z.imag), 15.0, kind="aton")
        for k, z in enumerate(np.concatenate([aids, away]))
    )
    with pytest.raises(NoFix):
        navfix.associate(Epoch(None, targets, marks))


@pytest.mark.parametrize("uncertain_m", [10.0, 200.0])
def test_the_bound_of_the_proof_holds_for_poses_anywhere_in_a_cell(uncertain_m: float):
    """Also where the marks in range are far less certain than most others."""
    own, near = Position(54.0, 8.0), [(900.0, 300.0), (-1500.0, 2500.0), (-3300.0, -700.0), (4200.0, -2600.0)]
    seen = tuple(Mark(f"{j}", PLANE.to_position(*place), uncertain_m) for j, place in enumerate(near))
    others = tuple(Mark(f"far {j}", PLANE.to_position(20000.0 + 900.0 * j, 0.0), 10.0) for j in range(9))
    polar = [inverse(own, mark.position) for mark in seen]
    targets = tuple(
        RadarTarget(f"{j}", *place, range_sigma_m=5.0, bearing_sigma_deg=0.1) for j, place in enumerate(polar)
    )
    scene = scenes.build(Epoch(None, targets, seen + others), radar_model("imo"), MODEL)
    field = em.Field(scene, MODEL)
    grid = proof._Grid.of(field)
    random = np.random.default_rng(1)
    place = complex(*scenes.cloud_to_plane(scene.origin, [own.lat_deg], [own.lon_deg])[0])
    p = place + 1.5 * uncertain_m * np.exp(2j * math.pi * random.uniform(size=200))
    poses = Poses(p, np.radians(random.uniform(-0.5, 0.5, size=200)))
    found = evidence.log_likelihood_ratio(field, poses, em.lay_over(field, poses))
    row, column = (
        np.floor(part / grid.cell_m).astype(int) for part in ((p - grid.corner).real, (p - grid.corner).imag)
    )
    assert found.max() > 10.0
    assert np.all(found <= grid.bound(0.0)[row * grid.east + column])


@pytest.mark.parametrize("seed", range(3))
def test_the_bound_of_a_cut_cell_holds_in_it_and_falls_as_it_shrinks(seed: int):
    made = make_scene(SceneRecipe(20, 80, 6.0, 12.0, 0.3, 0.1), seed)
    scene = scenes.build(made.epoch, radar_model("imo"), MODEL)
    field, random = em.Field(scene, MODEL), np.random.default_rng(seed)
    peaks = proof._Grid.of(field).peaks()
    place = complex(*scenes.cloud_to_plane(scene.origin, [made.position.lat_deg], [made.position.lon_deg])[0])
    cells = Cells(np.array([place + 60.0 - 90.0j]), np.radians([made.heading_deg + 0.2]), 400.0, math.radians(1.0))
    last = math.inf
    for _ in range(4):
        bounds = bound(field, cells, peaks)
        assert bounds.max() <= last + 1e-9
        last = bounds.max()
        for k in range(0, len(cells), max(1, len(cells) // 16)):
            offset = random.uniform(-0.5, 0.5, (40, 3)) * [cells.side_m, cells.side_m, cells.turn_rad]
            poses = Poses(cells.p[k] + offset[:, 0] + 1j * offset[:, 1], cells.heading_rad[k] + offset[:, 2])
            found = evidence.log_likelihood_ratio(field, poses, em.lay_over(field, poses))
            assert np.all(found <= bounds[k] + 0.1)  # matches beyond four sigma are left out of the bound
        cells = cells.split()
    assert len(cells) == 8**4


def test_pairs_of_marks_are_all_found_and_two_in_one_point_are_none():
    random = np.random.default_rng(4)
    z = random.uniform(0, 5000, 300) + 1j * random.uniform(0, 5000, 300)
    z[7] = z[8]
    index = PairIndex.of(z, 2000.0)
    i, j = np.triu_indices(300, 1)
    apart_m = np.abs(z[i] - z[j])
    wanted = {(a, b) for a, b, d in zip(i, j, apart_m, strict=True) if 0.0 < d <= 2000.0}
    assert {tuple(sorted(pair)) for pair in zip(index.first.tolist(), index.second.tolist(), strict=True)} == wanted
    assert np.all(np.diff(index.distance_m) >= 0.0)


@pytest.mark.parametrize("order", list(permutations(range(3)))[:2])
def test_two_marks_in_one_point_and_close_echoes_are_no_error(order: tuple[int, ...]):
    places = [(0, 0), (0, 0), (300, 200), (300, 200), (-200, 400), (500, -300)]
    marks = tuple(Mark(str(i), PLANE.to_position(n, e), 5.0) for i, (n, e) in enumerate(places))
    polar = [(400, 10.0), (440, 10.5), (500, 80.0), (540, 81.0), (700, 200.0), (600, 300.0)]
    targets = tuple(RadarTarget(str(i), r, b) for i, (r, b) in enumerate(polar))
    for chosen in (marks, tuple(marks[0] for _ in order)):
        with pytest.raises(NoFix):
            navfix.associate(Epoch(None, targets, chosen))


@pytest.mark.parametrize("azimuth_deg", [70.0, 250.0])
def test_the_shift_of_a_second_group_points_from_the_true_to_the_stated_positions(azimuth_deg: float):
    random = np.random.default_rng(12)
    true = random.uniform(-15000.0, 15000.0, (24, 2))
    shift = 1500.0 * np.array([math.cos(math.radians(azimuth_deg)), math.sin(math.radians(azimuth_deg))])
    stated = true + np.where(np.arange(24)[:, None] < 9, shift, 0.0)
    own = Position(54.0, 8.0)
    polar = [inverse(own, PLANE.to_position(*place)) for place in true]
    targets = tuple(
        RadarTarget(f"{i}", r, b - 123.0, range_sigma_m=30.0, bearing_sigma_deg=0.3) for i, (r, b) in enumerate(polar)
    )
    marks = tuple(Mark(f"{j}", PLANE.to_position(*place), 10.0) for j, place in enumerate(stated))
    found = navfix.associate(Epoch(None, targets, marks))
    assert inverse(found.position, own)[0] < 50.0
    assert found.second_group is not None
    assert found.second_group.offset_m == pytest.approx(1500.0, abs=60.0)
    assert found.second_group.azimuth_deg == pytest.approx(azimuth_deg, abs=3.0)
    assert set(found.second_group.targets) == {f"{i}" for i in range(9)}
