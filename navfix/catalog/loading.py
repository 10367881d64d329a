"""The files of models/: which there are, their tables, and records made of them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import MISSING, fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from navfix.errors import CatalogError

Record = TypeVar("Record")


def data_folder(name: str) -> Path:
    """Return the folder ``models`` or ``data``: inside the package when installed, beside it in a checkout."""
    inside = Path(str(files("navfix"))) / name
    return inside if inside.is_dir() else inside.parent.parent / name


def names(kind: str) -> list[str]:
    """Return the names of all models of one kind ("radar", "kernel", ...)."""
    return sorted(path.stem for path in (data_folder("models") / kind).glob("*.toml"))


def kinds() -> list[str]:
    """Return the kinds of models: the folders of models/."""
    return sorted(path.name for path in data_folder("models").iterdir() if path.is_dir())


def table(kind: str, name: str) -> dict[str, Any]:
    """Return the raw table of one model file.

    Raises
    ------
    CatalogError : unknown name; a file that is not TOML or carries no title or source
    """
    path = data_folder("models") / kind / f"{name}.toml"
    if name not in names(kind):
        raise CatalogError(f"no {kind} model named {name!r}; there are {', '.join(names(kind))}", key=name)
    return read_table(path)


def read_table(path: Path) -> dict[str, Any]:
    """Return the table of a model file outside or inside the catalogue; it must carry a title and a source.

    Raises
    ------
    CatalogError : no such file, not readable as TOML, without a title or a source
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise CatalogError(f"{path}: no such file", path=str(path)) from error
    except OSError as error:
        raise CatalogError(f"{path}: cannot be read: {error.strerror}", path=str(path)) from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CatalogError(f"{path.name}: not a readable TOML file: {error}", path=str(path)) from error
    for key in ("title", "source"):
        if not isinstance(content.get(key), str) or not content[key].strip():
            raise CatalogError(f"{path.name}: every model needs a {key}", path=str(path), key=key)
    return content


def every_table() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield (kind, name, table) of the whole catalogue."""
    for kind in kinds():
        for name in names(kind):
            yield kind, name, table(kind, name)


def load(kind: str, name: str | Record, record: type[Record]) -> Record:
    """Return a record by its name in models/``kind``, or the record itself.

    Raises
    ------
    CatalogError : unknown name, unknown or missing key
    """
    if isinstance(name, record):
        return name
    key: Any = record  # for mypy a type variable has no hash
    found: Record = _load(kind, str(name), key)
    return found


@cache
def _load(kind: str, name: str, record: type[Any]) -> Any:
    return build(record, {"name": name, **table(kind, name)}, where=f"models/{kind}/{name}.toml")


def build(record: type[Record], content: dict[str, Any], *, where: str) -> Record:
    """Make a record of a table: every key known, every required key present, numbers where numbers belong.

    Raises
    ------
    CatalogError : unknown or missing key, or no number; it names ``where``
    """
    known = {field.name: field for field in fields(record)}  # type: ignore[arg-type]
    for key in content:
        if key not in known:
            raise CatalogError(f"{where}: unknown key {key!r}; known are {', '.join(known)}", path=where, key=key)
    for key, field in known.items():
        if key not in content and field.default is MISSING and field.default_factory is MISSING:
            raise CatalogError(f"{where}: missing key {key!r}", path=where, key=key)
        wants_number = str(field.type).startswith(("float", "int"))
        if (
            key in content
            and wants_number
            and (isinstance(content[key], bool) or not isinstance(content[key], int | float))
        ):
            raise CatalogError(f"{where}: {key} must be a number, got {content[key]!r}", path=where, key=key)
    return record(**content)
