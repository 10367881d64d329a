"""Hulls of unknown size, where on a hull its echo lies, and how well its outline is measured."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from navfix.catalog.loading import load, names


@dataclass(frozen=True, slots=True)
class HullModel:
    """The hull to expect of a ship that does not say its size: mean and 1 sigma, by AIS class and ship type.

    ``ship_types`` holds the first and the last type of ITU-R M.1371, or nothing: any other. ``centre_forward_share`` is
    how far the hull's centre lies forward of the AIS antenna, as a share of the length.
    """

    name: str
    title: str
    source: str
    ais_class: str
    ship_types: list[int]
    length_m: float
    length_sigma_m: float
    beam_m: float
    centre_forward_share: float
    centre_forward_sigma_share: float


@dataclass(frozen=True, slots=True)
class EchoModel:
    """Where on a hull its echo lies: about the mean depth of the visible side, with 1 sigma.

    Along the line of sight ``depth_sigma_share`` of that depth and ``edge_sigma_share`` of the way from it to the
    nearest edge; across it ``across_sigma_share`` of the width.
    """

    name: str
    title: str
    source: str
    depth_sigma_share: float
    edge_sigma_share: float
    across_sigma_share: float


@dataclass(frozen=True, slots=True)
class OutlineModel:
    """How well one boundary point of an echo is measured against the others, 1 sigma."""

    name: str
    title: str
    source: str
    range_sigma_m: float
    bearing_sigma_deg: float


def hull_model(name: str | HullModel) -> HullModel:
    """Return the hull to expect of a ship of unknown size by name in models/hull ("tanker"), or the record itself."""
    return load("hull", name, HullModel)


@cache
def hull_model_of(ais_class: str | None, ship_type: int | None) -> HullModel:
    """Return the hull to expect of a ship of this AIS class and type that does not say its size."""
    if ais_class == "B":
        return hull_model("class_b")
    models = [hull_model(name) for name in names("hull")]
    fits = [m for m in models if m.ship_types and m.ship_types[0] <= (ship_type or 0) <= m.ship_types[-1]]
    return fits[0] if fits else hull_model("class_a")


def echo_model(name: str | EchoModel = "visible_side") -> EchoModel:
    """Return where on a hull its echo lies by name in models/echo, or the record itself."""
    return load("echo", name, EchoModel)


def outline_model(name: str | OutlineModel = "digitised") -> OutlineModel:
    """Return how well the boundary points of an echo are measured by name in models/outline, or the record itself."""
    return load("outline", name, OutlineModel)
