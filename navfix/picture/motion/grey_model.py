"""Grey model GM(1,1) of a series of equally spaced values, and the motion model that it makes of a history.

References
----------
[1] Dong, AARFS system level design (2008), eq. 1.3 to 1.17; the stray minus of (1.11) is a product.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from navfix.catalog import AisModel, persisting_model
from navfix.errors import InputError
from navfix.picture.motion.growth import step_sigma_m
from navfix.picture.motion.history import History, unwrapped
from navfix.picture.motion.outcome import Carried, Declined
from navfix.picture.motion.steering import STILL_MPS, steering
from navfix.types import FloatArray

LEAST_VALUES = 5  # the source: n > 4
FARTHEST_STEPS = 3.0  # beyond the last value an exponential runs away
LIFT = 1000.0  # values over steps: ten miles between scans of a slow ship, in the terms of the source
MOST_UNEVEN = 3.0  # longest over shortest gap of the reports of a series


@dataclass(frozen=True, slots=True)
class GreyModel:
    """x0(k) + a z1(k) = b about the first value: ``a`` (development), ``b`` (grey input), ``first``."""

    a: float
    b: float
    first: float

    def accumulated(self, steps: ArrayLike) -> FloatArray:
        """Return x1 at ``steps`` after the first value (0: the first), eq. (1.15); the limit b k where a is 0."""
        k = np.asarray(steps, dtype=np.float64)
        return self.first * np.exp(-self.a * k) + self.b * _faded(self.a, k)

    def value(self, steps: ArrayLike) -> FloatArray:
        """Return x0 at ``steps`` after the first value, whole or not, eq. (1.16): x1(k) - x1(k - 1); k = 0: the first.

        Between 0 and 1 the difference would reach before the series: a straight line joins the two.
        """
        k = np.asarray(steps, dtype=np.float64)
        later = np.maximum(k, 1.0)
        found = (self.b - self.a * self.first) * np.exp(-self.a * (later - 1.0)) * _faded(self.a, np.float64(1.0))
        return np.where(k < 1.0, self.first + (found - self.first) * k, found)


def _faded(a: float, k: FloatArray | np.float64) -> FloatArray:
    """Return (1 - e^(-a k)) / a, in the limit k."""
    return np.asarray(k if abs(a) < 1e-12 else -np.expm1(-a * k) / a)


def accumulate(values: ArrayLike) -> FloatArray:
    """Return the accumulated series x1, eq. (1.5)."""
    return np.cumsum(np.asarray(values, dtype=np.float64))


def means(values: ArrayLike) -> FloatArray:
    """Return the means z1 of neighbours of the accumulated series, eq. (1.7), shape (n - 1,)."""
    x1 = accumulate(values)
    return 0.5 * (x1[:-1] + x1[1:])


def fit(values: ArrayLike) -> GreyModel:
    """Fit GM(1,1) to a series as the source asks for one.

    Raises
    ------
    InputError : fewer than five values, or one that is not positive
    """
    return closed_form(_checked(values))


def closed_form(values: ArrayLike) -> GreyModel:
    """Fit GM(1,1) by the closed form, eq. (1.11) and (1.12), to a series of any length.

    Where the least squares have no single answer (fewer than three values, one value beside which the others are
    nothing) the model is level: the mean of all values but the first.
    """
    x0, z1 = np.asarray(values, dtype=np.float64), means(values)
    n, y = len(z1), x0[1:]
    C, D, E, F = z1.sum(), y.sum(), z1 @ y, z1 @ z1
    determinant = n * F - C * C
    if n < 2 or determinant <= 1e-12 * n * F:
        return GreyModel(0.0, float(y.mean() if n else x0[0]), float(x0[0]))
    return GreyModel(float((C * D - n * E) / determinant), float((D * F - C * E) / determinant), float(x0[0]))


def fit_by_matrix(values: ArrayLike) -> GreyModel:
    """Fit GM(1,1) by least squares with the matrix B, eq. (1.9) and (1.10): the same as `fit`."""
    x0, z1 = _checked(values), means(values)
    B = np.column_stack([-z1, np.ones_like(z1)])
    a, b = np.linalg.solve(B.T @ B, B.T @ x0[1:])
    return GreyModel(float(a), float(b), float(x0[0]))


def _checked(values: ArrayLike) -> FloatArray:
    x0 = np.asarray(values, dtype=np.float64)
    if x0.ndim != 1 or len(x0) < LEAST_VALUES or not np.all(x0 > 0.0):
        raise InputError(f"GM(1,1) needs a series of at least {LEAST_VALUES} positive values, got {x0!r}")
    return x0


def class_ratios(values: ArrayLike) -> FloatArray:
    """Return x0(k - 1) / x0(k), eq. (1.17)."""
    x0 = np.asarray(values, dtype=np.float64)
    return x0[:-1] / x0[1:]


def admissible(values: ArrayLike) -> bool:
    """Tell whether all class ratios lie within (e^(-2/(n+1)), e^(2/(n+1))), eq. (1.17), and all values are positive."""
    x0 = np.asarray(values, dtype=np.float64)
    if not np.all(x0 > 0.0):
        return False
    return bool(np.all(np.abs(np.log(class_ratios(x0))) < 2.0 / (len(x0) + 1.0)))


def longest_admissible(series: Sequence[ArrayLike], *, least: int = LEAST_VALUES) -> int:
    """Return the largest n >= ``least`` so that n values of every series pass the class-ratio test together, or 0."""
    arrays = [np.asarray(values, dtype=np.float64) for values in series]
    for n in range(min(map(len, arrays)), least - 1, -1):
        if all(admissible(values[:n]) for values in arrays):
            return n
    return 0


def lifted(values: ArrayLike) -> tuple[FloatArray, float]:
    """Return the series shifted up to where its steps are small beside its values, and the shift; 0 where they are.

    The class-ratio test breaks down near zero and for negative values, and GM(1,1) bends a straight line that starts
    there into an exponential; of the lifted series, less the shift, it is a good model of the series.
    """
    x0 = np.asarray(values, dtype=np.float64)
    widest = float(np.max(np.abs(np.diff(x0)), initial=0.0))
    shift = max(max(LIFT * widest, 1.0) - float(np.min(x0)), 0.0)
    return x0 + shift, shift


def lifted_angles(angle_rad: ArrayLike) -> tuple[FloatArray, float]:
    """Return angles [rad] unwrapped and lifted, and the shift: 359 and 1 deg are neighbours, and 0 is no ratio."""
    return lifted(unwrapped(np.asarray(angle_rad, dtype=np.float64)))


def at_times(values: ArrayLike, start_s: float, step_s: float, wanted_s: ArrayLike) -> FloatArray:
    """Return a series at other times [s]: one GM(1,1) brings radar's even scans onto the instants of AIS."""
    series, shift = lifted(values)
    return fit(series).value((np.asarray(wanted_s, dtype=np.float64) - start_s) / step_s) - shift


