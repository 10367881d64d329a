"""The navigator: from nothing to a place, and from scan to scan with it; no sockets, no clock, no threads.

Cold until a place is believed. Then at each step first a blind solve of the window where one is due; only where that
says nothing, a solve with a prior from data older than the window. A track whose own evidence sinks lapses into no fix;
another place that is believed ends it; two believed places are none.
"""

from __future__ import annotations

import math
from collections import deque
from datetime import datetime

import numpy as np

from navfix.association.window import joint
from navfix.association.window.joint import Joint, Window
from navfix.association.window.tracks import epoch_time
from navfix.catalog import NavigatorModel, WindowModel, navigator_model, window_model
from navfix.errors import InputError, TooFewPairs
from navfix.sequence.acceptance import Acceptance, Blind, blind_of
from navfix.sequence.bank import Bank, Hypothesis
from navfix.sequence.outcome import Outcome
from navfix.sequence.places import Place
from navfix.sequence.track import Held, Track
from navfix.types import Alternative, Epoch, TrackState, TrackStatus


class Navigator:
    """Feed it epochs in the order of time; ``step`` gives the outcome at the newest one.

    Parameters
    ----------
    model, window : constants of the navigator and of its windows, by name or record
    """

    def __init__(self, *, model: NavigatorModel | str = "default", window: WindowModel | str = "joint") -> None:
        self._model, self._window = navigator_model(model), window_model(window)
        self._epochs: deque[Epoch] = deque()
        self._bank = Bank(self._model)
        self._acceptance = Acceptance(self._model)
        self._track: Track | None = None
        self._conflict_until_s = -np.inf
        self._last_cold_s = self._last_bank_s = -np.inf
        self._believed: list[Hypothesis] = []
        self._plain: Blind | None = None
        self._reason = "cold: nothing has been seen yet"

    @property
    def bank(self) -> Bank:
        """The places that are kept alive."""
        return self._bank

    def alternatives(self) -> tuple[Alternative, ...]:
        """Return the places that are kept alive, best first; ``score`` is that over minutes."""
        return tuple(
            Alternative(h.place.position, h.place.heading_deg, h.score, h.marks) for h in self._bank.hypotheses[:10]
        )

    def start_at(self, place: Place) -> None:
        """Begin with a place from outside, such as an earlier fix: it is checked and not believed.

        No fix is given out before a solve that does not know it has found it too.
        """
        self._track = Track(place, self._model, place.time_s, proven=False)

    def follows(self, epoch: Epoch) -> bool:
        """Tell whether an epoch is no earlier than the newest: an earlier one is of another recording."""
        return not self._epochs or epoch_time(epoch) >= epoch_time(self._epochs[-1])

    def feed(self, epoch: Epoch) -> None:
        """Take one epoch in.

        Raises
        ------
        InputError : an epoch without a time, or one earlier than the one before
        """
        if epoch.time_utc is None:
            raise InputError("the navigator needs the time of every epoch; this one has none")
        now_s = epoch_time(epoch)
        if not self.follows(epoch):
            raise InputError(
                f"epoch of {epoch.time_utc:%H:%M:%S.%f} fed after one of {self._epochs[-1].time_utc:%H:%M:%S.%f}: "
                "epochs must come in the order of time; begin a new navigator for another log"
            )
        self._epochs.append(epoch)
        while now_s - epoch_time(self._epochs[0]) > self._model.kept_s:
            self._epochs.popleft()

    def step(self, at: datetime | None = None) -> Outcome:
        """Return the outcome at the newest epoch (``at``: no later than this; the caller's clock is not read)."""
        if not self._epochs or (at is not None and self._epochs[-1].time_utc > at):  # type: ignore[operator]
            return Outcome("cold", None, self._reason, TrackState("cold"))
        now_s = epoch_time(self._epochs[-1])
        blind = self._solve_blind(now_s)
        self._update_bank(now_s)
        self._decide(now_s)
        if self._track is None:
            status: TrackStatus = "conflict" if self._reason.startswith("conflict") else "cold"
            return Outcome(status, None, self._reason, TrackState(status, score=self._best_score()))
        held = self._hold(now_s, blind)
        return self._outcome(now_s, held)

    # ------------------------------------------------------------------------------------------------ blind solves

    def _solve_blind(self, now_s: float) -> Joint | None:
        """Solve the window with nothing known beforehand, where one is due."""
        waiting = self._track is not None or self._span_s(now_s) > self._model.cold_every_s
        if waiting and now_s - self._last_cold_s < self._model.cold_every_s - 0.1:
            return None
        window = self._prepare(now_s, self._model.window_s)
        if window is None:
            return None
        self._last_cold_s = now_s
        found = joint.cold(window)
        best = blind_of(found, min(self._model.window_s, self._span_s(now_s)))
        self._acceptance.note(best)
        self._plain = best if best is not None and self._acceptance.plain(best) else None
        return found

    def _prepare(self, now_s: float, length_s: float) -> Window | None:
        """Make the window of the last ``length_s`` seconds ready, None where it holds too little."""
        epochs = [epoch for epoch in self._epochs if epoch_time(epoch) > now_s - length_s]
        if not epochs:
            return None
        try:
            return joint.prepare(epochs, self._window)
        except TooFewPairs:
            return None

    def _span_s(self, now_s: float) -> float:
        return now_s - epoch_time(self._epochs[0])

    # ------------------------------------------------------------------------------------------------ belief

    def _update_bank(self, now_s: float) -> None:
        """Every half minute: carry all places over the data since, and let blind solves propose new ones."""
        model = self._model
        if now_s - self._last_bank_s < model.bank_every_s - 0.1:
            return
        since_s = (
            min(now_s - self._last_bank_s, model.bank_every_s) if np.isfinite(self._last_bank_s) else model.bank_every_s
        )
        if self._span_s(now_s) < min(model.birth_windows_s) - 3.0:
            return
        window = self._prepare(now_s, since_s)
        if window is None:
            return
        self._last_bank_s = now_s
        births = []
        for length_s in model.birth_windows_s:
            if self._span_s(now_s) >= length_s - 3.0:
                whole = window if abs(length_s - since_s) < 1.0 else self._prepare(now_s, length_s)
                if whole is not None:
                    births.append(joint.cold(whole))
                    self._acceptance.note(blind_of(births[-1], length_s))
        self._bank.feed(window, births)

    def _best_score(self) -> float | None:
        return self._bank.hypotheses[0].score if self._bank.hypotheses else None

    def _decide(self, now_s: float) -> None:
        """Accept, keep or give up a place."""
        if self._last_bank_s == now_s or self._last_cold_s == now_s:
            self._believed = self._acceptance.accepted(self._bank)
        believed = self._believed = [
            h for h in self._believed if h.place.carried(now_s, self._model).sigma_m <= self._model.lost_m
        ]  # what was believed before a gap is nowhere after it
        if self._track is not None:
            self._track.lose_at(now_s)
        if self._track is not None and self._track.given_up:
            self._reason, self._track = self._track.given_up, None
        if self._track is None:
            self._accept(believed, now_s)
            return
        place = self._track.place_at(now_s)
        others = self._elsewhere(place, now_s)
        if others or self._contradicted(now_s, place):
            hold_s = self._model.conflict_hold_s if self._track.proven else 0.0
            self._track = None
            self._reason = "conflict: another place is believed as well as the one that was held; none is given out"
            self._conflict_until_s = now_s + hold_s
        elif any(h.place.carried(now_s, self._model).distance_m(place) <= self._model.same_m for h in believed):
            self._track.proven = True

    def _contradicted(self, now_s: float, place: Place) -> bool:
        """Tell whether a blind solve of now is sure of another place, or the bank holds another far ahead of this."""
        model = self._model
        sure = [blind for blind in self._acceptance.ended_at(now_s) if self._acceptance.sure(blind)]
        if any(place.differs(blind.place, model.apart_m, model.apart_deg) for blind in sure):
            return True
        if self._last_bank_s != now_s or not self._bank.hypotheses:
            return False
        best, here = self._bank.hypotheses[0], self._bank.near(place)
        behind = best.score - here.score if here is not None else math.inf
        return best.score > model.least_score + model.give_up_behind and behind > model.give_up_behind

    def _elsewhere(self, place: Place, now_s: float) -> list[Hypothesis]:
        """Return the believed places that are not this one."""
        model = self._model
        return [
            h for h in self._believed if h.place.carried(now_s, model).differs(place, model.apart_m, model.apart_deg)
        ]

    def _accept(self, believed: list[Hypothesis], now_s: float) -> None:
        if now_s < self._conflict_until_s:
            return
        if self._plain is not None and self._plain.end_s == now_s:
            if self._elsewhere(self._plain.place, now_s):
                self._reason = "conflict: one window leaves no doubt, and minutes speak for another place"
                return
            self._track = Track(self._plain.place, self._model, now_s)
            return
        if len(believed) == 1:
            self._track = Track(believed[0].place.carried(now_s, self._model), self._model, now_s)
            return
        if len(believed) > 1:
            self._reason = f"conflict: {len(believed)} places are believed at once, so none is given out"
        else:
            self._reason = self._why_cold()

    def _why_cold(self) -> str:
        if not self._bank.hypotheses:
            return "cold: no place explains the tracks better than chance so far"
        best = self._bank.hypotheses[0]
        return (
            f"cold: the best place has a score of {best.score:.1f}, ahead by {min(self._bank.ahead, 999.0):.1f}, "
            f"with {best.marks} marks; it must be found again without shared data, or prove itself at once"
        )

    # ------------------------------------------------------------------------------------------------ the track

    def _hold(self, now_s: float, blind: Joint | None) -> Held | None:
        """Fix the newest epoch: blind where that is good enough and agrees, else with the prior of older data."""
        track = self._track
        assert track is not None
        if blind is not None and len(blind.answers):
            best = blind_of(blind, self._model.window_s)
            assert best is not None
            if self._acceptance.fair(best) and track.agrees(best.place):
                track.proven = True
                return track.take_blind(blind, self._epochs[-1], now_s)
        begin = track.prior_for(now_s - self._model.window_s)
        length_s = min(self._model.window_s, now_s - begin.time_s)
        if length_s < self._model.shortest_window_s:
            return track.carry(self._epochs[-1], now_s) if track.last is not None else self._first_fix(now_s)
        window = self._prepare(now_s, length_s)
        return None if window is None else track.take_warm(window, begin, self._epochs[-1], now_s)

    def _first_fix(self, now_s: float) -> Held | None:
        """Return the fix at a place that was just believed: the answer of a blind solve that lies there."""
        track, window = self._track, self._prepare(now_s, self._model.window_s)
        if track is None or window is None:
            return None
        found = joint.cold(window)
        row = track.row_at_place(found, now_s)
        return None if row is None else track.take_blind(found, self._epochs[-1], now_s, row)

    def _outcome(self, now_s: float, held: Held | None) -> Outcome:
        track = self._track
        assert track is not None
        hypothesis = self._bank.near(track.place_at(now_s))
        state = TrackState(
            "tracking" if track.proven and not track.lapsed else "lapsed",
            track.probability_wrong,
            None if held is None else held.evidence,
            None if hypothesis is None else hypothesis.score,
            None if hypothesis is None else min(self._bank.rival_ahead(hypothesis), 1000.0),
            now_s - track.since_s,
            None if held is None else held.source,
            track.protection.innovation,
        )
        if track.given_up or track.lapsed or not track.proven or held is None or held.fix is None:
            unproven = "" if track.proven else "the place that was given is not confirmed yet by any solve without it"
            reason = track.given_up or track.why_lapsed or unproven or "the window holds too little for a fix"
            return Outcome(state.status, None, reason, state)
        return Outcome("tracking", held.fix, "", state, held.association)


__all__ = ["Blind", "Navigator", "Place"]
