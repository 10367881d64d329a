"""One linear step as textbooks print it: V = A dx + L, dx = -(A'PA)^-1 A'PL, with all its matrices."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.adjustment.network import RANGE, Network
from navfix.adjustment.sights import effective_sigma, jacobian, residuals
from navfix.errors import Unobservable
from navfix.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class LinearStep:
    """The linearised adjustment at a start; m observations in their own units (m or deg), u unknowns.

    Attributes
    ----------
    design_matrix : A (m, u), per north [m], east [m] and, where it is unknown, heading [rad]
    free_terms : L (m,) computed at the start minus observed
    weights : P (m,) kernel weight / sigma^2
    increments : dx (u,) from the start
    residuals : V (m,) = A dx + L = adjusted minus observed
    sigma0 : sqrt(V'PV / f), f the sum of the kernel weights minus u; None where f is not > 0
    cofactors : Q (u, u) = (A'PA)^-1
    adjusted_sigma : (m,) sigma0 sqrt(A Q A')_ii, standard deviation of the adjusted observations (sigma0 = 1 if None)
    position_sigma_m : sigma0 sqrt(Q_nn + Q_ee), the mean position error

    References
    ----------
    [1] Gdynia stand, Czaplewski et al., eq. (3) to (13).
    """

    design_matrix: FloatArray
    free_terms: FloatArray
    weights: FloatArray
    increments: FloatArray
    residuals: FloatArray
    sigma0: float | None
    cofactors: FloatArray
    adjusted_sigma: FloatArray
    position_sigma_m: float

    @property
    def observation_cofactors(self) -> FloatArray:
        """Return A Q A' (m, m), the cofactors of the adjusted observations."""
        return np.asarray(self.design_matrix @ self.cofactors @ self.design_matrix.T)

    @property
    def residual_cofactors(self) -> FloatArray:
        """Return P^-1 - A Q A' (m, m), the cofactors of the residuals; NaN on the diagonal where P is zero."""
        variances = np.divide(1.0, self.weights, out=np.full_like(self.weights, np.nan), where=self.weights > 0.0)
        adjusted = self.observation_cofactors
        matrix = -adjusted
        np.fill_diagonal(matrix, variances - np.diag(adjusted))
        return matrix


def linear_step(network: Network, pose: FloatArray, kernel_weight: FloatArray | None = None) -> LinearStep:
    """Linearise at ``pose`` (3,) and solve once.

    Parameters
    ----------
    kernel_weight : (m,) within 0 .. 1; None: 1 for every observation that takes part

    Raises
    ------
    Unobservable : A'PA is singular
    """
    u, unit = network.unknowns, np.where(network.kind == RANGE, 1.0, math.degrees(1.0))
    full = jacobian(network, pose)
    A = full[:, :u] * unit[:, None]
    L = residuals(network, pose) * unit
    share = network.mask.astype(np.float64) if kernel_weight is None else kernel_weight * network.mask
    P = share / (effective_sigma(network, full) * unit) ** 2
    Q = _inverse(A.T @ (P[:, None] * A))
    dx = -Q @ (A.T @ (P * L))
    V = A @ dx + L
    dof = float(np.sum(share)) - u
    sigma0 = math.sqrt(float(P @ V**2) / dof) if dof > 1e-9 else None
    scale = 1.0 if sigma0 is None else sigma0
    return LinearStep(
        design_matrix=A,
        free_terms=L,
        weights=P,
        increments=dx,
        residuals=V,
        sigma0=sigma0,
        cofactors=Q,
        adjusted_sigma=scale * np.sqrt(np.einsum("ij,jk,ik->i", A, Q, A)),
        position_sigma_m=scale * math.sqrt(Q[0, 0] + Q[1, 1]),
    )


def _inverse(normal: FloatArray) -> FloatArray:
    """Invert the normal matrix after scaling its diagonal to one."""
    scale = np.sqrt(np.diag(normal))
    if not np.all(scale > 0.0):
        raise Unobservable("the normal matrix at the start is singular", direction="not determined")
    scaled = normal / np.outer(scale, scale)
    if np.linalg.eigvalsh(scaled)[0] < 1e-12:
        raise Unobservable("the normal matrix at the start is singular", direction="not determined")
    return np.asarray(np.linalg.inv(scaled) / np.outer(scale, scale))
