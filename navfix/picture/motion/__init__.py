"""Motion models: where a mark is some seconds after its report, and how sure that is; chosen by name and by data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

from navfix.catalog import AisModel
from navfix.errors import InputError
from navfix.picture.motion import (
    constant_acceleration,
    constant_turn,
    constant_velocity,
    ekf,
    grey_model,
    persisting,
    smoother,
    spline,
    turn_filter,
    ukf,
)
from navfix.picture.motion.history import History, Point, history
from navfix.picture.motion.outcome import Carried, Declined

__all__ = ["DEFAULT", "MODELS", "Carried", "Declined", "History", "MotionModel", "Point", "carry", "history"]

MotionModel = Callable[[History, float, AisModel], Carried | Declined]

MODELS: Mapping[str, MotionModel] = MappingProxyType(
    {
        "constant_velocity": constant_velocity.carry,
        "constant_acceleration": constant_acceleration.carry,
        "constant_turn": constant_turn.carry,
        "persisting": persisting.carry,
        "grey": grey_model.carry,
        "spline": spline.carry,
        "smoother": smoother.carry,
        "unscented": partial(turn_filter.carry, predict=ukf.predict),
        "extended": partial(turn_filter.carry, predict=ekf.predict),
    }
)
DEFAULT = "persisting"


def carry(past: History, at_s: float, model: AisModel, *, name: str = DEFAULT) -> Carried:
    """Carry a station to an instant by a motion model; where that would rather not, by the default one.

    Parameters
    ----------
    past : what the station has reported, newest first
    at_s : the instant [POSIX s]
    model : how the sigma of its class grows
    name : one of `MODELS`

    Raises
    ------
    InputError : no such motion model
    """
    if name not in MODELS:
        raise InputError(f"no motion model named {name!r}; there are {', '.join(sorted(MODELS))}")
    carried = MODELS[name](past, at_s, model)
    return carried if isinstance(carried, Carried) else persisting.carry(past, at_s, model)