def carry(past: History, at_s: float, model: AisModel) -> Carried | Declined:
    """Carry a ship by GM(1,1) of its last positions north and east, brought to even steps by straight lines.

    Declines with fewer than five reports, with gaps that differ too much, and more than three steps ahead.
    """
    steers = steering(past, persisting_model())
    if steers is None or steers.speed_mps <= STILL_MPS:
        return Declined("a grey model needs a ship that moves and says how fast")
    if len(past) < LEAST_VALUES:
        return Declined(f"a grey model needs {LEAST_VALUES} reports, there are {len(past)}")
    time_s = past.time_s[LEAST_VALUES - 1 :: -1]
    gaps_s = np.diff(time_s)
    if gaps_s.max() > MOST_UNEVEN * gaps_s.min():
        return Declined(f"gaps between reports from {gaps_s.min():.0f} to {gaps_s.max():.0f} s are too uneven")
    step_s = float(time_s[-1] - time_s[0]) / (LEAST_VALUES - 1)
    age_s = at_s - float(time_s[-1])
    if not -step_s <= age_s <= FARTHEST_STEPS * step_s:
        return Declined(f"{age_s:.0f} s is too far from reports every {step_s:.0f} s")
    even_s = time_s[0] + step_s * np.arange(LEAST_VALUES)
    north, east = (
        float(at_times(np.interp(even_s, time_s, axis[LEAST_VALUES - 1 :: -1]), float(time_s[0]), step_s, at_s))
        for axis in (past.north_m, past.east_m)
    )
    sigma_m = math.hypot(step_sigma_m(steers, age_s, model), model.clock_sigma_s * steers.speed_mps * age_s / step_s)
    return Carried(north, east, sigma_m)
