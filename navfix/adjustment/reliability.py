"""What an adjustment is worth: sigma0, covariance, redundancy numbers, tests, detectable errors and their effect."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from navfix.adjustment.dense import Linear, linearise
from navfix.adjustment.network import TRUE_BEARING, Network
from navfix.adjustment.sights import effective_sigma, jacobian, prior_residual
from navfix.adjustment.whitening import back_to_units, normal_matrix, whiten, whitened, whitener
from navfix.kernels import Damping
from navfix.types import CovarianceScaling, FloatArray, GlobalTest
from navfix.types.adjusted import DELTA0

CONSPICUOUS = 3.2905  # standardised residual that chance exceeds once in a thousand
GLOBAL_SIGNIFICANCE = 0.05
FEWEST_DOF = 3.0  # with fewer, sigma0 says too little about the noise and the a priori one is kept
_NO_REDUNDANCY = 1e-9
_LEAST_REDUNDANCY = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Quality:
    """The quality of one solution; arrays (m,) follow the observations, in m and rad.

    ``testable`` is False where the redundancy number is zero: there ``standardized`` is 0 and ``mdb`` and
    ``external_m`` are infinite. ``external_m`` is how far an error of the size of the MDB shifts the position.
    ``prior_standardized`` is the heading prior's own standardised residual (0 without one).
    """

    residual: FloatArray
    sigma: FloatArray
    redundancy_number: FloatArray
    standardized: FloatArray
    testable: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    mdb: FloatArray
    external_m: FloatArray
    sigma0: float
    dof: float
    scaling: CovarianceScaling
    covariance: FloatArray
    cofactor: FloatArray
    global_test: GlobalTest | None
    prior_standardized: float
    r95_m: float


def assess(
    network: Network,
    pose: FloatArray,
    weights: FloatArray,
    cofactor: FloatArray,
    damping: Damping,
    *,
    compass_rad: tuple[float, float | None] | None = None,
    linear: Linear | None = None,
) -> Quality:
    """Assess a solution with ``weights`` (m,) and ``cofactor`` (u, u) = (A'WA)^-1.

    ``compass_rad``: the error common to the true bearings, already in their values, and the sigma of its prior (None
    without one), where it is an unknown beside the heading; the cofactor matrix is (4, 4) then. ``linear``: the
    observations about the pose, where they are at hand.

    sigma0^2 = (sum of weights x squared standardised residuals) / dof, dof = sum of weights (+ 1 for a heading prior)
    - unknowns: observations that were given up count neither above nor below. From three degrees of freedom on it
    scales the covariance.

    References
    ----------
    Baarda, A testing procedure for use in geodetic networks, 1968.
    """
    at = linear or linearise(network, None, damping, pose)
    a, v = at.jacobian, at.residual
    sigma = effective_sigma(network, a)
    design = _design(network, a, cofactor)
    gain = _gain(network, design, at.whitener, weights, cofactor)
    redundancy = np.clip(1.0 - np.sum(design * gain, axis=1), 0.0, 1.0)
    testable = redundancy > _NO_REDUNDANCY
    root = np.sqrt(np.where(testable, redundancy, 1.0))
    mdb = np.where(testable, sigma * DELTA0 / root, np.inf)
    statistic, dof = _squared_sum(network, at, weights, cofactor, compass_rad)
    sigma0, scaling = _reference_deviation(statistic, dof)
    scale = sigma0**2 if scaling == "a_posteriori" else 1.0
    covariance = scale * cofactor
    return Quality(
        residual=v,
        sigma=sigma,
        redundancy_number=redundancy,
        standardized=np.where(testable, v / (sigma * root), 0.0),
        testable=testable,
        mdb=mdb,
        external_m=np.where(testable, np.hypot(gain[:, 0], gain[:, 1]) * np.where(testable, mdb, 0.0), np.inf),
        sigma0=sigma0,
        dof=dof,
        scaling=scaling,
        covariance=covariance,
        cofactor=cofactor,
        global_test=global_test(statistic, dof),
        prior_standardized=_prior_standardized(network, pose, cofactor, compass_rad),
        r95_m=radius_of_probability(covariance[:2, :2], 0.95, dof=dof if scaling == "a_posteriori" else None),
    )


def redundancy_numbers(
    network: Network, pose: FloatArray, weights: FloatArray, cofactor: FloatArray, damping: Damping = "joint"
) -> FloatArray:
    """Return r (m,), the share of an error that shows in its own residual: the diagonal of I - A Q A'P.

    P are the weights of this solution; an observation that was given up has r = 1. Their sum, with that of a heading
    prior, is observations minus unknowns.
    """
    a = jacobian(network, pose)
    design = _design(network, a, cofactor)
    effect = _gain(network, design, whitener(network, a, damping), weights, cofactor)
    return np.asarray(np.clip(1.0 - np.sum(design * effect, axis=1), 0.0, 1.0))


def by_residual_sigma(network: Network, pose: FloatArray, damping: Damping) -> Network:
    """Return the network whose kernel arguments are standardised by the residuals' own a-priori sigma at ``pose`` (3,).

    sqrt(r) from the weights before damping, held fixed: computed anew from damped weights it would not settle. An
    observation that nothing controls keeps a tenth of its sigma.

    References
    ----------
    Gdynia stand (Czaplewski et al.), eq. 14-15.
    """
    u, undamped = network.unknowns, network.mask.astype(np.float64)
    matrix = normal_matrix(network, whitened(network, pose, damping)[1], undamped)[:u, :u]
    cofactor = np.asarray(np.linalg.inv(matrix), np.float64)
    redundancy = redundancy_numbers(network, pose, undamped, cofactor, damping)
    return replace(network, standard=np.sqrt(np.maximum(redundancy, _LEAST_REDUNDANCY)))


def _design(network: Network, jacobian_: FloatArray, cofactor: FloatArray) -> FloatArray:
    """Return the design matrix (m, u) for the unknowns of the cofactor matrix; a fourth one is the compass error."""
    u = len(cofactor)
    if u <= 3:
        return jacobian_[:, :u]
    return np.column_stack([jacobian_, -1.0 * (network.kind == TRUE_BEARING)])


def _gain(
    network: Network, design: FloatArray, factor: FloatArray, weights: FloatArray, cofactor: FloatArray
) -> FloatArray:
    """Return (m, u): how much each unknown moves per unit of each observation, P A Q."""
    a_white = whiten(network, factor, design)
    p_a = np.stack([back_to_units(network, factor, weights * column) for column in a_white.T], axis=1)
    return np.asarray(p_a @ cofactor)


def _squared_sum(
    network: Network,
    at: Linear,
    weights: FloatArray,
    cofactor: FloatArray,
    compass_rad: tuple[float, float | None] | None,
) -> tuple[float, float]:
    statistic = float(weights @ at.v_white**2) + float(prior_residual(network, at.pose)) ** 2
    dof = float(weights.sum()) + float(network.prior_counts) - len(cofactor)
    if compass_rad is not None and compass_rad[1] is not None:
        return statistic + (compass_rad[0] / compass_rad[1]) ** 2, dof + 1.0
    return statistic, dof


def _reference_deviation(statistic: float, dof: float) -> tuple[float, CovarianceScaling]:
    sigma0 = math.sqrt(statistic / dof) if dof > 1e-6 else 1.0
    enough = dof >= FEWEST_DOF - 1e-6 and sigma0 > 0.0
    return sigma0, "a_posteriori" if enough else "a_priori"


def _prior_standardized(
    network: Network, pose: FloatArray, cofactor: FloatArray, compass_rad: tuple[float, float | None] | None
) -> float:
    """Return the standardised residual of the heading's prior, or of the compass's where it is the larger; else 0."""
    priors = []
    if network.prior_counts and network.heading_prior_rad is not None:
        priors.append((float(prior_residual(network, pose)), network.heading_prior_rad[1], float(cofactor[2, 2])))
    if compass_rad is not None and compass_rad[1] is not None:
        priors.append((compass_rad[0] / compass_rad[1], compass_rad[1], float(cofactor[3, 3])))
    found = [z / math.sqrt(r) for z, sigma, q in priors if (r := 1.0 - q / sigma**2) > _NO_REDUNDANCY]
    return max(found, key=abs, default=0.0)


def global_test(statistic: float, dof: float, *, significance: float = GLOBAL_SIGNIFICANCE) -> GlobalTest | None:
    """Test the weighted sum of squared standardised residuals against chi-square (one-sided); None without dof."""
    from scipy.special import gammaincinv

    if dof <= 1e-6:
        return None
    threshold = 2.0 * float(gammaincinv(dof / 2.0, 1.0 - significance))
    return GlobalTest(statistic, dof, threshold, statistic <= threshold)


def radius_of_probability(covariance_m2: FloatArray, probability: float, *, dof: float | None = None) -> float:
    """Return the radius [m] of the circle that holds ``probability``, by integrating over all directions.

    A point of the unit circle at angle a becomes one of the ellipse at h^2 = (major cos a)^2 + (minor sin a)^2; beyond
    R lies exp(-R^2 / (2 h^2)) of what goes there, or (1 + R^2 / (h^2 dof))^(-dof / 2) when the covariance was scaled
    by a sigma0 of ``dof``. For a circle of sigma per axis and 95 % the radius is 2.448 sigma (not 2 drms = 2.83).
    """
    values = np.maximum(np.linalg.eigvalsh(np.asarray(covariance_m2, np.float64)), 0.0)
    minor, major = math.sqrt(values[0]), math.sqrt(values[1])
    if major <= 0.0:
        return 0.0
    form = 1.0 / np.maximum((major * np.cos(_CIRCLE)) ** 2 + (minor * np.sin(_CIRCLE)) ** 2, 1e-12 * major**2)

    squared = -2.0 * math.log1p(-probability) * major**2
    for _ in range(50):  # Newton's method on the logarithm of what lies beyond, nearly linear in R^2
        if dof is None:
            tail, slope = np.exp(-0.5 * squared * form), -0.5 * form
        else:
            tail, slope = (1.0 + squared * form / dof) ** (-0.5 * dof), -0.5 * form / (1.0 + squared * form / dof)
        beyond = float(tail.mean())
        change = math.log(beyond / (1.0 - probability)) * beyond / float((tail * slope).mean())
        squared = max(squared - change, 0.25 * squared)
        if abs(change) <= 1e-12 * squared:
            break
    return math.sqrt(squared)


_CIRCLE = (np.arange(256) + 0.5) * (2.0 * np.pi / 256)
