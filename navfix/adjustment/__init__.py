"""The adjustment: from associated targets and marks to a fix with a covariance that can be believed."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from navfix.adjustment.epoch import adjust
    from navfix.adjustment.mean import mean_fix

__all__ = ["adjust", "mean_fix"]

_HOME = {"adjust": "navfix.adjustment.epoch", "mean_fix": "navfix.adjustment.mean"}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(importlib.import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'navfix.adjustment' has no attribute {name!r}")
