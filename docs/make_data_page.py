"""List every file of data/ with origin, licence and checksum: `python docs/make_data_page.py` writes data/README.md."""

from __future__ import annotations

import hashlib
import tomllib
from pathlib import Path

DATA = Path(__file__).resolve().parents[1] / "data"
OWN = "made by navfix, Apache-2.0"
PUBLISHED = "published figures, source named; the file Apache-2.0"
INTRODUCTION = """\
# Data that navfix ships

- `golden/`: published tables, each with input, expected values, tolerance and its reason side by side.
- `scenarios/`: worlds of the simulator. `logs/`: what it made of them, with the truth beside each log.

Nothing here was recorded at sea. Rendered by `python docs/make_data_page.py`; a test compares the checksums.
"""


def rows() -> list[str]:
    """Return a line of the table for each file."""
    files = sorted(path for path in DATA.rglob("*") if path.is_file() and path.name != "README.md")
    return [f"| `{path.relative_to(DATA).as_posix()}` | {_origin(path)} | {_sha256(path)} |" for path in files]


def _origin(path: Path) -> str:
    """Return origin and licence as two cells."""
    if path.suffix == ".toml":
        source = " ".join(tomllib.loads(path.read_text(encoding="utf-8"))["source"].split())
        return f"{source} | {PUBLISHED if path.parent.name == 'golden' else OWN}"
    scenario = path.stem.removesuffix("_truth").removesuffix("_assoc")
    made_from = DATA / "scenarios" / f"{scenario}.toml"
    if not made_from.is_file():
        raise SystemExit(f"{path}: of unknown origin: there is no scenario {scenario}")
    return f"simulated: `navfix simulate {scenario}` | {OWN}"


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


if __name__ == "__main__":
    table = "\n".join(["| file | origin | licence | sha256 |", "|---|---|---|---|", *rows()])
    (DATA / "README.md").write_text(f"{INTRODUCTION}\n{table}\n", encoding="utf-8")
