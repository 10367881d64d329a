"""What is said of others: the verdict on the GNSS of the log, and the veracity of AIS stations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from navfix.types.places import Position

Verdict = Literal["ok", "caution", "unsafe", "not_available"]


@dataclass(frozen=True, slots=True)
class GnssVerdict:
    """The GNSS of the log against the fix: what was found, how far apart, and what could have been seen at all.

    Where epochs were followed, ``verdict`` is the lasting one and ``instant`` that of this epoch alone; ``alert`` is
    the sentence of a change, once; ``drift_mps`` the rate at which GNSS leaves the fix. None for a single epoch.
    """

    position: Position
    distance_m: float
    verdict: Verdict
    threshold_m: float
    smallest_detectable_m: float
    reasons: tuple[str, ...]
    instant: Verdict | None = None
    alert: str | None = None
    drift_mps: float | None = None


VeracityStatus = Literal["agrees", "disagrees", "no_echo", "elsewhere", "too_little"]


@dataclass(frozen=True, slots=True)
class ShipVeracity:
    """One AIS station against radar, over all epochs that were fed.

    ``offset_m`` and ``azimuth_deg`` say where radar sees it from where its AIS says it is, ``sigma_m`` how well that is
    known along this direction, ``p_value`` how often a true AIS would give as much; None where no echo belongs to it.
    ``seen`` counts the epochs with an echo, ``expected`` those in which one had to be seen, ``missing`` those of them
    without; ``target`` is the echo that lies elsewhere.
    """

    mark: str
    mmsi: int | None
    name: str | None
    status: VeracityStatus
    epochs: int
    seen: int
    expected: int
    missing: int
    offset_m: float | None = None
    azimuth_deg: float | None = None
    sigma_m: float | None = None
    p_value: float | None = None
    target: str | None = None
    note: str = ""
