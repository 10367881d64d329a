"""Every example of the documentation runs, on what the project ships, and says what it promises."""

import subprocess
import sys
from pathlib import Path

import pytest


def run(script: Path, *arguments: str, stdin: bytes | None = None) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, str(script), *arguments], input=stdin, capture_output=True, check=False, timeout=120
    )


def test_every_example_is_tested_here(repository: Path):
    examples = {path.name for path in (repository / "docs" / "examples").glob("*.py")}
    assert examples == {"bridge_integrator.py", "chart_alone.py", "gdynia_test.py", "own_epoch.py"}


@pytest.mark.parametrize("by_pipe", [False, True])
def test_bridge_integrators_program_gives_a_line_for_each_turn(repository: Path, by_pipe: bool):
    log = repository / "data" / "logs" / "approach.nmea"
    script = repository / "docs" / "examples" / "bridge_integrator.py"
    done = run(script, "-", stdin=log.read_bytes()) if by_pipe else run(script, str(log))
    assert done.returncode == 0, done.stderr.decode()
    lines = done.stdout.decode().splitlines()
    assert len(lines) >= 3
    fixes = [line for line in lines if " FIX  54." in line]
    assert len(fixes) >= 0.6 * len(lines)
    assert all("no GNSS to check" in line for line in fixes)


def test_own_epoch_is_fixed_where_own_ship_was(repository: Path):
    done = run(repository / "docs" / "examples" / "own_epoch.py")
    assert done.returncode == 0, done.stderr.decode()
    lat_deg, _, lon_deg, *_ = done.stdout.decode().split()
    assert float(lat_deg) == pytest.approx(54.1950, abs=5e-4)
    assert float(lon_deg) == pytest.approx(7.6100, abs=8e-4)


def test_the_first_example_prints_the_published_figures_and_stands_in_the_docs(repository: Path):
    done = run(repository / "docs" / "examples" / "gdynia_test.py")
    assert done.returncode == 0, done.stderr.decode()
    printed = done.stdout.decode()
    for figure in ("m0 1.948", "m_P 146.3", "V +1.022", "V -0.131", "V +3.181", "X 360701.7", "Y 6044794.8"):
        assert figure in printed, figure
    page = (repository / "docs" / "first_example.md").read_text()
    program = (repository / "docs" / "examples" / "gdynia_test.py").read_text()
    assert f"```text\n{printed}```" in page, "run: python docs/make_first_example.py"
    assert f"```python\n{program}```" in page


def test_examples_are_short(repository: Path):
    for path in (repository / "docs" / "examples").glob("*.py"):
        assert len(path.read_text().splitlines()) <= 60


def test_a_chart_alone_gives_a_position(repository: Path):
    done = run(repository / "docs" / "examples" / "chart_alone.py")
    assert done.returncode == 0, done.stderr.decode()
    assert "26 charted marks" in done.stdout.decode()
    assert "95 % ellipse" in done.stdout.decode()
