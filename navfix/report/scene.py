"""The picture of one epoch in metres about own ship: what the SVG and the GeoJSON draw."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from navfix.geodesy import LocalPlane
from navfix.report.answer import Answer
from navfix.report.rows import PairRow, pair_rows
from navfix.types import Epoch, Fix, Mark, MarkKind, PlanePosition, Position, RadarTarget

Status = Literal["matched", "outlier", "unmatched"]
PlaceKind = Literal["plain_mean", "gnss", "truth", "alternative"]


@dataclass(frozen=True, slots=True)
class SceneTarget:
    """One radar target at (north, east) [m] of own ship, with the bearing [deg] in the picture's axes."""

    label: str
    north_m: float
    east_m: float
    bearing_deg: float
    range_m: float
    status: Status


@dataclass(frozen=True, slots=True)
class SceneMark:
    """One mark where it says it is; ``pointing_deg`` is its heading, else its course, None where it tells neither."""

    label: str
    name: str
    kind: MarkKind
    north_m: float
    east_m: float
    pointing_deg: float | None
    status: Status
    mark: Mark | None


@dataclass(frozen=True, slots=True)
class Stick:
    """The residual of one pair: from the mark towards the place where the radar sees the target, metres, unscaled."""

    row: PairRow
    north_m: float
    east_m: float
    to_north_m: float
    to_east_m: float

    @property
    def length_m(self) -> float:
        return math.hypot(self.to_north_m, self.to_east_m)


@dataclass(frozen=True, slots=True)
class ScenePlace:
    """Another place: the plain-mean fix, the GNSS of the log, the truth, an alternative."""

    kind: PlaceKind
    caption: str
    north_m: float
    east_m: float


@dataclass(frozen=True, slots=True)
class Scene:
    """Everything about own ship in the origin; ``head_up``: without a fix the picture's up is the radar's zero mark."""

    origin: Position | PlanePosition | None
    heading_deg: float | None
    head_up: bool
    targets: tuple[SceneTarget, ...]
    marks: tuple[SceneMark, ...]
    sticks: tuple[Stick, ...]
    places: tuple[ScenePlace, ...]


def scene_of(answer: Answer) -> Scene:
    """Return the picture of an answer; without a fix only the radar's targets, as the radar shows them."""
    return _radar_scene(answer.epoch) if answer.fix is None else _fix_scene(answer, answer.fix)


# ----------------------------------------------------------------------------------------------------------- no fix


def _radar_scene(epoch: Epoch | None) -> Scene:
    """Draw head-up where any bearing is relative, else north-up; what the hint cannot turn that way is left out."""
    targets = () if epoch is None else epoch.targets
    hint = None if epoch is None or epoch.heading_hint is None else epoch.heading_hint.heading_deg
    head_up = any(target.bearing_reference == "relative" for target in targets)
    shown = []
    for target in targets:
        turn_deg: float | None = 0.0
        if head_up and target.bearing_reference == "true":
            turn_deg = None if hint is None else -hint
        if turn_deg is not None:
            shown.append(_target(target, turn_deg, "unmatched"))
    return Scene(None, 0.0 if head_up else hint, head_up, tuple(shown), (), (), ())


def _target(target: RadarTarget, turn_deg: float, status: Status) -> SceneTarget:
    bearing_deg = (target.bearing_deg + turn_deg) % 360.0
    north_m, east_m = polar(target.range_m, bearing_deg)
    return SceneTarget(target.label, north_m, east_m, bearing_deg, target.range_m, status)


def polar(range_m: float, bearing_deg: float) -> tuple[float, float]:
    """Return (north, east) [m] of a range and bearing."""
    bearing_rad = math.radians(bearing_deg)
    return range_m * math.cos(bearing_rad), range_m * math.sin(bearing_rad)


# ------------------------------------------------------------------------------------------------------------ a fix


def _fix_scene(answer: Answer, fix: Fix) -> Scene:
    rows = pair_rows(fix)
    placed = fix.epoch is not None and isinstance(fix.position, Position)
    marks = tuple(_marks(fix, rows)) if placed else tuple(_marks_of_rows(fix, rows))
    where = {mark.label: mark for mark in marks}
    return Scene(
        origin=fix.position,
        heading_deg=fix.heading_deg,
        head_up=False,
        targets=tuple(_targets(fix, rows)),
        marks=marks,
        sticks=tuple(_sticks(rows, where)),
        places=tuple(_places(answer, fix)),
    )


