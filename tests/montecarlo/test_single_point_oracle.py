"""Random single-point cases against an adjuster of another make: SciPy, with the cofactors written out here."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import least_squares

from navfix.adjustment import graph
from navfix.adjustment.adjust_case import adjust_case
from navfix.adjustment.case import Case, case_of
from navfix.errors import NoFix
from navfix.types import Fix, PlanePosition

POSITION_M, COVARIANCE, REDUNDANCY, W, HEADING_DEG = 1e-3, 1e-5, 1e-4, 1e-3, 1e-5


@dataclass(frozen=True)
class Oracle:
    """What SciPy and a few lines of numpy find; w standardised by sigma sqrt(r)."""

    pose: np.ndarray
    cofactor: np.ndarray
    redundancy: np.ndarray
    w: np.ndarray


def random_case(seed: int) -> Case:
    """Three to nine marks, each with a range, a bearing (true or relative) or both; noise of one sigma."""
    rng = np.random.default_rng([seed, 5])
    n, heading = int(rng.integers(3, 10)), rng.uniform(0.0, 360.0)
    own = rng.uniform(-2000.0, 2000.0, 2)
    marks, observations = [], []
    for index in range(n):
        north, east = own + rng.uniform(500.0, 9000.0) * np.array(_direction(rng.uniform(0.0, 360.0)))
        marks.append({"label": f"m{index}", "north_m": north, "east_m": east, "sigma_m": float(rng.choice([0.0, 8.0]))})
        distance = math.hypot(north - own[0], east - own[1])
        azimuth = math.degrees(math.atan2(east - own[1], north - own[0]))
        kinds = rng.choice(["range", "bearing", "both"], p=[0.2, 0.2, 0.6])
        if kinds != "bearing":
            value = distance + 20.0 * rng.normal()
            observations.append({"mark": f"m{index}", "kind": "range", "value": value, "sigma": 20.0})
        if kinds != "range":
            relative = bool(rng.random() < 0.7)
            value = (azimuth - heading * relative + 0.4 * rng.normal()) % 360.0
            kind = "relative_bearing" if relative else "true_bearing"
            observations.append({"mark": f"m{index}", "kind": kind, "value": value, "sigma": 0.4})
    start = {"north_m": own[0] + 40.0, "east_m": own[1] - 30.0, "heading_deg": heading + 1.0}
    return case_of({"frame": "plane", "marks": marks, "observations": observations, "start": start})


def _direction(azimuth_deg: float) -> tuple[float, float]:
    return math.cos(math.radians(azimuth_deg)), math.sin(math.radians(azimuth_deg))


def oracle(case: Case, near: np.ndarray) -> Oracle:
    """Solve by SciPy with sigmas of the final place, renewed until they stand still; 2 or 3 unknowns."""
    places = {mark.label: (mark.position, mark.sigma_m) for mark in case.marks}
    pose, sigma = near, np.ones(len(case.observations))

    def computed(x: np.ndarray) -> np.ndarray:
        v = []
        for o in case.observations:
            place = places[o.mark][0]
            north, east = place.north_m - x[0], place.east_m - x[1]  # type: ignore[union-attr]
            if o.kind == "range":
                v.append(math.hypot(north, east) - o.value)
            else:
                turn = x[2] if o.kind == "relative_bearing" else 0.0
                v.append(math.remainder(math.atan2(east, north) - turn - math.radians(o.value), 2.0 * math.pi))
        return np.array(v)

    def combined(x: np.ndarray) -> np.ndarray:
        result = []
        for o in case.observations:
            place, mark_m = places[o.mark]
            reach = math.hypot(place.north_m - x[0], place.east_m - x[1])  # type: ignore[union-attr]
            own, by_mark = (o.sigma, mark_m) if o.kind == "range" else (math.radians(o.sigma), mark_m / reach)
            result.append(math.hypot(own, by_mark))
        return np.array(result)

    for _ in range(8):
        sigma = combined(pose)
        found = least_squares(lambda x, s=sigma: computed(x) / s, pose, "3-point", method="lm", xtol=1e-15, ftol=1e-15)
        pose = found.x
    A = found.jac
    Q = np.linalg.inv(A.T @ A)
    r = 1.0 - np.sum((A @ Q) * A, axis=1)
    return Oracle(pose, Q, r, computed(pose) / (sigma * np.sqrt(np.maximum(r, 1e-12))))


@dataclass(frozen=True)
class Differences:
    """The largest differences between navfix and SciPy: m, relative, 1, 1, deg."""

    position_m: float
    covariance: float
    redundancy: float
    w: float
    heading_deg: float


def compare(case: Case, fix: Fix) -> Differences:
    assert isinstance(fix.position, PlanePosition)
    heading = [] if fix.heading_deg is None else [math.radians(fix.heading_deg)]
    found = oracle(case, np.array([fix.position.north_m + 1.0, fix.position.east_m - 1.0, *heading]))
    turn_deg = math.degrees(math.remainder(heading[0] - found.pose[2], 2.0 * math.pi)) if heading else 0.0
    scale = np.sqrt(np.outer(np.diag(found.cofactor), np.diag(found.cofactor)))
    numbers = np.array([o.redundancy_number for o in fix.observations])
    tested = [i for i, o in enumerate(fix.observations) if o.redundancy_number > 1e-3 and o.standardized is not None]
    return Differences(
        math.hypot(fix.position.north_m - found.pose[0], fix.position.east_m - found.pose[1]),
        float(np.max(np.abs(fix.cofactor_matrix - found.cofactor) / scale)),
        float(np.max(np.abs(numbers - found.redundancy))),
        max((abs((fix.observations[i].standardized or 0.0) - float(found.w[i])) for i in tested), default=0.0),
        abs(turn_deg),
    )


def compared(cases: int, solver: str) -> list[Differences]:
    """Compare random cases with SciPy; those that the geometry leaves free are left out."""
    found = []
    for seed in range(cases):
        case = random_case(seed)
        try:
            fix = adjust_case(case, kernel="none", damping="separate", solver=solver)  # type: ignore[arg-type]
        except NoFix:
            continue
        found.append(compare(case, fix))
    return found


@pytest.mark.parametrize("solver", ["gtsam", "dense"])
def test_random_cases_agree_with_scipy(solver: str) -> None:
    """200 cases by each road; those that the geometry leaves free are few."""
    if solver == "gtsam" and not graph.available():
        pytest.skip("GTSAM is not installed")
    found = compared(200, solver)
    assert len(found) >= 185
    assert max(d.position_m for d in found) < POSITION_M
    assert max(d.covariance for d in found) < COVARIANCE
    assert max(d.redundancy for d in found) < REDUNDANCY
    assert max(d.w for d in found) < W
    assert max(d.heading_deg for d in found) < HEADING_DEG
