"""NMEA 0183 and AIS: sentences in (`Reader` for a stream, `read_log` for a file) and out (`navfix.nmea.write`).

The only package that knows sentences, knots and nautical miles: what leaves it is in metres, m/s and degrees.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from navfix.nmea.log import Log, read_log
    from navfix.nmea.reader import Reader

__all__ = ["Log", "Reader", "read_log"]


def __getattr__(name: str) -> Any:
    """Import the reader when it is asked for: `navfix.nmea.records` alone stays cheap."""
    if name == "Reader":
        from navfix.nmea.reader import Reader

        return Reader
    if name in ("Log", "read_log"):
        from navfix.nmea import log

        return getattr(log, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
