"""Kernels (damping functions): loss, derivative and weight of the standardised residual z >= 0.

The loss is the integral of the derivative, the derivative is weight x z: an adjustment that lowers the sum of the
losses and one that iterates on the weights meet in the same place.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from navfix.errors import InputError
from navfix.types import FloatArray

Damping = Literal["joint", "separate"]
Standardisation = Literal["sigma", "gdynia"]
Curve = Callable[..., FloatArray]


@dataclass(frozen=True, slots=True)
class Family:
    """The shape of a kernel: the names of its constants and its three curves f(z, *constants)."""

    constants: tuple[str, ...]
    loss: Curve
    derivative: Curve
    weight: Curve


@dataclass(frozen=True, slots=True)
class Kernel:
    """A damping function with its constants.

    ``separate`` are the constants for one residual (normal with unit variance when the observation is good),
    ``joint`` those for the norm of a target's two residuals (chi with two degrees of freedom); both in the order of
    ``FAMILIES[family].constants`` and of the same Gaussian ``efficiency``.

    Raises
    ------
    InputError : an unknown family, a wrong number of constants, constants that are not increasing positive numbers
    """

    name: str
    title: str
    source: str
    family: str
    separate: tuple[float, ...]
    joint: tuple[float, ...]
    efficiency: float
    note: str = ""

    def __post_init__(self) -> None:
        if self.family not in FAMILIES:
            raise InputError(f"kernel {self.name}: unknown family {self.family!r}; there are {', '.join(FAMILIES)}")
        for constants in (self.separate, self.joint):
            _check_constants(self.name, self.family, constants)

    def constants(self, damping: Damping = "separate") -> tuple[float, ...]:
        """Return the constants of one kind of damping."""
        return self.joint if damping == "joint" else self.separate

    def loss(self, z: ArrayLike, damping: Damping = "separate") -> FloatArray:
        """Return the loss, z^2 / 2 for small z."""
        return FAMILIES[self.family].loss(np.asarray(z, np.float64), *self.constants(damping))

    def derivative(self, z: ArrayLike, damping: Damping = "separate") -> FloatArray:
        """Return d loss / dz (the influence function), z for small z."""
        return FAMILIES[self.family].derivative(np.asarray(z, np.float64), *self.constants(damping))

    def weight(self, z: ArrayLike, damping: Damping = "separate") -> FloatArray:
        """Return derivative / z within 0 .. 1, 1 for small z."""
        return FAMILIES[self.family].weight(np.asarray(z, np.float64), *self.constants(damping))

    def bound(self, damping: Damping = "separate") -> float:
        """Return what one hopeless observation or target costs: the loss far out (infinite where it never levels)."""
        far = self.loss(np.array([1e6, 2e6]), damping)
        return float(far[1]) if far[1] - far[0] < 1e-6 * far[0] else math.inf


def _check_constants(name: str, family: str, constants: tuple[float, ...]) -> None:
    names = FAMILIES[family].constants
    if len(constants) != len(names):
        raise InputError(f"kernel {name}: family {family} has the constants {names}, got {constants}")
    if not all(math.isfinite(value) and value > 0.0 for value in constants if value != math.inf):
        raise InputError(f"kernel {name}: constants must be > 0, got {constants}")
    thresholds = () if family in ("danish", "tls") else constants
    if any(low >= high for low, high in pairwise(thresholds)):
        raise InputError(f"kernel {name}: {', '.join(names)} must increase, got {constants}")


def gaussian_efficiency(kernel: Kernel, damping: Damping = "separate", *, dof: int | None = None) -> float:
    """Return the variance of the mean over that of the damped estimate when all observations are good.

    ``dof`` components are damped together (1 for separate, 2 for joint damping). For z = |x|, x ~ N(0, I_p), with w
    the weight and psi the derivative: B = E[psi' + (p - 1) w] / p, V = E[psi^2] / p, efficiency = B^2 / V
    (Huber, Robust Statistics, 1981, sections 3.2 and 8).
    """
    p = dof if dof is not None else (2 if damping == "joint" else 1)
    z = (np.arange(400_000) + 0.5) * (20.0 / 400_000)
    density = z ** (p - 1) * np.exp(-0.5 * z**2)
    density /= density.sum()
    psi, weight = kernel.derivative(z, damping), kernel.weight(z, damping)
    slope = z * psi - (p - 1) * weight  # E[psi'] = E[(z - (p - 1) / z) psi], by parts
    b = float(density @ (slope + (p - 1) * weight)) / p
    return b**2 / (float(density @ psi**2) / p)


# ----------------------------------------------------------------------------------------------------------- curves


def _falling(z: FloatArray, first: float, last: float) -> FloatArray:
    """Return the line from 1 at ``first`` to 0 at ``last``, level outside."""
    return np.minimum(np.maximum((last - z) / (last - first), 0.0), 1.0)


def _none_loss(z: FloatArray) -> FloatArray:
    return 0.5 * z**2


def _none_derivative(z: FloatArray) -> FloatArray:
    return z.copy()


def _none_weight(z: FloatArray) -> FloatArray:
    return np.ones_like(z)


def _huber_loss(z: FloatArray, k: float) -> FloatArray:
    inner = np.minimum(z, k)
    return inner * (z - 0.5 * inner)


def _huber_derivative(z: FloatArray, k: float) -> FloatArray:
    return np.minimum(z, k)


def _huber_weight(z: FloatArray, k: float) -> FloatArray:
    return k / np.maximum(z, k) if math.isfinite(k) else np.ones_like(z)


def _hampel_loss(z: FloatArray, a: float, b: float, c: float) -> FloatArray:
    inner = np.minimum(z, a)
    flat = a * (np.minimum(np.maximum(z, a), b) - a)
    falling = np.minimum(np.maximum(c - z, 0.0), c - b)
    return 0.5 * inner**2 + flat + 0.5 * a * ((c - b) - falling**2 / (c - b))


def _hampel_derivative(z: FloatArray, a: float, b: float, c: float) -> FloatArray:
    return np.minimum(z, a) * _falling(z, b, c)


def _hampel_weight(z: FloatArray, a: float, b: float, c: float) -> FloatArray:
    return a / np.maximum(z, a) * _falling(z, b, c)


def _danish_loss(z: FloatArray, k: float, l: float, g: float) -> FloatArray:  # noqa: E741 - the source's letter
    from scipy.special import gamma, gammainc

    inner, u = np.minimum(z, k), np.maximum(z - k, 0.0)
    power = l * np.minimum(u, 1e100) ** g if g < 3 else l * np.minimum(u, 1e50) ** g
    first = l ** (-2.0 / g) * gamma(2.0 / g) * gammainc(2.0 / g, power)
    second = k * l ** (-1.0 / g) * gamma(1.0 / g) * gammainc(1.0 / g, power)
    return np.asarray(0.5 * inner**2 + (first + second) / g)


def _danish_derivative(z: FloatArray, k: float, l: float, g: float) -> FloatArray:  # noqa: E741
    return z * _danish_weight(z, k, l, g)


def _danish_weight(z: FloatArray, k: float, l: float, g: float) -> FloatArray:  # noqa: E741
    with np.errstate(over="ignore"):
        return np.asarray(np.exp(-l * np.maximum(z - k, 0.0) ** g))


def _tukey_loss(z: FloatArray, c: float) -> FloatArray:
    return c**2 / 6.0 * (1.0 - (1.0 - np.minimum(z / c, 1.0) ** 2) ** 3)


def _tukey_derivative(z: FloatArray, c: float) -> FloatArray:
    return np.where(z < c, z * (1.0 - (z / c) ** 2) ** 2, 0.0)


def _tukey_weight(z: FloatArray, c: float) -> FloatArray:
    return np.asarray((1.0 - np.minimum(z / c, 1.0) ** 2) ** 2)


def _igg3_loss(z: FloatArray, k0: float, k1: float) -> FloatArray:
    left = _falling(z, k0, k1)
    return 0.5 * np.minimum(z, k0) ** 2 + k0 * (k1 - k0) / 3.0 * (1.0 - left**3)


def _igg3_derivative(z: FloatArray, k0: float, k1: float) -> FloatArray:
    return np.minimum(z, k0) * _falling(z, k0, k1) ** 2


def _igg3_weight(z: FloatArray, k0: float, k1: float) -> FloatArray:
    return k0 / np.maximum(z, k0) * _falling(z, k0, k1) ** 2


def _linear_loss(z: FloatArray, k: float, k_b: float) -> FloatArray:
    x = np.minimum(np.maximum(z, k), k_b)
    outer = (k_b * (x**2 - k**2) / 2.0 - (x**3 - k**3) / 3.0) / (k_b - k)
    return 0.5 * np.minimum(z, k) ** 2 + outer


def _linear_derivative(z: FloatArray, k: float, k_b: float) -> FloatArray:
    return z * _linear_weight(z, k, k_b)


def _linear_weight(z: FloatArray, k: float, k_b: float) -> FloatArray:
    return _falling(z, k, k_b)


def _tls_loss(z: FloatArray, c: float, mu: float) -> FloatArray:
    inner, outer = c * math.sqrt(mu / (mu + 1.0)), c * math.sqrt((mu + 1.0) / mu)
    x = np.minimum(np.maximum(z, inner), outer)
    between = c * x * math.sqrt(mu * (mu + 1.0)) - 0.5 * mu * (c**2 + x**2)
    return np.where(z < inner, 0.5 * z**2, between)


def _tls_derivative(z: FloatArray, c: float, mu: float) -> FloatArray:
    return z * _tls_weight(z, c, mu)


def _tls_weight(z: FloatArray, c: float, mu: float) -> FloatArray:
    falling = c * math.sqrt(mu * (mu + 1.0)) / np.maximum(z, 1e-300) - mu
    return np.minimum(np.maximum(falling, 0.0), 1.0)


FAMILIES: dict[str, Family] = {
    "none": Family((), _none_loss, _none_derivative, _none_weight),
    "huber": Family(("k",), _huber_loss, _huber_derivative, _huber_weight),
    "hampel": Family(("a", "b", "c"), _hampel_loss, _hampel_derivative, _hampel_weight),
    "danish": Family(("k", "l", "g"), _danish_loss, _danish_derivative, _danish_weight),
    "tukey": Family(("c",), _tukey_loss, _tukey_derivative, _tukey_weight),
    "igg3": Family(("k0", "k1"), _igg3_loss, _igg3_derivative, _igg3_weight),
    "tls": Family(("c", "mu"), _tls_loss, _tls_derivative, _tls_weight),
    "gdynia_linear": Family(("k", "k_b"), _linear_loss, _linear_derivative, _linear_weight),
}
