"""Where the picture lies on earth: projection, scale and corners of its map, for a chart display that takes it over."""

from __future__ import annotations

import math
from xml.etree import ElementTree as ET

from navfix.geodesy import direct
from navfix.report.answer import Answer
from navfix.report.drawing.view import Box, View, add
from navfix.report.json_parts import position_to_dict
from navfix.report.numbers import iso_utc
from navfix.report.scene import Scene
from navfix.types import PlanePosition, Position

NAMESPACE = "urn:navfix:georeference:1"


def georeference(root: ET.Element, answer: Answer, scene: Scene, view: View, box: Box) -> None:
    """Write the projection, the scale and the corners of the map, which is ``box``, into ``<metadata>``."""
    scale = {"xmlns": NAMESPACE, "metresPerUnit": f"{1.0 / view.units_per_m:.9g}"}
    time = iso_utc(answer.time_utc)
    reference = ET.SubElement(add(root, "metadata"), "georeference", scale | ({} if time is None else {"time": time}))
    ET.SubElement(reference, "projection").text = _projection(scene)
    _located(reference, "origin", scene, view, view.point(0.0, 0.0))
    for name, corner in _corners(box).items():
        _located(reference, "corner", scene, view, corner).set("name", name)


def _projection(scene: Scene) -> str:
    if isinstance(scene.origin, Position):
        return "azimuthal equidistant about the origin, WGS 84, north up"
    if isinstance(scene.origin, PlanePosition):
        return "plane, north up"
    up = "the radar's zero mark up" if scene.head_up else "north up"
    return f"range and bearing from own ship, {up}; own ship's place is unknown"


def _located(parent: ET.Element, tag: str, scene: Scene, view: View, point: tuple[float, float]) -> ET.Element:
    """Add an element with a point of the picture and its place."""
    place = _place_names(scene, *view.metres(*point))
    where = {"x": f"{point[0]:.6f}", "y": f"{point[1]:.6f}"} | {name: repr(value) for name, value in place.items()}
    return ET.SubElement(parent, tag, where)


def _corners(box: Box) -> dict[str, tuple[float, float]]:
    right, bottom = box.x + box.width, box.y + box.height
    return {
        "upper_left": (box.x, box.y),
        "upper_right": (right, box.y),
        "lower_right": (right, bottom),
        "lower_left": (box.x, bottom),
    }


def _place_names(scene: Scene, north_m: float, east_m: float) -> dict[str, float | None]:
    """Return latitude and longitude of a point, or its plane coordinates, or its metres about own ship."""
    if isinstance(scene.origin, Position):
        azimuth_deg = math.degrees(math.atan2(east_m, north_m))
        return position_to_dict(direct(scene.origin, azimuth_deg, math.hypot(north_m, east_m)))
    if isinstance(scene.origin, PlanePosition):
        return position_to_dict(PlanePosition(scene.origin.north_m + north_m, scene.origin.east_m + east_m))
    return {"ahead_m": round(north_m, 3), "starboard_m": round(east_m, 3)}
