"""The total loss as a landscape over the poses: its height, slope and curvature, for many poses at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from navfix.adjustment.damped import kernel_curvature, loss_of_norms, norms, weights_of_norms
from navfix.adjustment.network import Network
from navfix.adjustment.polar import Polar, Seen
from navfix.adjustment.sights import Sight, curvature, jacobian, prior_residual, residuals, sight
from navfix.adjustment.whitening import (
    back_to_units,
    normal_matrix,
    target_norms,
    white_residuals,
    whiten,
    whiten_one,
    whitener,
)
from navfix.kernels import Damping, Kernel
from navfix.types import FloatArray

_SMALLEST_Z, _DZ = 1e-3, 1e-5


class Local(NamedTuple):
    """The landscape about poses (s, 3).

    ``scale`` (s, ...) : the observations' sigmas there, in the landscape's own form
    ``loss`` (s,), ``gradient`` (s, 3) : height and slope
    ``diagonal`` (s, 3) : of A'WA, the curvature if the observations were linear and the weights constant
    ``newton`` (s, 3, 3) : the full second derivative
    """

    scale: FloatArray
    loss: FloatArray
    gradient: FloatArray
    diagonal: FloatArray
    newton: FloatArray


View = tuple[NDArray[Any], ...]


class Landscape(Protocol):
    """What a descent asks of a network under a kernel; a view is what is seen from poses, arrays (s, ...)."""

    def view(self, pose: FloatArray) -> View:
        """Return what is seen from poses (s, 3)."""

    def about(self, pose: FloatArray, view: View | None = None) -> Local:
        """Return the landscape about poses (s, 3), seen with the sigmas that hold there."""

    def loss(self, pose: FloatArray, view: View, scale: FloatArray) -> FloatArray:
        """Return the losses (s,) at poses (s, 3), judged with sigmas that hold elsewhere."""


def landscape_of(network: Network, kernel: Kernel, damping: Damping) -> Landscape:
    """Return the landscape of any network; in closed form where every target has a range and a bearing."""
    if network.polar and damping == "joint" and network.standard is None:
        return PolarLandscape(Polar.of(network), network, kernel)
    return GeneralLandscape(network, kernel, damping)


@dataclass(frozen=True, slots=True)
class GeneralLandscape:
    """Any observations, any correlation, either damping; the scale is the whitener."""

    network: Network
    kernel: Kernel
    damping: Damping

    def view(self, pose: FloatArray) -> View:
        """Return lines of sight and residuals."""
        seen = sight(self.network, pose)
        return *seen, residuals(self.network, pose, seen)

    def about(self, pose: FloatArray, view: View | None = None) -> Local:
        """Return the landscape about poses (s, 3)."""
        network, kernel, damping = self.network, self.kernel, self.damping
        north, east, distance, v = view or self.view(pose)
        seen = Sight(north, east, distance)
        a = jacobian(network, pose, seen)
        factor = whitener(network, a, damping)
        v_white, a_white = whiten_one(network, factor, v), whiten(network, factor, a)
        z = norms(network, damping, v_white)
        weights = weights_of_norms(network, kernel, damping, z)
        newton = normal_matrix(network, a_white, weights)
        diagonal = np.diagonal(newton, axis1=-2, axis2=-1).copy()
        newton[..., :2, :2] += curvature(network, seen, back_to_units(network, factor, weights * v_white))
        if kernel.family != "none":
            newton += kernel_curvature(network, kernel, damping, a_white, v_white, z)
        loss = loss_of_norms(network, kernel, damping, z, prior_residual(network, pose))
        gradient = ((weights * v_white)[..., None, :] @ a_white)[..., 0, :]
        return Local(factor, loss, _with_prior(network, pose, gradient), diagonal, newton)

    def loss(self, pose: FloatArray, view: View, scale: FloatArray) -> FloatArray:
        """Return the losses (s,) at poses (s, 3) with the whitener of other poses."""
        z = norms(self.network, self.damping, whiten_one(self.network, scale, view[-1]))
        return loss_of_norms(self.network, self.kernel, self.damping, z, prior_residual(self.network, pose))


@dataclass(frozen=True, slots=True)
class PolarLandscape:
    """Range and bearing of every target, damped together; the scale (s, 2, g) holds their inverse variances."""

    polar: Polar
    network: Network
    kernel: Kernel

    def view(self, pose: FloatArray) -> View:
        """Return distances, directions and residuals."""
        return self.polar.seen(pose)

    def about(self, pose: FloatArray, view: View | None = None) -> Local:
        """Return the landscape about poses (s, 3)."""
        seen = Seen(*(view or self.view(pose)))
        scale = self.polar.inverse_variances(seen.distance)
        z = _polar_norms(seen, scale)
        weights, bend = _weights_and_slopes(self.kernel, z)
        gradient, diagonal, newton = self.polar.derivatives(seen, scale, weights, bend)
        if self.network.prior_counts and self.network.heading_prior_rad is not None:
            certainty = 1.0 / self.network.heading_prior_rad[1] ** 2
            diagonal[:, 2] += certainty
            newton[:, 2, 2] += certainty
        return Local(scale, self._total(z, pose), _with_prior(self.network, pose, gradient), diagonal, newton)

    def loss(self, pose: FloatArray, view: View, scale: FloatArray) -> FloatArray:
        """Return the losses (s,) at poses (s, 3) with the variances of other poses."""
        return self._total(_polar_norms(Seen(*view), scale), pose)

    def _total(self, z: FloatArray, pose: FloatArray) -> FloatArray:
        total = self.kernel.loss(z, "joint").sum(axis=-1)
        return np.asarray(total + 0.5 * prior_residual(self.network, pose) ** 2 if self.network.prior_counts else total)


def _polar_norms(seen: Seen, scale: FloatArray) -> FloatArray:
    """Return the norm of each target's residuals in units of sigma, (s, g)."""
    return np.asarray(np.sqrt(seen.range_v**2 * scale[:, 0] + seen.bearing_v**2 * scale[:, 1]))


def norms_of_targets(network: Network, pose: FloatArray) -> FloatArray:
    """Return the norm of each target's residuals in units of sigma at poses (s, 3), (s, g)."""
    if not network.polar:
        return target_norms(network, white_residuals(network, pose))
    polar = Polar.of(network)
    seen = polar.seen(pose)
    return _polar_norms(seen, polar.inverse_variances(seen.distance))


def _weights_and_slopes(kernel: Kernel, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the weights and dw/dz / z, by differences; the kernel is asked once for both."""
    if kernel.family == "none":
        return np.ones_like(z), np.zeros_like(z)
    away = np.maximum(z, _SMALLEST_Z)
    here, there = kernel.weight(np.array([z, away + _DZ]), "joint")
    return here, (there - here) / (_DZ * away)


def _with_prior(network: Network, pose: FloatArray, gradient: FloatArray) -> FloatArray:
    """Add the slope of the heading prior's loss to a gradient (s, 3)."""
    if network.prior_counts and network.heading_prior_rad is not None:
        gradient[..., 2] += prior_residual(network, pose) / network.heading_prior_rad[1]
    return gradient
