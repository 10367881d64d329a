"""Every file that the project ships in data/ is listed with origin, licence and the checksum that it has."""

from __future__ import annotations

import hashlib
import re
import tomllib
from pathlib import Path

import pytest

DATA = Path(__file__).resolve().parents[2] / "data"
FILES = sorted(
    path.relative_to(DATA).as_posix() for path in DATA.rglob("*") if path.is_file() and path.name != "README.md"
)


def _listed() -> dict[str, str]:
    """Return file -> the line of data/README.md that holds its name and a sha256."""
    lines = (DATA / "README.md").read_text(encoding="utf-8").splitlines()
    rows = [line for line in lines if re.search(r"\b[0-9a-f]{64}\b", line)]
    return {match[1]: row for row in rows if (match := re.search(r"`([^`]+)`", row))}


def test_the_list_names_the_files_that_are_there_and_no_other() -> None:
    assert sorted(_listed()) == FILES


@pytest.mark.parametrize("name", FILES)
def test_the_checksum_in_the_list_is_that_of_the_file(name: str) -> None:
    row = _listed()[name]
    assert hashlib.sha256((DATA / name).read_bytes()).hexdigest() in row
    assert len(re.sub(r"[0-9a-f]{64}|`[^`]+`|[|\s]", "", row)) > 15, "origin and licence stand in the row"


@pytest.mark.parametrize("name", [name for name in FILES if name.startswith("golden/") and name.endswith(".toml")])
def test_a_golden_table_names_its_source_and_the_reason_of_its_tolerance(name: str) -> None:
    text = (DATA / name).read_text(encoding="utf-8")
    assert len(tomllib.loads(text)["source"]) > 10
    assert "tolerance" in text
