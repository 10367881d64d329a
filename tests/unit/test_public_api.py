"""The public names: exactly these, documented, and loaded only when they are used."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import navfix

PUBLIC = "fix associate adjust mean_fix Position RadarTarget Mark Epoch Association Fix Kernel NavfixError"
HEAVY = ("numpy", "scipy", "gtsam", "geographiclib", "pyais", "pynmea2", "asyncio", "importlib.metadata")
ENTRY_POINTS = (
    "import navfix",
    "import navfix.cli",
    "import navfix.cli; navfix.cli.main(['--help'])",
    "import navfix.cli; navfix.cli.main(['models', '--help'])",
)


def test_the_public_names_are_exactly_these() -> None:
    assert sorted(navfix.__all__) == sorted(PUBLIC.split())


@pytest.mark.parametrize("name", PUBLIC.split())
def test_a_public_name_loads_and_is_documented(name: str) -> None:
    value = getattr(navfix, name)
    assert value is getattr(navfix, name)
    assert name in dir(navfix)
    assert inspect.getdoc(value)
    assert not inspect.getdoc(value).startswith(f"{name}("), "a record without a docstring shows its signature"


def test_public_names_are_callable_whatever_was_imported_before() -> None:
    # A module of the same name as a function in the package above it would take its place once it is imported.
    everything = [module.__name__ for module in _modules()]
    script = f"import importlib, navfix\nfor name in {everything}: importlib.import_module(name)\n"
    script += f"assert [n for n in {PUBLIC.split()} if not callable(getattr(navfix, n))] == []"
    ended = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        cwd=Path(navfix.__file__).parents[1],
    )
    assert ended.returncode == 0, ended.stderr


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'conjure'"):
        _ = navfix.conjure


@pytest.mark.parametrize("statement", ENTRY_POINTS)
def test_nothing_heavy_is_imported_before_it_is_needed(statement: str) -> None:
    ended = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", statement],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        cwd=Path(navfix.__file__).parents[1],
    )
    loaded = {line.split("|")[2].strip() for line in ended.stderr.splitlines() if line.startswith("import time:")}
    assert "navfix" in loaded
    # site runs .pth files of the environment before anything of ours: what they load is not ours to keep quick.
    assert not {name for name in loaded if name in HEAVY or name.split(".")[0] in HEAVY} - _loaded_by_an_empty_program()
    assert len(loaded) < 160


def _loaded_by_an_empty_program() -> set[str]:
    ended = subprocess.run(
        [sys.executable, "-c", "import sys; print(*sys.modules)"],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return set(ended.stdout.split())


def _modules() -> Iterator[ModuleType]:
    yield navfix
    for info in pkgutil.walk_packages(navfix.__path__, "navfix."):
        if not info.name.endswith("__main__"):
            yield importlib.import_module(info.name)


def _undocumented(module: ModuleType) -> Iterator[str]:
    """Yield the public functions, classes and methods of a module that have no docstring of their own."""
    if not module.__doc__:
        yield module.__name__
    for name, value in vars(module).items():
        if name.startswith("_") or getattr(value, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(value) and not value.__doc__:
            yield f"{module.__name__}.{name}"
        if inspect.isclass(value):
            yield from _undocumented_class(value)


def _undocumented_class(cls: type) -> Iterator[str]:
    where = f"{cls.__module__}.{cls.__qualname__}"
    if not cls.__doc__ or cls.__doc__.startswith(f"{cls.__name__}("):  # dataclass writes its signature there
        yield where
    for name, value in vars(cls).items():
        if not name.startswith("_") and inspect.isfunction(value) and not value.__doc__:
            yield f"{where}.{name}"


def test_everything_public_is_documented() -> None:
    missing = [name for module in _modules() for name in _undocumented(module)]
    assert not missing, "without a docstring: " + ", ".join(missing)


def test_a_missing_docstring_is_noticed() -> None:
    module = ModuleType("bare")
    exec("def f(): pass\nclass C:\n    def m(self): pass", {"__name__": "bare"}, vars(module))
    for value in (module.f, module.C, module.C.m):
        value.__module__ = "bare"
    assert list(_undocumented(module)) == ["bare", "bare.f", "bare.C", "bare.C.m"]
