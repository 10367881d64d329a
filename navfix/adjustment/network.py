"""The plane problem as arrays: observations of marks from one pose, checked, and what of them depends on no pose."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from navfix.errors import InputError
from navfix.types import FloatArray, IntArray, ObservationKind

RANGE, RELATIVE_BEARING, TRUE_BEARING = 0, 1, 2
KIND_NAMES: tuple[ObservationKind, ...] = ("range", "relative_bearing", "true_bearing")
KIND_CODES: dict[ObservationKind, int] = {name: code for code, name in enumerate(KIND_NAMES)}
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """Ranges and bearings from one pose (north m, east m, heading rad) to n marks; m observations.

    Attributes
    ----------
    kind : (m,) RANGE, RELATIVE_BEARING or TRUE_BEARING
    mark : (m,) index of the mark that was observed
    value, sigma : (m,) observed value and 1 sigma of the instrument alone, m or rad
    mark_ne_m : (n, 2) north, east
    mark_covariance_m2 : (n, 2, 2) of the marks' positions, zero for fixed ones
    target : (m,) observations with the same number belong to one target: they are damped together
    mask : (m,) which observations take part
    heading_prior_rad : heading and its sigma from a compass, or None
    standard : (m,) sigma of each residual in units of that of its observation, held fixed, by which the kernel's
        argument is divided; None: the kernel acts on residuals in units of the observations' sigma
    heading_unknown : True when an observation that takes part is a relative bearing
    blocks : (g, K) indices into the observations that take part in one target, -1 where it has fewer than K
    block_sizes : (g,) how many they are
    diagonal : True when the errors of different observations are uncorrelated
    in_order : True when the blocks are the observations in their order, none left out (the usual case)
    polar : True when every target has one range and one bearing of one mark, in this order, all uncorrelated
    is_range, is_relative : (m,) the kind once more, as masks
    place : (2, m) north and east of the mark that was observed
    spread_m2 : (3, m) its covariance: north, twice the mixed term, east
    """

    kind: IntArray
    mark: IntArray
    value: FloatArray
    sigma: FloatArray
    mark_ne_m: FloatArray
    mark_covariance_m2: FloatArray
    target: IntArray
    mask: BoolArray
    heading_prior_rad: tuple[float, float] | None = None
    standard: FloatArray | None = None
    heading_unknown: bool = field(init=False)
    blocks: IntArray = field(init=False)
    block_sizes: IntArray = field(init=False)
    diagonal: bool = field(init=False)
    in_order: bool = field(init=False)
    polar: bool = field(init=False)
    is_range: BoolArray = field(init=False)
    is_relative: BoolArray = field(init=False)
    place: FloatArray = field(init=False)
    spread_m2: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        _check(self)
        covariance = self.mark_covariance_m2[self.mark]
        mixed = [covariance[:, 0, 0], 2.0 * covariance[:, 0, 1], covariance[:, 1, 1]]
        blocks = _blocks(self)
        in_order, diagonal = np.array_equal(blocks.ravel(), np.arange(len(self.kind))), _is_diagonal(self, blocks)
        derived = {
            "heading_unknown": bool(np.any((self.kind == RELATIVE_BEARING) & self.mask)),
            "blocks": blocks,
            "block_sizes": np.asarray(np.count_nonzero(blocks >= 0, axis=1), np.int64),
            "diagonal": diagonal,
            "in_order": in_order,
            "polar": in_order and diagonal and _is_polar(self, blocks),
            "is_range": self.kind == RANGE,
            "is_relative": self.kind == RELATIVE_BEARING,
            "place": self.mark_ne_m[self.mark].T.copy(),
            "spread_m2": np.array(mixed),
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @classmethod
    def build(
        cls,
        kind: ArrayLike,
        mark: ArrayLike,
        value: ArrayLike,
        sigma: ArrayLike,
        mark_ne_m: ArrayLike,
        *,
        mark_sigma_m: ArrayLike = 0.0,
        mark_covariance_m2: ArrayLike | None = None,
        target: ArrayLike | None = None,
        mask: ArrayLike | None = None,
        heading_prior_rad: tuple[float, float] | None = None,
    ) -> Network:
        """Make a network; marks with ``mark_sigma_m`` (scalar or (n,), per axis) or a full ``mark_covariance_m2``.

        ``target`` defaults to the mark: what was measured to one mark is damped together.

        Raises
        ------
        InputError : arrays of unequal length, an unknown kind, a sigma that is not > 0, a mark that does not exist
        """
        kinds, marks = np.atleast_1d(np.asarray(kind, np.int64)), np.atleast_1d(np.asarray(mark, np.int64))
        places = np.asarray(mark_ne_m, np.float64).reshape(-1, 2)
        if mark_covariance_m2 is None:
            spread = np.broadcast_to(np.asarray(mark_sigma_m, np.float64), (len(places),)) ** 2
            covariance = spread[:, None, None] * np.eye(2)
        else:
            covariance = np.broadcast_to(np.asarray(mark_covariance_m2, np.float64), (len(places), 2, 2))
        return cls(
            kind=kinds,
            mark=marks,
            value=np.atleast_1d(np.asarray(value, np.float64)),
            sigma=np.broadcast_to(np.asarray(sigma, np.float64), kinds.shape),
            mark_ne_m=places,
            mark_covariance_m2=covariance,
            target=marks if target is None else np.atleast_1d(np.asarray(target, np.int64)),
            mask=np.ones(kinds.shape, bool) if mask is None else np.atleast_1d(np.asarray(mask, bool)),
            heading_prior_rad=heading_prior_rad,
        )

    @property
    def unknowns(self) -> int:
        """Three with an unknown heading, else two."""
        return 3 if self.heading_unknown else 2

    @property
    def prior_counts(self) -> bool:
        """Whether the heading prior is an observation of an unknown."""
        return self.heading_unknown and self.heading_prior_rad is not None

    @property
    def observations(self) -> int:
        """How many observations take part, the heading prior included."""
        return int(np.count_nonzero(self.mask)) + int(self.prior_counts)

    @property
    def redundancy(self) -> int:
        """Observations minus unknowns."""
        return self.observations - self.unknowns

    def with_marks(self, mark_ne_m: FloatArray) -> Network:
        """Return the same observations with the marks at other coordinates (a re-centred plane).

        What was checked and derived before does not depend on them, and is taken over.

        Raises
        ------
        InputError : other than one finite place a mark
        """
        places = np.asarray(mark_ne_m, np.float64).reshape(-1, 2)
        if places.shape != self.mark_ne_m.shape or not np.all(np.isfinite(places)):
            raise InputError(f"network: expected {len(self.mark_ne_m)} finite places, got shape {places.shape}")
        moved = object.__new__(Network)
        for name in self.__slots__:
            object.__setattr__(moved, name, getattr(self, name))
        object.__setattr__(moved, "mark_ne_m", places)
        object.__setattr__(moved, "place", places[self.mark].T.copy())
        return moved


def _check(network: Network) -> None:
    m, n = len(network.kind), len(network.mark_ne_m)
    for name in ("mark", "value", "sigma", "target", "mask"):
        if getattr(network, name).shape != (m,):
            raise InputError(f"network: {name} must have {m} entries, got shape {getattr(network, name).shape}")
    if m and not np.all((network.kind >= RANGE) & (network.kind <= TRUE_BEARING)):
        raise InputError(f"network: kind must be 0, 1 or 2, got {np.unique(network.kind).tolist()}")
    if m and not (network.mark.min() >= 0 and network.mark.max() < n):
        raise InputError(f"network: mark must be within 0 .. {n - 1}, got {network.mark.min()} .. {network.mark.max()}")
    if not np.all(np.isfinite(network.sigma) & (network.sigma > 0.0)):
        raise InputError(f"network: sigma must be > 0, got {network.sigma[~(network.sigma > 0.0)][:5].tolist()}")
    if not (np.all(np.isfinite(network.value)) and np.all(np.isfinite(network.mark_ne_m))):
        raise InputError("network: values and coordinates must be finite")
    if network.mark_covariance_m2.shape != (n, 2, 2):
        raise InputError(f"network: mark_covariance_m2 must be {(n, 2, 2)}, got {network.mark_covariance_m2.shape}")
    if n and not np.all(_smaller_eigenvalue(network.mark_covariance_m2) >= -1e-9):
        raise InputError("network: every mark covariance must be positive semidefinite")
    if network.heading_prior_rad is not None and not network.heading_prior_rad[1] > 0.0:
        raise InputError(f"network: the sigma of the heading prior must be > 0, got {network.heading_prior_rad[1]}")


def _smaller_eigenvalue(matrix: FloatArray) -> FloatArray:
    """Return the smaller eigenvalue of symmetric matrices (n, 2, 2)."""
    a, b, c = matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 1, 1]
    return np.asarray(0.5 * (a + c) - np.hypot(0.5 * (a - c), b))


def _blocks(network: Network) -> IntArray:
    """List the active observations of each target; targets that share an uncertain mark correlate: they are one."""
    uncertain = np.any(network.mark_covariance_m2 > 0.0, axis=(1, 2))
    keys = np.where(uncertain[network.mark], -1 - network.mark, network.target)
    groups: dict[int, list[int]] = {}
    for index in np.flatnonzero(network.mask):
        groups.setdefault(int(keys[index]), []).append(int(index))
    width = max((len(members) for members in groups.values()), default=1)
    return np.array([members + [-1] * (width - len(members)) for members in groups.values()], np.int64).reshape(
        -1, width
    )


def _is_diagonal(network: Network, blocks: IntArray) -> bool:
    """Tell whether all errors are uncorrelated: fixed marks, or isotropic ones with one range and one bearing each."""
    covariance = network.mark_covariance_m2
    isotropic = np.all(covariance[:, 0, 1] == 0.0) and np.all(covariance[:, 0, 0] == covariance[:, 1, 1])
    if not np.any(covariance):
        return True
    padded = np.append(np.where(network.kind == RANGE, 0, 1), -1)[blocks]
    return bool(isotropic and np.all(np.sum(padded == 0, axis=1) <= 1) and np.all(np.sum(padded == 1, axis=1) <= 1))


def _is_polar(network: Network, blocks: IntArray) -> bool:
    """Tell whether observations in order are a range and a bearing of one mark, over and over, of isotropic marks."""
    if blocks.shape[1] != 2:
        return False
    first, second = network.kind[::2], network.kind[1::2]
    return bool(np.all(first == RANGE) and np.all(second != RANGE) and np.all(network.mark[::2] == network.mark[1::2]))
