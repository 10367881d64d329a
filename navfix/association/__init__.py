"""Which radar target is which mark: association from any heading and any overlap, and knowing when not to answer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from navfix.association.epoch import associate

__all__ = ["associate"]


def __getattr__(name: str) -> Any:
    if name == "associate":
        import importlib

        value = importlib.import_module("navfix.association.epoch").associate
        globals()[name] = value
        return value
    raise AttributeError(f"module 'navfix.association' has no attribute {name!r}")
