"""What every JSON output shares: a position, an ellipse, one object as one line."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from navfix.report.numbers import degrees, plain
from navfix.types import Ellipse, PlanePosition, Position

ELLIPSE_PROBABILITIES = (0.95, 0.99)


def to_json_line(content: Mapping[str, Any]) -> str:
    """Return one object as one line of JSON without a line feed.

    Raises
    ------
    ValueError : NaN or Infinity in it, which JSON does not know
    """
    return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def position_to_dict(position: Position | PlanePosition) -> dict[str, float | None]:
    """Return {"lat_deg", "lon_deg"}, or {"north_m", "east_m"} for a place in a plane frame."""
    if isinstance(position, PlanePosition):
        return {"north_m": plain(position.north_m, 12), "east_m": plain(position.east_m, 12)}
    return {"lat_deg": degrees(position.lat_deg), "lon_deg": degrees(position.lon_deg)}


def ellipse_to_dict(ellipse: Ellipse) -> dict[str, float | None]:
    """Return probability, semi axes [m] and azimuth [deg] of an ellipse."""
    return {
        "probability": plain(ellipse.probability),
        "semi_major_m": plain(ellipse.semi_major_m),
        "semi_minor_m": plain(ellipse.semi_minor_m),
        "azimuth_deg": plain(ellipse.azimuth_deg),
    }
