"""Minimal solutions: every pose that a range, a bearing or a pair of bearings can share with another, in closed form.

Each of them leaves own ship on a curve that does not depend on the heading: a circle about the mark (range), a line
through it (true bearing), or the circle through two marks on which they are seen under the difference of their relative
bearings. All are circles a |p|^2 + b p + d = 0, a line where a = 0, and two of them meet in at most two places.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, Network
from navfix.types import FloatArray, IntArray

ComplexArray = NDArray[np.complex128]
_PARALLEL = 1e-9  # of two curves in the unit of the marks' extent: they do not meet, or everywhere
_FLAT = 1e-9
_ON_MARK = 1e-6  # of the marks' extent: the root in which two circles through one mark always meet
_ON_CIRCLE = 0.02  # relative: so near the danger circle a resection says nothing


class _Curves(NamedTuple):
    """Curves a |p|^2 + north n + east e + d = 0, each (c,)."""

    a: FloatArray
    north: FloatArray
    east: FloatArray
    d: FloatArray

    def at(self, place: ComplexArray) -> FloatArray:
        """Return the left-hand side at places (c,), n + i e."""
        return np.asarray(
            self.a * np.abs(place) ** 2 + self.north * place.real + self.east * place.imag + self.d, np.float64
        )

    def take(self, rows: IntArray) -> _Curves:
        return _Curves(*(column[rows] for column in self))


def minimal_places(network: Network, at_most: int) -> FloatArray:
    """Return the places (t, 2) in which two curves meet, of about ``at_most`` pairs of them; eq. (2.8) to (2.12).

    They are all exact solutions where the observations just suffice: two ranges, two true bearings, one of each, a
    range or a true bearing with two relative bearings, and three relative bearings (resection). Curves that nearly
    touch without meeting give the place between them. Where a heading prior exists, relative bearings are turned by it
    too.
    """
    centre, extent_m = _frame(network)
    mark = (_complex(network.mark_ne_m[network.mark]) - centre) / extent_m
    curves = _joined(
        [
            _circles(mark, network.value / extent_m, _of_kind(network, RANGE)),
            _lines(mark, network.value, _of_kind(network, TRUE_BEARING)),
            _by_prior(network, mark),
            _inscribed(mark, network.value, _of_kind(network, RELATIVE_BEARING), at_most),
        ]
    )
    first, second = index_pairs(len(curves.a), at_most)
    places = _meetings(curves.take(first), curves.take(second))
    places = places[np.isfinite(places)]
    bearings = mark[network.mask & ~network.is_range]
    if len(bearings):
        places = places[np.min(np.abs(places[:, None] - bearings), axis=1, initial=np.inf) > _ON_MARK]
    places = places * extent_m + centre
    return np.stack([places.real, places.imag], axis=1)


def on_danger_circle(network: Network, pose: FloatArray) -> bool:
    """Tell whether only relative bearings take part and own ship stands on one circle (or line) with all their marks.

    Anywhere on it the marks are seen under the same angles: three-point resection says nothing there.
    """
    kinds = network.kind[network.mask]
    marks = network.mark_ne_m[np.unique(network.mark[network.mask])]
    if network.prior_counts or np.any(kinds != RELATIVE_BEARING) or len(marks) < 3:
        return False
    off = _complex(marks - pose[:2])
    if np.min(np.abs(off)) <= 0.0:
        return False
    inverse = 1.0 / off  # inversion turns circles through own ship into lines
    apart = inverse - inverse.mean()
    moments = np.linalg.svd(np.stack([apart.real, apart.imag]), compute_uv=False)
    return bool(moments[1] <= _ON_CIRCLE * moments[0])


@lru_cache(maxsize=64)
def index_pairs(count: int, at_most: int) -> tuple[IntArray, IntArray]:
    """Return index pairs i < j: all, or an even choice in which every index occurs about as often; read-only."""
    pairs = _chosen_pairs(count, at_most)
    for index in pairs:
        index.setflags(write=False)
    return pairs


def _chosen_pairs(count: int, at_most: int) -> tuple[IntArray, IntArray]:
    if count * (count - 1) // 2 <= at_most:
        return np.triu_indices(count, 1)
    strides = np.unique(np.linspace(1, count // 2, max(at_most // count, 1)).astype(np.int64))
    base = np.unique(np.linspace(0, count - 1, min(count, at_most)).astype(np.int64))
    return np.tile(base, len(strides)), np.concatenate([(base + stride) % count for stride in strides])


# ------------------------------------------------------------------------------------------------------- the curves


def _circles(mark: ComplexArray, reach: FloatArray, ranges: IntArray) -> _Curves:
    """|p - m|^2 = r^2, eq. (2.8)."""
    m = mark[ranges]
    return _Curves(np.ones(len(m)), -2.0 * m.real, -2.0 * m.imag, np.abs(m) ** 2 - reach[ranges] ** 2)


def _lines(mark: ComplexArray, azimuth_rad: FloatArray, bearings: IntArray) -> _Curves:
    """Im((m - p) e^(-i b)) = 0, eq. (2.9)."""
    m, b = mark[bearings], azimuth_rad[bearings]
    return _Curves(np.zeros(len(m)), np.sin(b), -np.cos(b), np.imag(m * np.exp(-1j * b)))


def _by_prior(network: Network, mark: ComplexArray) -> _Curves:
    if not network.prior_counts or network.heading_prior_rad is None:
        return _joined([])
    return _lines(mark, network.value + network.heading_prior_rad[0], _of_kind(network, RELATIVE_BEARING))


def _inscribed(mark: ComplexArray, bearing_rad: FloatArray, bearings: IntArray, at_most: int) -> _Curves:
    """Im((m2 - p) conj(m1 - p) e^(-i g)) = 0 with g = b2 - b1, eq. (2.10)."""
    first, second = (bearings[index] for index in index_pairs(len(bearings), at_most))
    apart = mark[first] != mark[second]
    first, second = first[apart], second[apart]
    turn = np.exp(1j * (bearing_rad[first] - bearing_rad[second]))
    u, w = mark[second] * turn, np.conj(mark[first]) * turn
    return _Curves(turn.imag, -(u.imag + w.imag), u.real - w.real, np.imag(u * np.conj(mark[first])))


def _meetings(one: _Curves, other: _Curves) -> ComplexArray:
    """Return both places (2 c,) in which curves meet: eq. (2.11), (2.12); not finite where they do not."""
    with np.errstate(divide="ignore", invalid="ignore"):
        straight = (np.abs(one.a) < _FLAT) & (np.abs(other.a) < _FLAT)
        chord = _Curves(
            *(np.where(straight, p, other.a * p - one.a * q) for p, q in zip(one, other, strict=True))
        )  # what two circles share lies on the line in which |p|^2 cancels
        curve = _Curves(*(np.where(np.abs(one.a) > np.abs(other.a), p, q) for p, q in zip(one, other, strict=True)))
        slope = chord.north + 1j * chord.east
        length = np.abs(slope)
        foot, along = -chord.d * slope / length**2, 1j * slope / length
        half = 0.5 * (curve.north * along.real + curve.east * along.imag)
        rest = curve.at(foot)
        root = half + np.where(half < 0.0, -1.0, 1.0) * np.sqrt(np.maximum(half**2 - curve.a * rest, 0.0))
        near, far = foot - along * rest / root, foot - along * root / curve.a
        usable = length > _PARALLEL
        return np.concatenate([np.where(usable, near, np.nan), np.where(usable, far, np.nan)])


def _joined(parts: list[_Curves]) -> _Curves:
    """Return all curves in one, each scaled so that its largest coefficient is about one."""
    columns = [np.concatenate([getattr(part, name) for part in parts]) if parts else np.empty(0) for name in _NAMES]
    largest = np.maximum.reduce([np.abs(column) for column in columns])
    scale = np.where(largest > 0.0, largest, 1.0)
    return _Curves(*(column / scale for column in columns))


_NAMES = ("a", "north", "east", "d")


def _of_kind(network: Network, kind: int) -> IntArray:
    return np.flatnonzero((network.kind == kind) & network.mask)


def _frame(network: Network) -> tuple[complex, float]:
    """Return the middle of the marks and their extent, that of the longest range included."""
    marks = _complex(network.mark_ne_m[np.unique(network.mark[network.mask])])
    longest_m = float(network.value[network.is_range & network.mask].max(initial=0.0))
    centre = complex(marks.mean())
    return centre, max(float(np.abs(marks - centre).max()), longest_m, 1.0)


def _complex(north_east: FloatArray) -> ComplexArray:
    return np.asarray(north_east[..., 0] + 1j * north_east[..., 1], np.complex128)
