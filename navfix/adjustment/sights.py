"""What a network would observe from one or many poses: lines of sight, residuals, derivatives, combined sigma."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from navfix.adjustment.network import Network
from navfix.types import FloatArray
from navfix.units import wrap_pi

_TURN_RAD = 2.0 * np.pi
NEAREST_M = 1e-6  # a mark nearer than this has no direction: keeps the derivatives finite


class Sight(NamedTuple):
    """From own ship to the observed marks: north, east and distance [m], each (..., m)."""

    north: FloatArray
    east: FloatArray
    distance: FloatArray


def sight(network: Network, pose: FloatArray) -> Sight:
    """Return the lines of sight from ``pose`` (..., 3)."""
    north, east = network.place[0] - pose[..., 0:1], network.place[1] - pose[..., 1:2]
    return Sight(north, east, np.maximum(np.hypot(north, east), NEAREST_M))


def predict(network: Network, pose: FloatArray, seen: Sight | None = None) -> FloatArray:
    """Return what would be observed from ``pose`` (..., 3): (..., m) in m and rad (bearings not wrapped)."""
    north, east, distance = seen or sight(network, pose)
    bearing = np.arctan2(east, north) - network.is_relative * pose[..., 2:3]
    return np.where(network.is_range, distance, bearing)


def residuals(network: Network, pose: FloatArray, seen: Sight | None = None) -> FloatArray:
    """Return v = adjusted - observed, (..., m) in m and rad, bearings within -pi .. pi."""
    v = predict(network, pose, seen) - network.value
    turns = np.rint(v * (1.0 / _TURN_RAD))
    return np.asarray(v - np.where(network.is_range, 0.0, turns * _TURN_RAD))


def jacobian(network: Network, pose: FloatArray, seen: Sight | None = None) -> FloatArray:
    """Return d prediction / d (north, east, heading), (..., m, 3)."""
    north, east, distance = seen or sight(network, pose)
    inverse = 1.0 / distance
    cos, sin = north * inverse, east * inverse
    result = np.empty((*north.shape, 3))
    result[..., 0] = np.where(network.is_range, -cos, sin * inverse)
    result[..., 1] = np.where(network.is_range, -sin, -cos * inverse)
    result[..., 2] = -1.0 * network.is_relative
    return result


def curvature(network: Network, seen: Sight, factor: FloatArray) -> FloatArray:
    """Return the sum of ``factor`` (..., m) times d^2 prediction / d (north, east)^2, (..., 2, 2).

    The heading enters linearly. What the Gauss-Newton method leaves out: it matters where residuals are large.
    """
    inverse = 1.0 / seen.distance
    cos, sin = seen.north * inverse, seen.east * inverse
    by_range = np.where(network.is_range, factor * inverse, 0.0)
    by_bearing = np.where(network.is_range, 0.0, factor * inverse**2)
    mixed = cos * sin
    result = np.empty((*seen.north.shape[:-1], 2, 2))
    result[..., 0, 0] = np.sum(by_range * sin**2 + 2.0 * mixed * by_bearing, axis=-1)
    result[..., 1, 1] = np.sum(by_range * cos**2 - 2.0 * mixed * by_bearing, axis=-1)
    result[..., 0, 1] = result[..., 1, 0] = np.sum(by_bearing * (sin**2 - cos**2) - by_range * mixed, axis=-1)
    return result


def effective_sigma(network: Network, jacobian_: FloatArray) -> FloatArray:
    """Return 1 sigma of each observation, instrument and mark combined, (..., m).

    The mark is eliminated: moving it by s changes the prediction as moving own ship by -s does, so the variance is
    sigma^2 + j S j' with j the position part of the Jacobian: sigma^2 + s^2 for a range, sigma^2 + (s / d)^2 for a
    bearing at distance d to a mark of s per axis.
    """
    north, east = jacobian_[..., 0], jacobian_[..., 1]
    spread = network.spread_m2
    moved = spread[0] * north**2 + (spread[1] * north + spread[2] * east) * east
    return np.asarray(np.sqrt(network.sigma**2 + moved))


def prior_residual(network: Network, pose: FloatArray) -> FloatArray:
    """Return heading minus prior in units of its sigma, (...); zero without a prior or with a known heading."""
    if not network.prior_counts or network.heading_prior_rad is None:
        return np.zeros(pose.shape[:-1])
    heading_rad, sigma_rad = network.heading_prior_rad
    return np.asarray(wrap_pi(pose[..., 2] - heading_rad) / sigma_rad)
