"""AIS against radar over time: whose position radar does not confirm, by how much, and how surely."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from datetime import datetime

import numpy as np

from navfix.integrity.drift import ErrorModel
from navfix.integrity.elsewhere import Elsewhere, find_elsewhere
from navfix.integrity.sightings import Sighting, echoes, offsets, sightings
from navfix.types import Fix, FloatArray, Mark, Position, ShipVeracity, VeracityStatus

_ORDER: tuple[VeracityStatus, ...] = ("disagrees", "elsewhere", "no_echo", "agrees", "too_little")


@dataclass(frozen=True, slots=True)
class VeracitySettings:
    """What counts as an accusation.

    Attributes
    ----------
    significance : probability that any true AIS at all is called false (it is shared among the ships)
    fewest : epochs below which nothing is said
    large_m, near_share : a ship of this length, within this share of the range of the farthest echo, must have an echo
    missing_share : of the epochs with an expected echo, from which on a ship has none
    by_chance : probability of chance up to which a missing or another echo counts: radars do not track every echo, and
        ships in a lane keep their distance from each other
    beside_m : another echo so near may be that of this ship too: then none is missing
    """

    significance: float = 1e-3
    fewest: int = 5
    large_m: float = 60.0
    near_share: float = 0.5
    missing_share: float = 0.8
    by_chance: float = 0.1
    beside_m: float = 300.0
    model: ErrorModel = field(default_factory=ErrorModel)


@dataclass(slots=True)
class _Record:
    """Running sums of one station."""

    mark: Mark
    epochs: int = 0
    seen: int = 0
    expected: int = 0
    missing: int = 0
    offset_m: FloatArray = field(default_factory=lambda: np.zeros(2))
    steady_m2: FloatArray = field(default_factory=lambda: np.zeros((2, 2)))
    fresh_m2: FloatArray = field(default_factory=lambda: np.zeros((2, 2)))
    velocity_mps: FloatArray = field(default_factory=lambda: np.zeros(2))
    first_s: float | None = None
    last_s: float | None = None
    tracks: dict[str, Elsewhere] = field(default_factory=dict)


class AisVeracity:
    """Gathers what radar says about each AIS station; reads no clock: times come with the fixes.

    Everything is relative to the fix, which rests on the AIS positions that agree with each other: a shift that most of
    them share is not seen here (see the GNSS verdict on what can show it).
    """

    def __init__(self, settings: VeracitySettings | None = None) -> None:
        self._settings = settings or VeracitySettings()
        self._records: dict[str, _Record] = {}

    def feed(self, fix: Fix, at: datetime | None = None) -> None:
        """Take the fix of one epoch in; ``at`` is its time, default that of its epoch.

        Raises
        ------
        InputError : the fix does not carry its marks on earth
        """
        time = at or (None if fix.epoch is None else fix.epoch.time_utc)
        time_s = None if time is None else time.timestamp()
        paired = {s.mark.label: s for s in sightings(fix, self._settings.model)}
        self._unpaired(fix, paired, time_s)
        for sighting in paired.values():
            if sighting.mark.kind != "charted":
                self._add(sighting, time_s)

    def ships(self) -> tuple[ShipVeracity, ...]:
        """Return every station that was in radar range: those that radar contradicts first, the surest at the top."""
        rows = [self._judge(record) for record in self._records.values()]
        return tuple(sorted(rows, key=lambda r: (_ORDER.index(r.status), r.p_value or 0.0, -r.epochs, r.mark)))

    # ------------------------------------------------------------------------------------------------- taking it in

    def _record(self, mark: Mark) -> _Record:
        record = self._records.setdefault(str(mark.mmsi or mark.label), _Record(mark))
        record.mark = mark
        return record

    def _add(self, sighting: Sighting, time_s: float | None) -> None:
        record = self._record(sighting.mark)
        record.seen += 1
        record.offset_m = record.offset_m + sighting.offset_m
        record.steady_m2 = record.steady_m2 + sighting.steady_m2
        record.fresh_m2 = record.fresh_m2 + sighting.fresh_m2
        record.velocity_mps = record.velocity_mps + _velocity(sighting.mark)
        record.first_s = time_s if record.first_s is None else record.first_s
        record.last_s = time_s

    def _unpaired(self, fix: Fix, paired: dict[str, Sighting], time_s: float | None) -> None:
        """Count what had to be seen, and follow the echoes without a mark about the marks without an echo."""
        assert fix.epoch is not None
        if not fix.epoch.targets:
            return
        targets, taken = list(fix.epoch.targets), {s.target for s in paired.values()}
        echo_m = echoes(fix, targets)
        reach_m = float(np.max(np.hypot(*echo_m.T)))
        marks = [mark for mark in fix.epoch.marks if mark.kind != "charted"]
        for mark, place in zip(marks, offsets(fix, marks), strict=True):
            distance_m = float(np.hypot(*place))
            if distance_m > reach_m:
                continue
            record = self._record(mark)
            record.epochs += 1
            apart_m = np.hypot(*(echo_m - place).T)
            lonely = mark.label not in paired
            if self._must_be_seen(mark, distance_m, reach_m) and not (
                lonely and np.any(apart_m < self._settings.beside_m)
            ):
                record.expected += 1
                record.missing += lonely
            if lonely:
                free = [i for i, target in enumerate(targets) if target.label not in taken]
                self._follow(record, fix, place, [(targets[i].label, echo_m[i]) for i in free], time_s)

    def _must_be_seen(self, mark: Mark, distance_m: float, reach_m: float) -> bool:
        large = mark.hull is not None and mark.hull.length_m >= self._settings.large_m
        return large and distance_m <= self._settings.near_share * reach_m

    def _follow(
        self, record: _Record, fix: Fix, place: FloatArray, free: list[tuple[str, FloatArray]], time_s: float | None
    ) -> None:
        assert isinstance(fix.position, Position)
        for label, echo in free:
            if np.hypot(*(echo - place)) <= Elsewhere.farthest_m:
                track = record.tracks.setdefault(label, Elsewhere(label))
                track.add(record.mark.position, echo - place, float(np.hypot(*echo)), time_s)

    # ------------------------------------------------------------------------------------------------------ judging

    def _judge(self, record: _Record) -> ShipVeracity:
        s = self._settings
        if record.seen >= s.fewest:
            return self._judge_seen(record)
        velocity = _velocity(record.mark)
        others = [_velocity(r.mark) for r in self._records.values() if r is not record]
        other = find_elsewhere(record.tracks.values(), s.fewest, velocity, np.array(others).reshape(-1, 2))
        never_seen = record.seen == 0  # an echo where the AIS says, even once, speaks for the AIS
        if other is not None and never_seen and other.chance <= s.by_chance and self._claims(other.label) == 1:
            row = _row(record, "elsewhere", other.offset_m, other.covariance_m2, other.label, other.in_words)
            return replace(row, p_value=other.chance)
        hint = "" if other is None else f"; {other.in_words}"
        if not self._without_echo(record):
            return _row(record, "too_little")
        chance, of = self._share_without_echo(record)
        if chance <= s.by_chance:
            return replace(_row(record, "no_echo", note=f"large, near, and no echo there{hint}"), p_value=chance)
        return _row(record, "too_little", note=f"no echo, like {chance:.0%} of the {of} other large ships near{hint}")

    def _without_echo(self, record: _Record) -> bool:
        s = self._settings
        return record.expected >= s.fewest and record.missing >= s.missing_share * record.expected

    def _share_without_echo(self, record: _Record) -> tuple[float, int]:
        """Return the share of the other large ships near that have no echo either (Laplace), and their number."""
        others = [r for r in self._records.values() if r is not record and r.expected >= self._settings.fewest]
        return (sum(self._without_echo(r) for r in others) + 1.0) / (len(others) + 2.0), len(others)

    def _claims(self, label: str) -> int:
        """Return how many ships without an echo an echo keeps its distance from."""
        lonely = [r for r in self._records.values() if r.seen < self._settings.fewest and label in r.tracks]
        nothing = np.zeros((0, 2))
        fewest = self._settings.fewest
        return sum(find_elsewhere([r.tracks[label]], fewest, np.zeros(2), nothing) is not None for r in lonely)

    def _judge_seen(self, record: _Record) -> ShipVeracity:
        offset, covariance = record.offset_m / record.seen, self._covariance(record)
        ships = sum(r.seen >= self._settings.fewest for r in self._records.values())
        false = _p_value(offset, covariance) * ships < self._settings.significance
        note = _along_course(offset, covariance, record.velocity_mps / record.seen) if false else ""
        return _row(record, "disagrees" if false else "agrees", offset, covariance, None, note)

    def _covariance(self, record: _Record) -> FloatArray:
        """Eq. (7.12): what stays, and the rest divided by the number of independent looks."""
        looks = float(record.seen)
        if record.first_s is not None and record.last_s is not None:
            looks = min(looks, 1.0 + (record.last_s - record.first_s) / (2.0 * self._settings.model.memory_s))
        return record.steady_m2 / record.seen + record.fresh_m2 / record.seen / max(looks, 1.0)


def _velocity(mark: Mark) -> FloatArray:
    if mark.speed_mps is None or mark.course_deg is None:
        return np.zeros(2)
    course_rad = math.radians(mark.course_deg)
    return mark.speed_mps * np.array([math.cos(course_rad), math.sin(course_rad)])


def _p_value(offset: FloatArray, covariance: FloatArray) -> float:
    return math.exp(-0.5 * float(offset @ np.linalg.solve(covariance, offset)))


def _along_course(offset: FloatArray, covariance: FloatArray, velocity: FloatArray) -> str:
    """Say what an offset along the ship's own course looks like: a report of another time."""
    speed = float(np.hypot(*velocity))
    if speed < 1.0:
        return ""
    course = velocity / speed
    along, across = float(offset @ course), float(offset @ [-course[1], course[0]])
    sigma_across = math.sqrt(float(np.array([-course[1], course[0]]) @ covariance @ [-course[1], course[0]]))
    if abs(across) > 2.0 * sigma_across or abs(along) < 2.0 * abs(across):
        return ""
    return f"along its course: as if its reports were {abs(along) / speed:.0f} s {'late' if along > 0.0 else 'early'}"


def _row(
    record: _Record,
    status: VeracityStatus,
    offset: FloatArray | None = None,
    covariance: FloatArray | None = None,
    target: str | None = None,
    note: str = "",
) -> ShipVeracity:
    mark = record.mark
    offset_m = azimuth_deg = sigma_m = p_value = None
    if offset is not None and covariance is not None:
        offset_m, azimuth_deg = float(np.hypot(*offset)), math.degrees(math.atan2(offset[1], offset[0])) % 360.0
        along = offset / max(offset_m, 1e-9)
        sigma_m = math.sqrt(max(float(along @ covariance @ along), 0.0))
        p_value = _p_value(offset, covariance)
    return ShipVeracity(
        mark=mark.label,
        mmsi=mark.mmsi,
        name=mark.name,
        status=status,
        epochs=max(record.epochs, record.seen),
        seen=record.seen,
        expected=record.expected,
        missing=record.missing,
        offset_m=offset_m,
        azimuth_deg=azimuth_deg,
        sigma_m=sigma_m,
        p_value=p_value,
        target=target,
        note=note,
    )
