"""Wheel, sdist and editable install: each carries the models and the shipped logs, and solves a log.

Each kind goes into an environment of its own that borrows the dependencies of this one, so that nothing is downloaded.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

import navfix
from navfix import catalog

pytest.importorskip("hatchling", reason="building needs hatchling")
pytest.importorskip("build", reason="building needs build")

ASK = """
import json, navfix, navfix.catalog as c
data = c.data_folder("data")
print(json.dumps({
    "file": navfix.__file__,
    "version": navfix.__version__,
    "models": [f"{kind}/{name}" for kind, name, _ in c.every_table()],
    "data": sorted(p.relative_to(data).as_posix() for f in ("logs", "scenarios") for p in (data / f).glob("*")),
}))
"""


def _run(*command: str | Path, cwd: Path) -> str:
    """Run a command with the dependencies of this environment in reach; return what it prints."""
    borrowed = {"PYTHONPATH": sysconfig.get_path("purelib"), "OMP_NUM_THREADS": "1"}
    ended = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**os.environ, **borrowed},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert ended.returncode == 0, f"{command}\n{ended.stdout}\n{ended.stderr}"
    return ended.stdout


def _build(kind: str, repository: Path, out: Path) -> Path:
    """Build a wheel or an sdist of the repository; return the file."""
    _run(sys.executable, "-m", "build", f"--{kind}", "--no-isolation", "--outdir", out, repository, cwd=out)
    (built,) = out.iterdir()
    return built


def _wheel(repository: Path, out: Path) -> list[str]:
    return [str(_build("wheel", repository, out))]


def _sdist(repository: Path, out: Path) -> list[str]:
    return [str(_build("sdist", repository, out))]


def _editable(repository: Path, out: Path) -> list[str]:
    return ["--editable", str(repository)]


def _install(what: list[str], folder: Path) -> Path:
    """Make an environment with navfix alone; return the folder of its programs."""
    venv.create(folder, with_pip=False)
    programs = folder / "bin"
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", programs / "python")
    quiet = ("--quiet", "--no-deps", "--no-index", "--no-build-isolation")
    _run(*pip, "install", *quiet, *what, cwd=folder)
    return programs


@pytest.mark.parametrize("how", [_wheel, _sdist, _editable])
def test_an_install_carries_models_and_logs_and_solves_one(
    how: Callable[[Path, Path], list[str]], repository: Path, tmp_path: Path
) -> None:
    (tmp_path / "dist").mkdir()
    programs = _install(how(repository, tmp_path / "dist"), tmp_path / "env")
    told = json.loads(_run(programs / "python", "-c", ASK, cwd=tmp_path))
    home = repository if how is _editable else tmp_path / "env"
    assert Path(told["file"]).resolve().is_relative_to(home.resolve())
    assert told["version"] == navfix.__version__
    assert told["models"] == [f"{kind}/{name}" for kind, name, _ in catalog.every_table()]
    shipped = [f for f in ("logs", "scenarios") for f in (repository / "data" / f).glob("*")]
    assert told["data"] == sorted(p.relative_to(repository / "data").as_posix() for p in shipped)
    assert any(name.startswith("logs/") for name in told["data"])

    assert _run(programs / "navfix", "--version", cwd=tmp_path) == f"navfix {navfix.__version__}\n"
    assert "IMO" in _run(programs / "navfix", "models", "imo", cwd=tmp_path)
    assert "heading" in _run(programs / "navfix", "demo", cwd=tmp_path)
    assert list((tmp_path / "navfix-demo").glob("*.svg"))


def test_the_wheel_holds_the_package_and_nothing_else(repository: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(_build("wheel", repository, tmp_path)) as wheel:
        names = set(wheel.namelist())
        (metadata,) = (wheel.read(name).decode() for name in names if name.endswith("METADATA"))
    info = f"navfix-{navfix.__version__}.dist-info"
    assert {name.split("/")[0] for name in names} == {"navfix", info}
    assert {"navfix/py.typed", "navfix/models/radar/imo.toml", f"{info}/licenses/LICENSE"} <= names
    assert not [name for name in names if "__pycache__" in name]
    sources = {p.relative_to(repository).as_posix() for p in (repository / "navfix").rglob("*.py")}
    assert sources <= names
    assert "Requires-Python: >=3.11" in metadata
    assert "Requires-Dist: gtsam>=4.3" in metadata


def test_the_sdist_holds_what_a_build_and_a_test_run_need(repository: Path, tmp_path: Path) -> None:
    with tarfile.open(_build("sdist", repository, tmp_path)) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    wanted = "pyproject.toml README.md LICENSE CHANGELOG.md CITATION.cff Makefile mkdocs.yml data/README.md"
    assert set(wanted.split()) <= names
    assert {"navfix/__init__.py", "models/radar/imo.toml", "tests/conftest.py", "docs/validation.toml"} <= names
    assert not [name for name in names if "__pycache__" in name or name.startswith((".venv", "site/"))]
