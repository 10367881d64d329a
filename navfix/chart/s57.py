"""Charted objects from an S-57 cell (.000) with its updates (.001 ... beside it), through pyogrio (extra ``enc``)."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from navfix.chart.classes import CLASSES, MOORING_BUOY
from navfix.chart.depth import DepthArea, depth_areas, depth_at
from navfix.chart.properties import make_object
from navfix.chart.records import BadRow, ChartClass, ChartObject, NoMark, Problem
from navfix.chart.shapes import place_and_extent, wkb_points
from navfix.chart.tally import Tally
from navfix.errors import InputError

_COLUMNS = ("LNAM", "OBJNAM", "CONVIS", "CATWRK", "CATMOR", "DRVAL1", "DRVAL2")
_DEPTHS = ("DRGARE", "DEPARE")
_ABOVE_WATER = (4, 5)  # CATWRK: mast showing, hull showing
_STANDING_MOORING = (1, 5)  # CATMOR: dolphin, post or pile
_FLOATING_MOORING = 7  # CATMOR: mooring buoy
_CONSPICUOUS = 1  # CONVIS


def read_s57(path: Path, *, largest_extent_m: float) -> tuple[list[ChartObject], dict[str, int], tuple[Problem, ...]]:
    """Return the objects of a cell, how many of each class it holds, and what was passed over.

    Raises
    ------
    InputError : pyogrio is not installed; GDAL cannot read the file as S-57
    """
    layers = _Layers(path)
    areas = [area for name in _DEPTHS if name in layers.names for area in layers.depths(name)]
    tally = Tally()
    objects: list[ChartObject] = []
    counts: dict[str, int] = {}
    number = 0
    for code in CLASSES:
        if code not in layers.names:
            continue
        features = layers.features(code)
        for properties, wkb in features:
            number += 1
            counts[code] = counts.get(code, 0) + 1
            try:
                objects.append(_object(code, properties, wkb, areas, path.name, number, largest_extent_m))
            except BadRow as bad:
                tally.add(bad, number)
    return objects, counts, tally.problems()


def _object(
    code: str,
    properties: dict[str, Any],
    wkb: bytes | None,
    areas: list[DepthArea],
    source: str,
    number: int,
    largest_extent_m: float,
) -> ChartObject:
    found = _class_or_reject(code, properties)
    position, extent_m = place_and_extent(wkb_points(wkb))
    if extent_m > largest_extent_m:
        raise NoMark("too large for a mark", f"{code}, {extent_m:.0f} m")
    depth_m = depth_at(areas, position) if found.kind == "floating" else None
    told = {"label": properties.get("lnam"), "name": properties.get("objnam"), "depth_m": depth_m}
    return make_object(told, position, source=source, line=number, chart_class=found, extent_m=extent_m)


def _class_or_reject(code: str, properties: dict[str, Any]) -> ChartClass:
    """Return the class of an object; raise NoMark where this one of its class is no mark."""
    if code == "WRECKS" and _integer(properties.get("catwrk")) not in _ABOVE_WATER:
        raise NoMark("wreck below water")
    if code == "MORFAC":
        category = _integer(properties.get("catmor"))
        if category == _FLOATING_MOORING:
            return MOORING_BUOY
        if category not in _STANDING_MOORING:
            raise NoMark("mooring facility that does not stand alone")
    if CLASSES[code].role == "land" and _integer(properties.get("convis")) != _CONSPICUOUS:
        raise NoMark("object ashore that is not conspicuous")
    return CLASSES[code]


def _integer(value: Any) -> int | None:
    return None if value is None or not np.isfinite(value) else int(value)


class _Layers:
    """The layers of one cell."""

    def __init__(self, path: Path) -> None:
        self._pyogrio, self._path = _pyogrio(), path
        try:
            self.names = {str(row[0]) for row in self._quietly(self._pyogrio.list_layers, path)}
        except Exception as error:
            raise InputError(f"{path}: not a readable S-57 cell: {error}", source=str(path)) from error
        if "DSID" not in self.names:
            raise InputError(f"{path}: not an S-57 cell: it holds no data set identification", source=str(path))

    def features(self, layer: str) -> Iterator[tuple[dict[str, Any], bytes | None]]:
        """Yield properties (names in lower case) and geometry of each feature."""
        names, geometries, columns = self._read(layer)
        for row, wkb in enumerate(geometries):
            yield {name: column[row] for name, column in zip(names, columns, strict=True)}, wkb

    def depths(self, layer: str) -> list[DepthArea]:
        """Return the areas of a layer with their depths."""
        names, geometries, columns = self._read(layer)
        blank = np.full(len(geometries), np.nan)
        limits = {name: np.asarray(column, dtype=np.float64) for name, column in zip(names, columns, strict=True)
                  if name.startswith("drval")}  # fmt: skip
        return depth_areas(geometries, limits.get("drval1", blank), limits.get("drval2", blank))

    def _read(self, layer: str) -> tuple[list[str], Any, Any]:
        try:
            meta, _, geometries, columns = self._quietly(
                self._pyogrio.raw.read, self._path, layer=layer, columns=list(_COLUMNS)
            )
        except Exception as error:
            raise InputError(f"{self._path}: layer {layer} cannot be read: {error}", source=str(self._path)) from error
        return [str(name).lower() for name in meta["fields"]], geometries, columns

    @staticmethod
    def _quietly(call: Any, *args: Any, **kwargs: Any) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # GDAL warns of attributes that are unknown to its tables
            return call(*args, **kwargs)


def _pyogrio() -> ModuleType:
    try:
        import pyogrio
        import pyogrio.raw
    except ImportError as error:
        raise InputError(
            "an S-57 cell is read through pyogrio, which is not installed; pip install 'navfix[enc]', or export the "
            "marks as GeoJSON or CSV"
        ) from error
    module: ModuleType = pyogrio
    return module
