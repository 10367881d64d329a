"""Extended Kalman filter of a track: the same motion as the unscented one, through its derivative."""

from __future__ import annotations

from navfix.catalog import FilterModel
from navfix.picture.motion.geodetic_turn import jacobian, process_noise, propagate
from navfix.picture.motion.turn_filter import State


def predict(state: State, to_s: float, constants: FilterModel) -> State:
    """Move a state on to another time [POSIX s], earlier or later."""
    time_s = to_s - state.time_s
    F = jacobian(state.mean, time_s, constants.turn_persist_s)
    covariance = F @ state.covariance @ F.T + process_noise(state.mean, time_s, constants)
    return State(to_s, propagate(state.mean, time_s, constants.turn_persist_s), covariance)
