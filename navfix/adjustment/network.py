"""The plane problem as arrays: observations of marks from one pose, their residuals, Jacobian and combined sigma."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from navfix.errors import InputError
from navfix.kernels import Damping as Damping
from navfix.types import FloatArray, IntArray, ObservationKind
from navfix.units import wrap_pi

RANGE, RELATIVE_BEARING, TRUE_BEARING = 0, 1, 2
KIND_NAMES: tuple[ObservationKind, ...] = ("range", "relative_bearing", "true_bearing")
KIND_CODES: dict[ObservationKind, int] = {name: code for code, name in enumerate(KIND_NAMES)}
BoolArray = NDArray[np.bool_]
_NEAREST_M = 1e-6  # a mark nearer than this has no direction


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
    heading_unknown : True when an observation that takes part is a relative bearing
    blocks : (g, K) indices into the observations that take part in one target, -1 where it has fewer than K
    diagonal : True when the errors of different observations are uncorrelated
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
    heading_unknown: bool = field(init=False)
    blocks: IntArray = field(init=False)
    diagonal: bool = field(init=False)

    def __post_init__(self) -> None:
        _check(self)
        object.__setattr__(self, "heading_unknown", bool(np.any((self.kind == RELATIVE_BEARING) & self.mask)))
        object.__setattr__(self, "blocks", _blocks(self))
        object.__setattr__(self, "diagonal", _is_diagonal(self))

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

    @property
    def block_sizes(self) -> IntArray:
        """(g,) observations of each target that take part."""
        return np.asarray(np.count_nonzero(self.blocks >= 0, axis=1), np.int64)

    def with_marks(self, mark_ne_m: FloatArray) -> Network:
        """Return the same observations with the marks at other coordinates (a re-centred plane)."""
        return Network(
            self.kind,
            self.mark,
            self.value,
            self.sigma,
            np.asarray(mark_ne_m, np.float64).reshape(-1, 2),
            self.mark_covariance_m2,
            self.target,
            self.mask,
            self.heading_prior_rad,
        )


def _check(network: Network) -> None:
    m, n = len(network.kind), len(network.mark_ne_m)
    for name in ("mark", "value", "sigma", "target", "mask"):
        if getattr(network, name).shape != (m,):
            raise InputError(f"network: {name} must have {m} entries, got shape {getattr(network, name).shape}")
    if m and not np.all(np.isin(network.kind, (RANGE, RELATIVE_BEARING, TRUE_BEARING))):
        raise InputError(f"network: kind must be 0, 1 or 2, got {np.unique(network.kind).tolist()}")
    if m and not (network.mark.min() >= 0 and network.mark.max() < n):
        raise InputError(f"network: mark must be within 0 .. {n - 1}, got {network.mark.min()} .. {network.mark.max()}")
    if not np.all(np.isfinite(network.sigma) & (network.sigma > 0.0)):
        raise InputError(f"network: sigma must be > 0, got {network.sigma[~(network.sigma > 0.0)][:5].tolist()}")
    if not (np.all(np.isfinite(network.value)) and np.all(np.isfinite(network.mark_ne_m))):
        raise InputError("network: values and coordinates must be finite")
    if network.mark_covariance_m2.shape != (n, 2, 2):
        raise InputError(f"network: mark_covariance_m2 must be {(n, 2, 2)}, got {network.mark_covariance_m2.shape}")
    if n and not np.all(np.linalg.eigvalsh(network.mark_covariance_m2) >= -1e-9):
        raise InputError("network: every mark covariance must be positive semidefinite")
    if network.heading_prior_rad is not None and not network.heading_prior_rad[1] > 0.0:
        raise InputError(f"network: the sigma of the heading prior must be > 0, got {network.heading_prior_rad[1]}")


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


def _is_diagonal(network: Network) -> bool:
    """Tell whether all errors are uncorrelated: fixed marks, or isotropic ones with one range and one bearing each."""
    covariance = network.mark_covariance_m2
    isotropic = np.all(covariance[:, 0, 1] == 0.0) and np.all(covariance[:, 0, 0] == covariance[:, 1, 1])
    if not np.any(covariance):
        return True
    padded = np.append(np.where(network.kind == RANGE, 0, 1), -1)[network.blocks]
    return bool(isotropic and np.all(np.sum(padded == 0, axis=1) <= 1) and np.all(np.sum(padded == 1, axis=1) <= 1))


# ------------------------------------------------------------------------------------- functions of one or many poses


def _offsets(network: Network, pose: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return north and east from own ship to the observed mark and the distance, each (..., m) [m]."""
    mark = network.mark_ne_m[network.mark]
    north, east = mark[:, 0] - pose[..., 0:1], mark[:, 1] - pose[..., 1:2]
    return north, east, np.maximum(np.hypot(north, east), _NEAREST_M)


