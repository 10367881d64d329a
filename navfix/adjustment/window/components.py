"""Variance components: how large the errors of each sort really are, and how long they remember."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.adjustment.window.descent import COARSE, Damper, Descended, descend, inverse_of, normal_of, products_of
from navfix.adjustment.window.rows import (
    COMPONENTS,
    GIVEN,
    MOVE,
    NEW_BEARING,
    NEW_RANGE,
    OFFSET,
    PAIRS,
    STEADY_BEARING,
    STEADY_RANGE,
    TURN,
    Plan,
    Rows,
)
from navfix.catalog import AdjustmentModel
from navfix.types import FloatArray, IntArray

_FEWEST_NEIGHBOURS = 30
_MEMORY_BEGINS, _LONGEST_MEMORY = 0.15, 0.9


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """A solution with the cofactor matrix of all unknowns and, by component, squared residuals and redundancy."""

    descended: Descended
    damper: Damper
    cofactor: FloatArray
    squared: FloatArray
    redundancy: FloatArray
    memory: FloatArray


def judged(damper: Damper, descended: Descended, memory: FloatArray | None = None) -> Judged:
    """Assess a solution: partial redundancies r_g = sum of w (1 - w a'Qa) and squared residuals by component."""
    rows, w = descended.rows, descended.weights.row
    cofactor = inverse_of(normal_of(damper, rows, descended.weights)[0])
    lever = _levers(damper.plan, rows, cofactor)
    redundancy = _summed(rows.component, w * np.clip(1.0 - w * lever, 0.0, 1.0))
    squared = _summed(rows.component, w * rows.residual**2)
    return Judged(descended, damper, cofactor, squared, redundancy, np.ones(COMPONENTS) if memory is None else memory)


def _levers(plan: Plan, rows: Rows, cofactor: FloatArray) -> FloatArray:
    """Return a'Qa (m,) of the rows."""
    around = cofactor.ravel()[plan.place].reshape(len(PAIRS[0]), -1)
    twice = np.where(PAIRS[0] == PAIRS[1], 1.0, 2.0)
    return np.asarray(twice @ (products_of(rows.values, rows.values) * around))


def _summed(component: IntArray, values: FloatArray) -> FloatArray:
    return np.asarray(np.bincount(component, values, COMPONENTS), np.float64)


def with_components(damper: Damper, descended: Descended) -> Judged:
    """Estimate the variance components, then the memory of what is new in each scan, and solve with both; eq. (10.8).

    ``prior_dof`` degrees of freedom stand behind what each component is expected to be, so that few residuals change
    little. Own ship's motion is never taken for steadier than its model says. Errors of one track that resemble those
    of the scan before count for fewer observations: their variance grows by (1 + rho) / (1 - rho).
    """
    model = damper.plan.window.model
    found = judged(damper, descended)
    for _ in range(model.component_rounds):
        components = _estimated(found)
        if np.all(np.abs(np.log(components / damper.components)) < 0.02):
            break
        damper = replace(damper, components=components)
        found = judged(damper, descend(damper, found.descended.state, tolerance=COARSE))
    memory = _memory(found)
    damper = replace(damper, components=damper.components * memory)
    return judged(damper, descend(damper, found.descended.state), memory)


def _estimated(found: Judged) -> FloatArray:
    model, before = found.damper.plan.window.model, found.damper.components
    prior = model.prior_dof
    components = (prior * expected_components(before, model) + before * found.squared) / (prior + found.redundancy)
    components = np.clip(components, model.smallest_component, model.largest_component)
    components[[TURN, MOVE]] = np.maximum(components[[TURN, MOVE]], 1.0)
    components[GIVEN] = 1.0
    return np.asarray(components)


def expected_components(components: FloatArray, model: AdjustmentModel) -> FloatArray:
    """Return what each component is expected to be: 1, and for what stays with a track the rest of the stated total.

    A radar's sigma states the total of what stays and what is new. What is new shows in hundreds of sightings, what
    stays in a few tracks: so the total less what is new is expected to stay, and at least ``least_steady_share`` of
    the larger of the two; eq. (10.8a).
    """
    expected = np.ones(COMPONENTS)
    share = model.steady_share
    if share > 0.0:
        new = (1.0 - share) * components[[NEW_RANGE, NEW_BEARING]]
        left = np.maximum(1.0 - new, model.least_steady_share * np.maximum(1.0, new))
        expected[[STEADY_RANGE, STEADY_BEARING]] = left / share
    return expected


def _memory(found: Judged) -> FloatArray:
    """Return the factor (1 + rho) / (1 - rho) of the two components of the radar, 1 where nothing is remembered."""
    plan, seen = found.damper.plan, found.damper.plan.window.seen
    radar = found.descended.rows.residual[plan.radar].reshape(-1, 2) * found.descended.weights.sighting
    order = np.lexsort((seen.epoch, seen.track))
    follows = np.diff(seen.track[order]) == 0
    factor = np.ones(COMPONENTS)
    if np.count_nonzero(follows) < _FEWEST_NEIGHBOURS:
        return factor
    length = len(order) / len(np.unique(seen.track))
    for component, column in ((NEW_RANGE, radar[order, 0]), (NEW_BEARING, radar[order, 1])):
        squared = float(column @ column)
        if squared > 0.0:
            rho = float((column[1:] * column[:-1]) @ follows) / squared * length / max(length - 1.0, 1.0) + 1.0 / length
            if rho > _MEMORY_BEGINS:
                rho = min(rho, _LONGEST_MEMORY)
                factor[component] = (1.0 + rho) / (1.0 - rho)
    return factor


def reference_deviation(found: Judged) -> tuple[float, float]:
    """Return sigma0 of the errors that stay, and its degrees of freedom with those of the priors; eq. (10.9)."""
    stays = [STEADY_RANGE, STEADY_BEARING, OFFSET]
    model, components = found.damper.plan.window.model, found.damper.components
    expected = expected_components(components / found.memory, model)
    dof = float(np.sum(model.prior_dof + found.redundancy[stays]))
    squared = float(np.sum(model.prior_dof * (expected / components)[stays] + found.squared[stays]))
    return math.sqrt(squared / dof), dof
