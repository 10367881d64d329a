"""``navfix adjust``: text and JSON, several cases, bad cases, exit codes."""

from __future__ import annotations

import io
import json
import math
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from navfix.cli import main

REPOSITORY = Path(__file__).resolve().parents[2]
GDYNIA = str(REPOSITORY / "data" / "golden" / "gdynia.toml")
ELLIPSOID = str(REPOSITORY / "data" / "golden" / "gdynia_ellipsoid.toml")
BENNING = str(REPOSITORY / "data" / "golden" / "benning_8_8.toml")

RELATIVE = {
    "name": "ship",
    "frame": "plane",
    "marks": [
        {"label": "A", "north_m": 5000.0, "east_m": 0.0},
        {"label": "B", "north_m": 0.0, "east_m": 4000.0},
        {"label": "C", "north_m": -3000.0, "east_m": -1000.0},
    ],
    "observations": [
        {"mark": "A", "kind": "range", "value": 5000.0, "sigma": 20.0},
        {"mark": "A", "kind": "relative_bearing", "value": 340.0, "sigma": 0.5},
        {"mark": "B", "kind": "range", "value": 4000.0, "sigma": 20.0},
        {"mark": "B", "kind": "relative_bearing", "value": 70.0, "sigma": 0.5},
        {"mark": "C", "kind": "range", "value": 3162.3, "sigma": 20.0},
    ],
    "start": {"north_m": 50.0, "east_m": -80.0, "heading_deg": 15.0},
}
ONE_RANGE = {**RELATIVE, "observations": RELATIVE["observations"][:1]}  # type: ignore[index]


def written(folder: Path, content: object, name: str = "case.json") -> str:
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return str(path)


