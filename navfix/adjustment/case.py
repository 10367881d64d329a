"""The case file: marks, observations and a start, written by hand in TOML or JSON, validated."""

from __future__ import annotations

import json
import logging
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from navfix.adjustment.utm import zone_of
from navfix.errors import InputError
from navfix.types import ObservationKind, PlanePosition, Position

logger = logging.getLogger(__name__)

Frame = Literal["plane", "wgs84"]
_PLACE_KEYS: dict[str, tuple[str, str]] = {"plane": ("north_m", "east_m"), "wgs84": ("lat_deg", "lon_deg")}
_LARGEST, _SMALLEST_SIGMA = 1e9, 1e-9  # of any number in a case, m or deg: squares of more would overflow
_KINDS: tuple[ObservationKind, ...] = ("range", "true_bearing", "relative_bearing")
# what a file may say beside the case itself: words for people, and what a published example expects
_FREE_KEYS = ("name", "title", "source", "note", "expected", "tolerance")
_KEYS = ("frame", "marks", "observations", "start", "heading_deg", "utm_zone", *_FREE_KEYS)


@dataclass(frozen=True, slots=True)
class CaseMark:
    """A mark of known position; ``sigma_m`` is 1 sigma per axis, 0 for a fixed one."""

    label: str
    position: Position | PlanePosition
    sigma_m: float = 0.0


@dataclass(frozen=True, slots=True)
class CaseObservation:
    """What was measured to one mark: ``value`` and ``sigma`` in m (range) or deg (bearings).

    ``use`` False keeps the observation in the list without letting it take part. Observations of one ``target`` (the
    mark, unless the file says otherwise) are damped together.
    """

    mark: str
    kind: ObservationKind
    value: float
    sigma: float
    target: str
    use: bool = True


@dataclass(frozen=True, slots=True)
class Case:
    """One adjustment problem. ``start`` and ``heading_deg`` are None where the file gives none.

    ``utm_zone`` ("34N"): the plane is that of a UTM zone, and results are shown on WGS 84 too.
    """

    name: str
    frame: Frame
    marks: tuple[CaseMark, ...]
    observations: tuple[CaseObservation, ...]
    start: Position | PlanePosition | None = None
    heading_deg: float | None = None
    utm_zone: str | None = None

    @property
    def heading_unknown(self) -> bool:
        """Whether a relative bearing takes part: then the heading is an unknown."""
        return any(o.kind == "relative_bearing" and o.use for o in self.observations)


def parse_case(text: str, *, source: str = "case") -> Case:
    """Read a case of TOML or JSON text (JSON begins with "{").

    Raises
    ------
    InputError : neither TOML nor JSON, a missing or impossible value, an unknown mark; says what was expected
    """
    content = _read_json(text, source) if text.lstrip("\ufeff \t\r\n").startswith("{") else _read_toml(text, source)
    return case_of(content, source=source)


def case_of(content: Mapping[str, Any], *, source: str = "case") -> Case:
    """Make a case of a table (see `parse_case`); keys that nobody knows are left out with a warning in the log.

    Raises
    ------
    InputError : a missing or impossible value, an unknown mark
    """
    reader = _Reader(source)
    reader.warn_unknown("the case", content, _KEYS)
    frame: Frame = reader.choice("frame", content, tuple(_PLACE_KEYS))
    marks = tuple(reader.mark(entry, index, frame) for index, entry in enumerate(reader.tables("marks", content)))
    reader.unique("mark", [mark.label for mark in marks])
    labels = {mark.label for mark in marks}
    observations = tuple(
        reader.observation(entry, index, labels) for index, entry in enumerate(reader.tables("observations", content))
    )
    start, heading_deg = reader.start(content, frame)
    name = content.get("name", source)
    case = Case(str(name), frame, marks, observations, start, heading_deg, reader.utm_zone(content, frame))
    if case.start is not None and case.heading_unknown and heading_deg is None:
        raise reader.error("start: heading_deg is needed when relative bearings occur; add it, or leave out start")
    return case


# -------------------------------------------------------------------------------------------------------- reading


def _read_json(text: str, source: str) -> Mapping[str, Any]:
    try:
        content: Mapping[str, Any] = json.loads(text.lstrip("\ufeff"))
    except json.JSONDecodeError as error:
        raise InputError(f"{source}: not JSON: {error.msg}", source=source, line=error.lineno) from error
    return content


def _read_toml(text: str, source: str) -> Mapping[str, Any]:
    if not text.strip("\ufeff \t\r\n"):
        raise InputError(f"{source}: empty; expected a case with frame, marks and observations", source=source)
    try:
        return tomllib.loads(text.lstrip("\ufeff"))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source}: neither JSON nor TOML: {error}", source=source) from error


