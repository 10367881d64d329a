"""Over time: the navigator that holds a place, dead reckoning, errors common to minutes, and a whole log smoothed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from navfix.sequence.navigator import Navigator
    from navfix.sequence.outcome import Outcome

__all__ = ["Navigator", "Outcome"]

_HOMES = {"Navigator": "navigator", "Outcome": "outcome"}


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        import importlib

        value = getattr(importlib.import_module(f"navfix.sequence.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'navfix.sequence' has no attribute {name!r}")
