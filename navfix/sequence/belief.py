"""What is believed: which place is accepted, which held one is contradicted, and what a former place still counts."""

from __future__ import annotations

import math
from dataclasses import replace

from navfix.catalog import NavigatorModel
from navfix.sequence.acceptance import Acceptance, Blind
from navfix.sequence.bank import Bank, Hypothesis
from navfix.sequence.doubt import Former, Standing, against, by_lead
from navfix.sequence.places import Place
from navfix.sequence.track import Track

NOTHING_SEEN = "cold: nothing has been seen yet"


class Belief:
    """Accepts, keeps and gives up places; ``reason`` says in words why there is none."""

    def __init__(self, model: NavigatorModel) -> None:
        self._model = model
        self.bank = Bank(model)
        self.acceptance = Acceptance(model)
        self.reason = NOTHING_SEEN
        self.believed: list[Hypothesis] = []
        self.former: Former | None = None
        self._barred_until_s = self._jumped_s = -math.inf

    @property
    def best_score(self) -> float | None:
        """The score over minutes of the best place, None without any."""
        return self.bank.hypotheses[0].score if self.bank.hypotheses else None

    def decide(
        self, track: Track | None, now_s: float, *, solved: bool, fed: bool, plain: Blind | None = None
    ) -> Track | None:
        """Return the track to go on with, None where no place is held.

        Parameters
        ----------
        solved, fed : whether a blind solve was made now, whether the bank was fed now
        plain : the blind solve of now that leaves no doubt, if there is one
        """
        self._follow_former(now_s)
        if solved or fed:
            self.believed = self.acceptance.accepted(self.bank)
        self.believed = [
            h for h in self.believed if h.place.carried(now_s, self._model).sigma_m <= self._model.lost_m
        ]  # what was believed before a gap is nowhere after it
        if track is None:
            return self._accept(now_s, plain)
        track.lose_at(now_s)
        contradicted = self._contradicted(now_s, track.place_at(now_s), fed=fed)
        if fed:
            self._weigh(track, now_s)
        self._confirm(track, now_s)
        ended = track.given_up or (track.standing.given_up(now_s) if track.proven else "")
        if ended:
            self._end(track, now_s, ended)
            return self._accept(now_s, plain)
        if contradicted:
            self._end(track, now_s, "conflict: another place is believed as well as the one that was held")
            self._barred_until_s = now_s + (self._model.conflict_hold_s if track.proven else 0.0)
            return None
        return track

    def jumped(self, track: Track | None, now_s: float, by_m: float) -> None:
        """End a track because most AIS jumped alike: either all were shifted now, or had been before.

        Without a track the place that was given out last is met within half of the jump, too.
        """
        self._jumped_s = now_s
        if track is None:
            if self.former is not None:
                self.former = replace(self.former, within_m=min(self.former.within_m, 0.5 * by_m))
            return
        reason = f"conflict: the AIS positions of most ships have jumped by the same {by_m:.0f} m"
        self._end(track, now_s, reason, within_m=0.5 * by_m)
        self._barred_until_s = now_s + (self._model.conflict_hold_s if track.proven else 0.0)

    # ------------------------------------------------------------------------------------------------ a held place

    def _contradicted(self, now_s: float, place: Place, *, fed: bool) -> bool:
        """Tell whether only another place is believed, a blind solve of now is sure of one, or the bank far ahead."""
        model = self._model
        elsewhere = self.elsewhere(place, now_s)
        if elsewhere and len(elsewhere) == len(self.believed):
            return True
        sure = [blind for blind in self.acceptance.ended_at(now_s) if self.acceptance.sure(blind)]
        if any(place.differs(blind.place, model.apart_m, model.apart_deg) for blind in sure):
            return True
        if not fed or not self.bank.hypotheses:
            return False
        best, here = self.bank.hypotheses[0], self.bank.near(place)
        behind = best.score - here.score if here is not None else math.inf
        return best.score > model.least_score + model.give_up_behind and behind > model.give_up_behind

    def _weigh(self, track: Track, now_s: float) -> None:
        """Tell the track how it stands in the bank. A place that the bank does not hold is behind the best there."""
        place = track.place_at(now_s)
        here = self.bank.near(place)
        contested = bool(self.elsewhere(place, now_s))
        if here is not None:
            track.standing.note_lead(self.bank.rival_ahead(here), contested=contested)
        elif self.best_score is not None and self.best_score > self._model.least_score:
            track.standing.note_lead(-self.best_score, contested=contested)

    def _confirm(self, track: Track, now_s: float) -> None:
        """Note whether what knows nothing of the track has found it: a blind solve of now, or a believed place."""
        model, place = self._model, track.place_at(now_s)
        if any(self.acceptance.fair(b) and track.agrees(b.place) for b in self.acceptance.ended_at(now_s)):
            track.standing.confirm(now_s)
        if any(h.place.carried(now_s, model).distance_m(place) <= model.same_m for h in self.believed):
            track.proven = True

    def _end(self, track: Track, now_s: float, reason: str, within_m: float = math.inf) -> None:
        """End a track: what was given out stays in mind, and nothing is given out now."""
        self.reason = reason if not reason.startswith("conflict") else f"{reason}; none is given out"
        if track.standing.stated is not None and not track.lost:
            self.former = Former(track.place_at(now_s), track.standing.stated, now_s, within_m)

    def elsewhere(self, place: Place, now_s: float) -> list[Hypothesis]:
        """Return the believed places that are not this one."""
        model = self._model
        return [
            h for h in self.believed if h.place.carried(now_s, model).differs(place, model.apart_m, model.apart_deg)
        ]

    # ------------------------------------------------------------------------------------------------ a new place

    def _accept(self, now_s: float, plain: Blind | None) -> Track | None:
        """Return a track at the place that is believed, None where there is none, or two, or a former one bars it."""
        if now_s < self._barred_until_s:
            return None
        if plain is not None:
            if self.elsewhere(plain.place, now_s):
                self.reason = "conflict: one window leaves no doubt, and minutes speak for another place"
                return None
            return self._begin(plain.place, min(plain.evidence, plain.margin), now_s)
        if len(self.believed) == 1:
            best = self.believed[0]
            return self._begin(best.place.carried(now_s, self._model), self.bank.rival_ahead(best), now_s)
        if len(self.believed) > 1:
            self.reason = f"conflict: {len(self.believed)} places are believed at once, so none is given out"
        else:
            self.reason = self._why_cold()
        return None

    def _begin(self, place: Place, lead: float, now_s: float) -> Track | None:
        """Return a track at a place, None while a former place that was given out speaks against it."""
        model, former = self._model, self.former
        if former is not None and (former.agrees(place, model) or self._older(place, former)):
            self.former = former = None
        if former is not None:
            doubt = against(by_lead(lead, model), former.doubt_at(now_s, model))
            if doubt > model.most_doubt:
                self.reason = (
                    f"conflict: another place was given out {now_s - former.ended_s:.0f} s ago, and all AIS may have "
                    f"jumped since; that this one is wrong has a probability of {doubt:.2f}"
                )
                return None
        return Track(place, model, now_s, standing=Standing(model, now_s, lead, former), yaw=self.bank.yaw)

    def _older(self, place: Place, former: Former) -> bool:
        """Tell whether a place was followed long before another ended: then it is no jump of AIS; its lead counts.

        After a jump told from the reports nothing is older: whatever was followed before has jumped with the AIS.
        """
        if math.isfinite(former.within_m):
            return False
        here = self.bank.near(place)
        followed_s = 0.0 if here is None else here.windows * self._model.bank_every_s
        return followed_s >= place.time_s - former.ended_s + self._model.older_s

    def _follow_former(self, now_s: float) -> None:
        """Move a former place along with own ship, as the best place of the bank tells her motion.

        Where the bank's window holds a jump of all AIS its velocity is that of the jump: then the former place goes on
        by its own, turned as own ship was seen to turn.
        """
        if self.former is None:
            return
        velocity_mps = self.former.place.velocity_turned(now_s)
        if self.bank.hypotheses:
            best = self.bank.hypotheses[0].place
            if best.time_s - self._model.bank_every_s >= self._jumped_s:
                velocity_mps = best.velocity_mps
        self.former = self.former.moved(now_s, velocity_mps, self._model)

    def _why_cold(self) -> str:
        if not self.bank.hypotheses:
            return "cold: no place explains the tracks better than chance so far"
        best = self.bank.hypotheses[0]
        ahead = f"ahead by {self.bank.ahead:.1f}" if math.isfinite(self.bank.ahead) else "with no other beside it"
        return (
            f"cold: the best place has a score of {best.score:.1f}, {ahead}, and {best.marks} marks; "
            "it must be found again without shared data, or prove itself at once"
        )
