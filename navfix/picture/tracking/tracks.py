"""The life of a track: tentative, confirmed when its score proves a ship, lost when it is not seen any more."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from navfix.catalog import TrackingModel
from navfix.picture.tracking.filter import State
from navfix.types import FloatArray


@dataclass(slots=True, eq=False)
class Track:
    """One track. ``number`` is 0 while it is tentative; numbers are never used twice.

    ``score`` is the log likelihood ratio "a ship" against "clutter", eq. (11.7). ``twin_turns`` counts the turns beside
    an older track, ``coasted`` the turns since its last plot in which it was reported without one. ``plots`` (2,) [m]
    are kept while the track is tentative: when it dies they were clutter.
    """

    state: State
    number: int = 0
    hits: int = 1
    score: float = 0.0
    twin_turns: int = 0
    coasted: int = 0
    plots: list[FloatArray] = field(default_factory=list)

    @property
    def confirmed(self) -> bool:
        return self.number > 0


def score_hit(track: Track, log_likelihood: float, clutter_per_m2: float, model: TrackingModel) -> None:
    """Count a plot for the track: how much more likely it is under its prediction than as clutter, eq. (11.7)."""
    track.hits += 1
    track.score += math.log(model.detection) + log_likelihood - math.log(clutter_per_m2)


def score_miss(track: Track, model: TrackingModel) -> None:
    """Count a turn without a plot against the track."""
    track.score += math.log(1.0 - model.detection)


def proves_a_ship(track: Track, model: TrackingModel) -> bool:
    """Tell whether a tentative track may be reported."""
    return (
        track.hits >= model.least_hits
        and track.score >= model.confirm_score
        and track.state.speed_mps <= model.fastest_mps
    )


def is_over(track: Track, now_s: float, turn_s: float, model: TrackingModel) -> bool:
    """Tell whether a track has not been seen for too long [POSIX s], or can be no ship."""
    unseen_turns = (now_s - track.state.time_s) / turn_s
    patience = model.lost_turns if track.confirmed else model.tentative_turns
    return unseen_turns > patience or track.state.speed_mps > 2.0 * model.fastest_mps
