"""When a place is believed: blind evidence, found again without shared data, and ahead of every rival over minutes."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from navfix.association.window import gyro
from navfix.association.window.joint import Joint
from navfix.catalog import NavigatorModel
from navfix.sequence.bank import Bank, Hypothesis, places_of
from navfix.sequence.places import Place


@dataclass(frozen=True, eq=False)
class Blind:
    """The best answer of one blind solve: its data are of ``begin_s`` .. ``end_s`` [POSIX s].

    ``margin`` is what is left of the lead if the compass, where there is one, is wrong.
    """

    begin_s: float
    end_s: float
    place: Place
    evidence: float
    margin: float
    marks: int


def blind_of(found: Joint, window_s: float) -> Blind | None:
    """Return the best answer of a blind solve, None where there is none."""
    if not len(found.answers):
        return None
    best = found.answers.take(np.array([0]))
    place = places_of(found.window, best.knots, best.information)[0]
    margin = found.answers.margin - gyro.price(found.window)
    return Blind(place.time_s - window_s, place.time_s, place, float(best.evidence[0]), margin, int(best.marks[0]))


class Acceptance:
    """Remembers blind solves and tells which place may be believed."""

    def __init__(self, model: NavigatorModel) -> None:
        self._model = model
        self._blind: deque[Blind] = deque()
        self._carried_s = -np.inf
        self._carried: dict[Place, Place] = {}

    def note(self, blind: Blind | None) -> None:
        """Take a blind solve in; those older than the memory are forgotten."""
        if blind is None:
            return
        self._blind.append(blind)
        while blind.end_s - self._blind[0].end_s > self._model.memory_s:
            self._blind.popleft()

    def ended_at(self, now_s: float) -> list[Blind]:
        """Return the blind solves of all lengths whose data end now."""
        return [blind for blind in self._blind if blind.end_s == now_s]

    def plain(self, blind: Blind) -> bool:
        """Tell whether a blind solve leaves no doubt: so many marks agree that nothing else needs to be known."""
        model = self._model
        return (
            blind.evidence >= model.plain_evidence
            and blind.margin >= model.plain_margin
            and blind.marks >= model.plain_marks
        )

    def sure(self, blind: Blind) -> bool:
        """Tell whether one blind solve is enough by itself."""
        model = self._model
        return (
            blind.evidence >= model.sure_evidence
            and blind.margin >= model.sure_margin
            and blind.marks >= model.sure_marks
        )

    def fair(self, blind: Blind) -> bool:
        """Tell whether a blind solve counts as a finding: twice without shared data is enough."""
        model = self._model
        return (
            blind.evidence >= model.again_evidence
            and blind.margin >= model.again_margin
            and blind.marks >= model.again_marks
        )

    def accepted(self, bank: Bank) -> list[Hypothesis]:
        """Return the places of the bank that may be believed: none, one, or several (which means none).

        Several are those that would be believed were it not for each other: neither is clearly ahead.
        """
        found = [h for h in bank.hypotheses if h.score >= self._model.least_score and self._needed_lead(h) is not None]
        ahead = [h for h in found if bank.rival_ahead(h) >= (self._needed_lead(h) or 0.0)]
        if ahead:
            return ahead
        close = [h for h in found if bank.rival_ahead(h) > -self._model.least_ahead]
        return close if any(self._apart(one, other) for one in close for other in close) else []

    def _needed_lead(self, h: Hypothesis) -> float | None:
        """Return the lead [nats] with which a place is believed, None where no blind solves have found it."""
        model = self._model
        here = [b for b in self._blind if self._agrees(b.place, h.place)]
        if any(self.sure(b) for b in here if b.end_s >= h.place.time_s - model.bank_every_s):
            return model.least_ahead + h.compass_price
        findings = [b for b in here if self.fair(b)]
        twice = any(later.begin_s >= earlier.end_s for earlier in findings for later in findings)
        return max(model.least_ahead, model.again_ahead) + h.compass_price if twice else None

    def _apart(self, one: Hypothesis, other: Hypothesis) -> bool:
        return one.place.differs(other.place, self._model.same_m, self._model.apart_deg)

    def _agrees(self, earlier: Place, place: Place) -> bool:
        """Tell whether two places are one, the earlier carried to the time of the other."""
        model = self._model
        after_s = place.time_s - earlier.time_s
        near_m = model.same_m + model.gap_mps * abs(after_s)
        return self._at(place.time_s, earlier).distance_m(place) <= near_m

    def _at(self, time_s: float, earlier: Place) -> Place:
        """Return a place carried to an instant: that of all hypotheses, so that once is enough for each."""
        if time_s != self._carried_s:
            self._carried_s, self._carried = time_s, {}
        if earlier not in self._carried:
            self._carried[earlier] = earlier.carried(time_s, self._model)
        return self._carried[earlier]
