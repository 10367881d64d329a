"""Graduated non-convexity: truncated least squares reached from least squares by kernels that let go step by step.

A comparison method: it needs no robust start and is not fooled by single wrong targets, but follows wrong ones that
agree with each other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from navfix.adjustment.damped import kernel_arguments
from navfix.adjustment.dense import Descent, minimise
from navfix.adjustment.network import Network
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray

FAMILY = "tls"
START = "gnc"  # the name of where its way begins
_GROWTH = 1.4  # of mu from step to step
_TOLERANCE, _STEPS = 1e-2, 10


def graduated(network: Network, kernel: Kernel, damping: Damping, least_squares: FloatArray) -> Descent:
    """Go down from the least-squares pose (1, 3) with mu growing from nearly convex to the kernel's own.

    mu_0 = c^2 / (2 max z^2 - c^2): the largest residual just begins to be let go (Yang et al. 2020, section V).
    """
    c, last = kernel.constants(damping)
    largest = float(kernel_arguments(network, damping, least_squares[0]).max(initial=0.0))
    mu, poses = c**2 / max(2.0 * largest**2 - c**2, 1e-9), least_squares
    while mu < last:
        softer = replace(kernel, separate=(kernel.separate[0], mu), joint=(kernel.joint[0], mu))
        poses = minimise(network, softer, damping, poses, tolerance=_TOLERANCE, iterations=_STEPS).pose
        mu *= _GROWTH
    return minimise(network, kernel, damping, poses)


def start_pose(network: Network, none: Kernel, damping: Damping, near: FloatArray) -> FloatArray:
    """Return the least-squares pose (1, 3) that is reached from ``near`` (1, 3)."""
    return np.asarray(minimise(network, none, damping, near).pose)
