"""One version, said everywhere alike; the files that a release carries are there."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

import navfix


def test_the_version_stands_in_one_place(repository: Path) -> None:
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    assert "version" in project["dynamic"]
    assert "version" not in project
    assert re.fullmatch(r"\d+\.\d+\.\d+", navfix.__version__)


def test_the_changelog_begins_with_this_version(repository: Path) -> None:
    heads = re.findall(r"^## (\S+) - (\d{4}-\d{2}-\d{2})$", (repository / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert heads[0][0] == navfix.__version__
    assert heads == sorted(heads, key=lambda head: tuple(map(int, head[0].split("."))), reverse=True)


def test_the_citation_says_this_version_and_its_date(repository: Path) -> None:
    citation = (repository / "CITATION.cff").read_text()
    heads = re.findall(r"^## (\S+) - (\S+)$", (repository / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert re.search(r"^version: (\S+)$", citation, re.MULTILINE)[1] == navfix.__version__
    assert re.search(r"^date-released: (\S+)$", citation, re.MULTILINE)[1] == heads[0][1]


@pytest.mark.parametrize(
    "page", ["README.md", *sorted(p.name for p in (Path(__file__).parents[2] / "docs").glob("*.md"))]
)
def test_links_between_pages_lead_somewhere(repository: Path, page: str) -> None:
    path = repository / page if page == "README.md" else repository / "docs" / page
    links = re.findall(r"\]\((?!https?:)([^)#\s]+)", path.read_text(encoding="utf-8"))
    missing = [link for link in links if not (path.parent / link).exists()]
    assert not missing


def test_ci_runs_make_test(repository: Path) -> None:
    script = repository / ".ci" / "run"
    assert "make test" in script.read_text()
    assert script.stat().st_mode & 0o111
    dry = subprocess.run(["make", "-n", "test"], cwd=repository, capture_output=True, text=True, timeout=60, check=True)
    for check in ("ruff format --check", "ruff check", "mypy", "lint-imports", "pytest"):
        assert check in dry.stdout


def test_an_old_python_is_refused_with_a_clear_line(repository: Path, tmp_path: Path) -> None:
    ended = subprocess.run(
        ["make", "demo", "PYTHON=false", f"VENV={tmp_path / 'venv'}"],
        cwd=repository,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode == 2
    assert "navfix needs CPython 3.11 to 3.14" in ended.stderr
    assert not (tmp_path / "venv").exists()
