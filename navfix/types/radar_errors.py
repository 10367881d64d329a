"""What is wrong with the radar as a whole: an estimate of its clock and of its ranges, and what is taken off."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CommonError:
    """An error common to many observations: value and 1 sigma, in its own unit (s or m).

    ``separable`` is the share of its information that the other unknowns leave, 0 .. 1; ``marks`` how many marks carry
    it (a number that counts uneven shares less) and ``fixes`` how many fixes were fed; ``observable`` whether the
    estimate says anything; ``significant`` whether it is told from zero; ``reason`` why it is not used, if not.
    ``applied`` is what is taken off.
    """

    value: float
    sigma: float
    separable: float
    marks: float
    fixes: int
    observable: bool
    significant: bool
    reason: str | None = None
    applied: float = 0.0


@dataclass(frozen=True, slots=True)
class RadarErrors:
    """Radar clock minus AIS clock [s] and what the radar measures too much [m], over the last minutes."""

    clock: CommonError
    ranges: CommonError