def lines(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_the_textbook_report_holds_the_published_figures(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["adjust", GDYNIA]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    for figure in ("1.022", "0.320", "-0.131", "3.181", "146.3", "-352.9", "196.2", "1.948"):
        assert figure in captured.out, figure
    for title in ("FIRST STEP", "ADJUSTED with kernel hampel", "classical", "Huber", "Hampel", "Danish"):
        assert title in captured.out, title
    assert max(len(line) for line in captured.out.splitlines()) <= 100


@pytest.mark.parametrize("case", [GDYNIA, ELLIPSOID, BENNING])
def test_the_json_is_a_fix_with_the_textbooks_matrices(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["adjust", case, "--json", "--kernel", "none"]) == 0
    (fix,) = lines(capsys)
    assert (fix["schema"], fix["status"], fix["kernel"], fix["heading_deg"]) == ("navfix.fix/1", "fix", "none", None)
    assert set(fix["position"]) == ({"lat_deg", "lon_deg"} if case == ELLIPSOID else {"north_m", "east_m"})
    A, L, P = np.array(fix["design_matrix"]), np.array(fix["free_terms"]), np.diag(fix["weights"])
    assert A.shape == (5, 2)
    assert np.array(fix["covariance"]).shape == (2, 2)
    dx = -np.linalg.solve(A.T @ P @ A, A.T @ P @ L)
    assert fix["increments"] == pytest.approx(dx, rel=1e-6, abs=1e-6)
    assert np.array(fix["cofactors"]["unknowns"]) == pytest.approx(np.linalg.inv(A.T @ P @ A), rel=1e-5, abs=1e-12)
    assert fix["first_step"]["residuals"] == pytest.approx(A @ dx + L, rel=1e-5, abs=1e-7)
    trace = np.trace(np.array(fix["cofactors"]["residuals"]) @ P)
    assert trace == pytest.approx(fix["redundancy"], rel=1e-5)


def test_the_heading_is_an_unknown_in_radians(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["adjust", written(tmp_path, RELATIVE), "--json"]) == 0
    (fix,) = lines(capsys)
    assert fix["case"] == "ship"
    assert fix["heading_deg"] == pytest.approx(20.0, abs=0.01)
    assert np.array(fix["design_matrix"]).shape == (5, 3)
    assert fix["design_matrix"][1][2] == pytest.approx(-math.degrees(1.0))
    assert fix["increments"][2] == pytest.approx(math.radians(5.0), abs=0.01)
    assert np.array(fix["covariance"]).shape == (3, 3)


def test_the_report_of_a_heading_fits_100_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["adjust", written(tmp_path, RELATIVE)]) == 0
    out = capsys.readouterr().out
    assert "A heading" in out
    assert "heading   20.0" in out
    assert max(len(line) for line in out.splitlines()) <= 100


def test_several_cases_give_one_line_each_in_their_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One fix is enough for exit code 0; what went wrong stands in its line and on stderr."""
    no_fix, broken = written(tmp_path, ONE_RANGE, "one.json"), written(tmp_path, "not a case", "broken.toml")
    assert main(["adjust", BENNING, no_fix, broken, GDYNIA, "--json"]) == 0
    captured = capsys.readouterr()
    found = [json.loads(line) for line in captured.out.splitlines()]
    assert [(fix["status"], fix["reason"]) for fix in found] == [
        ("fix", None),
        ("no_fix", "too_few_pairs"),
        ("no_fix", "unreadable"),
        ("fix", None),
    ]
    assert len({frozenset(fix) for fix in found}) == 1
    assert found[1]["position"] is None
    assert len(captured.err.splitlines()) == 2
    assert "one.json" in captured.err
    assert "broken.toml" in captured.err


@pytest.mark.parametrize(
    ("content", "code", "words"),
    [
        (ONE_RANGE, 3, "no fix (too_few_pairs)"),
        ("", 4, "empty; expected a case"),
        ("$RATTM,01", 4, "neither JSON nor TOML"),
        ({**RELATIVE, "frame": "utm"}, 4, "frame must be one of plane, wgs84"),
        ({**RELATIVE, "start": {"north_m": 0.0, "east_m": 0.0}}, 4, "heading_deg is needed"),
    ],
)
def test_a_case_without_a_fix_ends_with_one_line(
    content: object, code: int, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["adjust", written(tmp_path, content)]) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert words in captured.err


def test_missing_files_directories_and_bytes_are_unreadable(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    binary = tmp_path / "bytes"
    binary.write_bytes(bytes(range(128, 256)))
    for name in (str(tmp_path / "missing.toml"), str(tmp_path), str(binary)):
        assert main(["adjust", name]) == 4
        captured = capsys.readouterr()
        assert captured.err.count("\n") == 1
        assert "internal error" not in captured.err


def test_an_unknown_kernel_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["adjust", GDYNIA, "--kernel", "huger"]) == 2
    assert "huger" in capsys.readouterr().err


def test_the_kernel_changes_the_fix(capsys: pytest.CaptureFixture[str]) -> None:
    found = {}
    for kernel in ("none", "huber", "hampel", "danish"):
        assert main(["adjust", GDYNIA, "--kernel", kernel, "--json"]) == 0
        (found[kernel],) = lines(capsys)
    weights = {kernel: fix["observations"][4]["weight"] for kernel, fix in found.items()}
    assert weights["none"] == 1.0
    assert all(weights[kernel] < 0.95 for kernel in ("huber", "hampel", "danish"))
    assert len({fix["position"]["north_m"] for fix in found.values()}) == 4


def test_a_case_comes_from_stdin_and_goes_to_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(json.dumps(RELATIVE)))
    out = [tmp_path / "report.txt", tmp_path / "fix.json"]
    assert main(["adjust", "-", "--out", str(out[0]), "--out", str(out[1])]) == 0
    assert out[0].read_text(encoding="utf-8") == capsys.readouterr().out
    assert json.loads(out[1].read_text(encoding="utf-8"))["case"] == "ship"


def test_an_input_is_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = written(tmp_path, RELATIVE)
    assert main(["adjust", case, "--out", case]) == 2
    assert json.loads(Path(case).read_text(encoding="utf-8")) == RELATIVE


def test_the_page_of_the_textbook_report_is_whole_and_needs_nothing_else(tmp_path: Path) -> None:
    page = tmp_path / "x.html"
    assert main(["adjust", GDYNIA, written(tmp_path, ONE_RANGE), "--out", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    for word in (
        "Decision matrix", "First step", "Cofactors of the unknowns", "Cofactors of the residuals", "external m",
        "classical", "Huber", "Hampel", "Danish", "146.3", "no fix:", "<svg", "global test", "FAILED",
    ):  # fmt: skip
        assert word in text, word
    assert text.index("ellipse 95 %") < text.index("First step")  # the result first, then how it was found
    assert not any(word in text for word in ("http:", "https:", "src=", "<script", "@import"))
    body = text.replace("<!DOCTYPE html>", "").replace('<meta charset="utf-8">', "")
    ElementTree.fromstring(re.sub(r"<meta [^>]*>", "", body))


def test_the_page_gives_each_row_its_unit_and_marks_what_was_damped_and_left_out(tmp_path: Path) -> None:
    """The second mark's range is 400 m off, one bearing is left out by the decision matrix."""
    more = [("D", 4000.0, -4000.0, 5656.9, 295.0), ("E", -5000.0, 3000.0, 5831.0, 129.04)]
    marks = [*RELATIVE["marks"], *({"label": d, "north_m": n, "east_m": e} for d, n, e, _, _ in more)]  # type: ignore[misc]
    observations = [dict(o) for o in RELATIVE["observations"]]  # type: ignore[attr-defined]
    for label, _, _, reach_m, bearing_deg in more:
        observations.append({"mark": label, "kind": "range", "value": reach_m, "sigma": 20.0})
        observations.append({"mark": label, "kind": "relative_bearing", "value": bearing_deg, "sigma": 0.5})
    observations[2]["value"] += 400.0
    observations[-1]["use"] = False
    page = tmp_path / "x.html"
    case = {**RELATIVE, "marks": marks, "observations": observations}
    assert main(["adjust", written(tmp_path, case), "--out", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    table = text[text.index("<h2>Observations") : text.index("<h2>Side by side")]
    rows = [re.findall(r"<td[^>]*>([^<]*)</td>", row) for row in re.findall(r"<tr class.*?</tr>", table)]
    assert {(row[1], row[2]) for row in rows} == {("range", "m"), ("rel. brg", "°")}
    assert table.count('<tr class="out">') == 1
    assert table.count('<tr class="damped">') == 2
    assert "bad" in table
    assert 'class="sight damped"' in text
    assert not re.search(r">-0(\.0*)?<", text)


def test_a_case_in_utm_is_shown_on_wgs84_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = Path(GDYNIA).read_text(encoding="utf-8")
    assert main(["adjust", written(tmp_path, 'utm_zone = "34N"\n' + text, "utm.toml")]) == 0
    out = capsys.readouterr().out
    assert "on WGS 84" in out
    assert "convergence -1.7" in out
    assert "scale 0.9998" in out
    assert main(["adjust", written(tmp_path, 'utm_zone = "99N"\n' + text, "bad.toml")]) == 4
    assert "utm_zone" in capsys.readouterr().err


def test_the_report_shows_external_reliability_and_the_cofactors_of_the_residuals(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An error of the size of the mdb, put into an observation, moves the position by the external reliability."""
    case = written(tmp_path, RELATIVE)
    assert main(["adjust", case, "--kernel", "none"]) == 0
    assert "external m" in capsys.readouterr().out

    def solved(content: dict[str, Any]) -> dict[str, Any]:
        assert main(["adjust", written(tmp_path, content, "moved.json"), "--kernel", "none", "--json"]) == 0
        return lines(capsys)[0]

    plain = solved(RELATIVE)
    first = plain["observations"][0]
    bias = 0.01 * first["mdb"]
    observations = [dict(o) for o in RELATIVE["observations"]]  # type: ignore[attr-defined]
    observations[0]["value"] += bias
    moved = solved({**RELATIVE, "observations": observations})
    shift = math.hypot(*(moved["position"][key] - plain["position"][key] for key in ("north_m", "east_m")))
    assert 100.0 * shift == pytest.approx(first["external_m"], rel=0.01)


def test_the_residuals_may_be_standardised_by_their_own_sigma(capsys: pytest.CaptureFixture[str]) -> None:
    weights = []
    for way in ("sigma", "gdynia"):
        assert main(["adjust", GDYNIA, "--json", "--standardise", way]) == 0
        weights.append([o["weight"] for o in lines(capsys)[0]["observations"]])
    assert weights[0] != weights[1]


def test_gnc_can_be_chosen(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["adjust", GDYNIA, "--json", "--kernel", "gnc"]) == 0
    assert lines(capsys)[0]["kernel"] == "gnc"


@pytest.mark.parametrize(
    ("options", "words", "keys"),
    [
        ([], "joint damping, in units of the sigma of the observation", ("joint", "sigma")),
        (
            ["--damping", "separate", "--standardise", "gdynia"],
            "separate damping, in units of the sigma of the residual (gdynia)",
            ("separate", "gdynia"),
        ),
    ],
)
def test_the_report_names_damping_and_standardisation(
    options: list[str], words: str, keys: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "report.html"
    assert main(["adjust", GDYNIA, *options, "--out", str(page)]) == 0
    assert words in capsys.readouterr().out
    assert words in page.read_text(encoding="utf-8")
    assert main(["adjust", GDYNIA, *options, "--json"]) == 0
    content = lines(capsys)[0]
    assert (content["damping"], content["standardise"]) == keys


def test_only_the_reports_that_are_asked_for_are_made(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The matrices of the textbook grow with the square of the marks: the text needs neither page nor JSON."""

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("not asked for")

    monkeypatch.setattr("navfix.report.case_html.case_html", refuse)
    monkeypatch.setattr("navfix.report.case_json.textbook_to_dict", refuse)
    assert main(["adjust", GDYNIA]) == 0
    assert "ADJUSTED" in capsys.readouterr().out
