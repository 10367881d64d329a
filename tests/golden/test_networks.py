"""Published single-point networks: adjusted places and their standard deviations."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Geod

from navfix.adjustment.adjust_case import adjust_case, first_step
from navfix.adjustment.case import case_of
from navfix.geodesy import direct, inverse
from navfix.types import Fix, PlanePosition, Position

GEOD = Geod(ellps="WGS84")
GOLDEN = Path(__file__).resolve().parents[2] / "data" / "golden"


def read(name: str) -> dict[str, Any]:
    return tomllib.loads((GOLDEN / f"{name}.toml").read_text(encoding="utf-8"))


def a_posteriori_sigma_m(fix: Fix) -> tuple[float, float]:
    """Return (east, north): the books scale by sigma0 whatever the redundancy."""
    north_m, east_m = fix.sigma0 * np.sqrt(np.diag(fix.cofactor_matrix))
    return float(east_m), float(north_m)


@pytest.mark.parametrize("name", ["benning_8_8", "strang_borre"])
@pytest.mark.parametrize("solver", ["gtsam", "dense"])
def test_the_books_place_and_standard_deviations(name: str, solver: Any) -> None:
    table = read(name)
    expected, tolerance = table["expected"], table["tolerance"]
    fix = adjust_case(case_of(table), kernel="none", solver=solver)
    assert isinstance(fix.position, PlanePosition)
    assert fix.position.east_m == pytest.approx(expected["east_m"], abs=tolerance["position_m"]["value"])
    assert fix.position.north_m == pytest.approx(expected["north_m"], abs=tolerance["position_m"]["value"])
    east_m, north_m = a_posteriori_sigma_m(fix)
    allowed = tolerance["sigma_cm"]["value"]
    assert 100.0 * east_m == pytest.approx(expected["sigma_east_cm"], abs=allowed)
    assert 100.0 * north_m == pytest.approx(expected["sigma_north_cm"], abs=allowed)
    assert 100.0 * math.hypot(east_m, north_m) == pytest.approx(expected["position_sigma_cm"], abs=allowed)


def test_the_increments_of_strang_and_borre_are_those_of_the_first_step() -> None:
    table = read("strang_borre")
    case = case_of(table)
    step = first_step(case, adjust_case(case, kernel="none"))
    assert step is not None
    assert 100.0 * step.increments[::-1] == pytest.approx(
        table["expected"]["increments_east_north_cm"], abs=table["tolerance"]["increments_cm"]["value"]
    )


def test_gdynia_iterated_to_the_end() -> None:
    table = read("gdynia")
    fix = adjust_case(case_of(table), kernel="none")
    assert isinstance(fix.position, PlanePosition)
    moved = (fix.position.east_m - table["start"]["east_m"], fix.position.north_m - table["start"]["north_m"])
    expected = table["expected"]["converged_increments_x_y_m"]
    assert moved == pytest.approx(expected, abs=table["tolerance"]["position_m"]["value"])


def test_gdynia_robust_damps_mark_5_alone() -> None:
    for kernel in ("huber", "hampel", "danish"):
        fix = adjust_case(case_of(read("gdynia")), kernel=kernel)
        damped = [o.mark for o in fix.observations if o.weight < 0.99]
        assert damped == ["5"], kernel


def test_gdynia_on_the_ellipsoid() -> None:
    """Beside the expected place, no shift of a metre may fit the bearings better by geodesics of another library."""
    table = read("gdynia_ellipsoid")
    fix = adjust_case(case_of(table), kernel="none")
    assert isinstance(fix.position, Position)
    expected = Position(table["expected"]["lat_deg"], table["expected"]["lon_deg"])
    assert inverse(fix.position, expected)[0] < table["tolerance"]["position_m"]["value"]

    def misfit(place: Position) -> float:
        azimuths = [GEOD.inv(place.lon_deg, place.lat_deg, m["lon_deg"], m["lat_deg"])[0] for m in table["marks"]]
        off = [(a - o["value"] + 180.0) % 360.0 - 180.0 for a, o in zip(azimuths, table["observations"], strict=True)]
        return sum(v * v for v in off)

    assert all(misfit(direct(fix.position, azimuth, 1.0)) > misfit(fix.position) for azimuth in range(0, 360, 30))


def test_distance_networks_of_the_suite_agree_with_gnu_gama(shared_data: Path) -> None:
    """Every single-point network of distances: adjusted values, ellipse, sigma0 and redundancy against GNU Gama."""
    networks = json.loads((shared_data / "adjustment" / "published_networks.json").read_text(encoding="utf-8"))
    chosen = [n for n in networks if {o["type"] for o in n["observations"]} == {"distance"} and len(n["adjusted"]) == 1]
    assert len(chosen) >= 2
    for network in chosen:
        point = network["adjusted"][0]
        case = case_of(
            {
                "frame": "plane",
                "marks": [{"label": f["id"], "east_m": f["x"], "north_m": f["y"]} for f in network["fixed"]],
                "observations": [
                    {
                        "mark": o["to"] if o["from"] == point["id"] else o["from"],
                        "kind": "range",
                        "value": o["obs"],
                        "sigma": o["stdev_apriori"] / 1000.0,
                    }
                    for o in network["observations"]
                ],
                "start": {"east_m": point["x"] + 0.05, "north_m": point["y"] - 0.05},
            }
        )
        fix = adjust_case(case, kernel="none")
        assert isinstance(fix.position, PlanePosition)
        assert (fix.position.east_m, fix.position.north_m) == pytest.approx((point["x"], point["y"]), abs=1e-5)
        assert fix.redundancy == network["dof"]
        assert fix.sigma0 == pytest.approx(network["m0_aposteriori"] / network["m0_apriori"], rel=1e-4)
        major_m, minor_m = fix.sigma0 * np.sqrt(np.linalg.eigvalsh(fix.cofactor_matrix))[::-1]
        ellipse = network["ellipse_mm"][0]
        assert (1000.0 * major_m, 1000.0 * minor_m) == pytest.approx((ellipse["a"], ellipse["b"]), rel=1e-4)
        for ours, theirs in zip(fix.observations, network["observations"], strict=True):
            assert ours.adjusted == pytest.approx(theirs["adj"], abs=1e-5)
            if ours.standardized is not None:  # theirs are scaled by sigma0 and have no sign
                assert abs(ours.standardized) / fix.sigma0 == pytest.approx(theirs["std-residual"], abs=2e-3)


@pytest.mark.parametrize("name", ["ghilani_15_4", "ghilani_16_1", "lother_strehle", "grossmann", "carosio"])
@pytest.mark.parametrize("solver", ["gtsam", "dense"])
def test_networks_of_angles_and_directions(name: str, solver: Any) -> None:
    """Place, standard ellipse and, where nothing was reduced, sigma0 and redundancy; also without the start given."""
    table = read(name)
    expected, tolerance = table["expected"], table["tolerance"]
    fix = adjust_case(case_of(table), kernel="none", damping="separate", solver=solver)
    assert isinstance(fix.position, PlanePosition)
    assert fix.position.east_m == pytest.approx(expected["east_m"], abs=tolerance["position_m"]["value"])
    assert fix.position.north_m == pytest.approx(expected["north_m"], abs=tolerance["position_m"]["value"])
    axes_mm = 1000.0 * np.sqrt(np.linalg.eigvalsh(fix.cofactor_matrix[:2, :2]))
    allowed = tolerance["semi_axes"]["value"]
    assert axes_mm == pytest.approx([expected["semi_minor_mm"], expected["semi_major_mm"]], rel=allowed)
    if "sigma0" in expected:
        assert fix.sigma0 == pytest.approx(expected["sigma0"], abs=tolerance["sigma0"]["value"])
        assert fix.redundancy == expected["redundancy"]
    alone = adjust_case(case_of({key: value for key, value in table.items() if key != "start"}), kernel="none")
    assert isinstance(alone.position, PlanePosition)
    assert alone.position.east_m == pytest.approx(fix.position.east_m, abs=1e-4)


@pytest.mark.parametrize("name", ["triangle_1", "triangle_2"])
@pytest.mark.parametrize("solver", ["gtsam", "dense"])
def test_points_by_intersection_without_redundancy(name: str, solver: Any) -> None:
    """Directions at two fixed points and nothing else: the place, without a start, and no global test."""
    table = read(name)
    fix = adjust_case(case_of(table), solver=solver)
    assert isinstance(fix.position, PlanePosition)
    assert fix.position.east_m == pytest.approx(
        table["expected"]["east_m"], abs=table["tolerance"]["position_m"]["value"]
    )
    assert fix.position.north_m == pytest.approx(
        table["expected"]["north_m"], abs=table["tolerance"]["position_m"]["value"]
    )
    assert fix.redundancy == 0
    assert fix.global_test is None


GOLDEN_OF = {
    "Benning88_Distance_fix": "benning_8_8",
    "Carosio_DistanceDirection_fix": "carosio",
    "Ghilani15_4_Angle_fix": "ghilani_15_4",
    "Ghilani16_1_Traverse": "ghilani_16_1",
    "Grossmann_Direction_fix": "grossmann",
    "LotherStrehle_Direction5": "lother_strehle",
    "StrangBorre_Distance_fix": "strang_borre",
    "triangle-1": "triangle_1",
    "triangle-2": "triangle_2",
}
WHY_NOT = {
    "geodet-pc-123": "the observations of Grossmann's network once more, in axes to south and west",
    "Ghilani15_5_Angle_fix": "three angles at the new point, measured one by one: differences of bearings with errors "
    "of their own; no set of relative bearings from one heading has that covariance",
}


def test_every_published_single_point_network_is_golden_or_says_why_not(shared_data: Path) -> None:
    networks = json.loads((shared_data / "adjustment" / "published_networks.json").read_text(encoding="utf-8"))
    names = {network["name"] for network in networks if len(network["adjusted"]) == 1}
    assert names == GOLDEN_OF.keys() | WHY_NOT.keys()
    for name in GOLDEN_OF.values():
        assert read(name)["source"]
    by_name = {network["name"]: network for network in networks}
    observed = [
        sorted(round(o["obs"] % 400.0, 6) for o in by_name[name]["observations"])
        for name in ("geodet-pc-123", "Grossmann_Direction_fix")
    ]
    assert observed[0] == pytest.approx(observed[1], abs=1e-5)
