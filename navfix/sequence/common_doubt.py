"""A fix whose data had an error common to all observations taken off: its covariance holds what is not known of that.

The error that was taken off has a sigma of its own. All observations carry it alike, so no number of them averages it
out and the residuals hardly show it: it is propagated to the pose, eq. (13.11a).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from navfix.adjustment.reliability import radius_of_probability
from navfix.integrity.levels import missed_detection_factor
from navfix.sequence.common_error import Column, whitened_rows
from navfix.types import Fix, FloatArray, Integrity, Position

SAID = "The ellipse holds what is not known of the radar errors that were taken off: 1 sigma {:.1f} m."


def with_common_doubt(fix: Fix, columns: Sequence[Column], sigmas: Sequence[float]) -> Fix:
    """Return the fix with the doubt about k common errors in its covariance, radius and protection level.

    The errors are taken as independent. The protection level grows by as many sigmas of that doubt as it has of noise,
    where one mark is left out and the doubt is largest. The position does not move.

    Parameters
    ----------
    columns : derivatives of an observation by each error
    sigmas : 1 sigma of what is left of each error, in its own unit; 0 for one that was not taken off
    """
    if not any(sigmas) or fix.epoch is None or not isinstance(fix.position, Position):
        return fix
    marks = {mark.label: mark for mark in fix.epoch.marks}
    rows, labels = whitened_rows(fix, fix.position, marks, columns, np.zeros(len(columns)))
    if len(rows) < 3:
        return fix
    moved = _moved(rows, sigmas)
    used = moved[: len(fix.covariance)]
    covariance = fix.covariance + used @ used.T
    scaled = fix.covariance_scaling == "a_posteriori"
    return replace(
        fix,
        covariance=covariance,
        cofactor_matrix=covariance / (fix.sigma0**2 if scaled else 1.0),
        integrity=None if fix.integrity is None else _integrity(fix, fix.integrity, covariance, rows, labels, sigmas),
        notes=(*fix.notes, SAID.format(float(np.linalg.norm(moved[:2])))),
    )


def _moved(rows: FloatArray, sigmas: Sequence[float]) -> FloatArray:
    """Return (3, k): how far 1 sigma of each error moves north [m], east [m], heading [rad]."""
    gain = np.linalg.lstsq(rows[:, :3], rows[:, 3:-1], rcond=None)[0]  # (A'A)^-1 A'a
    return np.asarray(gain * np.asarray(sigmas))


def _integrity(
    fix: Fix,
    stated: Integrity,
    covariance: FloatArray,
    rows: FloatArray,
    labels: Sequence[str],
    sigmas: Sequence[float],
) -> Integrity:
    dof = fix.dof if fix.covariance_scaling == "a_posteriori" else None
    r95_m = radius_of_probability(covariance[:2, :2], 0.95, dof=dof)
    if stated.probability_of_missed_detection is None:
        return replace(stated, r95_m=r95_m)
    of_mark = np.array(labels)
    left = [rows, *(rows[of_mark != label] for label in dict.fromkeys(labels))]
    doubt_m = max(float(np.linalg.norm(_moved(some, sigmas)[:2])) for some in left)
    more_m = missed_detection_factor(stated.probability_of_missed_detection, len(left) - 1) * doubt_m
    return replace(
        stated,
        r95_m=r95_m,
        protection_level_m=_more(stated.protection_level_m, more_m),
        slope_level_m=_more(stated.slope_level_m, more_m),
    )


def _more(level_m: float | None, more_m: float) -> float | None:
    return None if level_m is None else level_m + more_m
