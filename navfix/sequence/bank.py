"""The bank of hypotheses: every place that may be right, each judged by all that was seen over minutes.

A blind solve of a window proposes places; each is then carried along and fitted to windows that share no data. For
every (track, ship) the mean of its log likelihood ratio over the windows is kept: a constant error is not fresh
evidence in every scan, and a lost match takes its credit back. The score of a place counts each track and each ship
once: eq. (14.1) of the theory. What is right stands ahead of every rival after minutes; what is foreign does not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from navfix.association.matchings import log_mean_evidence
from navfix.association.scene import heading_of, position_of
from navfix.association.window import gyro, jackknife, joint, pairs
from navfix.association.window.field import WindowField
from navfix.association.window.fit import as_clutter, paths_over_ground
from navfix.association.window.joint import Joint, Window
from navfix.association.window.knots import Knots
from navfix.catalog import AssociationModel, NavigatorModel, association_model
from navfix.sequence.lives import Lives
from navfix.sequence.places import Place, as_prior
from navfix.sequence.yaw import YawLog
from navfix.types import FloatArray

LOG_VOLUME = 1.5 * math.log(2.0 * math.pi)


@dataclass(slots=True)
class Mean:
    """A running mean; ``last_s`` is when something was added last [POSIX s]."""

    total: float = 0.0
    count: int = 0
    last_s: float = -math.inf

    def add(self, value: float) -> None:
        """Take one value in."""
        self.total += value
        self.count += 1

    @property
    def value(self) -> float:
        """The mean so far, 0 of nothing."""
        return self.total / self.count if self.count else 0.0


@dataclass(slots=True, eq=False)
class Hypothesis:
    """A place with what speaks for it: log ratios by (life, mark), detection by mark, own motion against the null.

    ``strayed`` is what it pays for moving away from where it said it would be: a place that wanders from ship to ship
    collects the evidence of many accidents. ``compass`` is what own compass says of its heading, one piece of evidence
    however often it is read; ``compass_price`` what a wrong one could feign.
    """

    place: Place
    pairs: dict[tuple[int, str], Mean] = field(default_factory=dict)
    detection: dict[str, Mean] = field(default_factory=dict)
    strayed: float = 0.0
    motion: Mean = field(default_factory=Mean)
    compass: Mean = field(default_factory=Mean)
    compass_price: float = 0.0
    windows: int = 0
    score: float = -math.inf
    marks: int = 0
    evidence: float = -math.inf


class Bank:
    """Keeps hypotheses; fed with windows that share no data, and with the answers of blind solves."""

    def __init__(self, model: NavigatorModel, shared: AssociationModel | None = None) -> None:
        self._model, self._shared = model, shared or association_model()
        self._lives = Lives(model.memory_s)
        self.yaw = YawLog()
        self.hypotheses: list[Hypothesis] = []

    @property
    def ahead(self) -> float:
        """By how many nats the best place is ahead of every other (infinite where there is no other)."""
        scores = [h.score for h in self.hypotheses]
        return scores[0] - scores[1] if len(scores) > 1 else math.inf

    def feed(self, window: Window, births: Sequence[Joint]) -> None:
        """Carry every place into a window that shares no data with the one before, add the births, judge, prune."""
        scene = window.field.scene
        now_s = scene.middle_s + scene.end_s
        self._lives.note(window, now_s)
        if self.hypotheses and len(scene.tracks) and len(scene.paths.marks):
            self._advance(window)
        elif self.hypotheses:
            for h in self.hypotheses:
                h.place = h.place.carried(now_s, self._model)
        for found in births:
            self._turn(found)
            self._bear(found)
        log_area = window.prior.log_area
        for h in self.hypotheses:
            self._forget(h, now_s)
            h.score, h.marks = self._judge(h, log_area)
        self._prune()

    def near(self, place: Place) -> Hypothesis | None:
        """Return the best hypothesis at a place, None where there is none."""
        model = self._model
        near = [
            h
            for h in self.hypotheses
            if not h.place.carried(place.time_s, model).differs(place, model.same_m, model.apart_deg)
        ]
        return max(near, key=lambda h: h.score, default=None)

    def rival_ahead(self, of: Hypothesis) -> float:
        """Return by how many nats ``of`` is ahead of the best other one (negative where it is behind)."""
        model = self._model
        others = [h.score for h in self.hypotheses if h.place.differs(of.place, model.same_m, model.apart_deg)]
        return of.score - max(others) if others else math.inf

    # ------------------------------------------------------------------------------------------------ one window

    def _advance(self, window: Window) -> None:
        """Fit every hypothesis to the window from its own place, and credit or debit its pairs."""
        prior = as_prior([h.place for h in self.hypotheses], window, self._model)
        found = joint.warm(window, prior)
        places = places_of(window, found.answers.knots, found.answers.information)
        self._credit(self.hypotheses, found)
        moved_sq = window.prior.given(prior).pose_misfit_sq(found.answers.knots)
        strayed = 0.5 * np.maximum(moved_sq - self._model.steady_sq, 0.0)
        fading = math.exp(-self._model.bank_every_s / self._model.memory_s)
        for h, place, evidence, debt in zip(
            self.hypotheses, places, found.answers.evidence.tolist(), strayed.tolist(), strict=True
        ):
            carried = h.place.carried(place.time_s, self._model)
            lost_way = carried.turned_unseen and evidence <= 0.0  # a fit from an unknown heading that fits nothing
            h.place = carried if lost_way else replace(place, yaw=self.yaw)
            h.evidence, h.strayed = evidence, fading * h.strayed + debt

    def _turn(self, found: Joint) -> None:
        """Give hypotheses that turned unseen the pose of a blind solve at their place, where it explains more."""
        turned = [h for h in self.hypotheses if h.place.turned_unseen]
        if not turned or not len(found.answers):
            return
        best = found.answers.take(np.array([0]))
        (place,), evidence = places_of(found.window, best.knots, best.information), float(best.evidence[0])
        for h in turned:
            if evidence > max(h.evidence, 0.0) and h.place.distance_m(place) <= self._model.same_m:
                h.place, h.evidence = replace(place, yaw=self.yaw), evidence

    def _bear(self, found: Joint) -> None:
        """Add the answers of a blind solve at places where there is no hypothesis yet."""
        rows = np.flatnonzero((found.answers.evidence > -self._model.birth_deficit) & (found.answers.marks >= 2))
        rows = rows[: self._model.births]
        if not len(rows):
            return
        answers = found.answers.take(rows)
        born: list[Hypothesis] = []
        for place, evidence in zip(
            places_of(found.window, answers.knots, answers.information), answers.evidence, strict=True
        ):
            born.append(Hypothesis(replace(place, yaw=self.yaw), evidence=float(evidence)))
        self._credit(born, Joint(found.window, answers))
        self.hypotheses += [h for h in born if not any(self._same(h.place, k.place) for k in self.hypotheses)]

    def _credit(self, hypotheses: Sequence[Hypothesis], found: Joint) -> None:
        window, knots = found.window, found.answers.knots
        mark, log_ratio = pairs.log_ratios(window.field, knots)
        lives = self._lives.of(window)
        labels = [m.label for m in window.field.scene.paths.marks]
        detection = _detection(window.field, knots)
        motion = _motion(window, knots)
        compass, price = gyro.gain(found, gyro.heading_prior(window)), gyro.price(window)
        alive, lost = set(lives), pairs.LEAST_LOG_RATIO
        now_s = window.field.scene.middle_s + window.field.scene.end_s
        for k, h in enumerate(hypotheses):
            h.windows += 1
            h.motion.add(float(motion[k]))
            if compass is not None:
                h.compass.add(float(compass[k]))
                h.compass_price = price
            seen: dict[tuple[int, str], float] = {}
            for i, life in enumerate(lives):
                for q in np.flatnonzero(log_ratio[k, i] > lost):
                    seen[life, labels[mark[k, i, q]]] = float(log_ratio[k, i, q])
            for pair in h.pairs.keys() | seen.keys():
                if pair[0] in alive:
                    h.pairs.setdefault(pair, Mean()).add(seen.get(pair, lost))
            for j in np.flatnonzero(detection[k]):
                mean = h.detection.setdefault(labels[j], Mean())
                mean.add(float(detection[k, j]))
                mean.last_s = max(mean.last_s, now_s)

    # ------------------------------------------------------------------------------------------------ the score

    def _forget(self, h: Hypothesis, now_s: float) -> None:
        """Forget tracks and ships alike not seen for long: else a ship left behind is missed for ever."""
        lives = self._lives.known
        h.pairs = {pair: mean for pair, mean in h.pairs.items() if pair[0] in lives}
        h.detection = {m: mean for m, mean in h.detection.items() if now_s - mean.last_s <= self._model.memory_s}

    def _judge(self, h: Hypothesis, log_area: float) -> tuple[float, int]:
        """Return the score of a place and how many marks it explains: eq. (14.1)."""
        lives = self._lives.known
        marks = sorted(h.detection.keys() | {mark for _, mark in h.pairs})
        column = {mark: j for j, mark in enumerate(marks)}
        row = {life: i for i, life in enumerate(sorted(lives))}
        log_ratio = np.full((len(row), len(marks)), -np.inf)
        for (life, mark), mean in h.pairs.items():
            log_ratio[row[life], column[mark]] = mean.value
        if not len(row) or not len(marks):
            return -math.inf, 0
        least = self._model.least_detection
        pd = np.clip([h.detection[m].value if m in h.detection else least for m in marks], least, 1.0)
        levels = []
        for level in self._shared.detection_level:
            odds = level * pd / (1.0 - level * pd)
            levels.append(
                ((np.exp(np.minimum(log_ratio, 100.0)) * odds)[None], np.array([np.log1p(-level * pd).sum()]))
            )
        index = np.broadcast_to(np.arange(len(marks)), log_ratio.shape)[None]
        log_mean = float(log_mean_evidence(levels, index, np.array(self._shared.clutter_share), len(marks))[0])
        volume = LOG_VOLUME + 0.5 * float(np.linalg.slogdet(h.place.covariance)[1])
        explained = int((log_ratio.max(axis=0) > 1.0).sum())
        place = min(volume - log_area - math.log(2.0 * math.pi), 0.0) + h.compass.value
        return log_mean - h.strayed + min(h.motion.value, 0.0) + place, explained

    def _prune(self) -> None:
        """Keep the best of every group that has come together, and nothing far behind the best."""
        ranked = sorted(self.hypotheses, key=lambda h: -h.score)
        kept: list[Hypothesis] = []
        for h in ranked:
            if h.score < ranked[0].score - self._model.drop_behind or len(kept) >= self._model.places:
                break
            if not any(self._same(h.place, other.place) for other in kept):
                kept.append(h)
        self.hypotheses = kept

    def _same(self, one: Place, other: Place) -> bool:
        model = self._model
        return one.distance_m(other) <= model.merge_m and one.turn_deg(other) <= model.merge_deg


def places_of(window: Window, knots: Knots, information: FloatArray) -> list[Place]:
    """Return own motions as places at the end of their window."""
    scene = window.field.scene
    p, heading, velocity = jackknife.at_end(window.field, knots)
    covariance = jackknife.formal_at_end(window.field, information)
    return [
        Place(
            scene.middle_s + scene.end_s,
            position_of(scene.flat, complex(p[k])),
            heading_of(scene.flat, complex(p[k]), float(heading[k]) + scene.yaw_at_end),
            complex(velocity[k]),
            covariance[k],
        )
        for k in range(len(knots))
    ]


def _detection(field: WindowField, knots: Knots) -> FloatArray:
    """Return the detection probability (k, n) at level 1 of every mark, 0 out of radar range."""
    scene = field.scene
    distance_m = np.abs(scene.paths.z[None, :, scene.gauge] - knots.p[:, scene.gauge, None])
    pd = field.flat.detection(distance_m, scene.flat.conspicuity[None, :])
    return np.where(distance_m <= scene.flat.radar_range_m, pd, 0.0)


def _motion(window: Window, knots: Knots) -> FloatArray:
    """Return by how much own motion (k,) makes the clutter likelier than the null's own motion does."""
    clutter = as_clutter(window.field, paths_over_ground(window.field, knots)[0])
    fitted: FloatArray = clutter.log_density.sum(axis=1) + window.prior.log_shape(knots)
    null_path, _ = paths_over_ground(window.field, window.null.shape)
    null = float(as_clutter(window.field, null_path).log_density.sum() + window.prior.log_shape(window.null.shape)[0])
    return np.asarray(fitted - null, dtype=np.float64)
