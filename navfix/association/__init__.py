"""Which radar target is which mark: association from any heading and any overlap, and knowing when not to answer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from navfix.association.epoch import associate
    from navfix.association.kept_index import KeptIndex

__all__ = ["KeptIndex", "associate"]
_HOMES = {"KeptIndex": "kept_index", "associate": "epoch"}


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        import importlib

        value = getattr(importlib.import_module(f"navfix.association.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'navfix.association' has no attribute {name!r}")
