"""Errors common to all observations of many fixes, with their sigma: what pose and noise cannot explain.

Each fix gives l = A dx + a tau + noise: misclosures, design matrix, and a column for each common error. The pose is
eliminated fix by fix; what is left of ``a`` adds up in a fading memory. Errors of one ship (its hull, its AIS antenna,
its clock) last, so its contributions are one voice: the variance is that of leaving out one mark after the other
(theory, eq. 13.10 and 13.11).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from navfix.geodesy import LocalPlane
from navfix.types import AdjustedObservation, CommonError, Fix, FloatArray, Mark, Position

Column = Callable[[AdjustedObservation, Mark, float, float], float]  # observation, its mark, range m, azimuth rad

MANY = 1e6
_CARRIES = 0.01  # of all information: a mark with less is no voice
_REMEMBERED = 5.0  # memories: of a mark not seen for longer less than 1 % is left, and it is dropped


@dataclass(frozen=True, slots=True)
class Wanted:
    """One common error: its derivative and what is asked of its estimate.

    ``column`` derivative of an observation [m or rad] by the error; ``sigma`` known beforehand; ``walk`` 1 sigma per
    root of a second; ``common`` 1 sigma of what all marks have in common; ``least_marks`` that carry it;
    ``least_separable`` share of its information that the pose and the other errors leave; ``missing`` says in words
    what is wrong where too few marks do.
    """

    column: Column
    sigma: float
    walk: float
    common: float
    least_marks: float
    least_separable: float
    missing: str


class CommonErrors:
    """Adds up fixes in a memory that fades, and estimates k common errors together.

    Parameters
    ----------
    wanted : the errors
    memory_s : information fades by 1/e in so many seconds
    probability : two-sided, that a significant error is told from zero
    """

    def __init__(self, wanted: Sequence[Wanted], *, memory_s: float, probability: float) -> None:
        self._wanted, self._memory_s, self._probability = tuple(wanted), memory_s, probability
        self._prior = np.diag([1.0 / w.sigma**2 for w in wanted])
        self._voices: dict[str, _Voice] = {}
        self._whole = np.zeros(len(wanted))
        self._time_s = -math.inf
        self._fixes = 0

    def feed(self, fix: Fix, *, applied: Sequence[float]) -> None:
        """Take a fix, from whose data ``applied`` of each error was taken off.

        A fix without an epoch or a time, or in a plane of its own, says nothing.
        """
        epoch = fix.epoch
        if epoch is None or epoch.time_utc is None or not isinstance(fix.position, Position):
            return
        marks = {mark.label: mark for mark in epoch.marks}
        rows, labels = whitened_rows(fix, fix.position, marks, [w.column for w in self._wanted], np.asarray(applied))
        if len(rows) < 4:
            return
        self._fade(epoch.time_utc.timestamp())
        self._fixes += 1
        self._add(rows, labels)

    def estimate(self) -> tuple[CommonError, ...]:
        """Return each error with its sigma; one that says nothing has its sigma from beforehand."""
        voices = list(self._voices.values())
        count = len(self._wanted)
        N = sum((v.information for v in voices), np.zeros((count, count)))
        u = sum((v.total for v in voices), np.zeros(count))
        inverse = np.linalg.inv(N + self._prior)
        value = inverse @ u
        without = np.array([np.linalg.solve(N - v.information + self._prior, u - v.total) for v in voices])
        spread = _jackknife(without.reshape(-1, count))
        left = np.maximum(1.0 / np.diag(inverse) - np.diag(self._prior), 0.0)
        found = []
        for i, wanted in enumerate(self._wanted):
            carried = np.array([v.information[i, i] for v in voices])
            known = wanted.walk**2 * self._memory_s / 2.0 + wanted.common**2  # the estimate is a mean over the memory
            scatter = max(spread[i], inverse[i, i])
            separable = float(left[i] / self._whole[i]) if self._whole[i] > 0.0 else 0.0
            found.append(self._judged(wanted, float(value[i]), (scatter, known), separable, _voices(carried)))
        return tuple(found)

    def _judged(
        self, wanted: Wanted, value: float, variances: tuple[float, float], separable: float, marks: float
    ) -> CommonError:
        """Judge an estimate by its variances: how the marks scatter, which few hardly tell, and what is stated."""
        observable, significant, reason = False, False, None
        if marks < wanted.least_marks:
            reason = f"{wanted.missing}; {wanted.least_marks:.0f} are the least"
        elif separable < wanted.least_separable:
            reason = f"the position explains it as well: {100.0 * separable:.0f} % of its information is left"
        else:
            observable = True
            quantiles = [student_quantile((1.0 + self._probability) / 2.0, dof) for dof in (marks - 1.0, MANY)]
            significant = abs(value) > math.hypot(
                *(q * math.sqrt(v) for q, v in zip(quantiles, variances, strict=True))
            )
            reason = None if significant else "it is not told from zero"
        return CommonError(
            value, math.sqrt(sum(variances)), separable, marks, self._fixes, observable, significant, reason
        )

    def _fade(self, time_s: float) -> None:
        elapsed_s = max(time_s - self._time_s, 0.0) if math.isfinite(self._time_s) else 0.0
        kept = math.exp(-elapsed_s / self._memory_s)
        self._time_s = max(time_s, self._time_s)
        self._whole *= kept
        self._voices = {
            label: _Voice(v.information * kept, v.total * kept, v.heard_s)
            for label, v in self._voices.items()
            if self._time_s - v.heard_s <= _REMEMBERED * self._memory_s
        }

    def _add(self, rows: FloatArray, labels: Sequence[str]) -> None:
        """Eliminate the pose of one fix; heading also takes a constant error of true bearings, as in the adjustment."""
        A, a, misclosure = rows[:, :3], rows[:, 3:-1], rows[:, -1]
        basis, _ = np.linalg.qr(A)
        left = a - basis @ (basis.T @ a)
        rest = misclosure - basis @ (basis.T @ misclosure)
        self._whole += np.sum(a**2, axis=0)
        for label in dict.fromkeys(labels):
            own = np.array([label == other for other in labels])
            voice = self._voices.get(label)
            N, u = left[own].T @ left[own], left[own].T @ rest[own]
            if voice is not None:
                N, u = N + voice.information, u + voice.total
            self._voices[label] = _Voice(N, u, self._time_s)


@dataclass(frozen=True, slots=True, eq=False)
class _Voice:
    """What one mark says: information (k, k) and misclosure sum (k,); when it was heard last [s]."""

    information: FloatArray
    total: FloatArray
    heard_s: float


def student_quantile(probability: float, dof: float) -> float:
    """Return the quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(dof, probability))


