"""Solution separation: what the answer would be without one mark, and how far that may lie away by chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.errors import InputError
from navfix.types import FloatArray

BoolArray = NDArray[np.bool_]
_SINGULAR = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Blocks:
    """A linearised adjustment, target by target, in units of sigma and damped: rows are sqrt(weight) a / sigma.

    Attributes
    ----------
    rows : (g, K, u) design rows of each target's observations, zero where it has fewer than K
    residual : (g, K) its residuals in the same units
    prior : (u, u) information that belongs to no target (a heading prior), zero where there is none
    labels : (g,) names of the targets' marks
    """

    rows: FloatArray
    residual: FloatArray
    prior: FloatArray
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        g, k, u = self.rows.shape
        if self.residual.shape != (g, k) or self.prior.shape != (u, u) or len(self.labels) != g:
            raise InputError(f"blocks: rows {self.rows.shape} do not fit residuals {self.residual.shape}")

    @property
    def information(self) -> FloatArray:
        """A_k' W_k A_k of each target, (g, u, u)."""
        return np.asarray(np.swapaxes(self.rows, 1, 2) @ self.rows)

    def taking_part(self) -> Blocks:
        """Return the targets that the kernel has left any weight."""
        kept = np.flatnonzero(np.any(self.rows != 0.0, axis=(1, 2)))
        return Blocks(self.rows[kept], self.residual[kept], self.prior, tuple(self.labels[i] for i in kept))


@dataclass(frozen=True, slots=True, eq=False)
class Separation:
    """The answers with one hypothesis left out each; all arrays begin with the hypotheses (h,).

    ``cofactor`` (u, u) and ``without`` (h, u, u): with everything and without; ``shift`` (h, u): answer without minus
    answer with everything; ``determined`` (h,): whether anything is left to determine it.
    """

    cofactor: FloatArray
    without: FloatArray
    shift: FloatArray
    determined: BoolArray

    @property
    def variance(self) -> FloatArray:
        """Of the shift, (h, u): s_k^2 - s_0^2 (before scaling by sigma0^2)."""
        whole = np.diagonal(self.cofactor)
        return np.asarray(np.maximum(np.diagonal(self.without, axis1=1, axis2=2) - whole, 0.0))


def separate(blocks: Blocks, hypotheses: BoolArray | None = None) -> Separation:
    """Leave out each target, or each set of targets that a row of ``hypotheses`` (h, g) names.

    The normal matrix N = A'WA loses the rank of what is left out, N_k = N - A_k'W_k A_k, and because A'Wv = 0 in the
    minimum, the answer moves by N_k^-1 A_k'W_k v_k, v = adjusted - observed: eq. (7.1). Weights are those of the
    whole adjustment.

    References
    ----------
    Blanch et al., Advanced RAIM user algorithm description, 2012 (there by solving every subset).
    """
    information = blocks.information
    gradient = np.einsum("gku,gk->gu", blocks.rows, blocks.residual)
    normal = information.sum(axis=0) + blocks.prior
    if hypotheses is not None:
        chosen = np.asarray(hypotheses, np.float64)
        information, gradient = np.tensordot(chosen, information, 1), chosen @ gradient
    if not _regular(normal):
        count, u = gradient.shape
        nothing = np.zeros((count, u, u))
        return Separation(np.zeros((u, u)), nothing, np.zeros((count, u)), np.zeros(count, bool))
    scale = 1.0 / np.sqrt(np.diagonal(normal))
    reduced = (normal - information) * scale[:, None] * scale
    determined = np.linalg.eigvalsh(reduced)[:, 0] > _SINGULAR
    inverse = np.linalg.inv(np.where(determined[:, None, None], reduced, np.eye(len(normal))))
    without = inverse * scale[:, None] * scale
    shift = (without @ gradient[..., None])[..., 0]
    return Separation(np.linalg.inv(normal), without, shift, determined)


def _regular(normal: FloatArray) -> bool:
    """Tell whether the observations of a fix determine it by themselves: a scan within a smoothed log may not."""
    diagonal = np.diagonal(normal)
    if not len(diagonal) or np.any(diagonal <= 0.0):
        return False
    scale = 1.0 / np.sqrt(diagonal)
    return bool(np.linalg.eigvalsh(normal * scale[:, None] * scale)[0] > _SINGULAR)
