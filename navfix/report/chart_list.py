"""The objects of a chart as text, JSON, CSV and GeoJSON; the last two can be given back as a chart."""

from __future__ import annotations

import csv
import io
import json
import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from navfix.catalog import ChartModel, chart_model
from navfix.chart.marks import is_mark, sigma_m
from navfix.chart.records import Chart, ChartObject
from navfix.geodesy import inverse
from navfix.report import words
from navfix.report.numbers import degrees, plain
from navfix.types import Position

SCHEMA = "navfix.chart/1"
COLUMNS = ("label", "lat", "lon", "kind", "type", "sigma_m", "depth_m", "name", "mmsi", "equipment")


@dataclass(frozen=True, slots=True)
class Listed:
    """One object of a chart, and where it lies from the place that was asked about (None without one)."""

    item: ChartObject
    sigma_m: float
    distance_m: float | None = None
    azimuth_deg: float | None = None


def listed(
    chart: Chart, *, land: bool = False, near: Position | None = None, radius_m: float = 0.0,
    model: ChartModel | str = "aids",
) -> tuple[Listed, ...]:  # fmt: skip
    """Return the objects that can be marks; with ``near`` those within ``radius_m`` of it, the nearest first."""
    chosen = chart_model(model)
    wanted = [item for item in chart.objects if is_mark(item, land=land)]
    if near is None:
        return tuple(Listed(item, sigma_m(item, chosen)) for item in wanted)
    found = [Listed(item, sigma_m(item, chosen), *inverse(near, item.position)[:2]) for item in wanted]
    within = [row for row in found if row.distance_m is not None and row.distance_m <= radius_m]
    return tuple(sorted(within, key=lambda row: row.distance_m or 0.0))


def chart_text(chart: Chart, rows: Sequence[Listed]) -> str:
    """Return the table, at most 100 columns, with the counts above it and what was passed over below."""
    kinds = Counter(row.item.kind for row in rows)
    lines = [
        f"CHART  {chart.name}",
        f"{words.plural(len(rows), 'mark')}: {kinds['fixed']} fixed, {kinds['floating']} floating",
        *(f"  {count:>5}  {name}" for name, count in _by_class(rows)),
    ]
    if chart.counts:
        read = ", ".join(f"{count} {code}" for code, count in chart.counts.items())
        lines += ["", *textwrap.wrap(f"Objects in the files, before those in one place were merged: {read}", 100)]
    lines += [str(problem)[:100] for problem in chart.passed_over]
    away = any(row.distance_m is not None for row in rows)
    head = f"{'name':<28}{'type':<23}{'position':<31}{'sigma m':>7}"
    lines += ["", head + (f"{'distance':>11}" if away else "")]
    lines += [_line(row, away) for row in rows]
    return "\n".join(line.rstrip() for line in lines)


def chart_json(chart: Chart, rows: Sequence[Listed]) -> str:
    """Return one JSON object (``navfix.chart/1``)."""
    return json.dumps(
        {
            "schema": SCHEMA,
            "chart": chart.name,
            "counts": dict(chart.counts),
            "kinds": dict(Counter(row.item.kind for row in rows)),
            "types": dict(_by_class(rows)),
            "passed_over": [
                {"reason": p.reason, "count": p.count, "first": p.line, "example": p.example} for p in chart.passed_over
            ],
            "marks": [_properties(row) | _place(row) | _away(row) for row in rows],
        },
        ensure_ascii=False,
        allow_nan=False,
    )


def chart_geojson(rows: Sequence[Listed]) -> str:
    """Return a FeatureCollection of points."""
    features = [
        {
            "type": "Feature",
            "geometry": {
                "type": "Point",
                "coordinates": [degrees(row.item.position.lon_deg), degrees(row.item.position.lat_deg)],
            },
            "properties": _properties(row) | _away(row),
        }
        for row in rows
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}, ensure_ascii=False, indent=1) + "\n"


def chart_csv(rows: Sequence[Listed]) -> str:
    """Return CSV with the columns that the CSV reader takes."""
    out = io.StringIO()
    table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    table.writeheader()
    for row in rows:
        content = _properties(row) | _place(row)
        table.writerow(content | {"equipment": " ".join(row.item.equipment)})
    return out.getvalue()


def _by_class(rows: Sequence[Listed]) -> list[tuple[str, int]]:
    return Counter(row.item.chart_class.words for row in rows).most_common()


def _line(row: Listed, away: bool) -> str:
    name = (row.item.name or row.item.label)[:27]
    place = words.place(row.item.position)
    line = f"{name:<28}{row.item.chart_class.words[:22]:<23}{place:<31}{row.sigma_m:>7.1f}"
    return line + (f"{words.short_distance(row.distance_m or 0.0):>11}" if away else "")


def _properties(row: Listed) -> dict[str, Any]:
    item = row.item
    return {
        "label": item.label,
        "kind": item.kind,
        "type": item.chart_class.code or item.chart_class.words,
        "sigma_m": plain(row.sigma_m, 4),
        "depth_m": plain(item.depth_m),
        "name": item.name,
        "mmsi": item.mmsi,
        "equipment": list(item.equipment),
    }


def _place(row: Listed) -> dict[str, float]:
    return {"lat": degrees(row.item.position.lat_deg), "lon": degrees(row.item.position.lon_deg)}


def _away(row: Listed) -> dict[str, float | None]:
    if row.distance_m is None or row.azimuth_deg is None:
        return {}
    return {"distance_m": plain(row.distance_m), "azimuth_deg": plain(row.azimuth_deg % 360.0)}
