"""Protection levels from separated solutions and, beside them, from slopes: eq. (7.2) to (7.6)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from navfix.errors import InputError
from navfix.integrity.separation import Blocks, Separation
from navfix.types import FloatArray

_AXES = 2


def false_alarm_factor(probability: float, hypotheses: int, axes: int = _AXES) -> float:
    """Return K_fa: a two-sided normal quantile, the probability split evenly over hypotheses and axes."""
    return _quantile(probability / (2.0 * axes * hypotheses))


def missed_detection_factor(probability: float, hypotheses: int, axes: int = _AXES) -> float:
    """Return K_md: the same for the hypotheses and, as one more, that nothing is wrong."""
    return _quantile(probability / (2.0 * axes * (hypotheses + 1)))


def _quantile(tail: float) -> float:
    from scipy.special import ndtri

    return -float(ndtri(tail))


@dataclass(frozen=True, slots=True, eq=False)
class Levels:
    """What solution separation says: ``protection_m``, and the hypotheses whose shift is beyond its threshold.

    ``worst`` is the hypothesis that makes the level what it is, -1 where none does: the fix itself.
    ``ratio`` (h,) is the largest shift over its threshold, of north and east.
    """

    protection_m: float
    worst: int
    ratio: FloatArray

    @property
    def alarms(self) -> tuple[int, ...]:
        """Hypotheses that an alarm stands against."""
        return tuple(int(i) for i in np.flatnonzero(self.ratio > 1.0))


def separation_levels(
    separation: Separation, *, scale: float, probability_of_false_alarm: float, probability_of_missed_detection: float
) -> Levels:
    """Return the protection level PL_k = K_fa sqrt(s_k^2 - s_0^2) + K_md s_k, the worst of all k on each axis.

    HPL = hypot(PL_north, PL_east), eq. (7.3) and (7.4); ``scale`` multiplies every sigma. The alarm of hypothesis k is
    a shift beyond K_fa sqrt(s_k^2 - s_0^2), eq. (7.2): without an alarm, an error that mark k causes stays within PL_k
    but for the probability of missed detection.
    """
    count = len(separation.without)
    k_fa = false_alarm_factor(probability_of_false_alarm, max(count, 1))
    k_md = missed_detection_factor(probability_of_missed_detection, count)
    whole = scale * np.sqrt(np.diagonal(separation.cofactor)[:_AXES])
    sigma = scale * np.sqrt(np.diagonal(separation.without, axis1=1, axis2=2)[:, :_AXES])
    threshold = k_fa * scale * np.sqrt(separation.variance[:, :_AXES])
    level = np.vstack([k_md * whole, threshold + k_md * sigma])
    ratio = np.abs(separation.shift[:, :_AXES]) / np.maximum(threshold, 1e-9)
    worst = int(np.argmax(np.hypot(*level.T))) - 1
    return Levels(float(np.hypot(*level.max(axis=0))), worst, ratio.max(axis=1, initial=0.0))


def level_of_risk(
    sigma: float,
    hypothesis_sigma: ArrayLike,
    threshold: ArrayLike,
    prior: ArrayLike,
    risk: float,
    *,
    bias: float = 0.0,
    hypothesis_bias: ArrayLike = 0.0,
) -> float:
    """Return the level of one axis whose whole risk is ``risk``: the least that the hypotheses allow, eq. (7.5).

    2 Q((PL - b_0) / s_0) + sum over k of p_k Q((PL - T_k - b_k) / s_k) = risk, solved by bisection to 1e-6.
    `separation_levels` splits the risk evenly beforehand (all p_k = 1) and is never below this.

    References
    ----------
    Blanch et al., Advanced RAIM user algorithm description, 2012: the equations of VPL and HPL.
    """
    from scipy.special import ndtr

    sigmas, thresholds, priors, biases = np.broadcast_arrays(hypothesis_sigma, threshold, prior, hypothesis_bias)

    def excess(level: float) -> float:
        faulty = float(np.sum(priors * ndtr(-(level - thresholds - biases) / sigmas)))
        return 2.0 * float(ndtr(-(level - bias) / sigma)) + faulty - risk

    if not 0.0 < risk < 1.0:
        raise InputError(f"risk must be within 0 .. 1, got {risk!r}")
    low, high = 0.0, sigma
    while excess(high) > 0.0:
        low, high = high, 2.0 * high
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return high


def slope_level(
    blocks: Blocks,
    cofactor: FloatArray,
    *,
    scale: float,
    dof: float,
    probability_of_false_alarm: float,
    probability_of_missed_detection: float,
) -> float:
    """Return the slope protection level [m]: the worst ratio of position error to its sign in the residuals, eq. (7.6).

    An error f in the observations of mark k shifts the position by |G_k f| and adds f'(I - H_k) f to the sum of
    squares, which is noticed for sure from the non-centrality that leaves it below the global test's threshold only
    with the probability of missed detection. Infinite where no redundancy controls a mark. Not a strict bound: the
    noise of the fix itself is not in it.

    References
    ----------
    Brown & Chin, GPS RAIM: calculation of thresholds and protection radius, 1998; Walter & Enge, Weighted RAIM, 1995.
    """
    from scipy.special import chndtrinc, gammaincinv

    if dof <= 0.0:
        return math.inf
    gain = (blocks.rows @ cofactor)[:, :, :_AXES]
    seen = np.eye(blocks.rows.shape[1]) - blocks.rows @ cofactor @ np.swapaxes(blocks.rows, 1, 2)
    if np.linalg.eigvalsh(seen)[:, 0].min() < 1e-9:
        return math.inf
    squared = np.linalg.eigvals(np.linalg.solve(seen, gain @ np.swapaxes(gain, 1, 2))).real.max()
    threshold = 2.0 * float(gammaincinv(dof / 2.0, 1.0 - probability_of_false_alarm))
    noncentrality = float(chndtrinc(threshold, dof, probability_of_missed_detection))
    return scale * math.sqrt(float(squared) * noncentrality)
