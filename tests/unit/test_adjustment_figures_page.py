"""docs/adjustment_figures.md holds every table of its command, and the command still makes them."""

from __future__ import annotations

import re

import pytest

from tests.benchmarks.bench_figures import PAGE, TABLES, written


def block(table: str) -> str:
    found = re.search(rf"<!-- {table} -->(.*?)<!-- end -->", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None, table
    return found.group(1)


@pytest.mark.parametrize("table", TABLES)
def test_each_table_stands_on_the_page_with_its_command(table: str) -> None:
    text = block(table)
    assert f"bench_figures.py {table} --runs" in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert len({row.count("|") for row in rows}) == 1
    assert len(rows) >= 4


@pytest.mark.parametrize("table", ["oracle", "minimum", "protection", "protection-harder", "bound", "coverage"])
def test_the_command_makes_the_rows_that_the_page_shows(table: str) -> None:
    """Two runs a row: the same scenes and columns as on the page."""
    lines = list(TABLES[table][0](2))
    shown = [line for line in block(table).splitlines() if line.startswith("|")]
    assert lines[:2] == shown[:2]
    assert len(lines) == len(shown)
    assert [line.split("|")[1] for line in lines[2:]] == [line.split("|")[1] for line in shown[2:]]


def test_a_page_without_a_place_for_a_table_is_refused() -> None:
    with pytest.raises(ValueError, match="one place"):
        written("nothing", "bound", [], 1)
    page = written("a <!-- bound --> old <!-- end --> b", "bound", ["| x |"], 7)
    assert page.startswith("a <!-- bound -->")
    assert "| x |" in page
    assert "old" not in page
