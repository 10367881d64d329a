"""What a hostile sea can do to the navigator: jumps of all AIS, a spoofed cluster, swapped numbers, wrong states.

Each change acts on the epochs of a simulated recording from an instant on; the truth stays own ship's true track. What
the navigator gives out is then counted against it: how long a wrong place is held, and with which stated doubt.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cache
from typing import Any

import numpy as np

from navfix.association.window.tracks import epoch_time
from navfix.geodesy import LocalPlane, inverse
from navfix.nmea import read_log
from navfix.picture import epochs
from navfix.report.truth import TruthTrack
from navfix.sequence import Navigator
from navfix.sequence.places import Place
from navfix.simulation import scenario
from navfix.simulation.files import truth_csv
from navfix.types import Epoch, HeadingHint

WRONG_M = 500.0
STEP_S = 10.0
Change = Callable[[Epoch], Epoch]


@dataclass(frozen=True, eq=False)
class Scene:
    """A simulated recording: an epoch for each radar turn, and own ship's true track."""

    epochs: tuple[Epoch, ...]
    truth: TruthTrack

    def changed(self, change: Change, *, after_s: float = 0.0, for_s: float = math.inf) -> Scene:
        """Return the scene with a change of every epoch from ``after_s`` on, ``for_s`` seconds long."""
        begin_s = epoch_time(self.epochs[0]) + after_s
        seen = [begin_s <= epoch_time(e) < begin_s + for_s for e in self.epochs]
        return replace(self, epochs=tuple(change(e) if hit else e for e, hit in zip(self.epochs, seen, strict=True)))

    def later(self, after_s: float) -> Scene:
        """Return the scene without what comes before ``after_s``: a restart."""
        begin_s = epoch_time(self.epochs[0]) + after_s
        return replace(self, epochs=tuple(e for e in self.epochs if epoch_time(e) >= begin_s))


@cache
def scene(
    seed: int,
    *,
    ships: int = 16,
    dumb: int = 6,
    lat_deg: float = 54.0,
    lon_deg: float = 12.0,
    duration_s: float = 240.0,
    gyro: bool = False,
    turn_degps: float = 0.0,
    turn_deg: float = 90.0,
) -> Scene:
    """Return own ship among ``ships`` with AIS and ``dumb`` echoes without, in radar range of 6 NM.

    With ``turn_degps`` she alters course by ``turn_deg`` after 110 s, as fast as that.
    """
    turn = {"turn_at_s": 110.0, "turn_deg": turn_deg, "turn_rate_deg_per_min": 60.0 * turn_degps} if turn_degps else {}
    content: dict[str, Any] = {
        "title": "Among ships",
        "source": "made up",
        "start_utc": datetime(2026, 6, 1, 11, 58, tzinfo=UTC),
        "duration_s": duration_s,
        "lat_deg": lat_deg,
        "lon_deg": lon_deg,
        "own": {"speed_mps": 5.0, "course_deg": float(37 * seed % 360), "yaw_deg": 1.0, **turn},
        "traffic": [
            {"layout": "uniform", "count": ships, "radius_m": 10000.0, "inner_radius_m": 900.0, "hull_min_m": 40.0},
            {"layout": "uniform", "count": 12, "radius_m": 30000.0, "inner_radius_m": 12000.0},
            {"layout": "uniform", "count": dumb, "radius_m": 9000.0, "inner_radius_m": 900.0, "with_ais": 0.0},
        ],
        "radar": {"maximum_range_m": 11112.0, "acquired": 0.9, "bearing_bias_deg": -1.5},
        "sensors": {"heading": "hdt"} if gyro else {},
    }
    recording = scenario.simulate(scenario.from_table(content, name="hostile"), seed)
    found = tuple(epochs(read_log(list(recording.lines), report=False).records))
    return Scene(found, TruthTrack.parse(truth_csv(recording).splitlines()))


# ------------------------------------------------------------------------------------------------ what is done to it


def jump(north_m: float, east_m: float) -> Change:
    """All AIS positions are moved alike."""

    def change(epoch: Epoch) -> Epoch:
        return replace(epoch, marks=tuple(_moved(mark, north_m, east_m) for mark in epoch.marks))

    return change


def spoofed_cluster(share: float, north_m: float, east_m: float) -> Change:
    """Move a share of the ships alike, by their number: always the same ones."""

    def change(epoch: Epoch) -> Epoch:
        moved = [_moved(m, north_m, east_m) if _draw(m.label) < share else m for m in epoch.marks]
        return replace(epoch, marks=tuple(moved))

    return change