class _Reader:
    """Takes values out of tables and names the file and the place in every complaint."""

    def __init__(self, source: str) -> None:
        self.source = source

    def error(self, message: str) -> InputError:
        return InputError(f"{self.source}: {message}", source=self.source)

    def warn_unknown(self, where: str, table: Mapping[str, Any], known: Sequence[str]) -> None:
        for key in table:
            if key not in known:
                logger.warning(
                    "%s: %s: unknown key %r is left out; known are %s", self.source, where, key, ", ".join(known)
                )

    def unique(self, word: str, labels: Sequence[str]) -> None:
        for label in labels:
            if labels.count(label) > 1:
                raise self.error(f"{word} {label!r} occurs more than once; every label must be unique")

    def tables(self, key: str, content: Mapping[str, Any]) -> list[Mapping[str, Any]]:
        entries = content.get(key)
        if not isinstance(entries, list) or not entries or not all(isinstance(entry, Mapping) for entry in entries):
            raise self.error(f"{key} must be a list of at least one table, got {_shown(entries)}")
        return entries

    def choice(self, key: str, table: Mapping[str, Any], allowed: Sequence[str], where: str = "") -> Any:
        value = table.get(key)
        if value not in allowed:
            raise self.error(f"{where}{key} must be one of {', '.join(allowed)}, got {_shown(value)}")
        return value

    def number(self, key: str, table: Mapping[str, Any], where: str, default: float | None = None) -> float:
        value = table.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.error(f"{where}: {key} must be a finite number, got {_shown(value)}")
        if abs(value) > _LARGEST:
            raise self.error(f"{where}: {key} must be within +-{_LARGEST:g}, got {value:g}")
        return float(value)

    def label(self, key: str, table: Mapping[str, Any], where: str) -> str:
        value = table.get(key)
        if isinstance(value, bool) or not isinstance(value, str | int) or not str(value).strip():
            raise self.error(f"{where}: {key} must be a name, got {_shown(value)}")
        return str(value)

    def place(self, table: Mapping[str, Any], frame: Frame, where: str) -> Position | PlanePosition:
        first, second = _PLACE_KEYS[frame]
        missing = [key for key in (first, second) if key not in table]
        if missing:
            raise self.error(f"{where}: {missing[0]} is missing; frame {frame!r} needs {first} and {second}")
        kind = PlanePosition if frame == "plane" else Position
        try:
            return kind(self.number(first, table, where), self.number(second, table, where))
        except InputError as error:
            if error.source:
                raise
            raise self.error(f"{where}: {error}") from error

    def mark(self, table: Mapping[str, Any], index: int, frame: Frame) -> CaseMark:
        label = self.label("label", table, f"mark {index + 1}")
        where = f"mark {label}"
        self.warn_unknown(where, table, ("label", "sigma_m", "note", *_PLACE_KEYS[frame]))
        sigma_m = self.number("sigma_m", table, where, default=0.0)
        if sigma_m < 0.0:
            raise self.error(f"{where}: sigma_m must be >= 0, got {sigma_m:g}")
        return CaseMark(label, self.place(table, frame, where), sigma_m)

    def observation(self, table: Mapping[str, Any], index: int, labels: set[str]) -> CaseObservation:
        where = f"observation {index + 1}"
        self.warn_unknown(where, table, ("mark", "kind", "value", "sigma", "target", "use", "note"))
        mark = self.label("mark", table, where)
        if mark not in labels:
            raise self.error(f"{where}: no mark has the label {mark!r}; there are {', '.join(sorted(labels)[:20])}")
        kind: ObservationKind = self.choice("kind", table, _KINDS, f"{where}: ")
        value, sigma = self.number("value", table, where), self.number("sigma", table, where)
        if kind == "range" and value <= 0.0:
            raise self.error(f"{where}: a range must be > 0 m, got {value:g}")
        if sigma < _SMALLEST_SIGMA:
            raise self.error(f"{where}: sigma must be > 0, got {sigma:g}")
        use = table.get("use", True)
        if not isinstance(use, bool):
            raise self.error(f"{where}: use must be true or false, got {_shown(use)}")
        target = self.label("target", table, where) if "target" in table else mark
        return CaseObservation(mark, kind, value, sigma, target, use)

    def utm_zone(self, content: Mapping[str, Any], frame: Frame) -> str | None:
        value = content.get("utm_zone")
        if value is None:
            return None
        if frame != "plane":
            raise self.error("utm_zone belongs to frame 'plane'")
        try:
            zone_of(str(value))
        except InputError as error:
            raise self.error(str(error)) from error
        return str(value).strip().upper()

    def start(self, content: Mapping[str, Any], frame: Frame) -> tuple[Position | PlanePosition | None, float | None]:
        table = content.get("start")
        if table is None:
            table = {}
        if not isinstance(table, Mapping):
            raise self.error(f"start must be a table, got {_shown(table)}")
        self.warn_unknown("start", table, (*_PLACE_KEYS[frame], "heading_deg", "note"))
        heading = table if "heading_deg" in table else content
        heading_deg = self.number("heading_deg", heading, "start") if heading.get("heading_deg") is not None else None
        place = self.place(table, frame, "start") if set(table) - {"heading_deg", "note"} else None
        return place, heading_deg


def _shown(value: object) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
