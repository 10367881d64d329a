"""Step 6b: the EM of one scan, over a window: responsibilities of whole tracks, Gauss-Newton on the whole own motion.

E-step: each track is one of the marks near it, or clutter that stands or moves. M-step: one Gauss-Newton step on all
knots and the clock, with the priors of own motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from navfix.association.em import NOMINAL_LEVEL, NOMINAL_SHARE
from navfix.association.window.field import WindowField
from navfix.association.window.fit import Clutter, Fit, as_clutter, lay_over, log_fit
from navfix.association.window.knots import Knots, MotionPrior
from navfix.association.window.normal import normal_equations
from navfix.types import FloatArray


@dataclass(frozen=True, eq=False)
class Expectation:
    """Responsibilities (k, m, q) of the marks and (k, m) of clutter."""

    on_mark: FloatArray
    on_clutter: FloatArray
    scatter_weight: FloatArray
    clutter: Clutter


def density_ratio(
    field: WindowField, fit: Fit, clutter: Clutter, widening: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Return N_ij / (lambda_i V_i) (k, m, q), and the weight of the scatter: eq. (6.20) at detection odds of one."""
    log_density, weight = log_fit(field, fit, widening)
    against = np.log(field.flat.clutter_per_m2)[None, :] + clutter.log_density
    ratio = np.exp(np.minimum(log_density - against[:, :, None], 200.0))
    return (ratio if fit.barred is None else np.where(fit.barred[:, :, None], 0.0, ratio)), weight


def expect(field: WindowField, fit: Fit, widening: float = 1.0) -> Expectation:
    """Return the E-step at nominal clutter share and detection level."""
    clutter = as_clutter(field, fit.path)
    density, weight = density_ratio(field, fit, clutter, widening)
    ratio = field.odds(fit.mark, NOMINAL_LEVEL) * density
    total = NOMINAL_SHARE + ratio.sum(axis=2)
    return Expectation(ratio / total[:, :, None], NOMINAL_SHARE / total, weight, clutter)


def knot_step(field: WindowField, knots: Knots, widening: float, prior: MotionPrior) -> tuple[Knots, FloatArray]:
    """One E-step and one M-step over all unknowns; return the moved motions and the information (k, d, d).

    k sets of barred tracks on one motion make k of it.
    """
    fit = lay_over(field, knots)
    information, gradient = normal_equations(field, knots, fit, expect(field, fit, widening), widening)
    information += prior.full_information
    gradient += prior.gradient(knots)
    step: FloatArray = np.asarray(np.linalg.solve(information, gradient[:, :, None])[:, :, 0], dtype=np.float64)
    return knots.moved(step), information
