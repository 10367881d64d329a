"""The list of radar targets and AIS ships of one instant: text, JSON, CSV, GeoJSON."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Iterator
from typing import Any

from navfix.report.numbers import degrees, iso_utc, plain
from navfix.report.tables import clipped
from navfix.report.words import bearing, plural, utc
from navfix.types import Position, TargetList, TrackedShip
from navfix.units import KNOT_MPS

SCHEMA = "navfix.targets/1"
_ORDER = ("fused", "radar", "ais")
_TITLES = {"fused": "RADAR AND AIS", "radar": "RADAR ONLY", "ais": "AIS ONLY"}
_GREY = "pairs by the grey relation of the tracks, to compare: an echo without AIS near a ship is taken for it"
_NUMBERS = (
    "range_m", "range_variance_m2", "bearing_deg", "bearing_variance_deg2", "speed_mps", "speed_variance_m2ps2",
    "course_deg", "course_variance_deg2", "probability",
)  # fmt: skip
COLUMNS = (
    "sensor", "label", "target", "mark", "mmsi", "name", "kind", *_NUMBERS[:3], "bearing_reference", *_NUMBERS[3:],
    "lat_deg", "lon_deg",
)  # fmt: skip


def ordered(ships: TargetList) -> list[TrackedShip]:
    """Return fused ships first, then radar's, then AIS's, each by range."""
    return sorted(ships.ships, key=lambda s: (_ORDER.index(s.sensor), s.range_m or math.inf, s.label))


def targets_text(ships: TargetList) -> str:
    """Return the list as text, at most 100 columns."""
    lines = [f"TARGETS  {utc(ships.time_utc)}   {_counts(ships)}", _own(ships), ""]
    for sensor in _ORDER:
        rows = [ship for ship in ordered(ships) if ship.sensor == sensor]
        if rows:
            lines += [_TITLES[sensor], *_table(rows), ""]
    lines.append("1 sigma behind each value; bearings and courses are true, r: relative to the radar's zero mark")
    return "\n".join(lines) + "\n"


def targets_json(ships: TargetList) -> str:
    """Return the object ``navfix.targets/1`` as one line, ending in a line feed."""
    return json.dumps(to_dict(ships), ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


def to_dict(ships: TargetList) -> dict[str, Any]:
    """Return the list as plain data; the same keys for every ship, null for what is not known."""
    own = ships.own_position
    return {
        "schema": SCHEMA,
        "status": "apart" if own is None else "fused",
        "reason": ships.reason,
        "message": ships.message,
        "time_utc": iso_utc(ships.time_utc),
        "pairing": ships.pairing,
        "own_ship": None if own is None else {**_place(own), "heading_deg": plain(ships.own_heading_deg)},
        "targets": [ship_to_dict(ship) for ship in ordered(ships)],
    }


def ship_to_dict(ship: TrackedShip) -> dict[str, Any]:
    """Return one ship as plain data."""
    words = {key: getattr(ship, key) for key in ("sensor", "label", "target", "mark", "mmsi", "name", "kind")}
    numbers = {key: plain(getattr(ship, key)) for key in _NUMBERS}
    position = None if ship.position is None else _place(ship.position)
    return {**words, "bearing_reference": ship.bearing_reference, **numbers, "position": position}


def targets_csv(ships: TargetList) -> str:
    """Return the list as CSV, one line a ship; what is not known is blank."""
    out = io.StringIO()
    table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    table.writeheader()
    for ship in ordered(ships):
        row = ship_to_dict(ship)
        table.writerow({**{key: row[key] for key in COLUMNS if key in row}, **(row["position"] or {})})
    return out.getvalue()


def targets_geojson(ships: TargetList) -> str:
    """Return a FeatureCollection: own ship and every ship that has a place."""
    features = [
        _feature(
            ship.position, {"what": ship.sensor, **{k: v for k, v in ship_to_dict(ship).items() if k != "position"}}
        )
        for ship in ordered(ships)
        if ship.position is not None
    ]
    if ships.own_position is not None:
        own = {"what": "own ship", "time_utc": iso_utc(ships.time_utc), "heading_deg": plain(ships.own_heading_deg)}
        features.insert(0, _feature(ships.own_position, own))
    collection = {"type": "FeatureCollection", "features": features}
    return json.dumps(collection, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


WRITERS: dict[str, Callable[[TargetList], str]] = {
    ".txt": targets_text,
    ".json": targets_json,
    ".csv": targets_csv,
    ".geojson": targets_geojson,
}


def _counts(ships: TargetList) -> str:
    fused, radar, ais = (len(ships.of(sensor)) for sensor in ("fused", "radar", "ais"))
    return f"{fused} fused, {plural(radar, 'echo')} alone".replace("echos", "echoes") + f", {ais} AIS alone"


def _own(ships: TargetList) -> str:
    from navfix.report.words import place

    if ships.own_position is None:
        return f"NOT FUSED: no fix ({ships.reason}): {ships.message}"
    heading = "" if ships.own_heading_deg is None else f"   heading {bearing(ships.own_heading_deg)}"
    pairing = "" if ships.pairing == "fix" else f"\n{_GREY}"
    return f"own ship {place(ships.own_position)}{heading}{pairing}"


def _table(rows: list[TrackedShip]) -> Iterator[str]:
    titles = (("range m", 10), ("±", 6), ("bearing °", 11), ("±", 6), ("kn", 7), ("±", 5), ("course °", 10), ("±", 5))
    head = f"  {'target':<7}{'AIS':<24}" + "".join(f"{title:>{width}}" for title, width in titles)
    yield head
    yield "-" * len(head)
    for ship in rows:
        name = ship.name or ship.mark or ""
        yield (
            f"  {clipped(ship.target or '', 6):<7}{clipped(name, 23):<24}"
            + _pair(ship.range_m, ship.range_variance_m2, 10, 6, 0)
            + _pair(
                ship.bearing_deg,
                ship.bearing_variance_deg2,
                10,
                6,
                1,
                "r" if ship.bearing_reference == "relative" else " ",
            )
            + _pair(_knots(ship.speed_mps), _square(_knots, ship.speed_variance_m2ps2), 7, 5, 1)
            + _pair(
                None if ship.course_deg is None else round(ship.course_deg) % 360.0, ship.course_variance_deg2, 10, 5, 0
            )
        ).rstrip()


def _pair(
    value: float | None, variance: float | None, width: int, sigma_width: int, decimals: int, mark: str = ""
) -> str:
    if value is None or variance is None:
        return " " * (width + sigma_width + len(mark))
    return f"{value:>{width}.{decimals}f}{mark}{math.sqrt(variance):>{sigma_width}.{decimals}f}"


def _knots(speed_mps: float | None) -> float | None:
    return None if speed_mps is None else speed_mps / KNOT_MPS


def _square(convert: Callable[[float | None], float | None], variance: float | None) -> float | None:
    sigma = None if variance is None else convert(math.sqrt(variance))
    return None if sigma is None else sigma**2


def _place(position: Position) -> dict[str, float]:
    return {"lat_deg": degrees(position.lat_deg), "lon_deg": degrees(position.lon_deg)}


def _feature(position: Position, properties: dict[str, Any]) -> dict[str, Any]:
    point = {"type": "Point", "coordinates": [degrees(position.lon_deg), degrees(position.lat_deg)]}
    return {"type": "Feature", "geometry": point, "properties": properties}
