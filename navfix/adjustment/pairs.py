"""Pairs of targets and marks as a network: sigmas, masks, and what the true bearings hang on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, BoolArray, Network
from navfix.catalog import RadarModel
from navfix.errors import InputError, TooFewPairs
from navfix.types import Association, Epoch, FloatArray, HeadingHint, IntArray, Mark, RadarTarget


class Pair(NamedTuple):
    """A target and the mark that it is."""

    target: RadarTarget
    mark: Mark


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """What is adjusted: pairs, their network with all marks at the origin, and the compass in the true bearings.

    ``kind`` (m,) is the kind of each observation as it was measured. Where every bearing that takes part is true and
    the compass may err (``common`` True), the network holds them as relative bearings: the unknown turn is then the
    compass error, and ``heading_prior_rad`` = (0, ``compass_sigma_rad``) its prior.
    """

    pairs: Sequence[Pair]
    network: Network
    kind: IntArray
    compass_sigma_rad: float
    common: bool

    @property
    def mixed(self) -> bool:
        """Whether relative and true bearings take part together and the compass in the true ones may err."""
        return self.compass_sigma_rad > 0.0 and not self.common and self.network.heading_unknown and self.any_true

    @property
    def any_true(self) -> bool:
        """Whether a true bearing takes part."""
        return bool(np.any((self.kind == TRUE_BEARING) & self.network.mask))


def pairs_of(epoch: Epoch, association: Association) -> list[Pair]:
    """Return the pairs of an association.

    Raises
    ------
    TooFewPairs : there is none
    """
    pairs = [Pair(epoch.targets[t], epoch.marks[m]) for t, m in association.pairs]
    if not pairs:
        raise TooFewPairs("no pairs: nothing to adjust", observations=0, unknowns=3)
    return pairs


def problem_of(
    pairs: Sequence[Pair],
    sigmas: FloatArray,
    mask: BoolArray,
    *,
    heading_prior: HeadingHint | None = None,
    compass_sigma_deg: float = 0.0,
) -> Problem:
    """Make the network of pairs; ``sigmas`` (k, 2) of range [m] and bearing [rad], ``mask`` (k, 2).

    Raises
    ------
    InputError : a compass sigma that is negative or not finite
    """
    if not (math.isfinite(compass_sigma_deg) and compass_sigma_deg >= 0.0):
        raise InputError(f"compass_sigma_deg must be >= 0, got {compass_sigma_deg}")
    bearing = [TRUE_BEARING if p.target.bearing_reference == "true" else RELATIVE_BEARING for p in pairs]
    kind = np.column_stack([np.full(len(pairs), RANGE), bearing]).ravel()
    taking_part = set(kind[mask.ravel()].tolist())
    common = compass_sigma_deg > 0.0 and TRUE_BEARING in taking_part and RELATIVE_BEARING not in taking_part
    prior = None if heading_prior is None else (heading_prior.heading_deg, heading_prior.sigma_deg)
    prior = (0.0, compass_sigma_deg) if common else prior
    network = Network.build(
        kind=np.where(kind == TRUE_BEARING, RELATIVE_BEARING, kind) if common else kind,
        mark=np.repeat(np.arange(len(pairs)), 2),
        value=np.array([(p.target.range_m, math.radians(p.target.bearing_deg)) for p in pairs]).ravel(),
        sigma=sigmas.ravel(),
        mark_ne_m=np.zeros((len(pairs), 2)),
        mark_sigma_m=[p.mark.sigma_m for p in pairs],
        mask=mask.ravel(),
        heading_prior_rad=None if prior is None else (math.radians(prior[0]), math.radians(prior[1])),
    )
    return Problem(pairs, network, kind, math.radians(compass_sigma_deg), common)


def observation_sigmas(
    pairs: Sequence[Pair], radar: RadarModel, range_sigma_m: float | None, bearing_sigma_deg: float | None
) -> FloatArray:
    """Return (k, 2): sigma of range [m] and bearing [rad]; an explicit one, else the target's, else the radar's.

    Raises
    ------
    InputError : an explicit sigma that is not > 0
    """
    for name, value in (("range_sigma_m", range_sigma_m), ("bearing_sigma_deg", bearing_sigma_deg)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} must be > 0, got {value}")
    by_model = radar.sigma_of_range_m(np.array([pair.target.range_m for pair in pairs]))
    rows = [
        (
            range_sigma_m or pair.target.range_sigma_m or by_model[row],
            math.radians(bearing_sigma_deg or pair.target.bearing_sigma_deg or radar.bearing_sigma_deg),
        )
        for row, pair in enumerate(pairs)
    ]
    return np.array(rows, np.float64)


def mask_of(mask: ArrayLike | None, count: int) -> BoolArray:
    """Return a mask (k, 2) of one given as None, (k,) or (k, 2).

    Raises
    ------
    InputError : another shape
    """
    if mask is None:
        return np.ones((count, 2), bool)
    given = np.asarray(mask, bool)
    if given.shape not in ((count,), (count, 2)):
        raise InputError(f"mask must have shape ({count},) or ({count}, 2), got {given.shape}")
    return np.repeat(given[:, None], 2, axis=1) if given.ndim == 1 else given