def _status(row: PairRow | None) -> Status:
    return "unmatched" if row is None else ("outlier" if row.outlier else "matched")


def _true_turn_deg(fix: Fix, reference: str) -> float | None:
    return 0.0 if reference == "true" else fix.heading_deg


def _targets(fix: Fix, rows: list[PairRow]) -> Iterator[SceneTarget]:
    by_label = {row.target: row for row in rows}
    if fix.epoch is not None:
        for target in fix.epoch.targets:
            turn_deg = _true_turn_deg(fix, target.bearing_reference)
            if turn_deg is not None:
                yield _target(target, turn_deg, _status(by_label.get(target.label)))
        return
    for row in rows:
        if row.range is None or row.bearing is None or row.range.observed <= 0.0:
            continue
        turn_deg = _true_turn_deg(fix, row.bearing.kind.removesuffix("_bearing"))
        if turn_deg is not None:
            bearing_deg = (row.bearing.observed + turn_deg) % 360.0
            range_m = row.range.observed
            yield SceneTarget(row.target, *polar(range_m, bearing_deg), bearing_deg, range_m, _status(row))


def _marks(fix: Fix, rows: list[PairRow]) -> Iterator[SceneMark]:
    assert fix.epoch is not None
    assert isinstance(fix.position, Position)
    plane, by_label = LocalPlane(fix.position), {row.mark_label: row for row in rows}
    for mark in fix.epoch.marks:
        north_m, east_m = (float(metres) for metres in plane.to_plane(mark.position))
        pointing_deg = mark.course_deg if mark.heading_deg is None else mark.heading_deg
        status = _status(by_label.get(mark.label))
        yield SceneMark(mark.label, mark.name or mark.label, mark.kind, north_m, east_m, pointing_deg, status, mark)


def _marks_of_rows(fix: Fix, rows: list[PairRow]) -> Iterator[SceneMark]:
    """Yield the marks of a fix without an epoch: where the adjusted observations point to."""
    for row in rows:
        turn_deg = None if row.bearing is None else _true_turn_deg(fix, row.bearing.kind.removesuffix("_bearing"))
        if row.range is not None and row.bearing is not None and turn_deg is not None:
            north_m, east_m = polar(row.range.adjusted, row.bearing.adjusted + turn_deg)
            yield SceneMark(row.mark_label, row.name, "charted", north_m, east_m, None, _status(row), row.mark)


def _sticks(rows: list[PairRow], where: dict[str, SceneMark]) -> Iterator[Stick]:
    for row in rows:
        mark = where.get(row.mark_label)
        if mark is None or row.offset_m is None or row.offset_azimuth_deg is None:
            continue
        north_m, east_m = polar(row.offset_m, row.offset_azimuth_deg)
        yield Stick(row, mark.north_m, mark.east_m, -north_m, -east_m)


def _places(answer: Answer, fix: Fix) -> Iterator[ScenePlace]:
    if not isinstance(fix.position, Position):
        for number, other in enumerate(fix.alternatives, 2):
            if isinstance(other.position, PlanePosition) and isinstance(fix.position, PlanePosition):
                north_m, east_m = other.position.north_m, other.position.east_m
                caption = f"place {number}"
                yield ScenePlace("alternative", caption, north_m - fix.position.north_m, east_m - fix.position.east_m)
        return
    plane = LocalPlane(fix.position)
    for kind, caption, position in _other_positions(answer, fix):
        north_m, east_m = (float(metres) for metres in plane.to_plane(position))
        yield ScenePlace(kind, caption, north_m, east_m)


def _other_positions(answer: Answer, fix: Fix) -> Iterator[tuple[PlaceKind, str, Position]]:
    if answer.truth is not None:
        yield "truth", "truth", answer.truth.position
    if answer.plain_mean is not None:
        yield "plain_mean", "plain mean", answer.plain_mean.position
    if answer.gnss is not None and answer.gnss.verdict != "not_available":
        yield "gnss", f"GNSS {answer.gnss.verdict}", answer.gnss.position
    found = fix.association
    for number, other in enumerate((*(() if found is None else found.alternatives), *fix.alternatives), 2):
        if isinstance(other.position, Position):
            yield "alternative", f"place {number}", other.position
