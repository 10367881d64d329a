"""Just enough observations: every exact solution is found, listed, and none is picked where two fit alike."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from navfix.adjustment.adjust_case import adjust_case
from navfix.adjustment.case import Case, case_of
from navfix.adjustment.minimal import minimal_places, on_danger_circle
from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, Network
from navfix.adjustment.sights import residuals
from navfix.errors import Ambiguous, NoFix, Unobservable
from navfix.types import PlanePosition

R, B, T = RANGE, RELATIVE_BEARING, TRUE_BEARING
KIND_WORDS = {R: "range", B: "relative_bearing", T: "true_bearing"}
# kind and number of the mark: every set that just suffices
SETS = {
    "three relative bearings": ((B, 0), (B, 1), (B, 2)),
    "range and two bearings, two marks": ((R, 0), (B, 0), (B, 1)),
    "range and two bearings, three marks": ((R, 0), (B, 1), (B, 2)),
    "two ranges and a bearing": ((R, 0), (R, 1), (B, 0)),
    "two ranges and a bearing to a third mark": ((R, 0), (R, 1), (B, 2)),
    "two true bearings and a relative one": ((T, 0), (T, 1), (B, 2)),
    "range, true and relative bearing": ((R, 0), (T, 1), (B, 0)),
    "true bearing and two relative ones": ((T, 0), (B, 1), (B, 2)),
    "two ranges": ((R, 0), (R, 1)),
    "two true bearings": ((T, 0), (T, 1)),
    "range and true bearing": ((R, 0), (T, 1)),
    "range and true bearing of one mark": ((R, 0), (T, 0)),
}


@dataclass(frozen=True)
class Drawn:
    """A network of exact values, and the pose that they were computed from."""

    network: Network
    truth: np.ndarray


def drawn(name: str, seed: int) -> Drawn:
    """Marks 0.5 to 15 km all round own ship, 20 m and 0.5 deg."""
    rng = np.random.default_rng([seed, *name.encode()])
    kinds, marks = (np.array(column) for column in zip(*SETS[name], strict=True))
    truth = np.array([*rng.uniform(-2e3, 2e3, 2), rng.uniform(-math.pi, math.pi) * bool(np.any(kinds == B))])
    distance = np.exp(rng.uniform(math.log(500.0), math.log(15e3), marks.max() + 1))
    azimuth = rng.uniform(0.0, 2.0 * math.pi, marks.max() + 1)
    places = truth[:2] + distance[:, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    value = np.where(kinds == R, distance[marks], azimuth[marks] - truth[2] * (kinds == B))
    sigma = np.where(kinds == R, 20.0, math.radians(0.5))
    return Drawn(Network.build(kinds, marks, value, sigma, places), truth)


def as_case(network: Network, start: dict[str, float] | None = None) -> Case:
    unit = [1.0 if kind == R else math.degrees(1.0) for kind in network.kind]
    table = {
        "frame": "plane",
        "marks": [{"label": f"m{i}", "north_m": n, "east_m": e} for i, (n, e) in enumerate(network.mark_ne_m.tolist())],
        "observations": [
            {"mark": f"m{mark}", "kind": KIND_WORDS[kind], "value": float(value) * u, "sigma": float(sigma) * u}
            for kind, mark, value, sigma, u in zip(
                network.kind.tolist(), network.mark.tolist(), network.value, network.sigma, unit, strict=True
            )
        ],
    }
    return case_of(table if start is None else table | {"start": start})


@cache
def exact_solutions(name: str, seed: int) -> np.ndarray:
    """Find every pose (s, 3) with zero residuals by damped Newton steps from 300 places; knows no geometry."""
    network = drawn(name, seed).network
    u = network.unknowns
    rng, unit = np.random.default_rng(seed), np.array([1e3, 1e3, 1.0])[:u]
    scale = np.where(network.kind == R, 1e-3, 1.0)
    x = np.column_stack([rng.uniform(-25e3, 25e3, (300, 2)), rng.uniform(-math.pi, math.pi, 300)])
    x[:, u:] = 0.0

    def misfit(pose: np.ndarray) -> np.ndarray:
        return residuals(network, pose) * scale

    mu = np.full(len(x), 1e-3)
    for _ in range(60):
        f, step = misfit(x), np.eye(3)[:u] * [1e-2, 1e-2, 1e-8]
        j = np.stack([(misfit(x + d) - misfit(x - d)) / (2.0 * d.sum()) for d in step], axis=-1) * unit
        normal = np.swapaxes(j, 1, 2) @ j + mu[:, None, None] * np.eye(u)
        change = np.zeros_like(x)
        change[:, :u] = -np.linalg.solve(normal, np.swapaxes(j, 1, 2) @ f[..., None])[..., 0] * unit
        change *= np.minimum(1.0, 5e3 / np.maximum(np.hypot(change[:, 0], change[:, 1]), 1e-9))[:, None]
        better = np.sum(misfit(x + change) ** 2, axis=1) < np.sum(f**2, axis=1)
        x, mu = np.where(better[:, None], x + change, x), np.where(better, np.maximum(0.2 * mu, 1e-14), 8.0 * mu)
    found: list[np.ndarray] = []
    for pose in x[np.max(np.abs(misfit(x)), axis=1) < 1e-7]:
        if all(np.hypot(*(pose[:2] - other[:2])) > 5.0 for other in found):
            found.append(pose)
    return np.array(found).reshape(-1, 3)


def listed(places: list[object], pose: np.ndarray) -> bool:
    return any(
        isinstance(p, PlanePosition) and math.hypot(p.north_m - pose[0], p.east_m - pose[1]) < 1.0 for p in places
    )


@pytest.mark.parametrize("name", SETS)
def test_the_truth_is_among_the_places_in_which_two_curves_meet(name: str) -> None:
    for seed in range(30):
        scene = drawn(name, seed)
        off_m = np.min(np.hypot(*(minimal_places(scene.network, 60) - scene.truth[:2]).T))
        assert off_m < 1e-3, (seed, off_m)


@pytest.mark.parametrize("kernel", ["none", "hampel"])
@pytest.mark.parametrize("name", SETS)
def test_every_exact_solution_is_listed_and_none_is_picked(name: str, kernel: str) -> None:
    """Without a start: the one solution, or `Ambiguous` with all that a blind search finds."""
    several = 0
    for seed in range(4):
        scene = drawn(name, seed)
        solutions = exact_solutions(name, seed)
        assert len(solutions) >= 1
        try:
            fix = adjust_case(as_case(scene.network), kernel=kernel)
            places = [fix.position, *(other.position for other in fix.alternatives)]
            assert len(solutions) == 1 or np.ptp(solutions[:, :2], axis=0).max() < 50.0
        except Ambiguous as error:
            places = [other.position for other in error.alternatives]
            several += 1
        except Unobservable:
            continue
        assert all(listed(list(places), pose) for pose in solutions), seed
    assert several >= (2 if name == "two ranges" else 0)


@pytest.mark.parametrize("kernel", ["none", "huber", "hampel"])
def test_from_a_start_one_solution_is_the_fix_and_the_other_an_alternative(kernel: str) -> None:
    """Starts 100 m, 3 km and 20 km off, heading up to 40 deg off: a range and two bearings."""
    name = "range and two bearings, two marks"
    for seed in range(4):
        scene = drawn(name, seed)
        solutions = exact_solutions(name, seed)
        for off_m in (100.0, 3e3, 2e4):
            heading_deg = math.degrees(scene.truth[2]) + min(off_m / 100.0, 40.0)
            start = {"north_m": scene.truth[0] + off_m, "east_m": scene.truth[1], "heading_deg": heading_deg % 360.0}
            try:
                fix = adjust_case(as_case(scene.network, start), kernel=kernel)
            except Unobservable:
                continue
            assert any(listed([fix.position], pose) for pose in solutions), (seed, off_m)
            assert all(listed([fix.position, *(a.position for a in fix.alternatives)], pose) for pose in solutions)


def test_bearings_alone_need_no_start_however_many_are_wrong() -> None:
    """Twelve relative bearings, four of them wrong: the resection is found and the wrong ones are given up."""
    rng = np.random.default_rng(5)
    for _ in range(10):
        places = rng.uniform(-1e4, 1e4, (12, 2))
        azimuth = np.arctan2(places[:, 1], places[:, 0])
        seen = azimuth - 2.0 + math.radians(0.3) * rng.normal(size=12)
        seen[:4] += rng.uniform(0.2, 2.0, 4)
        network = Network.build(np.full(12, B), np.arange(12), seen, math.radians(0.3), places)
        fix = adjust_case(as_case(network), kernel="hampel")
        assert isinstance(fix.position, PlanePosition)
        assert math.hypot(fix.position.north_m, fix.position.east_m) < 200.0
        assert all(o.weight < 0.5 for o in fix.observations[:4])


def test_the_danger_circle_is_named() -> None:
    """Own ship on the circle through all three marks: any place on it sees them under the same angles."""
    azimuth = np.radians([10.0, 120.0, 215.0])
    places = 5e3 * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    own = np.array([5e3 * math.cos(5.0), 5e3 * math.sin(5.0), 0.3])
    off = places - own[:2]
    network = Network.build([B] * 3, [0, 1, 2], np.arctan2(off[:, 1], off[:, 0]) - 0.3, math.radians(0.5), places)
    assert on_danger_circle(network, own)
    assert not on_danger_circle(network, own + [900.0, 0.0, 0.0])
    with pytest.raises(Unobservable, match="on one circle"):
        adjust_case(as_case(network))


def test_curves_that_miss_each_other_give_no_fix_or_a_place_between() -> None:
    """Two ranges too short to meet by 400 m at 20 m sigma: no exact solution, and none is claimed."""
    network = Network.build([R, R], [0, 1], [4800.0, 4800.0], 20.0, [[0.0, 0.0], [0.0, 10_000.0]])
    with pytest.raises(NoFix):
        adjust_case(as_case(network))


@pytest.mark.parametrize("kernel", ["none", "huber", "hampel"])
def test_a_start_on_a_mark_is_not_the_answer(kernel: str) -> None:
    """No bearing has a direction there: the descent must not stay, however little the observations agree."""
    places = [[0.0, 0.0], [500.0, 0.0], [0.0, 800.0]]
    own = np.array([-60.0, 20.0])
    off = np.array(places) - own
    range_m, bearing_rad = np.hypot(*off.T), np.arctan2(off[:, 1], off[:, 0])
    values = np.column_stack([range_m, bearing_rad]).ravel()
    network = Network.build([R, B] * 3, [0, 0, 1, 1, 2, 2], values, [5.0, math.radians(0.5)] * 3, places)
    start = {"north_m": 0.0, "east_m": 0.0, "heading_deg": 0.0}
    fix = adjust_case(as_case(network, start), kernel=kernel)
    assert listed([fix.position], own)
