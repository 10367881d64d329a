"""Charted objects from GeoJSON (RFC 7946): points, and lines and areas that are small enough to be one mark."""

from __future__ import annotations

import json
from typing import Any

from navfix.chart.properties import make_object
from navfix.chart.records import BadRow, ChartObject, NoMark, Problem
from navfix.chart.shapes import geojson_points, place_and_extent
from navfix.chart.tally import Tally
from navfix.errors import InputError


def read_geojson(text: str, *, source: str, largest_extent_m: float) -> tuple[list[ChartObject], tuple[Problem, ...]]:
    """Return the objects of a GeoJSON text and what was passed over; lines count features, from 1.

    Raises
    ------
    InputError : not JSON, or JSON without features
    """
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{source}:{error.lineno}: not JSON: {error.msg}", source=source, line=error.lineno) from error
    except RecursionError as error:
        raise InputError(f"{source}: not GeoJSON: nested too deeply", source=source) from error
    objects, tally = [], Tally()
    for number, feature in enumerate(_features(content, source), start=1):
        try:
            objects.append(_object(feature, source, number, largest_extent_m))
        except BadRow as bad:
            tally.add(bad, number)
    return objects, tally.problems()


def _features(content: Any, source: str) -> list[Any]:
    if isinstance(content, dict):
        if content.get("type") == "Feature":
            return [content]
        features = content.get("features")
        if isinstance(features, list):
            return features
    seen = content.get("type") if isinstance(content, dict) else type(content).__name__
    raise InputError(f"{source}: not GeoJSON: expected a FeatureCollection, got {seen!r}", source=source)


def _object(feature: Any, source: str, number: int, largest_extent_m: float) -> ChartObject:
    if not isinstance(feature, dict):
        raise BadRow("no feature", str(feature)[:60])
    position, extent_m = place_and_extent(geojson_points(feature.get("geometry")))
    if extent_m > largest_extent_m:
        raise NoMark("too large for a mark", f"{extent_m:.0f} m")
    return make_object(_properties(feature), position, source=source, line=number, extent_m=extent_m)


def _properties(feature: dict[str, Any]) -> dict[str, Any]:
    """Return the properties with names in lower case; some exports put them one level deeper, into ``tags``."""
    properties = feature.get("properties")
    properties = properties if isinstance(properties, dict) else {}
    tags = properties.get("tags")
    flat = {
        **({"id": feature["id"]} if "id" in feature else {}),
        **properties,
        **(tags if isinstance(tags, dict) else {}),
    }
    return {str(key).lower(): value for key, value in flat.items()}
