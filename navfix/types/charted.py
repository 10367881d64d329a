"""What a chart says about AIS aids to navigation, and which of the data at hand are used."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class OffStation:
    """An aid whose AIS position is not its charted place: how far off [m] and in which direction [deg].

    ``flagged``: the aid says itself that it is off position.
    """

    mmsi: int
    name: str | None
    charted: str
    distance_m: float
    azimuth_deg: float
    flagged: bool = False


@dataclass(frozen=True, slots=True)
class ChartCheck:
    """Charted marks against the aids that AIS shows at one instant.

    ``charted`` marks in all files, ``in_reach`` of radar about the AIS picture; ``added`` of them as marks that AIS
    does not show. ``confirmed`` aids (MMSI) lie at their charted place and are one mark with it; ``off_station`` ones
    are left out; ``not_charted`` ones are kept as AIS gives them. ``shift_m`` along ``shift_azimuth_deg`` leads from
    the charted places to AIS where several aids are off station by one vector; None where they are not.
    """

    charted: int
    in_reach: int
    added: int
    confirmed: tuple[int, ...] = ()
    off_station: tuple[OffStation, ...] = ()
    not_charted: tuple[int, ...] = ()
    shift_m: float | None = None
    shift_azimuth_deg: float | None = None


Filter = Literal["newest", "aids", "standing"]
Decision = Literal["all", "source", "none"]


@dataclass(frozen=True, slots=True)
class MethodChoice:
    """Which data a fix is made from, decided by what is there.

    ``ships``, ``own_speed``, ``three_aids``: what was found. ``source`` and ``filters``: what the decision table of the
    source takes then. ``decision``: "all" marks and targets together, the "source" table's choice, or "none".
    """

    ships: bool
    own_speed: bool
    three_aids: bool
    source: str
    filters: tuple[Filter, ...]
    decision: Decision
    reason: str
