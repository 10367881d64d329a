"""The fix as GPX 1.1: own ship and the marks that carried it as waypoints."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from navfix.errors import InputError
from navfix.report import words
from navfix.report.answer import Answer
from navfix.report.numbers import degrees, iso_utc
from navfix.report.outliers import outlier_words
from navfix.report.rows import pair_rows
from navfix.report.tables import clipped
from navfix.types import Fix, Position

NAMESPACE = "http://www.topografix.com/GPX/1/1"


def gpx_text(answer: Answer) -> str:
    """Return a GPX file; without a fix it holds no waypoint and says why in its description.

    Raises
    ------
    InputError : the fix lies in a plane frame, not on the globe
    """
    root = ET.Element("gpx", {"xmlns": NAMESPACE, "version": "1.1", "creator": "navfix"})
    metadata = ET.SubElement(root, "metadata")
    if answer.fix is None:
        _child(metadata, "name", "no fix")
        _child(metadata, "desc", "" if answer.error is None else f"{answer.error.reason}: {answer.error}")
    else:
        _child(metadata, "name", "fix")
    _child(metadata, "time", iso_utc(answer.time_utc))
    if answer.fix is not None:
        _waypoints(root, answer, answer.fix)
    ET.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _waypoints(root: ET.Element, answer: Answer, fix: Fix) -> None:
    if not isinstance(fix.position, Position):
        raise InputError("GPX needs a place on the globe, the fix lies in a plane frame: write .json or .svg")
    ellipse = fix.ellipse(0.95)
    heading = "" if fix.heading_deg is None else f"heading {words.bearing(fix.heading_deg)}, "
    size = f"ellipse 95 % {ellipse.semi_major_m:.1f} x {ellipse.semi_minor_m:.1f} m"
    axis = f"along {words.direction(ellipse.azimuth_deg)}"
    _waypoint(root, fix.position, "own ship", f"{heading}{size} {axis}", iso_utc(answer.time_utc), "fix")
    for row in pair_rows(fix):
        if row.mark is not None:
            what = outlier_words(row) if row.outlier else f"target {row.target}"
            _waypoint(root, row.mark.position, row.name, what, None, row.mark.kind)


def _waypoint(root: ET.Element, position: Position, name: str, what: str, time: str | None, kind: str) -> None:
    place = {"lat": f"{degrees(position.lat_deg):.9f}", "lon": f"{degrees(position.lon_deg):.9f}"}
    waypoint = ET.SubElement(root, "wpt", place)
    for tag, content in (("time", time), ("name", name), ("desc", what), ("type", kind)):
        _child(waypoint, tag, content)


def _child(parent: ET.Element, tag: str, content: str | None) -> None:
    if content:
        ET.SubElement(parent, tag).text = clipped(content, 1000)
