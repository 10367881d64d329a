"""One error common to all observations of many fixes, with its sigma: what pose and noise cannot explain.

Each fix gives l = A dx + a tau + noise: misclosures, design matrix, and the column of the common error. The pose is
eliminated fix by fix; what is left of ``a`` adds up. Errors of one ship (its hull, its AIS antenna, its clock) last, so
its contributions are one voice: the variance is taken from how the ships scatter (theory, eq. 13.10 to 13.13).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from navfix.geodesy import LocalPlane
from navfix.types import AdjustedObservation, Fix, FloatArray, Mark, Position

Column = Callable[[AdjustedObservation, Mark, float, float], float]  # observation, its mark, range m, azimuth rad


@dataclass(frozen=True, slots=True)
class CommonError:
    """An error common to many observations: value and 1 sigma, in its own unit.

    ``separable`` is the share of its information that pose unknowns leave, 0 .. 1; ``marks`` and ``fixes`` count what
    it stands on; ``significant`` says whether it is told from zero at 95 %; ``reason`` why it is not used, if not.
    """

    value: float
    sigma: float
    separable: float
    marks: int
    fixes: int
    significant: bool
    reason: str | None = None


@dataclass(frozen=True, slots=True)
class _Share:
    """What one fix says: per mark (information, misclosure sum), information before the pose was eliminated."""

    time_s: float
    by_mark: dict[str, tuple[float, float]]
    whole: float


class CommonErrors:
    """Adds up fixes over a span of time.

    Parameters
    ----------
    column : derivative of an observation [m or rad] by the error
    span_s : fixes older than this before the newest are forgotten
    least_marks : fewer marks that carry information give no estimate
    least_separable : below this share the error hides behind the pose
    """

    def __init__(self, column: Column, *, span_s: float, least_marks: int, least_separable: float) -> None:
        self._column = column
        self._span_s, self._least_marks, self._least_separable = span_s, least_marks, least_separable
        self._shares: deque[_Share] = deque()

    def feed(self, fix: Fix, *, applied: float = 0.0) -> None:
        """Take a fix, from whose data ``applied`` of the error was taken off.

        A fix without an epoch or a time, or in a plane of its own, says nothing.
        """
        epoch = fix.epoch
        if epoch is None or epoch.time_utc is None or not isinstance(fix.position, Position):
            return
        marks = {mark.label: mark for mark in epoch.marks}
        share = _share_of(fix, fix.position, marks, self._column, applied, epoch.time_utc.timestamp())
        if share is not None:
            self._shares.append(share)
        while self._shares and self._shares[-1].time_s - self._shares[0].time_s > self._span_s:
            self._shares.popleft()

    def estimate(self) -> CommonError | None:
        """Return the error with its sigma, None before any fix was fed."""
        if not self._shares:
            return None
        marks: dict[str, list[float]] = {}
        for share in self._shares:
            for label, (information, total) in share.by_mark.items():
                known = marks.setdefault(label, [0.0, 0.0])
                known[0] += information
                known[1] += total
        N = sum(information for information, _ in marks.values())
        whole = sum(share.whole for share in self._shares)
        carrying = sum(information > 0.01 * N for information, _ in marks.values()) if N > 0.0 else 0
        separable = N / whole if whole > 0.0 else 0.0
        if separable < self._least_separable or carrying < self._least_marks:
            return CommonError(0.0, math.inf, separable, carrying, len(self._shares), False, self._why(separable))
        value = sum(total for _, total in marks.values()) / N
        left = sum((total - information * value) ** 2 for information, total in marks.values())
        sigma = math.sqrt(max(left * carrying / (carrying - 1.0) / N**2, 1.0 / N))
        significant = abs(value) > student_quantile(0.975, carrying - 1) * sigma
        reason = None if significant else "it is not told from zero"
        return CommonError(value, sigma, separable, carrying, len(self._shares), significant, reason)

    def _why(self, separable: float) -> str:
        if separable < self._least_separable:
            return f"the position explains it as well: only {100.0 * separable:.0f} % of its information is left"
        return f"it needs {self._least_marks} marks that show it"


def student_quantile(probability: float, dof: int) -> float:
    """Return the quantile of Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(dof, probability))


def _share_of(
    fix: Fix, position: Position, marks: dict[str, Mark], column: Column, applied: float, time_s: float
) -> _Share | None:
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
        design = _design(o, range_m, azimuth)
        a = column(o, mark, range_m, azimuth)
        rows.append(root * np.array([*design, a, a * applied - o.residual * unit]))
        labels.append(o.mark)
    if len(rows) < 4:
        return None
    return _reduced(np.array(rows), labels, time_s)


def _design(o: AdjustedObservation, range_m: float, azimuth_rad: float) -> tuple[float, float, float]:
    """Return the derivatives of an observation by north, east, heading."""
    cos, sin = math.cos(azimuth_rad), math.sin(azimuth_rad)
    if o.kind == "range":
        return -cos, -sin, 0.0
    return sin / range_m, -cos / range_m, -1.0


def _reduced(rows: FloatArray, labels: list[str], time_s: float) -> _Share:
    """Eliminate the pose; heading also takes a constant error of true bearings, as the adjustment does."""
    A, a, misclosure = rows[:, :3], rows[:, 3], rows[:, 4]
    basis, _ = np.linalg.qr(A)
    left = a - basis @ (basis.T @ a)
    by_mark: dict[str, tuple[float, float]] = {}
    for label, one, whole, value in zip(labels, left, a, misclosure, strict=True):
        information, total = by_mark.get(label, (0.0, 0.0))
        by_mark[label] = information + float(one * whole), total + float(one * value)
    return _Share(time_s, by_mark, float(a @ a))
