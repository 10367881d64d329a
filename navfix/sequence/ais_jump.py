"""Have the AIS positions of most ships jumped alike? Ships cannot: then either all were shifted, or are back again.

Each position is compared with that of the epoch before, carried on by the ship's own speed and course. That needs no
radar and no place of own ship, so that it tells a jump before any window is long enough to be misled by it.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from navfix.association.scene import ComplexArray
from navfix.association.window.tracks import epoch_time
from navfix.catalog import NavigatorModel
from navfix.geodesy import LocalPlane
from navfix.types import Epoch, Mark, Position


@dataclass(frozen=True, slots=True)
class _Known:
    """A ship as last heard: ``heard_s`` when a report came in or its position jumped [POSIX s]."""

    mark: Mark
    time_s: float
    report_s: float
    heard_s: float


@dataclass(frozen=True, slots=True)
class _Jumped:
    """One ship's jump (north, east) [m], its velocity [m/s] and what is known of the difference [m]."""

    time_s: float
    by: complex
    velocity: complex
    sigma_m: float


class AisJump:
    """Feed it epochs in the order of time; it remembers what ships did within ``ais_jump_memory_s``."""

    def __init__(self, model: NavigatorModel) -> None:
        self._model = model
        self._known: dict[str, _Known] = {}
        self._jumped: dict[str, _Jumped] = {}

    def feed(self, epoch: Epoch) -> float | None:
        """Take the next epoch in; return how far [m] most ships have jumped alike by now, None where they have not."""
        now_s = epoch_time(epoch)
        since_s = now_s - self._model.ais_jump_memory_s
        for mark in epoch.marks:
            if mark.kind == "ship":
                self._compare(mark, now_s)
        self._known = {label: known for label, known in self._known.items() if known.time_s >= since_s}
        self._jumped = {label: jump for label, jump in self._jumped.items() if jump.time_s >= since_s}
        heard = sum(known.heard_s >= since_s for known in self._known.values())
        found = self._common(heard)
        if found is not None:
            self._jumped.clear()
        return found

    def _compare(self, mark: Mark, now_s: float) -> None:
        report_s = now_s - (mark.age_s or 0.0)
        before = self._known.get(mark.label)
        if before is None:
            self._known[mark.label] = _Known(mark, now_s, report_s, -math.inf)
            return
        new = report_s > before.report_s + 0.5
        by, velocity = _moved(before, mark, now_s)
        sigma_m = _sigma_m(before.mark, mark)
        if abs(by) > self._model.ais_jump_sigmas * sigma_m:
            self._jumped[mark.label] = _Jumped(now_s, by, velocity, sigma_m)
            new = True
        self._known[mark.label] = _Known(mark, now_s, report_s, now_s if new else before.heard_s)

    def _common(self, heard: int) -> float | None:
        """Return the size of a jump that more than half of the ships heard share, None where there is none."""
        model, jumped = self._model, list(self._jumped.values())
        if len(jumped) < model.ais_jump_ships or len(jumped) <= 0.5 * heard:
            return None
        by = np.array([jump.by for jump in jumped])
        sigma_m = np.array([jump.sigma_m for jump in jumped])
        common = complex(np.median(by.real), np.median(by.imag))
        alike = np.abs(by - common) <= model.ais_jump_sigmas * sigma_m
        if alike.sum() < model.ais_jump_ships or alike.sum() <= 0.5 * heard:
            return None
        velocity = np.array([jump.velocity for jump in jumped])
        if _misfit(by[alike], _by_clock(by[alike], velocity[alike])) <= _misfit(by[alike], common):
            return None  # the clock of the log jumped, no ship did
        return abs(common)


def _moved(before: _Known, mark: Mark, now_s: float) -> tuple[complex, complex]:
    """Return where a ship is beside where it would be (north, east) [m], and its velocity [m/s]."""
    course = math.radians(before.mark.course_deg or 0.0)
    velocity = cmath.rect(before.mark.speed_mps or 0.0, course)
    offset = _offset(before.mark.position, mark.position)
    return offset - velocity * (now_s - before.time_s), velocity


def _sigma_m(before: Mark, mark: Mark) -> float:
    """Return 1 sigma of how far two positions of one ship differ [m]: her hull, known or not, is in both alike."""
    hull_m = min(before.hull_sigma_m, mark.hull_sigma_m)
    return math.sqrt(before.sigma_m**2 + mark.sigma_m**2 - 2.0 * hull_m**2)


def _offset(origin: Position, position: Position) -> complex:
    north_m, east_m = LocalPlane(origin).to_plane(position)
    return complex(north_m, east_m)


def _by_clock(by: ComplexArray, velocity: ComplexArray) -> ComplexArray:
    """Return the offsets that one step of a clock explains best."""
    moving = float(np.vdot(velocity, velocity).real)
    step_s = float(np.vdot(velocity, by).real) / moving if moving > 0.0 else 0.0
    return step_s * velocity


def _misfit(by: ComplexArray, expected: ComplexArray | complex) -> float:
    return float((np.abs(by - expected) ** 2).sum())
