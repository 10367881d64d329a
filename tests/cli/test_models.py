"""`navfix models`: the catalogue with its sources."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from navfix import catalog
from navfix.cli import main


def test_every_model_is_listed_with_its_source(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["models"]) == 0
    text = capsys.readouterr().out
    words = " ".join(text.split())
    for kind, name, table in catalog.every_table():
        assert kind in text
        assert f"  {name} " in text
        assert " ".join(table["source"].split()) in words
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize(
    ("wanted", "names"), [("imo", ["imo"]), ("radar/imo", ["imo"]), ("radar", catalog.names("radar"))]
)
def test_a_name_a_kind_or_both_select(wanted: str, names: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["models", wanted, "--json"]) == 0
    entries = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in entries if entry["kind"] == "radar"] == names


def test_one_model_shows_every_value(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["models", "imo"]) == 0
    text = capsys.readouterr().out
    for value in catalog.table("radar", "imo").values():
        assert str(value) in " ".join(text.split())
    assert "bearing_sigma_deg    = 1.02\n" in text


def test_an_unknown_name_is_usage_and_names_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["models", "nope"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("navfix: no model or kind named 'nope'; there are ")
    assert "radar/imo" in captured.err


def test_out_writes_what_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["models", "--out", str(tmp_path / "m.txt"), "--out", str(tmp_path / "m.json")]) == 0
    assert (tmp_path / "m.txt").read_text(encoding="utf-8") == capsys.readouterr().out
    assert len(json.loads((tmp_path / "m.json").read_text())) == len(list(catalog.every_table()))
