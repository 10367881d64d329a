"""Put what `navfix demo` and the README's Python print into the README: `python docs/make_readme.py`.

The picture of the demo goes into docs/images.
"""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from navfix.cli import main

ROOT = Path(__file__).resolve().parents[1]
ROWS = 6  # of the residual table: the README shows its form, the report all of it


def demo_output(folder: Path) -> str:
    """Run `navfix demo` in a folder; return what it prints."""
    printed = io.StringIO()
    before = Path.cwd()
    try:
        os.chdir(folder)
        with contextlib.redirect_stdout(printed):
            code = main(["demo"])
    finally:
        os.chdir(before)
    if code:
        raise SystemExit(f"navfix demo ended with {code}")
    return printed.getvalue()


def shortened(report: str) -> str:
    """Return the report up to the first rows of its residual table."""
    lines = report.splitlines()
    rule = next(number for number, line in enumerate(lines) if line.startswith("----"))
    return "\n".join([*lines[: rule + 1 + ROWS], "  ..."]) + "\n"


def snippet_output(readme: str, folder: Path) -> str:
    """Run the first Python of the README in a folder with the shipped log as approach.nmea; return what it prints."""
    shutil.copy(ROOT / "data" / "logs" / "approach.nmea", folder / "approach.nmea")
    code = readme.partition("```python\n")[2].partition("```")[0]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout


def fill(readme: str, name: str, text: str) -> str:
    """Return the README with a text between the marks of this name."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->\n"
    before, _, rest = readme.partition(begin)
    return f"{before}{begin}\n```text\n{text}```\n\n{end}{rest.partition(end)[2]}"


def filled(readme: str, folder: Path) -> str:
    """Return the README with all outputs as they are now; the demo leaves its files in the folder."""
    readme = fill(readme, "demo output", shortened(demo_output(folder)))
    return fill(readme, "python output", snippet_output(readme, folder))


if __name__ == "__main__":
    path = ROOT / "README.md"
    with tempfile.TemporaryDirectory() as folder:
        path.write_text(filled(path.read_text(encoding="utf-8"), Path(folder)), encoding="utf-8")
        (ROOT / "docs" / "images").mkdir(exist_ok=True)
        shutil.copy(Path(folder) / "navfix-demo" / "fix.svg", ROOT / "docs" / "images" / "demo.svg")
