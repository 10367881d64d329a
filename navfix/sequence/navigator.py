"""The navigator: from nothing to a place, and from scan to scan with it; no sockets, no clock, no threads.

Cold until a place is believed. Then at each step first a blind solve of the window where one is due; only where that
says nothing, a solve with a prior from data older than the window. A track whose own evidence sinks lapses into no fix;
another place that is believed ends it; two believed places are none.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from datetime import datetime

import numpy as np

from navfix.adjustment.window.prior import KnownPose
from navfix.association.window import gyro, joint
from navfix.association.window.associate import WindowAnswer
from navfix.association.window.joint import Joint, Window
from navfix.association.window.tracks import epoch_time, since_silence
from navfix.catalog import NavigatorModel, RadarModel, WindowModel, navigator_model, window_model
from navfix.errors import InputError, TooFewPairs
from navfix.kernels import Kernel
from navfix.refinement import contradicted, refined
from navfix.sequence.acceptance import Blind, blind_of
from navfix.sequence.ais_jump import AisJump
from navfix.sequence.bank import Bank
from navfix.sequence.belief import Belief
from navfix.sequence.between_fixes import BetweenFixes
from navfix.sequence.gyro_check import GyroCheck
from navfix.sequence.outcome import Outcome, outcome_of
from navfix.sequence.places import Place
from navfix.sequence.track import Held, Track
from navfix.types import Alternative, DeadReckoning, Epoch, Fix, TrackState, TrackStatus


class Navigator:
    """Feed it epochs in the order of time; ``step`` gives the outcome at the newest one.

    Parameters
    ----------
    model, window : constants of the navigator and of its windows, by name or record
    radar : sigmas of the targets that bring none, in the association and the adjustment of each window
    kernel : of the adjustment of each window, as for `navfix.fix`
    """

    def __init__(
        self,
        *,
        model: NavigatorModel | str = "default",
        window: WindowModel | str = "joint",
        radar: RadarModel | str = "imo",
        kernel: Kernel | str = "hampel",
    ) -> None:
        self._radar, self._kernel = radar, kernel
        self._model, self._window = navigator_model(model), window_model(window)
        self._epochs: deque[Epoch] = deque()
        self._belief = Belief(self._model)
        self._track: Track | None = None
        self._last_cold_s = self._last_bank_s = -np.inf
        self._plain: Blind | None = None
        self._gyro = GyroCheck(self.bank.yaw, self._model)
        self._between = BetweenFixes()
        self._ais_jump = AisJump(self._model)
        self._jumped_m: float | None = None
        self._seen_s = -np.inf

    @property
    def bank(self) -> Bank:
        """The places that are kept alive."""
        return self._belief.bank

    def alternatives(self) -> tuple[Alternative, ...]:
        """Return the places that are kept alive, best first; ``score`` is that over minutes."""
        return tuple(
            Alternative(h.place.position, h.place.heading_deg, h.score, h.marks) for h in self.bank.hypotheses[:10]
        )

    def start_at(self, place: Place) -> None:
        """Begin with a place from outside, such as an earlier fix: it is checked and not believed.

        No fix is given out before a solve that does not know it has found it too.
        """
        self._track = Track(place, self._model, place.time_s, proven=False, yaw=self.bank.yaw)

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
        self.bank.yaw.feed(epoch)
        self._jumped_m = self._ais_jump.feed(epoch) or self._jumped_m
        self._between.carry(self._gyro.believed(epoch))
        if self._track is not None and now_s - self._seen_s > self._model.unseen_s:
            self._track.drift_to(self._between.drifted(self._track.place_at(now_s)), now_s)
        if epoch.targets and epoch.marks:
            self._seen_s = now_s
        while now_s - epoch_time(self._epochs[0]) > self._model.kept_s:
            self._epochs.popleft()

    def step(self, at: datetime | None = None) -> Outcome:
        """Return the outcome at the newest epoch (``at``: no later than this; the caller's clock is not read)."""
        if not self._epochs or (at is not None and self._epochs[-1].time_utc > at):  # type: ignore[operator]
            return Outcome("cold", None, self._belief.reason, TrackState("cold"))
        now_s = epoch_time(self._epochs[-1])
        seen = now_s - self._seen_s <= self._model.unseen_s
        blind = self._solve_blind(now_s) if seen else None
        if seen:
            self._update_bank(now_s, blind)
        if self._jumped_m is not None:
            self._belief.jumped(self._track, now_s, self._jumped_m)
            self._track = self._jumped_m = None
        self._track = self._belief.decide(
            self._track,
            now_s,
            solved=self._last_cold_s == now_s,
            fed=self._last_bank_s == now_s,
            plain=self._plain if self._plain is not None and self._plain.end_s == now_s else None,
        )
        conflict = self._track is None and self._belief.reason.startswith("conflict")
        reckoned = self._between.answer(self._track, now_s, conflict=conflict, seen=seen)
        if self._track is None:
            status: TrackStatus = "conflict" if conflict else "cold"
            state = TrackState(status, score=self._belief.best_score)
            return Outcome(status, None, self._belief.reason, state, dead_reckoning=reckoned)
        held = self._hold(now_s, blind, reckoned) if seen else None
        outcome = self._outcome(now_s, held, reckoned)
        if outcome.fix is not None and held is not None and not held.carried:
            self._between.take(self._epochs[-1], outcome.fix, held.velocity_mps, blind=held.source == "blind")
        return outcome

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
        found = gyro.cold(window)
        best = blind_of(found, min(self._model.window_s, self._span_s(now_s)))
        self._belief.acceptance.note(best)
        self._plain = best if best is not None and self._belief.acceptance.plain(best) else None
        return found

    def _prepare(self, now_s: float, length_s: float) -> Window | None:
        """Make the window of the last ``length_s`` seconds ready, None where it holds too little."""
        epochs = since_silence([e for e in self._epochs if epoch_time(e) > now_s - length_s], self._window)
        if not epochs:
            return None
        try:
            return joint.prepare(epochs, self._window, radar=self._radar)
        except TooFewPairs:
            return None

    def _adjust(self, epochs: Sequence[Epoch], found: WindowAnswer, prior: KnownPose | None) -> Fix | None:
        """Adjust a window at the place that its association found.

        None where few pairs near a prior say one thing and all scans adjusted together another: neither is a fix. So
        many marks as make a blind answer sure are not few.
        """
        fix = refined(epochs, found, radar=self._radar, kernel=self._kernel, prior=prior)
        few = len({mark for pairs in found.labels for mark in pairs.values()}) < self._model.sure_marks
        return None if prior is not None and few and contradicted(fix) else fix

    def _span_s(self, now_s: float) -> float:
        return now_s - epoch_time(self._epochs[0])

    # ------------------------------------------------------------------------------------------------ the bank

    def _update_bank(self, now_s: float, blind: Joint | None) -> None:
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
                found = blind if blind is not None and length_s == model.window_s else None  # the same scans: solved
                whole = window if abs(length_s - since_s) < 1.0 else None
                if found is None:
                    whole = whole or self._prepare(now_s, length_s)
                    found = None if whole is None else gyro.cold(whole)
                if found is not None:
                    births.append(found)
                    self._belief.acceptance.note(blind_of(found, length_s))
        self.bank.feed(window, births)

    # ------------------------------------------------------------------------------------------------ the track

    def _hold(self, now_s: float, blind: Joint | None, reckoned: DeadReckoning | None) -> Held | None:
        """Fix the newest epoch: blind where that is good enough and agrees, else with the prior of older data."""
        track = self._track
        assert track is not None
        if blind is not None and len(blind.answers):
            best = blind_of(blind, self._model.window_s)
            assert best is not None
            if self._belief.acceptance.fair(best) and track.agrees(best.place):
                track.proven = True
                track.standing.confirm(now_s)
                return track.take_blind(blind, self._adjust, now_s)
            if self._belief.acceptance.fair(best) and track.surprised_by(best.place):
                return None
        if track.adrift:
            return None
        begin = track.prior_for(now_s - self._model.window_s)
        length_s = min(self._model.window_s, now_s - begin.time_s)
        if length_s < self._model.shortest_window_s:
            if track.last is None:
                return self._first_fix(now_s) if track.fresh else None
            return track.carry(self._epochs[-1], now_s, reckoned)
        window = self._prepare(now_s, length_s)
        return None if window is None else track.take_warm(window, begin, self._adjust, now_s)

    def _first_fix(self, now_s: float) -> Held | None:
        """Return the fix at a place that was just believed: the answer of a blind solve that lies there."""
        track, window = self._track, self._prepare(now_s, self._model.window_s)
        if track is None or window is None:
            return None
        found = gyro.cold(window)
        row = track.row_at_place(found, now_s)
        return None if row is None else track.take_blind(found, self._adjust, now_s, row)

    def _outcome(self, now_s: float, held: Held | None, reckoned: DeadReckoning | None) -> Outcome:
        track = self._track
        assert track is not None
        hypothesis = self.bank.near(track.place_at(now_s))
        ahead = None if hypothesis is None else self.bank.rival_ahead(hypothesis)
        score = None if hypothesis is None else hypothesis.score
        why = self._why_reckoned(track, now_s)
        return outcome_of(track, held, reckoned, now_s, score=score, ahead=ahead, why_none=why)

    def _why_reckoned(self, track: Track, now_s: float) -> str:
        """Return why a place that is held and not doubted gives no fix."""
        if now_s - self._seen_s > self._model.unseen_s:
            return f"no echo and mark together for {now_s - self._seen_s:.0f} s: only dead reckoning goes on"
        if track.adrift:
            return "own ship went unseen for too long to be looked for near dead reckoning: a blind solve must find her"
        if track.protection.startled:
            return "the window lies farther from where the track says than chance explains"
        return "the window holds too little for a fix"


__all__ = ["Blind", "Navigator", "Place"]
