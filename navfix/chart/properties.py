"""One row or feature of any source -> a charted object: property names of many origins, values checked."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from navfix.chart.classes import CLASSES, plain_class, recognise
from navfix.chart.records import BadRow, ChartClass, ChartObject, NoMark, ObjectKind
from navfix.errors import InputError
from navfix.types import Position

# What a column or property may be called, the first that holds a value wins; compared without case.
NAMES: dict[str, tuple[str, ...]] = {
    "label": ("label", "id", "@id", "lnam", "ref", "seamark:reference", "number", "light_list_number"),
    "lat": ("lat", "lat_deg", "latitude", "y"),
    "lon": ("lon", "lon_deg", "long", "lng", "longitude", "x"),
    "kind": ("kind", "fixed_or_floating"),
    "type": ("type", "seamark:type", "class", "object_class", "acronym", "objl", "layer"),
    "name": ("name", "objnam", "seamark:name", "nobjnm", "aid_name"),
    "mmsi": ("mmsi", "seamark:mmsi", "seamark:radio_station:mmsi", "ais_mmsi"),
    "sigma_m": ("sigma_m", "sigma"),
    "depth_m": ("depth_m", "depth"),
}
_SHAPES = (("boyshp", "BOYSPP"), ("bcnshp", "BCNSPP"), ("seamark:buoy", "BOYSPP"), ("seamark:beacon", "BCNSPP"))
_UNKNOWN = plain_class("mark of unknown type", "floating")
_DMS = re.compile(
    r"^([NSEW])?\s*(-?\d+(?:\.\d+)?)[°\s-]*(?:(\d+(?:\.\d+)?)['′\s-]*)?(?:(\d+(?:\.\d+)?)[\"″\s]*)?([NSEW])?$"
)


def value_of(properties: Mapping[str, Any], field: str) -> str | None:
    """Return the text of a field under any of its names, None where all are missing or blank.

    ``properties`` has its keys in lower case.
    """
    for name in NAMES[field]:
        value = properties.get(name)
        if value is not None and not isinstance(value, dict | list) and str(value).strip():
            return str(value).strip()
    return None


def make_object(
    properties: Mapping[str, Any],
    position: Position,
    *,
    source: str,
    line: int,
    chart_class: ChartClass | None = None,
    extent_m: float = 0.0,
) -> ChartObject:
    """Return the object of one row; ``chart_class`` where the source says it otherwise (the layer of an S-57 cell).

    Raises
    ------
    BadRow : a value that cannot be right, or a type that is no mark
    """
    kind = _kind(value_of(properties, "kind"))
    found = chart_class or class_of(properties, kind)
    name = value_of(properties, "name")
    label = value_of(properties, "label") or name or f"chart:{line}"
    return ChartObject(
        label=label,
        position=position,
        chart_class=found,
        kind=kind or found.kind,
        name=name,
        mmsi=_mmsi(value_of(properties, "mmsi")),
        sigma_m=_metres(value_of(properties, "sigma_m"), "sigma_m"),
        depth_m=_metres(value_of(properties, "depth_m"), "depth_m"),
        extent_m=extent_m,
        equipment=_equipment(properties.get("equipment")),
        source=source,
        line=line,
    )


def class_of(properties: Mapping[str, Any], kind: ObjectKind | None) -> ChartClass:
    """Return the class by type, else by attributes that only buoys or only beacons have.

    Without any a mark is taken as floating, which has the larger sigma.

    Raises
    ------
    NoMark : a type that is named and not known, where the kind is not named either
    """
    said = value_of(properties, "type")
    if said is not None:
        said = _moored(said, properties)
        found = recognise(said)
        if found is not None:
            return found
        if kind is None:
            raise NoMark("type is no mark", said)
        return plain_class(said.lower(), kind)
    for attribute, code in _SHAPES:
        if any(key.startswith(attribute) and properties[key] not in (None, "") for key in properties):
            lateral = properties.get("catlam") not in (None, "")
            return CLASSES[code[:3] + "LAT" if lateral else code]
    return _UNKNOWN if kind is None else plain_class("mark of unknown type", kind)


def _moored(said: str, properties: Mapping[str, Any]) -> str:
    """Return the words for a mooring of OpenSeaMap, which may be a buoy, a dolphin or a wall."""
    if said.lower() != "mooring":
        return said
    return f"mooring {properties.get('seamark:mooring:category', 'of unknown category')}"


def place(lat: str | None, lon: str | None) -> Position:
    """Return the position of two texts: decimal degrees, or degrees and minutes with N, S, E, W (``54-30.5N``).

    Raises
    ------
    BadRow : missing, not a number, out of range
    """
    if lat is None or lon is None:
        raise BadRow("no position", f"lat {lat!r}, lon {lon!r}")
    try:
        return Position(_degrees(lat, "NS"), _degrees(lon, "EW"))
    except InputError as error:
        raise BadRow("position out of range", str(error)) from error


def _degrees(text: str, letters: str) -> float:
    found = _DMS.match(text.strip().upper())
    letter = found and (found[1] or found[5])
    if found is None or (letter and letter not in letters) or (found[1] and found[5]):
        try:
            return _finite(float(text), text)
        except ValueError:
            raise BadRow("position is no number", text) from None
    minutes, seconds = float(found[3] or 0.0), float(found[4] or 0.0)
    if minutes >= 60.0 or seconds >= 60.0 or (found[3] and "." in found[2]):
        raise BadRow("position is no number", text)
    size = abs(float(found[2])) + minutes / 60.0 + seconds / 3600.0
    return -size if letter in ("S", "W") or found[2].startswith("-") else size


def _finite(number: float, text: str) -> float:
    if not math.isfinite(number):
        raise BadRow("position is no number", text)
    return number


def _kind(text: str | None) -> ObjectKind | None:
    if text is None:
        return None
    word = text.lower()
    if word in ("fixed", "floating"):
        return word  # type: ignore[return-value]
    raise BadRow("kind must be fixed or floating", text)


def _metres(text: str | None, name: str) -> float | None:
    if text is None:
        return None
    try:
        number = float(text)
    except ValueError:
        raise BadRow(f"{name} is no number", text) from None
    if not math.isfinite(number) or number < 0.0:
        raise BadRow(f"{name} must be >= 0", text)
    return number


def _equipment(value: Any) -> tuple[str, ...]:
    """Return the codes of a list, or of a text with blanks between them."""
    parts = value if isinstance(value, list) else str(value or "").split()
    return tuple(str(part) for part in parts)


def _mmsi(text: str | None) -> int | None:
    if text is None:
        return None
    digits = text.removesuffix(".0")
    if digits == "0":  # how tables say that there is none
        return None
    if not digits.isdecimal() or not 0 < int(digits) <= 999_999_999:
        raise BadRow("mmsi must have nine digits", text)
    return int(digits)
