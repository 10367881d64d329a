"""Range and bearing of every target in polar coordinates: residuals and derivatives of the loss in closed form.

The usual network. As complex numbers, north + i east, a mark at distance d in direction t is d e^(it), and the position
part of the derivatives of its range and its bearing is -e^(it) and -i e^(it) / d. So slope and curvature are simple
along and across each line of sight; turning them into north and east takes their sums with cos t and sin t, and those
of the second derivatives, products of two directions, with cos 2t and sin 2t.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navfix.adjustment.network import Network
from navfix.adjustment.sights import NEAREST_M
from navfix.types import FloatArray

ComplexArray = NDArray[np.complex128]


class Seen(NamedTuple):
    """Marks from poses, (s, g): directions e^(it), distances [m], residuals of range [m] and bearing [rad]."""

    direction: ComplexArray
    distance: FloatArray
    range_v: FloatArray
    bearing_v: FloatArray


class Polar(NamedTuple):
    """A network of g targets, each with one range and one bearing of one mark; arrays (g,).

    ``place`` : of the marks [m]; ``bearing`` : e^(-i b) of the observed bearings; ``relative`` : 1 where the heading
    enters the bearing, else 0; variances of the observations [m^2], [rad^2] and of the marks per axis [m^2]
    """

    place: ComplexArray
    range_m: FloatArray
    bearing: ComplexArray
    relative: FloatArray
    all_relative: bool
    range_variance: FloatArray
    bearing_variance: FloatArray
    mark_variance: FloatArray

    @classmethod
    def of(cls, network: Network) -> Polar:
        """Return a network (``network.polar``) in polar form."""
        variance, relative = network.sigma**2, network.is_relative[1::2]
        return cls(
            place=network.place[0, ::2] + 1j * network.place[1, ::2],
            range_m=network.value[::2],
            bearing=np.exp(-1j * network.value[1::2]),
            relative=relative.astype(np.float64),
            all_relative=bool(relative.all()),
            range_variance=variance[::2],
            bearing_variance=variance[1::2],
            mark_variance=network.spread_m2[0, ::2],
        )

    def seen(self, pose: FloatArray) -> Seen:
        """Return the marks as seen from poses (s, 3); v = adjusted - observed, bearings within -pi .. pi."""
        away = self.place - (pose[:, 0] + 1j * pose[:, 1])[:, None]
        distance = np.maximum(np.abs(away), NEAREST_M)
        ahead = np.exp(-1j * pose[:, 2])[:, None]
        turned = away * self.bearing * (ahead if self.all_relative else np.where(self.relative > 0.0, ahead, 1.0))
        return Seen(away / distance, distance, distance - self.range_m, np.arctan2(turned.imag, turned.real))

    def inverse_variances(self, distance: FloatArray) -> FloatArray:
        """Return 1 / sigma^2 of range and bearing, instrument and mark combined, (s, 2, g)."""
        result = np.empty((len(distance), 2, distance.shape[1]))
        result[:, 0] = 1.0 / (self.range_variance + self.mark_variance)
        result[:, 1] = 1.0 / (self.bearing_variance + self.mark_variance / distance**2)
        return result

    def derivatives(
        self, seen: Seen, inverse_variance: FloatArray, weights: FloatArray, bend: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return gradient (s, 3), diagonal of A'WA (s, 3) and second derivative (s, 3, 3) of the total loss.

        ``weights`` and ``bend`` (s, g): the kernel's weight w and dw/dz / z of each target, so that its loss has the
        gradient w q and the second derivative w A'A + w v d^2 v + bend q q', with q = A'v.
        """
        inverse = 1.0 / seen.distance
        a, turn = seen.range_v * inverse_variance[:, 0], seen.bearing_v * inverse_variance[:, 1]
        b = turn * inverse  # q is -(a, b) along and across the line of sight, and -turn in the heading
        turn = turn if self.all_relative else turn * self.relative
        wa, wb, bend_a, bend_b = weights * a, weights * b, bend * a, bend * b
        along, turning = weights * inverse_variance[:, 0], weights * inverse_variance[:, 1]
        per_m = turning * inverse
        across = per_m * inverse
        turning, per_m = (turning, per_m) if self.all_relative else (turning * self.relative, per_m * self.relative)
        terms = np.empty((len(weights), 12, weights.shape[1]))
        terms[:, 0], terms[:, 1] = along, across
        terms[:, 2] = along + bend_a * a
        terms[:, 3] = across + bend_b * b + wa * inverse
        terms[:, 4] = bend_a * b - wb * inverse
        terms[:, 5], terms[:, 6] = bend_a * turn, bend_b * turn + per_m
        terms[:, 7], terms[:, 8], terms[:, 9] = wa, wb, weights * turn
        terms[:, 10], terms[:, 11] = turning, turning + bend * turn**2
        found = (terms @ _waves(seen.direction)).reshape(len(weights), -1) @ _ASSEMBLY
        return found[:, :3], found[:, 3:6], found[:, 6:].reshape(-1, 3, 3)


def _waves(direction: ComplexArray) -> FloatArray:
    """Return 1, cos t, sin t, cos 2t, sin 2t of each direction, (s, g, 5)."""
    double = direction * direction
    waves = np.empty((*direction.shape, 5))
    waves[..., 0] = 1.0
    waves[..., 1], waves[..., 2] = direction.real, direction.imag
    waves[..., 3], waves[..., 4] = double.real, double.imag
    return waves


def _assembly() -> FloatArray:
    """Return what turns the sums of 12 terms times 5 waves into gradient (3), diagonal (3) and second derivative (9).

    Along and across each line of sight become north and east: a symmetric matrix (p, q; q, r) in the sight's axes is
    ((p + r) / 2 + D, ne; ne, (p + r) / 2 - D), D = (p - r) / 2 cos 2t - q sin 2t, ne = (p - r) / 2 sin 2t + q cos 2t.
    """
    one, cos, sin, cos2, sin2 = range(5)
    gradient = [{(7, cos): -1.0, (8, sin): 1.0}, {(7, sin): -1.0, (8, cos): -1.0}, {(9, one): -1.0}]
    gauss = {(0, one): 0.5, (1, one): 0.5}
    diagonal = [gauss | {(0, cos2): x, (1, cos2): -x} for x in (0.5, -0.5)] + [{(10, one): 1.0}]
    full = {(2, one): 0.5, (3, one): 0.5}
    nn, ee = (full | {(2, cos2): x, (3, cos2): -x, (4, sin2): -2.0 * x} for x in (0.5, -0.5))
    ne, nh = {(2, sin2): 0.5, (3, sin2): -0.5, (4, cos2): 1.0}, {(5, cos): 1.0, (6, sin): -1.0}
    eh, hh = {(5, sin): 1.0, (6, cos): 1.0}, {(11, one): 1.0}
    columns = [*gradient, *diagonal, nn, ne, nh, ne, ee, eh, nh, eh, hh]
    table = np.zeros((12, 5, len(columns)))
    for column, entries in enumerate(columns):
        for (term, wave), factor in entries.items():
            table[term, wave, column] = factor
    return table.reshape(60, len(columns))


_ASSEMBLY = _assembly()
