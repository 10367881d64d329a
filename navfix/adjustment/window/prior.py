"""The pose at the first epoch of a window as older data have it: one factor of the network, not mixed in later."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from navfix.adjustment.window.state import COMPASS, Layout
from navfix.geodesy import LocalPlane
from navfix.types import FloatArray, IntArray, Position
from navfix.units import wrap_pi

if TYPE_CHECKING:
    from navfix.adjustment.window.problem import WindowNetwork


@dataclass(frozen=True, slots=True, eq=False)
class KnownPose:
    """Own pose at the first epoch of a window, from data that the window does not hold.

    ``covariance`` (3, 3) in north [m], east [m], heading [rad]. Where all bearings are true, ``heading_deg`` is the
    compass error: the angle that turns the echoes to north.
    """

    position: Position
    heading_deg: float
    covariance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PlanePose:
    """A known pose on the plane of a window: ``pose`` (3,) north m, east m, rad, and R (3, 3), R'R = covariance^-1."""

    known: KnownPose
    pose: FloatArray
    root: FloatArray


def on_plane(known: KnownPose | None, plane: LocalPlane, any_relative: bool) -> PlanePose | None:
    """Bring a known pose onto a plane; the compass error of true bearings is the same on every plane."""
    if known is None:
        return None
    turn_deg = known.heading_deg - (plane.convergence_deg(known.position) if any_relative else 0.0)
    pose = np.append(plane.to_plane(known.position), math.radians(turn_deg))
    return PlanePose(known, pose, np.linalg.cholesky(np.linalg.inv(known.covariance)).T)


def known_pose_rows(
    window: WindowNetwork, layout: Layout, state: FloatArray, width: int
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Return residuals (3,), columns (3, width), derivatives (3, width) of the known pose, none without one.

    The three are whitened together: R (x - x0) with R'R the inverse of the covariance; eq. (10.6a).
    """
    prior = window.prior
    if prior is None:
        return np.zeros(0), np.zeros((0, width), np.int64), np.zeros((0, width))
    third = 2 if window.any_relative else layout.shared + COMPASS
    scale = np.array([1.0, 1.0, 1.0 if window.any_relative else window.global_sigma[COMPASS]])
    at = np.array([0, 1, third])
    off = scale * state[at] - prior.pose
    off[2] = wrap_pi(off[2])
    columns, values = np.zeros((3, width), np.int64), np.zeros((3, width))
    columns[:, :3], values[:, :3] = at, prior.root * scale
    return prior.root @ off, columns, values