def _jackknife(without: FloatArray) -> FloatArray:
    """Return the variance (k,) of an estimate from its values (m, k) without one mark after the other."""
    count = len(without)
    if count < 2:
        return np.full(without.shape[1], np.inf)
    return np.asarray((count - 1.0) / count * np.sum((without - without.mean(axis=0)) ** 2, axis=0))


def _voices(carried: FloatArray) -> float:
    """Return how many marks carry the information: uneven shares count less (1 / sum of squared shares)."""
    total = float(carried.sum())
    if total <= 0.0:
        return 0.0
    shares = carried[carried > _CARRIES * total] / total
    return float(shares.sum() ** 2 / np.sum(shares**2))


def whitened_rows(
    fix: Fix, position: Position, marks: dict[str, Mark], columns: Sequence[Column], applied: FloatArray
) -> tuple[FloatArray, list[str]]:
    """Return the whitened rows (n, 3 + k + 1): design, columns of the errors, misclosure; and the mark of each."""
    rows, labels = [], []
    plane = LocalPlane(position)
    for o in fix.observations:
        mark = marks.get(o.mark)
        if mark is None or o.weight <= 0.0 or o.sigma <= 0.0:
            continue
        north, east = plane.to_plane(mark.position)
        range_m, azimuth = math.hypot(north, east), math.atan2(east, north)
        unit = 1.0 if o.unit == "m" else math.radians(1.0)
        root = math.sqrt(o.weight) / (o.sigma * unit)
        a = np.array([column(o, mark, range_m, azimuth) for column in columns])
        misclosure = float(a @ applied) - o.residual * unit
        rows.append(root * np.array([*_design(o, range_m, azimuth), *a, misclosure]))
        labels.append(o.mark)
    return np.array(rows), labels


def _design(o: AdjustedObservation, range_m: float, azimuth_rad: float) -> tuple[float, float, float]:
    """Return the derivatives of an observation by north, east, heading."""
    cos, sin = math.cos(azimuth_rad), math.sin(azimuth_rad)
    if o.kind == "range":
        return -cos, -sin, 0.0
    return sin / range_m, -cos / range_m, -1.0
