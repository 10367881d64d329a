"""The validation page: no row vanishes, and no row claims what no test or command shows."""

from __future__ import annotations

import ast
import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest

from navfix.cli import COMMANDS

DOCS = Path(__file__).resolve().parents[2] / "docs"


def _generator() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_validation", DOCS / "make_validation.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


PAGE = _generator()
ROWS = PAGE.load()


@cache
def _functions(path: Path) -> frozenset[str]:
    """Return the names of the functions of a test file, those in classes as Class::name."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    plain = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    inside = {f"{cls.name}::{node.name}" for cls in classes for node in cls.body if isinstance(node, ast.FunctionDef)}
    return frozenset(plain | inside)


def _exists(proof: str) -> bool:
    """Tell whether a test function or a command of this name is there."""
    if proof.startswith("navfix "):
        return proof.split()[1] in COMMANDS
    file, _, function = proof.partition("::")
    path = DOCS.parent / file
    return path.is_file() and (
        function.split("[")[0] in _functions(path) if function else file.startswith("tests/benchmarks/")
    )


def test_every_feature_has_exactly_one_row_in_order() -> None:
    counts = {"K": 39, "A": 16, "G": 25, "U": 12, "E": 13}
    assert list(ROWS) == [f"{letter}{number}" for letter, count in counts.items() for number in range(1, count + 1)]


def test_the_rendered_page_is_up_to_date() -> None:
    page = (DOCS / "validation.md").read_text(encoding="utf-8")
    assert page == PAGE.render(ROWS), "run `python docs/make_validation.py`"


@pytest.mark.parametrize("key", ROWS)
def test_a_row_says_only_what_is_shown(key: str) -> None:
    row = ROWS[key]
    assert set(row) <= {"feature", "status", "shown_by", "figure"}
    assert row["feature"].strip()
    assert row["status"] in PAGE.STATUSES
    proofs = PAGE.shown_by(row)
    missing = [proof for proof in proofs if not _exists(proof)]
    assert not missing, f"{key} names what is not there: {missing}"
    if row["status"] == "done":
        assert proofs, f"{key} is done and names no test or command"
    if row["status"] != "planned":
        assert row.get("figure", "").strip(), f"{key} gives neither a figure nor a reason"
    assert "|" not in row["feature"] + row.get("figure", ""), "a bar would break the table"


def test_a_name_that_is_not_there_is_noticed() -> None:
    assert _exists("tests/unit/test_validation_page.py::test_a_name_that_is_not_there_is_noticed")
    assert not _exists("tests/unit/test_validation_page.py::test_never_written")
    assert not _exists("tests/unit/never_written.py::test_never_written")
    assert not _exists("navfix conjure")
