"""Charted marks beside AIS: those in reach join the picture, and AIS aids are confirmed or refuted by them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from navfix.catalog import AisModel, ChartModel, ais_model, chart_model
from navfix.geodesy import ecef, inverse
from navfix.nmea.records import AisPosition
from navfix.types import ChartCheck, FloatArray, Mark, OffStation, Position

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

Aid = tuple[AisPosition, str | None]  # an AIS aid, and why it is no mark by itself (None where it is one)
VIRTUAL = "virtual aid to navigation"
OFF_POSITION = "aid off position"
OFF_STATION = "aid off station"
FEWEST_ALIKE, ALIKE_M = 2, 60.0  # aids off station by one vector, within what buoys swing
NAME_LETTERS = 4
AIS_NAME_LETTERS = 20  # type 21 cuts a name here unless it carries an extension


@dataclass(frozen=True, slots=True)
class Joined:
    """The marks of an epoch with the charted ones among them, who was left out and why, and the account."""

    marks: tuple[Mark, ...]
    left_out: dict[str, int]
    check: ChartCheck


@dataclass(frozen=True, slots=True)
class _Match:
    """An aid and the charted mark (index) that it is taken for; ``apart_m`` and the gate [m] that it would pass."""

    aid: Aid
    index: int
    apart_m: float
    gate_m: float
    by_name: bool

    @property
    def flagged(self) -> bool:
        return self.aid[1] == OFF_POSITION


class ChartedMarks:
    """The marks of the charts, ready to be asked for those near a place.

    Parameters
    ----------
    marks : of kind "charted"
    model : gates, by name in models/chart or as a record
    """

    def __init__(self, marks: Iterable[Mark], model: ChartModel | str = "aids") -> None:
        self.marks = tuple(marks)
        self._model = chart_model(model)

    def join(
        self,
        ais: Sequence[Mark],
        aids: Sequence[Aid],
        left_out: Mapping[str, int],
        reach_m: float,
    ) -> Joined:
        """Join the charted marks with those of AIS.

        Parameters
        ----------
        ais : marks of the AIS picture; without any, every charted mark takes part
        aids : AIS aids, also those that are no marks by themselves
        reach_m : how far radar sees now; a charted mark farther than twice this from an AIS mark is not seen with it
        """
        near = self._in_reach(ais, reach_m)
        matches = self._matches(aids)
        off = [m for m in matches if m.flagged or m.apart_m > m.gate_m]
        held = [m for m in matches if not m.flagged and m.apart_m <= m.gate_m]
        gone = {m.index for m in off if m.by_name or m.flagged}  # otherwise the charted mark may be in its place
        confirmed = {m.index: m.aid[0] for m in held}
        taken = {m.aid[0].mmsi for m in matches}
        added = [i for i in sorted(set(near) | set(confirmed)) if i not in gone]
        charted = [self.marks[i] if i not in confirmed else _confirmed(self.marks[i], confirmed[i]) for i in added]
        refuted = tuple(_off_station(m, self.marks[m.index]) for m in off)
        shift_m, shift_azimuth_deg = common_shift(refuted)
        check = ChartCheck(
            charted=len(self.marks),
            in_reach=len(set(near) | set(confirmed)),
            added=sum(i not in confirmed for i in added),
            confirmed=tuple(m.aid[0].mmsi for m in held),
            off_station=refuted,
            not_charted=tuple(aid.mmsi for aid, why in aids if why is None and aid.mmsi not in taken),
            shift_m=shift_m,
            shift_azimuth_deg=shift_azimuth_deg,
        )
        kept = [mark for mark in ais if mark.mmsi not in taken]
        return Joined((*kept, *charted), _recounted(left_out, held, off), check)

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self._places)

    @cached_property
    def _by_mmsi(self) -> dict[int, int]:
        return {mark.mmsi: i for i, mark in enumerate(self.marks) if mark.mmsi is not None}

    @cached_property
    def _places(self) -> FloatArray:
        return _ecef(self.marks)

    def _in_reach(self, ais: Sequence[Mark], reach_m: float) -> list[int]:
        """Return the charted marks near any AIS mark, eq. (C.4), the nearest ones if too many.

        Where AIS shows only a few, own ship may well be near none of them: then its own range is the limit.
        """
        if not ais or not self.marks:
            return list(range(len(self.marks)))
        from scipy.spatial import cKDTree

        distance_m, _ = cKDTree(_ecef(ais)).query(self._places)
        sparse = len(ais) < self._model.sparse_ais
        within_m = self._model.ais_range_m + reach_m if sparse else 2.0 * reach_m
        near = np.flatnonzero(distance_m <= within_m)
        order = near[np.argsort(distance_m[near], kind="stable")][: self._model.most_marks]
        return [int(i) for i in order]

    # ------------------------------------------------------------------------------- which charted mark an aid is

    def _matches(self, aids: Sequence[Aid]) -> list[_Match]:
        """Return the charted mark of every aid that has one, each mark once: by MMSI or name, else by place."""
        if not self.marks or not aids:
            return []
        candidates = [match for aid in aids for match in self._candidates(aid)]
        candidates.sort(key=lambda m: (not m.by_name, m.apart_m / m.gate_m))
        found: dict[int, _Match] = {}
        claimed: set[int] = set()
        for match in candidates:
            if match.index not in claimed and match.aid[0].mmsi not in found:
                found[match.aid[0].mmsi] = match
                claimed.add(match.index)
        return list(found.values())

    def _candidates(self, aid: Aid) -> list[_Match]:
        report, why = aid
        place, model = _position(report), self._model
        here = ecef(place.lat_deg, place.lon_deg)
        own = self._by_mmsi.get(report.mmsi)
        around = self._tree.query_ball_point(here, model.named_within_m) if own is None else [own]
        apart_m = np.linalg.norm(self._places[around] - here, axis=-1)  # the chord: within a millimetre at 3 NM
        matches = [self._match(aid, int(i), float(d)) for i, d in zip(around, apart_m, strict=True)]
        known = [m for m in matches if m.by_name]
        if why == VIRTUAL:  # nothing floats off station where nothing floats
            return [m for m in known or matches if m.apart_m <= m.gate_m]
        if known:
            return known
        nameless = [
            m
            for m in matches
            if m.apart_m <= max(m.gate_m, model.nameless_within_m) and self.marks[m.index].name is None
        ]
        return nameless + [m for m in matches if m.apart_m <= m.gate_m and self.marks[m.index].name is not None]

    def _match(self, aid: Aid, index: int, apart_m: float) -> _Match:
        mark, aton = self.marks[index], ais_model("aton")
        gate_m = self._model.gate_sigma * float(np.hypot(_aid_sigma(aid[0], aton), mark.sigma_m))
        same = (mark.mmsi is not None and mark.mmsi == aid[0].mmsi) or same_name(mark.name, aid[0].name)
        return _Match(aid, index, apart_m, gate_m, same)


def common_shift(off: Sequence[OffStation]) -> tuple[float, float] | tuple[None, None]:
    """Return distance [m] and azimuth [deg] of the vector by which aids are off station alike, None where not.

    Two or more that differ from their median by less than `ALIKE_M` are alike: a chart of another datum, or AIS
    positions that are shifted together. Buoys adrift go their own ways.
    """
    vectors = np.array(
        [aid.distance_m * np.exp(1j * np.radians(aid.azimuth_deg)) for aid in off if not aid.flagged], dtype=complex
    )
    if len(vectors) < FEWEST_ALIKE:
        return None, None
    middle = complex(np.median(vectors.real), np.median(vectors.imag))
    alike = np.abs(vectors - middle) <= ALIKE_M
    if alike.sum() < FEWEST_ALIKE or 2 * alike.sum() <= len(vectors):
        return None, None
    shift = complex(vectors[alike].mean())
    return abs(shift), float(np.degrees(np.angle(shift))) % 360.0


def same_name(charted: str | None, ais: str | None) -> bool:
    """Tell whether two names mean one aid: the same letters and digits, as far as AIS spells them.

    Less than `NAME_LETTERS` of them, such as a bare number, name an aid only within its own channel.
    """
    if not charted or not ais:
        return False
    one, other = ("".join(c for c in text.upper() if c.isalnum()) for text in (charted, ais))
    cut = len(ais.strip()) >= AIS_NAME_LETTERS - 1
    return len(other) >= NAME_LETTERS and (one == other or (cut and one.startswith(other)))


def _aid_sigma(report: AisPosition, model: AisModel) -> float:
    return model.accurate_sigma_m if report.accurate else model.default_sigma_m


def _confirmed(mark: Mark, report: AisPosition) -> Mark:
    """Return the charted mark with the identity that AIS adds. Its place stays the chart's: it vouches for AIS."""
    heard = None if report.time_s is None else datetime.fromtimestamp(report.time_s, UTC)
    return replace(mark, mmsi=report.mmsi, name=mark.name or report.name, time_utc=heard)


def _off_station(match: _Match, mark: Mark) -> OffStation:
    report = match.aid[0]
    distance_m, azimuth_deg, *_ = inverse(mark.position, _position(report))
    return OffStation(report.mmsi, report.name, mark.name or mark.label, distance_m, azimuth_deg % 360.0, match.flagged)


def _recounted(left_out: Mapping[str, int], held: Sequence[_Match], off: Sequence[_Match]) -> dict[str, int]:
    """Return who was left out: without the aids that the chart confirms, with those that it refutes."""
    counted = Counter(dict(left_out))
    counted.subtract(match.aid[1] for match in held if match.aid[1] is not None)
    counted[OFF_STATION] += sum(match.aid[1] is None for match in off)
    return {reason: count for reason, count in counted.items() if count > 0}


def _position(report: AisPosition) -> Position:
    assert report.lat_deg is not None  # `Traffic.aids` gives none without
    assert report.lon_deg is not None
    return Position(report.lat_deg, report.lon_deg)


def _ecef(marks: Sequence[Mark]) -> FloatArray:
    return ecef([m.position.lat_deg for m in marks], [m.position.lon_deg for m in marks]).reshape(-1, 3)
