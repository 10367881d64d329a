"""What a chart file holds: objects with a known position, and the account of what could not be read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from navfix.types import Position

ObjectKind = Literal["fixed", "floating"]
Role = Literal["structure", "equipment", "appendage", "land", "virtual"]


@dataclass(frozen=True, slots=True)
class ChartClass:
    """A class of charted objects.

    ``role``: a "structure" stands in the water or floats there; "equipment" (a light, a daymark) belongs to a structure
    and is a fixed one where none is charted; an "appendage" (topmark, fog signal, racon) is never a mark alone; "land"
    lies ashore; "virtual" has no echo.
    """

    code: str
    words: str
    kind: ObjectKind
    role: Role = "structure"


@dataclass(frozen=True, slots=True)
class ChartObject:
    """One charted object; ``sigma_m``, ``depth_m`` and ``extent_m`` in metres, None where the chart does not say.

    ``equipment`` holds the codes of what was charted in the same place and merged into this object. ``source`` is the
    file, ``line`` its line (CSV) or running number (GeoJSON, S-57), counted from 1.
    """

    label: str
    position: Position
    chart_class: ChartClass
    kind: ObjectKind
    name: str | None = None
    mmsi: int | None = None
    sigma_m: float | None = None
    depth_m: float | None = None
    extent_m: float = 0.0
    equipment: tuple[str, ...] = ()
    source: str = ""
    line: int | None = None


@dataclass(frozen=True, slots=True)
class Problem:
    """Rows that were passed over for one reason: how many, and the first of them.

    ``harmless`` where the row reads well and is no mark by its nature, such as a wreck below water.
    """

    reason: str
    count: int
    line: int | None = None
    example: str = ""
    harmless: bool = False

    def __str__(self) -> str:
        where = "" if self.line is None else f", first in {self.line}"
        return f"{self.count} passed over: {self.reason}{where}{': ' + self.example if self.example else ''}"


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """One chart file, or several joined: the objects that can be marks, merged where they stand in one place.

    ``counts`` tells how many objects of each class code were read before merging; ``passed_over`` how many rows and
    objects are no marks, by reason.
    """

    name: str
    objects: tuple[ChartObject, ...]
    counts: Mapping[str, int] = field(default_factory=dict)
    passed_over: tuple[Problem, ...] = ()


class BadRow(Exception):
    """A row that cannot be read; the reader counts it by ``reason`` and goes on."""

    harmless = False

    def __init__(self, reason: str, example: str = "") -> None:
        super().__init__(f"{reason}: {example}" if example else reason)
        self.reason = reason
        self.example = example


class NoMark(BadRow):
    """A row that reads well and is no mark by its nature."""

    harmless = True
