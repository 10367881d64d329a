"""A place that is held: fixes from blind or prior windows, and the evidence by which it lapses or is given up."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from navfix.adjustment.window.prior import KnownPose
from navfix.association.scene import position_of
from navfix.association.window import associate, jackknife, joint
from navfix.association.window.joint import Joint, Window
from navfix.association.window.settle import settle
from navfix.association.window.tracks import epoch_time
from navfix.catalog import NavigatorModel
from navfix.geodesy import LocalPlane
from navfix.integrity import with_window_integrity
from navfix.sequence.bank import places_of
from navfix.sequence.doubt import Standing
from navfix.sequence.places import Place, as_known_pose, as_prior
from navfix.sequence.protection import TrackProtection
from navfix.sequence.yaw import YawLog
from navfix.types import Association, DeadReckoning, Epoch, Fix
from navfix.units import wrap_180

_SURPRISED = "given up: three windows in a row lay far from where the track said that they would"
_BY = {"log_and_gyro": " by log and gyro", "log": " by log", "last_velocity": ""}

REFUTES = 16.27  # chi-square, 3 degrees of freedom, 99.9 %
Adjust = Callable[[Sequence[Epoch], associate.WindowAnswer, KnownPose | None], Fix | None]


@dataclass(frozen=True, eq=False)
class Held:
    """One step of the track: its fix (None where too little was matched) and where it came from.

    A fix that was only ``carried`` forward from the one before rests on no new scan. ``velocity_mps`` over ground
    (north, east) is None where the window was too short to show one.
    """

    place: Place
    fix: Fix | None
    association: Association | None
    evidence: float
    source: Literal["blind", "prior"]
    carried: bool = False
    velocity_mps: complex | None = None


class Track:
    """Follows one place. ``given_up`` says why it ended, "" while it lives."""

    def __init__(
        self,
        place: Place,
        model: NavigatorModel,
        now_s: float,
        *,
        proven: bool = True,
        standing: Standing | None = None,
        yaw: YawLog | None = None,
    ) -> None:
        self._model, self._yaw = model, yaw
        self.standing = standing or Standing(model, now_s)
        self.protection = TrackProtection(model)
        self.proven = proven
        self._history: deque[Place] = deque([replace(place, yaw=yaw)])
        self._evidence: deque[tuple[float, float]] = deque()
        self.since_s = now_s
        self.lapsed = False
        self._lapsed_since_s = math.inf
        self.given_up = ""
        self.why_lapsed = ""
        self.last: Held | None = None
        self.adrift = self._drifted = False
        self.fresh = True

    @property
    def probability_wrong(self) -> float | None:
        """At most so likely is a place wrong that is given out, by the negative controls; None for any other."""
        silent = not self.proven or self.lapsed or self.given_up or self.standing.outdone
        return None if silent else self.standing.probability_wrong(self._history[-1].time_s)

    def place_at(self, time_s: float) -> Place:
        """Return the newest place, carried to an instant."""
        return self._history[-1].carried(time_s, self._model)

    def drift_to(self, reckoned: Place | None, now_s: float) -> None:
        """Go on without echoes, by dead reckoning where there is any: a place before the gap is no prior by itself.

        Where own ship may be too far from there, only a blind solve takes the place up again: near a wrong prior some
        few pairs always fit.
        """
        self._history = deque([self.place_at(now_s) if reckoned is None else reckoned])
        self.last, self._drifted = None, True
        self.adrift = reckoned is None or reckoned.sigma_m > self._model.drift_m

    def lose_at(self, now_s: float) -> None:
        """Give up a place that went unseen for so long that it may be anywhere: any echo would fit some ship."""
        if not self.given_up:
            self.given_up = _why_lost(self.place_at(now_s), self._model)

    @property
    def lost(self) -> bool:
        """Whether own ship may be anywhere by now."""
        return self.given_up.startswith("lost")

    def agrees(self, place: Place) -> bool:
        """Tell whether another place of now is this one: near, the same way round, no surprise after the newest."""
        return self._beside(place) and (self._drifted or self._innovation(place) <= self._model.surprise_sq)

    def surprised_by(self, place: Place) -> bool:
        """Tell whether a place of now is neither this one nor clearly elsewhere: own ship or all AIS have jumped.

        So many of them in a row end the track, as windows do that lie far from their prior.
        """
        if not self._beside(place) or self._drifted:
            return False
        innovation = self._innovation(place)
        if innovation <= self._model.surprise_sq:
            return False
        self.protection.note_innovation(innovation)
        if self.protection.surprised:
            self.given_up = _SURPRISED
        return True

    def _beside(self, place: Place) -> bool:
        return not self.place_at(place.time_s).differs(place, self._model.apart_m, self._model.apart_deg)

    def _innovation(self, place: Place) -> float:
        """Return how far a blind place lies from the newest one, squared in sigmas; 0 where that is of too long ago."""
        before, model = self._history[-1], self._model
        after_s = place.time_s - before.time_s
        if after_s > 2.0 * model.cold_every_s:
            return 0.0
        turned_deg = 0.0 if before.yaw is None else before.yaw.between_deg(before.time_s, place.time_s)
        swept_m = abs(before.velocity_mps) * after_s * abs(math.sin(math.radians(turned_deg) / 2.0))
        return before.carried(place.time_s, model).misfit_sq(place, model, swept_m)

    def prior_for(self, begin_s: float) -> Place:
        """Return the newest place whose data are all older than ``begin_s``, or the oldest there is."""
        older = [place for place in self._history if place.time_s <= begin_s]
        return older[-1] if older else self._history[0]

    def row_at_place(self, found: Joint, now_s: float) -> int | None:
        """Return which answer of a blind solve lies at this place, None where none does."""
        here = self.place_at(now_s)
        places = places_of(found.window, found.answers.knots, found.answers.information)
        model, marks = self._model, found.answers.marks
        fits = [
            row
            for row, place in enumerate(places)
            if marks[row] >= model.fewest_marks and not here.differs(place, model.same_m, model.apart_deg)
        ]
        return fits[0] if fits else None

    def take_blind(self, found: Joint, adjust: Adjust, now_s: float, row: int = 0) -> Held:
        """Take a blind answer at this place as the fix, its scans adjusted as one graph."""
        found = Joint(found.window, found.answers.take(np.roll(np.arange(len(found.answers)), -row)))
        window, answers = found.window, found.answers
        settled = settle(found, window.prior, fewest_marks=window.field.model.fewest_marks)
        answer = associate.window_answer(found, settled)
        place = self._place(window, settled.pose, now_s)
        self.protection.note_innovation(self._innovation(place))
        self.protection.note_blind(place, self.place_at(now_s))
        given_place = float(answers.evidence[0]) + window.prior.log_area - _log_prior_area(self._model)
        fix = adjust(window.epochs, answer, None) if self._matched_now(answer, window, now_s) else None
        if self._drifted or self._refuted(place):  # from here on the blind place is the prior, not what led elsewhere
            self.adrift = self._drifted = False
            self._history.clear()
        velocity = _velocity(window, settled.pose)
        return self._take(Held(place, fix, answer.association, given_place, "blind", velocity_mps=velocity), now_s)

    def _refuted(self, found: Place) -> bool:
        """Tell whether a blind place of now is not where this track says that own ship is, nor lies so."""
        model, here = self._model, self.place_at(found.time_s)
        north_m, east_m = LocalPlane(here.position).to_plane(found.position)
        step = np.array([north_m, east_m, math.radians(wrap_180(found.heading_deg - here.heading_deg))])
        widened = np.diag([model.prior_m**2, model.prior_m**2, math.radians(model.prior_deg) ** 2])
        either = model.prior_factor**2 * (here.covariance + found.covariance) + widened
        return float(step @ np.linalg.solve(either, step)) > REFUTES

    def take_warm(self, window: Window, begin: Place, adjust: Adjust, now_s: float) -> Held:
        """Solve a window with a prior from before it, and take what its graph says, the prior one of its factors."""
        prior = as_prior([begin], window, self._model)
        found = joint.warm(window, prior)
        answers = found.answers
        known = window.prior.given(prior)
        self.protection.note_innovation(float(known.pose_misfit_sq(answers.knots)[0]))
        settled = settle(found, known, fewest_marks=self._model.fewest_marks)
        answer = associate.window_answer(found, settled)
        # Nothing but this place was looked at: there is no margin, and of being wrong only what is known of the track.
        association = replace(answer.association, margin=None, probability_wrong=self.probability_wrong)
        enough = settled.marks >= self._model.fewest_marks and self._matched_now(answer, window, now_s)
        fix = None
        if enough:
            answer = replace(answer, fix=replace(answer.fix, association=association), association=association)
            fix = adjust(window.epochs, answer, as_known_pose(begin, window.epochs[0], self._model))
        place, velocity = self._place(window, settled.pose, now_s), _velocity(window, settled.pose)
        evidence = float(answers.evidence[0])
        return self._take(Held(place, fix, association, evidence, "prior", velocity_mps=velocity), now_s)

    def carry(self, epoch: Epoch, now_s: float, reckoned: DeadReckoning | None) -> Held | None:
        """Return the last fix carried to a new epoch: data newer than the place are too few for a window yet.

        It goes on by dead reckoning: by log and gyro where they are heard, by the velocity of the last window else.
        """
        last = self.last
        if last is None or last.fix is None or reckoned is None:
            return None
        fix, covariance = last.fix, last.fix.covariance.copy()
        covariance[:2, :2] = reckoned.covariance
        if fix.heading_deg is not None and reckoned.heading_sigma_deg is not None:
            covariance[2, 2] = math.radians(reckoned.heading_sigma_deg) ** 2
        by = _BY[reckoned.source]
        fix = replace(
            fix,
            position=reckoned.position,
            heading_deg=None if fix.heading_deg is None else reckoned.heading_deg,
            covariance=covariance,
            cofactor_matrix=covariance / fix.sigma0**2,
            association=None,
            observations=(),
            epoch=epoch,
            notes=(f"Carried forward by {now_s - last.place.time_s:.1f} s{by}.",),
        )
        return Held(last.place, with_window_integrity(fix), None, last.evidence, "prior", carried=True)

    def _matched_now(self, answer: associate.WindowAnswer, window: Window, now_s: float) -> bool:
        """Tell whether an echo that matches a mark is new enough: a fix by older ones would be dead reckoning."""
        times = [epoch_time(epoch) for epoch, pairs in zip(window.epochs, answer.labels, strict=True) if pairs]
        return max(times, default=-math.inf) > now_s - self._model.unseen_s

    def _place(self, window: Window, pose: jackknife.PoseAtEnd, now_s: float) -> Place:
        return Place(
            now_s,
            position_of(window.field.scene.flat, pose.p),
            math.degrees(pose.heading_rad) % 360.0,
            pose.velocity,
            pose.formal,
            self._yaw,
        )

    def _take(self, held: Held, now_s: float) -> Held:
        if held.fix is not None:
            level_m = self.protection.level_m(held.place)
            held = replace(held, fix=with_window_integrity(held.fix, level_m))
        self.last, self.fresh = held, False
        if held.fix is not None or held.source == "blind":  # what matched too little tells nothing of the place
            self._history.append(held.place)
        while len(self._history) > 1 and now_s - self._history[1].time_s > self._model.window_s + 5.0:
            self._history.popleft()
        self.given_up = _why_lost(held.place, self._model)
        if self.protection.surprised:
            self.given_up = _SURPRISED
        self._watch(held.evidence, now_s)
        return held

    def _watch(self, evidence: float, now_s: float) -> None:
        """Lapse when the evidence given the place has been low for long; come back when it is high again."""
        model = self._model
        self._evidence.append((now_s, evidence))
        while now_s - self._evidence[0][0] > model.lapse_memory_s:
            self._evidence.popleft()
        best = max(value for _, value in self._evidence)
        if not self.lapsed and best < model.lapse_evidence and now_s - self.since_s >= model.lapse_memory_s:
            self.lapsed, self._lapsed_since_s = True, now_s
        elif self.lapsed and evidence >= model.back_evidence:
            self.lapsed, self._lapsed_since_s = False, math.inf
        self.why_lapsed = (
            f"lapsed: the tracks of the last {model.lapse_memory_s:.0f} s hardly speak for the place"
            if self.lapsed
            else ""
        )
        if self.lapsed and now_s - self._lapsed_since_s > model.drop_after_s:
            self.given_up = f"given up: nothing has spoken for the place for {model.drop_after_s:.0f} s"


def _velocity(window: Window, pose: jackknife.PoseAtEnd) -> complex | None:
    """Return the velocity over ground that a window shows, None where it is too short for one."""
    return pose.velocity if window.field.scene.knots > 1 else None


def _why_lost(place: Place, model: NavigatorModel) -> str:
    sigma_m = place.sigma_m
    return f"lost: the place is uncertain by {sigma_m:.0f} m (1 sigma)" if sigma_m > model.lost_m else ""


def _log_prior_area(model: NavigatorModel) -> float:
    """Return ln of the area [m^2] that a prior of this navigator usually leaves, for evidence on one scale."""
    sigma_m, sigma_rad = 5.0 * model.prior_m, 2.0 * math.radians(model.prior_deg)
    return math.log(2.0 * math.pi * sigma_m**2) + math.log(sigma_rad / math.sqrt(2.0 * math.pi))
