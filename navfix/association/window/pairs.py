"""Step 9: which track is which mark at one own motion, one to one, and how likely each pair is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from navfix.association.em import GATE, NOMINAL_LEVEL, NOMINAL_SHARE
from navfix.association.pairs import likeliest
from navfix.association.window.em import density_ratio
from navfix.association.window.field import WindowField
from navfix.association.window.fit import Fit, as_clutter, lay_over
from navfix.association.window.knots import Knots
from navfix.association.window.tracks import epoch_time
from navfix.types import Epoch, FloatArray, IntArray

if TYPE_CHECKING:
    from navfix.association.window.joint import Window

LEAST_LOG_RATIO = -5.0  # what a pair is worth where its track lives and is not near its mark
SAME_SCAN_S = 1.0  # the targets of a scan carry times of their own
CERTAIN = 1e9  # larger ratios say no more, and lose the digits of the sums that they stand in


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs (p, 2) of track and mark index with posterior (p,), and the misfit of each track's mean [m] (p, 2)."""

    index: IntArray
    probability: FloatArray
    misfit_m: FloatArray


def one_to_one(field: WindowField, knots: Knots) -> Pairs:
    """Return the likeliest one-to-one pairs at a single own motion; a track may stay without a mark."""
    fit = lay_over(field, knots)
    density, _ = density_ratio(field, fit, as_clutter(field, fit.path))
    ratio = (field.odds(fit.mark, NOMINAL_LEVEL) * density)[0]
    against_clutter = np.where(fit.distance_sq[0] <= GATE, np.minimum(ratio / NOMINAL_SHARE, CERTAIN), 0.0)
    index, probability = likeliest(against_clutter, fit.mark[0], len(field.scene.paths.marks))
    return Pairs(index, probability, _mean_misfit(field, fit, *index.T))


def _mean_misfit(field: WindowField, fit: Fit, track: IntArray, mark: IntArray) -> FloatArray:
    neighbour = np.argmax(fit.mark[0, track] == mark[:, None], axis=1)
    misfit: FloatArray = fit.misfit[0, track, neighbour, 0] / np.sqrt(field.scene.bins[track])[:, None]
    return misfit


def log_ratios(field: WindowField, knots: Knots) -> tuple[IntArray, FloatArray]:
    """Return the marks near every track (k, m, q) and ln of N_ij / (lambda_i V_i) (k, m, q), at least -5."""
    fit = lay_over(field, knots)
    density, _ = density_ratio(field, fit, as_clutter(field, fit.path))
    return fit.mark, np.log(np.maximum(density, math.exp(LEAST_LOG_RATIO)))


def labels_by_epoch(window: Window, index: IntArray, epochs: Sequence[Epoch]) -> list[dict[str, str]]:
    """Return {target label: mark label} for each epoch of a window, from its pairs (p, 2) of track and mark.

    A label that is used again belongs to its track only between the track's first and last report.
    """
    scene = window.field.scene
    named = [(scene.tracks[track], scene.paths.marks[mark].label) for track, mark in index.tolist()]
    found = []
    for epoch in epochs:
        marks, time_s = {mark.label for mark in epoch.marks}, epoch_time(epoch)
        there = {t.label for t in epoch.targets if t.bearing_reference == scene.flat.reference}
        found.append(
            {
                track.label: mark
                for track, mark in named
                if track.label in there and mark in marks
                if track.time_s[0] - SAME_SCAN_S <= time_s <= track.time_s[-1] + SAME_SCAN_S
            }
        )
    return found