def predict(network: Network, pose: FloatArray) -> FloatArray:
    """Return what would be observed from ``pose`` (..., 3): (..., m) in m and rad (bearings not wrapped)."""
    north, east, distance = _offsets(network, pose)
    bearing = np.arctan2(east, north) - np.where(network.kind == RELATIVE_BEARING, pose[..., 2:3], 0.0)
    return np.where(network.kind == RANGE, distance, bearing)


def residuals(network: Network, pose: FloatArray) -> FloatArray:
    """Return v = adjusted - observed, (..., m) in m and rad, bearings within -pi .. pi."""
    v = predict(network, pose) - network.value
    return np.where(network.kind == RANGE, v, wrap_pi(v))


def jacobian(network: Network, pose: FloatArray) -> FloatArray:
    """Return d prediction / d (north, east, heading), (..., m, 3); a mark at own ship's place has zeros."""
    north, east, distance = _offsets(network, pose)
    is_range = network.kind == RANGE
    squared = distance**2
    d_north = np.where(is_range, -north / distance, east / squared)
    d_east = np.where(is_range, -east / distance, -north / squared)
    d_heading = np.broadcast_to(np.where(network.kind == RELATIVE_BEARING, -1.0, 0.0), d_north.shape)
    return np.stack([d_north, d_east, d_heading], axis=-1)


def curvature(network: Network, pose: FloatArray, factor: FloatArray) -> FloatArray:
    """Return the sum of ``factor`` (..., m) times d^2 prediction / d (north, east)^2, (..., 2, 2).

    The heading enters linearly. What the Gauss-Newton method leaves out: it matters where residuals are large.
    """
    north, east, distance = _offsets(network, pose)
    squared = distance**2
    is_range = network.kind == RANGE
    by_range = np.where(is_range, factor / (squared * distance), 0.0)
    by_bearing = np.where(is_range, 0.0, factor / squared**2)
    both = 2.0 * north * east * by_bearing
    h_nn = np.sum(by_range * east**2 + both, axis=-1)
    h_ee = np.sum(by_range * north**2 - both, axis=-1)
    h_ne = np.sum(by_bearing * (east**2 - north**2) - by_range * north * east, axis=-1)
    return np.stack([np.stack([h_nn, h_ne], axis=-1), np.stack([h_ne, h_ee], axis=-1)], axis=-1)


def effective_sigma(network: Network, jacobian_: FloatArray) -> FloatArray:
    """Return 1 sigma of each observation, instrument and mark combined, (..., m).

    The mark is eliminated: moving it by s changes the prediction as moving own ship by -s does, so the variance is
    sigma^2 + j S j' with j the position part of the Jacobian: sigma^2 + s^2 for a range, sigma^2 + (s / d)^2 for a
    bearing at distance d to a mark of s per axis.
    """
    spread = network.mark_covariance_m2[network.mark]
    north, east = jacobian_[..., 0], jacobian_[..., 1]
    moved = spread[:, 0, 0] * north**2 + (2.0 * spread[:, 0, 1] * north + spread[:, 1, 1] * east) * east
    return np.asarray(np.sqrt(network.sigma**2 + moved))


