"""The laws of own motion between two instants: the way through the water, a turn, and how a velocity wanders."""

from __future__ import annotations

import numpy as np

from navfix.types import FloatArray


def through_water(log_mps: tuple[float, float], heading_deg: float, turned_deg: float, step_s: float) -> complex:
    """Return the way (north, east) [m, complex] by the log at both ends of a step, along the heading in its middle."""
    middle = np.exp(1j * np.radians(heading_deg + 0.5 * turned_deg))
    return complex(0.5 * (log_mps[0] + log_mps[1]) * step_s * middle)


def turned(velocity: complex, turned_deg: float) -> complex:
    """Return a velocity that has turned with the ship."""
    return complex(velocity * np.exp(1j * np.radians(turned_deg)))


def wandering(walk: float, step_s: float) -> FloatArray:
    """Return the covariance (4, 4) that a wandering velocity adds in a step; ``walk`` in (m/s)^2 per s: eq. (10.12)."""
    axis = walk * np.array([[step_s**3 / 3.0, step_s**2 / 2.0], [step_s**2 / 2.0, step_s]])
    return np.asarray(np.kron(axis, np.eye(2)), np.float64)
