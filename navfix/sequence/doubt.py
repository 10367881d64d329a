"""How likely a held place is wrong: by its lead over the strongest rival, and by how long ago it was last confirmed.

The lead is in nats of the bank, over the best other place that is kept alive. A confirmation is a solve that knew
nothing of the track and found it. The figures are counted on negative controls and are upper
bounds: eq. (14.3) of the theory.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from navfix.catalog import NavigatorModel
from navfix.sequence.places import Place

NOT_CHECKED = (
    "a shift of all AIS positions alike from the first scan on",
    "AIS positions that are false in a way that fits every echo",
)


def by_lead(lead: float, model: NavigatorModel) -> float:
    """Return the probability that a place with this lead [nats] is wrong, just confirmed: eq. (14.3)."""
    falling = model.doubt_accepted * math.exp(-model.doubt_per_nat * (lead - model.least_ahead))
    return min(max(model.doubt_reached, falling), 1.0)


def aged(probability: float, age_s: float, rate_per_hour: float) -> float:
    """Return a probability of being wrong after ``age_s`` in which nothing confirmed the place: eq. (14.3)."""
    return probability - (1.0 - probability) * math.expm1(-rate_per_hour * max(age_s, 0.0) / 3600.0)


def against(probability: float, former: float) -> float:
    """Return the probability that a place is wrong beside another that had ``former``: one of them is. Eq. (14.4)."""
    wrong, right = probability * (1.0 - former), former * (1.0 - probability)
    return wrong / (wrong + right) if wrong + right > 0.0 else 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Former:
    """A place that was given out and has ended: ``doubt`` is the probability of being wrong that was stated last.

    Only what lies ``within_m`` of it is taken for the same place: after a jump of all AIS half of its size.
    """

    place: Place
    doubt: float
    ended_s: float
    within_m: float = math.inf

    def doubt_at(self, now_s: float, model: NavigatorModel) -> float:
        """Return how likely it was wrong, as far as it still counts: its memory fades with ``former_s``."""
        return aged(self.doubt, now_s - self.ended_s, 3600.0 / model.former_s)

    def moved(self, now_s: float, velocity_mps: complex, model: NavigatorModel) -> Former:
        """Return it moved along as own ship does: if all AIS have jumped, own ship still lies as far from them."""
        return replace(self, place=replace(self.place, velocity_mps=velocity_mps).carried(now_s, model))

    def agrees(self, place: Place, model: NavigatorModel) -> bool:
        """Tell whether another place is this one some time later."""
        within_m = min(model.apart_m, self.within_m)
        return not self.place.carried(place.time_s, model).differs(place, within_m, model.apart_deg)


class Standing:
    """What is known of the trust in one track: its lead, its last confirmation, and a place given out before it."""

    def __init__(self, model: NavigatorModel, now_s: float, lead: float = 0.0, former: Former | None = None) -> None:
        self._model = model
        self.lead = lead
        self._former = former
        self.confirmed_s = now_s
        self.outdone = False
        self.stated: float | None = None
        self._quiet_since_s = now_s

    def confirm(self, now_s: float) -> None:
        """A solve that knows nothing of the track has found it."""
        self.confirmed_s = max(self.confirmed_s, now_s)

    def note_lead(self, ahead: float, *, contested: bool = False) -> None:
        """Take the bank's view of the place: by how much it is ahead of every rival [nats].

        A place that another overtakes is outdone until its lead is clear again.
        """
        self.lead = ahead
        if ahead < 0.0 or contested:
            self.outdone = True
        elif ahead >= self._model.least_ahead:
            self.outdone = False

    def probability_wrong(self, now_s: float) -> float:
        """Return the probability that the place is wrong: eq. (14.3), beside a former place eq. (14.4)."""
        alone = aged(by_lead(self.lead, self._model), now_s - self.confirmed_s, self._model.doubt_per_hour)
        if self._former is None:
            return alone
        return max(alone, against(alone, self._former.doubt_at(now_s, self._model)))

    def why_silent(self, now_s: float) -> str:
        """Return why the place is not given out now, "" where nothing is against it."""
        if self.outdone:
            return "lapsed: another place explains the minutes as well as the one that is held"
        probability = self.probability_wrong(now_s)
        if probability > self._model.most_doubt:
            return (
                f"lapsed: the place may be wrong with a probability of {probability:.2f}; no solve without it "
                f"has found it for {now_s - self.confirmed_s:.0f} s"
            )
        return ""

    def given_up(self, now_s: float) -> str:
        """Return why the place ends, "" while it may come back: it was not given out for too long."""
        if not self.why_silent(now_s):
            self._quiet_since_s = now_s
            return ""
        quiet_s = now_s - self._quiet_since_s
        if quiet_s <= self._model.drop_after_s:
            return ""
        return f"given up: the place was in doubt for {quiet_s:.0f} s"
