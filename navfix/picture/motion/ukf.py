"""Unscented Kalman filter of a track: additive noise, or the state augmented by the noises as the source has it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from navfix.catalog import FilterModel
from navfix.picture.motion.geodetic_turn import process_noise, propagate
from navfix.picture.motion.turn_filter import State
from navfix.picture.motion.unscented import Scaling, Transformed, transform
from navfix.types import FloatArray

Function = Callable[[FloatArray], FloatArray]


def predict(state: State, to_s: float, constants: FilterModel) -> State:
    """Move a state on to another time [POSIX s], earlier or later."""
    time_s = to_s - state.time_s
    scaling = Scaling(constants.alpha, constants.beta, constants.kappa)
    moved = transform(state.mean, state.covariance, lambda x: propagate(x, time_s, constants.turn_persist_s), scaling)
    covariance = moved.covariance + process_noise(state.mean, time_s, constants)
    return State(to_s, moved.mean, covariance)


def update(
    mean: FloatArray, covariance: FloatArray, observed: FloatArray, function: Function, noise: FloatArray, by: Scaling
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance after an observation with additive noise (source, step 4)."""
    return _gain(mean, covariance, observed, transform(mean, covariance, function, by), noise)


def predict_augmented(
    mean: FloatArray,
    covariance: FloatArray,
    function: Callable[[FloatArray, FloatArray], FloatArray],
    noise: FloatArray,
    by: Scaling,
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance of ``function(x, w)``, the state augmented by the process noise w."""
    n = len(mean)
    moved = transform(
        np.concatenate([mean, np.zeros(len(noise))]),
        _block(covariance, noise),
        lambda a: function(a[:, :n], a[:, n:]),
        by,
    )
    return moved.mean, moved.covariance


def update_augmented(
    mean: FloatArray,
    covariance: FloatArray,
    observed: FloatArray,
    function: Callable[[FloatArray, FloatArray], FloatArray],
    noise: FloatArray,
    by: Scaling,
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance after an observation ``function(x, v)``, the state augmented by its noise v."""
    n = len(mean)
    seen = transform(
        np.concatenate([mean, np.zeros(len(noise))]),
        _block(covariance, noise),
        lambda a: function(a[:, :n], a[:, n:]),
        by,
    )
    seen = Transformed(seen.mean, seen.covariance, seen.cross[:n])
    return _gain(mean, covariance, observed, seen, np.zeros_like(noise))


def _gain(
    mean: FloatArray, covariance: FloatArray, observed: FloatArray, seen: Transformed, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    S = seen.covariance + noise
    K = np.linalg.solve(S, seen.cross.T).T
    return mean + K @ (observed - seen.mean), covariance - K @ S @ K.T


def _block(first: FloatArray, second: FloatArray) -> FloatArray:
    n = len(first)
    joined = np.zeros((n + len(second), n + len(second)))
    joined[:n, :n], joined[n:, n:] = first, second
    return joined
