"""Kernels of the catalogue and of files of the user."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from navfix.catalog.loading import build, read_table, table
from navfix.errors import CatalogError, InputError
from navfix.kernels import FAMILIES, Kernel


def kernel(name: str | Path | Kernel) -> Kernel:
    """Return a kernel by its name in models/kernel, by the path of a TOML file, or the kernel itself.

    Raises
    ------
    CatalogError : unknown name; a file that cannot be read, or with unknown, missing or impossible constants
    """
    if isinstance(name, Kernel):
        return name
    if isinstance(name, Path) or name.endswith(".toml"):
        path = Path(name)
        return _build_kernel(path.stem, read_table(path), where=str(path))
    return _kernel(name)


@cache
def _kernel(name: str) -> Kernel:
    return _build_kernel(name, table("kernel", name), where=f"models/kernel/{name}.toml")


def _build_kernel(name: str, content: dict[str, Any], *, where: str) -> Kernel:
    family = FAMILIES.get(str(content.get("family")))
    if family is None:
        seen = content.get("family")
        raise CatalogError(
            f"{where}: family must be one of {', '.join(FAMILIES)}, got {seen!r}", path=where, key="family"
        )
    constants = {key: _constants(content.get(key, {}), family.constants, where, key) for key in ("separate", "joint")}
    try:
        return build(Kernel, {"name": name, **content, **constants}, where=where)
    except InputError as error:
        raise CatalogError(f"{where}: {error}", path=where) from error


def _constants(section: Any, names: tuple[str, ...], where: str, key: str) -> tuple[float, ...]:
    if not isinstance(section, dict) or set(section) != set(names):
        seen = ", ".join(section) if isinstance(section, dict) else repr(section)
        raise CatalogError(
            f"{where}: [{key}] must hold {', '.join(names) or 'nothing'}, got {seen or 'nothing'}", path=where, key=key
        )
    for constant, value in section.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise CatalogError(
                f"{where}: {key}.{constant} must be a number, got {value!r}", path=where, key=f"{key}.{constant}"
            )
    return tuple(float(section[constant]) for constant in names)
