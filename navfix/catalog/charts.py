"""How well a chart knows its marks."""

from __future__ import annotations

from dataclasses import dataclass

from navfix.catalog.loading import load


@dataclass(frozen=True, slots=True)
class ChartModel:
    """How well a chart knows where an echo is, and when an AIS aid is a charted one (see models/chart/aids.toml)."""

    name: str
    title: str
    source: str
    fixed_sigma_m: float
    sinker_sigma_m: float
    land_sigma_m: float
    chain_per_depth: float
    tide_m: float
    default_depth_m: float
    largest_depth_m: float
    largest_extent_m: float
    colocated_m: float
    same_object_m: float
    gate_sigma: float
    named_within_m: float
    nameless_within_m: float
    sparse_ais: int
    ais_range_m: float
    most_marks: int


def chart_model(name: str | ChartModel = "aids") -> ChartModel:
    """Return the sigmas and gates of charted marks by name in models/chart, or the record itself."""
    return load("chart", name, ChartModel)
