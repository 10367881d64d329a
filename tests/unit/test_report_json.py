"""The fix as JSON: every key, the same keys without a fix, plain numbers only."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from navfix.report import Answer
from navfix.report.fix_json import answer_to_dict, fix_to_dict
from navfix.report.json_parts import to_json_line
from navfix.report.numbers import plain
from navfix.types import Ellipse, Fix, GlobalTest
from tests.factories import every_fix, every_no_fix, make_answer, make_fix, make_no_fix, make_plane_fix

KEYS = {
    "schema", "status", "reason", "message", "time_utc", "position", "heading_deg", "heading_reference", "covariance",
    "cofactor_matrix", "covariance_scaling", "ellipses", "sigma0", "redundancy", "kernel", "global_test",
    "observations", "pairs", "unmatched_targets", "unmatched_marks", "ambiguity", "integrity", "gnss", "plain_mean",
    "timing_ms",
}  # fmt: skip
EXTRA_KEYS = {
    "radar_errors",
    "truth",
    "targets",
    "marks",
    "notes",
    "compass_error_deg",
    "compass_error_sigma_deg",
    "damping",
    "standardise",
    "dead_reckoning",
    "chart",
    "track",
    "choice",
    "observed",
}
OBSERVATION_KEYS = {
    "target", "mark", "kind", "unit", "observed", "adjusted", "residual", "sigma", "standardized", "redundancy_number",
    "weight", "mdb", "external_m",
}  # fmt: skip


def parsed(answer: Answer) -> dict:
    """Return what another program reads: parsed JSON, where NaN and Infinity are errors."""
    return json.loads(to_json_line(answer_to_dict(answer)), parse_constant=lambda name: pytest.fail(f"{name} in JSON"))


@pytest.mark.parametrize("name", [*every_fix(), *every_no_fix()])
def test_a_fix_and_no_fix_carry_the_same_keys(name: str) -> None:
    content = parsed((every_fix() | every_no_fix())[name])
    assert set(content) == KEYS | EXTRA_KEYS
    assert content["schema"] == "navfix.fix/1"
    assert set(content["timing_ms"]) == {"epoch", "associate", "adjust"}


def test_a_fix_says_everything() -> None:
    answer = make_answer()
    fix, content = answer.fix, parsed(answer)
    assert fix is not None
    assert (content["status"], content["reason"]) == ("fix", None)
    assert isinstance(content["message"], str)
    assert content["time_utc"] == "2026-03-04T05:06:07.250Z"
    assert set(content["position"]) == {"lat_deg", "lon_deg"}
    assert content["position"]["lat_deg"] == pytest.approx(fix.position.lat_deg, abs=1e-9)
    assert content["heading_deg"] == pytest.approx(fix.heading_deg, abs=1e-7)
    assert content["heading_reference"] == "radar_zero_mark"
    assert content["covariance_scaling"] == "a_posteriori"
    assert np.allclose(
        np.array(content["covariance"]), content["sigma0"] ** 2 * np.array(content["cofactor_matrix"]), rtol=1e-7
    )
    assert content["redundancy"] == 31
    assert content["kernel"] == "hampel"
    assert content["global_test"] == {"statistic": 29.7, "dof": 27.4, "threshold": 40.6, "passed": True}
    assert content["integrity"] == {
        "r95_m": 18.3,
        "protection_level_m": 61.0,
        "probability_of_false_alarm": 1e-5,
        "probability_of_missed_detection": 1e-3,
        "slope_level_m": None,
        "reason": None,
    }
    assert content["timing_ms"] == {"epoch": 3.21, "associate": 41.0, "adjust": 6.5}


def test_ellipses_are_those_of_95_and_99_percent() -> None:
    answer = make_answer()
    assert answer.fix is not None
    found = parsed(answer)["ellipses"]
    for ellipse, probability in zip(found, (0.95, 0.99), strict=True):
        assert set(ellipse) == {"probability", "semi_major_m", "semi_minor_m", "azimuth_deg"}
        expected = answer.fix.ellipse(probability)
        assert Ellipse(**ellipse).semi_major_m == pytest.approx(expected.semi_major_m, rel=1e-8)
        assert ellipse["probability"] == probability


def test_observations_keep_their_order_and_their_keys() -> None:
    content = parsed(make_answer())
    assert all(set(observation) == OBSERVATION_KEYS for observation in content["observations"])
    assert [o["target"] for o in content["observations"][:4]] == ["01", "01", "02", "02"]
    assert [o["unit"] for o in content["observations"][:2]] == ["m", "deg"]
    first = content["observations"][0]
    assert first["residual"] == pytest.approx(first["adjusted"] - first["observed"], abs=1e-6)


def test_a_fix_that_has_no_pair_of_its_scan_says_so() -> None:
    content = fix_to_dict(replace(make_fix(), observations=()))
    assert content["message"] == "fix carried by other scans: no pair of this one"


def test_pairs_and_what_is_left_over() -> None:
    content = parsed(make_answer())
    assert content["pairs"][0] == {"target": "01", "mark": "257000100", "probability": 0.999}
    assert len(content["pairs"]) == 17
    assert content["unmatched_targets"] == ["18", "19", "20"]
    assert content["unmatched_marks"] == 43
    assert (content["targets"], content["marks"]) == (20, 60)


def test_ambiguity_carries_alternatives_and_second_group() -> None:
    ambiguity = parsed(every_fix()["with_alternatives"])["ambiguity"]
    assert set(ambiguity) == {"evidence", "margin", "probability_wrong", "alternatives", "second_group"}
    assert ambiguity["second_group"] == {"offset_m": 820.0, "azimuth_deg": 45.0, "targets": ["02", "05", "09"]}
    assert {"position", "heading_deg", "score"} <= set(ambiguity["alternatives"][0])
    assert parsed(make_answer())["ambiguity"]["second_group"] is None


def test_gnss_and_plain_mean_stand_beside_the_fix() -> None:
    content = parsed(make_answer())
    assert set(content["gnss"]) == {
        "position", "distance_m", "verdict", "threshold_m", "smallest_detectable_m", "reasons",
        "instant_verdict", "alert", "drift_mps",
    }  # fmt: skip
    assert content["gnss"]["verdict"] == "unsafe"
    assert {"position", "distance_m", "ellipse"} <= set(content["plain_mean"])
    assert content["plain_mean"]["distance_m"] == pytest.approx(146.8, abs=1.0)
    assert content["plain_mean"]["ellipse"]["probability"] == 0.95


def test_truth_gives_the_errors() -> None:
    truth = parsed(make_answer())["truth"]
    assert truth["distance_m"] == 4.0
    assert truth["heading_error_deg"] == 0.06
    assert parsed(make_answer(truth=None))["truth"] is None


@pytest.mark.parametrize("reason", ["ambiguous", "no_agreement", "too_few_pairs", "unobservable"])
def test_no_fix_gives_its_reason_and_null_elsewhere(reason: str) -> None:
    content = parsed(every_no_fix()[reason])
    assert (content["status"], content["reason"]) == ("no_fix", reason)
    assert content["message"]
    assert content["time_utc"] == "2026-03-04T05:06:07.250Z"
    silent = KEYS - {"schema", "status", "reason", "message", "time_utc", "timing_ms", "ambiguity"}
    assert {key: content[key] for key in silent} == dict.fromkeys(silent)


def test_no_fix_cuts_no_alternative_off() -> None:
    assert len(parsed(make_no_fix())["ambiguity"]["alternatives"]) == 14
    assert parsed(every_no_fix()["too_few_pairs"])["ambiguity"] is None


def test_a_plane_fix_has_metres_for_its_position() -> None:
    content = fix_to_dict(make_plane_fix())
    assert content["position"] == {"north_m": 1234.5678, "east_m": -88.25}
    assert np.array(content["covariance"]).shape == (2, 2)
    assert content["heading_deg"] is None
    assert content["ambiguity"]["alternatives"][0]["position"] == {"north_m": 900.0, "east_m": 10.0}


def test_what_is_not_finite_becomes_null() -> None:
    fix = make_fix()
    odd = replace(
        fix,
        sigma0=math.nan,
        global_test=GlobalTest(math.inf, math.inf, 1.0, False),
        observations=(replace(fix.observations[0], mdb=math.inf, standardized=None),),
        covariance=np.full((3, 3), math.nan),
        covariance_scaling="a_priori",
    )
    assert isinstance(odd, Fix)
    content = parsed(Answer(epoch=fix.epoch, fix=odd))
    assert content["sigma0"] is None
    assert content["global_test"]["statistic"] is None
    assert content["observations"][0]["mdb"] is None
    assert content["covariance"] == [[None] * 3] * 3


def test_a_line_of_json_is_one_line_and_refuses_nan() -> None:
    assert "\n" not in to_json_line(answer_to_dict(make_answer()))
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_json_line({"x": math.nan})


def test_numbers_keep_nine_digits_at_any_scale() -> None:
    assert plain(123456.7891234) == 123456.789
    assert plain(1.23456789123e-7) == 1.23456789e-7
    assert plain(None) is None
