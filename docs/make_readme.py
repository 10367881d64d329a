"""Put what `navfix demo` prints into the README, its picture into docs/images: `python docs/make_readme.py`."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import tempfile
from pathlib import Path

from navfix.cli import main

ROOT = Path(__file__).resolve().parents[1]
BEGIN, END = "<!-- demo output: begin -->\n", "<!-- demo output: end -->\n"
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


def block(report: str) -> str:
    """Return what stands between the marks of the README."""
    return f"\n```text\n{shortened(report)}```\n\n"


def between_marks(readme: str) -> str:
    """Return what stands between the marks of a README."""
    return readme.partition(BEGIN)[2].partition(END)[0]


if __name__ == "__main__":
    path = ROOT / "README.md"
    readme = path.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        report = demo_output(Path(folder))
        (ROOT / "docs" / "images").mkdir(exist_ok=True)
        shutil.copy(Path(folder) / "navfix-demo" / "fix.svg", ROOT / "docs" / "images" / "demo.svg")
    path.write_text(readme.replace(BEGIN + between_marks(readme) + END, BEGIN + block(report) + END), encoding="utf-8")
