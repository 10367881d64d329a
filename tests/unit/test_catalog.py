"""The catalogue: every file loads into its record and carries a source; a wrong one is refused by name."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from navfix import catalog
from navfix.catalog import loading
from navfix.cli import options
from navfix.errors import CatalogError

MODELS = [(kind, name) for kind in catalog.kinds() for name in catalog.names(kind)]
GOOD = {
    "title": "A radar",
    "source": "this test",
    "range_sigma_m": 10.0,
    "range_sigma_fraction": 0.01,
    "bearing_sigma_deg": 1,
    "maximum_range_m": 2e4,
    "turn_s": 2.5,
}


def _loader(kind: str) -> Callable[[str], Any]:
    """Return the function of the catalogue that reads one kind: ``radar_model``, ``kernel``, ..."""
    names = (f"{kind}_method", f"{kind}_model", kind)
    loader = next((getattr(catalog, name) for name in names if hasattr(catalog, name)), None)
    assert loader is not None, f"models/{kind} has no reader in navfix.catalog: nobody checks its keys"
    return loader


def _toml(content: dict[str, object]) -> str:
    return "".join(
        f"{key} = {str(value).lower() if isinstance(value, bool) else repr(value)}\n" for key, value in content.items()
    )


@pytest.fixture
def own_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Put an empty catalogue of our own in place of the shipped one; return its radar folder."""
    (tmp_path / "radar").mkdir()
    monkeypatch.setattr(loading, "data_folder", lambda _: tmp_path)
    loading._load.cache_clear()
    yield tmp_path / "radar"
    loading._load.cache_clear()


def test_the_catalogue_holds_radars_ais_classes_and_kernels() -> None:
    assert {"radar", "ais", "kernel"} <= set(catalog.kinds())
    assert {"imo", "imo_plot", "small_craft"} <= set(catalog.names("radar"))
    assert {"none", "huber", "hampel", "danish", "tukey"} <= set(catalog.names("kernel"))


@pytest.mark.parametrize(("kind", "name"), MODELS)
def test_every_model_loads_into_its_record_and_carries_a_source(kind: str, name: str) -> None:
    model = _loader(kind)(name)
    assert model.name == name
    assert len(model.title) > 3
    assert len(model.source) > 8, "a source says where the numbers come from"
    numbers = [value for value in dataclasses.astuple(model) if isinstance(value, float)]
    assert all(math.isfinite(number) and number >= 0.0 for number in numbers)
    assert _loader(kind)(model) is model, "a record in place of a name passes through"


def test_kernels_named_in_the_help_are_in_the_catalogue() -> None:
    assert set(options.KERNELS.split(", ")) <= set(catalog.names("kernel"))


@pytest.mark.parametrize(("kind", "loader"), [(kind, _loader(kind)) for kind in catalog.kinds()])
def test_an_unknown_name_is_refused_and_the_known_ones_are_listed(kind: str, loader: Callable[[str], Any]) -> None:
    with pytest.raises(CatalogError, match="'nope'") as caught:
        loader("nope")
    assert caught.value.key == "nope"
    assert all(name in str(caught.value) for name in catalog.names(kind))


def test_a_name_does_not_lead_out_of_the_catalogue() -> None:
    for name in ("../radar/imo", "imo.toml", "", "."):
        with pytest.raises(CatalogError):
            catalog.radar_model(name)


def test_a_good_file_loads(own_models: Path) -> None:
    (own_models / "good.toml").write_text(_toml(GOOD))
    assert catalog.radar_model("good").bearing_sigma_deg == 1
    assert list(catalog.every_table()) == [("radar", "good", GOOD)]


@pytest.mark.parametrize("key", GOOD)
def test_a_missing_key_is_named(own_models: Path, key: str) -> None:
    (own_models / "bad.toml").write_text(_toml({k: v for k, v in GOOD.items() if k != key}))
    with pytest.raises(CatalogError, match=key) as caught:
        catalog.radar_model("bad")
    assert caught.value.key == key
    assert "bad.toml" in str(caught.value.path)


@pytest.mark.parametrize(
    ("key", "value"),
    [("beam_deg", 1.2), ("turn_s", "fast"), ("turn_s", True), ("source", "  "), ("title", 7), ("range_sigma_m", [1.0])],
)
def test_an_unknown_key_or_a_wrong_value_is_named(own_models: Path, key: str, value: object) -> None:
    (own_models / "bad.toml").write_text(_toml({**GOOD, key: value}))
    with pytest.raises(CatalogError, match=key) as caught:
        catalog.radar_model("bad")
    assert caught.value.key == key


@pytest.mark.parametrize("content", [b"title = ", b"\xff\xfe\x00", b"[title]\nx = 1\nsource = 'elsewhere'\n"])
def test_a_file_that_is_no_model_is_refused(own_models: Path, content: bytes) -> None:
    (own_models / "bad.toml").write_bytes(content)
    with pytest.raises(CatalogError, match=re.escape("bad.toml")):
        catalog.radar_model("bad")


def test_a_kernel_of_the_user_is_read_from_its_path(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text((catalog.data_folder("models") / "kernel" / "huber.toml").read_text().replace("1.345", "2.5", 1))
    assert catalog.kernel(str(own)).name == "own"
    assert catalog.kernel(own) != catalog.kernel("huber")
    with pytest.raises(CatalogError, match=r"gone\.toml"):
        catalog.kernel(tmp_path / "gone.toml")


def test_the_message_is_printed_as_it_was_written() -> None:
    assert str(CatalogError("no model", key="x")) == "no model"