def whitener(network: Network, jacobian_: FloatArray, damping: Damping = "joint") -> FloatArray:
    """Return what turns residuals into uncorrelated ones of unit variance, for `whiten`.

    Range and bearing of one mark are uncorrelated when the mark's sigma is the same in every direction: the inverse
    sigma (..., m), zero where masked out. Otherwise joint damping decorrelates the observations of each target by the
    inverse Cholesky factor of their covariance, (..., g, K, K); separate damping looks at each observation by itself
    and leaves the correlation out.
    """
    if network.diagonal or damping == "separate":
        return np.asarray(network.mask / effective_sigma(network, jacobian_))
    return np.linalg.inv(np.linalg.cholesky(block_covariance(network, jacobian_)))


def whiten(network: Network, whitener_: FloatArray, columns: FloatArray) -> FloatArray:
    """Return ``columns`` (..., m, c) in units of sigma, zero where masked out; leading axes as in the whitener."""
    if whitener_.ndim < columns.ndim:
        return columns * whitener_[..., None]
    used = network.blocks >= 0
    padded = np.where(used[..., None], columns[..., network.blocks, :], 0.0)
    result = np.zeros_like(columns)
    result[..., network.blocks[used], :] = (whitener_ @ padded)[..., used, :]
    return result


def back_to_units(network: Network, whitener_: FloatArray, white: FloatArray) -> FloatArray:
    """Return the transposed whitener times ``white`` (..., m): derivatives by the observations in their own units."""
    if whitener_.ndim == white.ndim:
        return white * whitener_
    used = network.blocks >= 0
    padded = np.where(used, white[..., network.blocks], 0.0)
    result = np.zeros_like(white)
    result[..., network.blocks[used]] = (np.swapaxes(whitener_, -1, -2) @ padded[..., None])[..., used, 0]
    return result


def whitened(network: Network, pose: FloatArray, damping: Damping = "joint") -> tuple[FloatArray, FloatArray]:
    """Return residuals (..., m) and Jacobian (..., m, 3) in units of their sigma at ``pose`` (..., 3)."""
    a = jacobian(network, pose)
    w = whitener(network, a, damping)
    return whiten(network, w, residuals(network, pose)[..., None])[..., 0], whiten(network, w, a)


def block_covariance(network: Network, jacobian_: FloatArray) -> FloatArray:
    """Return the covariance of the observations of each target, (..., g, K, K); unused places have variance 1."""
    used = network.blocks >= 0
    j = np.where(used[..., None], jacobian_[..., network.blocks, :2], 0.0)
    mark = network.mark[network.blocks[:, 0]]
    variance = np.where(used, network.sigma[network.blocks] ** 2, 1.0)
    covariance: FloatArray = j @ network.mark_covariance_m2[mark] @ np.swapaxes(j, -1, -2)
    return covariance + variance[..., None] * np.eye(network.blocks.shape[1])


def target_norms(network: Network, v_white: FloatArray) -> FloatArray:
    """Return the norm of each target's whitened residuals, (..., g): chi with as many dof as it has observations."""
    squared: FloatArray = np.where(network.blocks >= 0, v_white[..., network.blocks] ** 2, 0.0)
    return np.asarray(np.sqrt(squared.sum(axis=-1)))


def spread_to_observations(network: Network, per_target: FloatArray) -> FloatArray:
    """Give each observation the value of its target: (..., g) -> (..., m); zero where it does not take part."""
    used = network.blocks >= 0
    result = np.zeros((*per_target.shape[:-1], len(network.kind)))
    result[..., network.blocks[used]] = np.broadcast_to(per_target[..., None], (*per_target.shape, used.shape[1]))[
        ..., used
    ]
    return result


def prior_residual(network: Network, pose: FloatArray) -> FloatArray:
    """Return heading minus prior in units of its sigma, (...); zero without a prior or with a known heading."""
    if not network.prior_counts or network.heading_prior_rad is None:
        return np.zeros(pose.shape[:-1])
    heading_rad, sigma_rad = network.heading_prior_rad
    return np.asarray(wrap_pi(pose[..., 2] - heading_rad) / sigma_rad)
