"""Where the marks of a scene lie: anywhere alike, about anchorages, in lanes, in a channel; and how they crowd."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from navfix.types import FloatArray
from navfix.units import NM_M

Crowding = Callable[[NDArray[np.complex128]], FloatArray]  # marks per m^2 at places of any shape
LAYOUTS = ("uniform", "anchorages", "lanes", "channel")


def in_disc(random: np.random.Generator, count: int, radius_m: float) -> NDArray[np.complex128]:
    """Return places (n,) that lie anywhere alike in a disc about the origin [m]."""
    radius = radius_m * np.sqrt(random.uniform(size=count))
    return np.asarray(radius * np.exp(2j * math.pi * random.uniform(size=count)), dtype=np.complex128)


def lay_out(
    random: np.random.Generator, layout: str, count: int, radius_m: float
) -> tuple[NDArray[np.complex128], Crowding | None]:
    """Return true places (n,) of the marks about the centre, and their density anywhere (None where uniform)."""
    if layout == "uniform":
        return in_disc(random, count, radius_m), None
    if layout == "anchorages":
        return _anchorages(random, count, radius_m)
    if layout == "lanes":
        return _lanes(random, count, radius_m)
    if layout == "channel":
        return _channel(random, count)
    raise ValueError(f"layout must be one of {', '.join(LAYOUTS)}, got {layout!r}")


def _anchorages(random: np.random.Generator, count: int, radius_m: float) -> tuple[NDArray[np.complex128], Crowding]:
    """Six marks in ten crowd about anchorages, one for twenty marks; the others lie anywhere."""
    centres = in_disc(random, max(2, count // 20), 0.8 * radius_m)
    scatter = 900.0 * (random.normal(size=count) + 1j * random.normal(size=count))
    clustered = centres[random.integers(len(centres), size=count)] + scatter
    places = np.where(random.uniform(size=count) < 0.6, clustered, in_disc(random, count, radius_m))

    def crowding(place: NDArray[np.complex128]) -> FloatArray:
        near = sum(np.exp(-0.5 * np.abs(place - centre) ** 2 / 900.0**2) for centre in centres) / len(centres)
        return np.asarray(count * (0.6 * near / (2.0 * math.pi * 900.0**2) + 0.4 / (math.pi * radius_m**2)))

    return places, crowding


def _lanes(random: np.random.Generator, count: int, radius_m: float) -> tuple[NDArray[np.complex128], Crowding]:
    """Two lanes beside each other."""
    along = random.uniform(-radius_m, radius_m, size=count)
    across = 600.0 * random.normal(size=count) + np.where(random.uniform(size=count) < 0.5, 1500.0, -1500.0)
    turn = np.exp(1j * random.uniform(0.0, math.pi))

    def crowding(place: NDArray[np.complex128]) -> FloatArray:
        local = place * np.conj(turn)
        ridges = sum(np.exp(-0.5 * (local.imag - side) ** 2 / 600.0**2) for side in (1500.0, -1500.0)) / 2.0
        per_m2 = count / (2.0 * radius_m) * ridges / (math.sqrt(2.0 * math.pi) * 600.0)
        return np.where(np.abs(local.real) <= radius_m, per_m2, 0.0)

    return np.asarray((along + 1j * across) * turn), crowding


def _channel(random: np.random.Generator, count: int) -> tuple[NDArray[np.complex128], Crowding]:
    """Pairs of buoys, a mile apart along the fairway."""
    place = np.arange(count)
    row = (place // 2 - (count // 2 - 1) / 2.0) * NM_M + 1j * np.where(place % 2 == 0, 150.0, -150.0)
    turn = np.exp(1j * random.uniform(0.0, math.pi))

    def crowding(where: NDArray[np.complex128]) -> FloatArray:
        local = where * np.conj(turn)
        inside = (np.abs(local.imag) <= 300.0) & (np.abs(local.real) <= count / 4.0 * NM_M)
        return np.where(inside, 2.0 / (NM_M * 600.0), 0.0)

    return np.asarray(row * turn), crowding