def swap_numbers(epoch: Epoch) -> Epoch:
    """Give the radar's target numbers in turn to the next target."""
    labels = sorted(t.label for t in epoch.targets)
    turned = dict(zip(labels, labels[1:] + labels[:1], strict=True))
    return replace(epoch, targets=tuple(replace(t, label=turned[t.label]) for t in epoch.targets))


def renumber(epoch: Epoch) -> Epoch:
    """Give all targets other numbers from the same hundred: the tracker was started again."""
    anew = {t.label: f"{(37 * int(t.label) + 11) % 100:02d}" for t in epoch.targets}
    return replace(epoch, targets=tuple(replace(t, label=anew[t.label]) for t in epoch.targets))


def lose_echoes(share: float) -> Change:
    """Lose a share of the echoes, always the same ones: rain, or another range scale; 1 is a radar that is off."""

    def change(epoch: Epoch) -> Epoch:
        return replace(epoch, targets=tuple(t for t in epoch.targets if _draw(t.label) >= share))

    return change


def silence(epoch: Epoch) -> Epoch:
    """Hear no AIS at all."""
    return replace(epoch, marks=())


def gyro_off(truth: TruthTrack, off_deg: float) -> Change:
    """Let a gyro be in the log that is off by so much."""

    def change(epoch: Epoch) -> Epoch:
        there = truth.at(epoch_time(epoch))
        assert there is not None
        assert there.heading_deg is not None
        return replace(epoch, heading_hint=HeadingHint((there.heading_deg + off_deg) % 360.0, 1.5))

    return change


def wrong_state(found: Scene, north_m: float, east_m: float, *, believed: bool) -> Navigator:
    """Return a navigator that begins at a wrong place; ``believed``: as if it had accepted it and given it out."""
    time_s = epoch_time(found.epochs[0])
    there = found.truth.at(time_s)
    assert there is not None
    wrong = LocalPlane(there.position).to_position(north_m, east_m)
    navigator = Navigator()
    navigator.start_at(Place(time_s, wrong, 10.0, 0j, np.diag([900.0, 900.0, 0.01**2])))
    if believed:
        assert navigator._track is not None
        navigator._track.proven = True
        navigator._track.standing.stated = 0.01
    return navigator


def _moved(mark: Any, north_m: float, east_m: float) -> Any:
    return replace(mark, position=LocalPlane(mark.position).to_position(north_m, east_m))


def _draw(label: str) -> float:
    return (sum(ord(c) * (i + 7) * 2654435761 for i, c in enumerate(label)) % 1000) / 1000.0


# ------------------------------------------------------------------------------------------------ what comes of it


@dataclass
class Told:
    """What a navigator gave out over a scene; ``expected_wrong`` is the sum of the doubts that were stated.

    ``inside`` counts the fixes whose 95 % ellipse holds the truth.
    """

    steps: int = 0
    fixes: int = 0
    wrong: int = 0
    inside: int = 0
    worst_m: float = 0.0
    longest_wrong_s: float = 0.0
    expected_wrong: float = 0.0
    surest_wrong: float = math.inf
    statuses: tuple[str, ...] = ()


def tell(found: Scene, navigator: Navigator | None = None, *, step_s: float = STEP_S) -> Told:
    """Run a navigator over a scene and count what it gives out against the truth."""
    navigator, told, last_s, held_s = navigator or Navigator(), Told(), -math.inf, 0.0
    statuses = []
    for epoch in found.epochs:
        navigator.feed(epoch)
        now_s = epoch_time(epoch)
        if now_s - last_s < step_s - 0.1:
            continue
        last_s, outcome = now_s, navigator.step()
        told.steps += 1
        statuses.append(outcome.track.status)
        error_m = 0.0
        if outcome.fix is not None:
            there = found.truth.at(now_s)
            assert there is not None
            error_m, azimuth_deg = inverse(outcome.fix.position, there.position)
            azimuth = math.radians(azimuth_deg)
            told.inside += outcome.fix.ellipse(0.95).holds(error_m * math.cos(azimuth), error_m * math.sin(azimuth))
            stated = 1.0 if outcome.track.probability_wrong is None else outcome.track.probability_wrong
            told.fixes += 1
            told.expected_wrong += stated
            told.worst_m = max(told.worst_m, error_m)
            if error_m > WRONG_M:
                told.surest_wrong = min(told.surest_wrong, stated)
        wrong = error_m > WRONG_M
        told.wrong += wrong
        held_s = held_s + step_s if wrong else 0.0
        told.longest_wrong_s = max(told.longest_wrong_s, held_s)
    told.statuses = tuple(statuses)
    return told


def longest_wrong_s(tolds: Sequence[Told]) -> float:
    """Return the longest time [s] that any of them held a wrong place."""
    return max((told.longest_wrong_s for told in tolds), default=0.0)
