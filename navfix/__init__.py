"""navfix: a ship's position and heading without GNSS, from radar targets, AIS and the chart.

>>> import navfix
>>> fix = navfix.fix(epoch)                      # doctest: +SKIP
>>> fix.position, fix.heading_deg, fix.ellipse(0.95)  # doctest: +SKIP

Names are loaded when they are first used, so that ``import navfix`` stays quick.
"""

from __future__ import annotations

import importlib
import logging
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from navfix.adjustment import adjust, mean_fix
    from navfix.association import associate
    from navfix.errors import NavfixError
    from navfix.kernels import Kernel
    from navfix.pipeline import fix
    from navfix.types import Association, Epoch, Fix, Mark, Position, RadarTarget

__version__ = "0.2.0"

__all__ = [
    "Association",
    "Epoch",
    "Fix",
    "Kernel",
    "Mark",
    "NavfixError",
    "Position",
    "RadarTarget",
    "adjust",
    "associate",
    "fix",
    "mean_fix",
]

_HOME = {
    "Association": "navfix.types",
    "Epoch": "navfix.types",
    "Fix": "navfix.types",
    "Kernel": "navfix.kernels",
    "Mark": "navfix.types",
    "NavfixError": "navfix.errors",
    "Position": "navfix.types",
    "RadarTarget": "navfix.types",
    "adjust": "navfix.adjustment",
    "associate": "navfix.association",
    "fix": "navfix.pipeline",
    "mean_fix": "navfix.adjustment",
}

logging.getLogger(__name__).addHandler(logging.NullHandler())


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(importlib.import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'navfix' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
