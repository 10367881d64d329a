"""The headline comparison, quick: robust fix against plain mean, and that its page and picture are whole."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.benchmarks.bench_mean import CELLS, ESTIMATORS, Cell, measure, page, picture
from tests.benchmarks.bench_mean_geometry import measure as geometry

DOCS = Path(__file__).resolve().parents[2] / "docs"
NAMES = ("plain mean", "Hampel")


@pytest.mark.parametrize(("wrong", "least"), [(0, 1.4), (4, 10.0), (8, 10.0)])
def test_the_fix_is_better_than_the_plain_mean(wrong: int, least: float) -> None:
    plain, robust = measure(120, 20, wrong, agreeing=False, names=NAMES)
    print(f"20 pairs, {5 * wrong} % wrong: plain mean {plain.ratio:.2f}, robust {robust.ratio:.2f} times the bound")
    assert plain.ratio >= least * robust.ratio
    assert robust.astray == 0.0


def test_the_fix_is_near_the_bound_where_wrong_pairs_agree() -> None:
    (robust,) = measure(120, 20, 8, agreeing=True, names=("Hampel",))
    assert robust.ratio <= 1.30
    assert robust.astray == 0.0


def test_marks_out_to_the_radar_range_give_the_mean_twice_the_error_of_the_fix() -> None:
    """No gross errors, 20 marks even in the area of 12 NM: CPD's heading, and the source's way in degrees."""
    _, (fitting, by_cpd, as_source) = geometry("12 NM disc, even in area, 30 m", 25)
    print(f"plain mean over fix: heading by fit {fitting:.2f}, by CPD {by_cpd:.2f}, as its source {as_source:.2f}")
    assert by_cpd > 1.7
    assert as_source > 2.0


def test_the_page_holds_every_cell_and_estimator() -> None:
    text = (DOCS / "robust_vs_mean.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| (\d+) \(\d+ %\) \|(.*)\|$", text, re.MULTILINE)
    expected = [(n, w) for n, counts in CELLS.items() for w in counts]
    agreeing = [(n, w) for n, counts in CELLS.items() for w in counts if w >= 2]
    assert [(int(n), int(w)) for n, w, _ in rows] == expected + agreeing
    assert all(len(cells.split("|")) == len(ESTIMATORS) for *_, cells in rows)


def test_page_and_picture_are_made_of_the_table() -> None:
    cells = [Cell(1.0 + index, 2.0 * index, 0.0) for index in range(len(ESTIMATORS))]
    table = {(20, agreeing, wrong): cells for agreeing in (False, True) for wrong in CELLS[20] if wrong or not agreeing}
    written = page(table, 7, ["| geometry |"])
    assert "| 20 | 4 (20 %) | 1.00 (0.0) |" in written
    assert "20 % wrong: 0.1 times" in written
    assert written.endswith("| geometry |\n")
    drawn = ElementTree.fromstring(picture(table))
    texts = [element.text for element in drawn.iter("{http://www.w3.org/2000/svg}text")]
    assert all(texts.count(name) == 2 for name in ESTIMATORS if name != "mean, true heading")


def test_the_committed_picture_is_an_svg_that_needs_nothing_else() -> None:
    text = (DOCS / "images" / "robust_vs_mean.svg").read_text(encoding="utf-8")
    ElementTree.fromstring(text)
    assert "href" not in text
    assert all(name in text for name in ESTIMATORS if name != "mean, true heading")
