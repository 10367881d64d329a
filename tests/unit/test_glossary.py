"""Every word of a report is in the glossary, every key of the JSON in the glossary or the integrator's guide."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from navfix.report.fix_json import answer_to_dict
from navfix.report.targets import to_dict
from navfix.report.text import report_text
from navfix.types import Position, TargetList, TrackedShip

REPOSITORY = Path(__file__).resolve().parents[2]
UNITS = ("m", "deg", "ms", "utc")


def _factories() -> ModuleType:
    spec = importlib.util.spec_from_file_location("factories", REPOSITORY / "tests" / "factories.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


FACTORIES = _factories()
ANSWERS = {
    **FACTORIES.every_fix(),
    **FACTORIES.every_no_fix(),
    "caution": FACTORIES.make_answer(cautions=("Check the compass.",)),
}


def _page(name: str) -> str:
    return (REPOSITORY / "docs" / name).read_text(encoding="utf-8").casefold().replace("-", " ")


def _terms() -> set[str]:
    """Return the words that the glossary explains: the first cell of each row, its variants one by one."""
    cells = re.findall(r"^\| ([^|]+) \|", _page("glossary.md"), re.MULTILINE)
    variants = {variant.strip() for cell in cells for variant in re.split(r"[,()]", cell)}
    return variants | {cell.strip() for cell in cells}


def _labels(report: str) -> Iterator[str]:
    """Yield the words in the left column, and those above the columns of the residual table."""
    for line in report.splitlines():
        label = line[:16].strip()
        if re.match(r"[A-Z]", line) and line[15:16] == " " and len(line) > 16 and re.search(r"\s{2}", line[:17]):
            yield re.sub(r" \d+ %", "", label)
        if line.lstrip().startswith("target mark "):
            yield from (word for word in line.split() if word not in ("m", "°"))


def _keys(record: Any) -> Iterator[str]:
    if isinstance(record, dict):
        for key, value in record.items():
            yield key
            yield from _keys(value)
    elif isinstance(record, list):
        for item in record:
            yield from _keys(item)


@pytest.mark.parametrize("name", ANSWERS)
def test_every_word_of_a_report_is_in_the_glossary(name: str) -> None:
    labels = {label.casefold() for label in _labels(report_text(ANSWERS[name]))}
    assert len(labels) >= 2
    known = _terms()
    missing = {word for word in labels if not any(re.search(rf"\b{re.escape(word)}s?\b", term) for term in known)}
    assert not missing


@pytest.mark.parametrize("name", ANSWERS)
def test_every_key_of_the_json_is_explained(name: str) -> None:
    text = _page("glossary.md") + _page("integrators-guide.md")

    def explained(key: str) -> bool:
        words = key.split("_")
        plain = " ".join(words[:-1] if len(words) > 1 and words[-1] in UNITS else words)
        return f"`{key}`" in text or plain in text or plain.replace("standardized", "standardised") in text

    assert not {key for key in _keys(answer_to_dict(ANSWERS[name])) if not explained(key)}


def test_every_key_of_the_list_of_targets_is_explained() -> None:
    ships = TargetList(None, (TrackedShip("ais", "1"),), Position(54.0, 8.0), 20.0)
    text = _page("glossary.md") + _page("integrators-guide.md")
    missing = {key for key in _keys(to_dict(ships)) if f"`{key}`" not in text and key.replace("_", " ") not in text}
    assert not missing - {"lat_deg", "lon_deg"}
