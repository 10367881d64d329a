"""The fix of a window, refined: its pairs adjusted as one factor graph over all scans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from navfix.adjustment.window import KnownPose, adjust_window
from navfix.association.window.associate import WindowAnswer
from navfix.catalog import RadarModel, adjustment_model
from navfix.errors import NoFix
from navfix.geodesy import LocalPlane
from navfix.kernels import Kernel
from navfix.types import Epoch, Fix, Position
from navfix.units import wrap_180

_ELSEWHERE = "the adjustment of all scans leads elsewhere"


def refined(
    epochs: Sequence[Epoch],
    found: WindowAnswer,
    *,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    prior: KnownPose | None = None,
) -> Fix:
    """Adjust the pairs that the association of a window found, from its pose, over all of its epochs.

    The marginal covariance of the graph trusts the errors that it was told of. On real traffic few tracks carry a
    window and err in ways that nobody stated, so the spread of the pose without one track after the other is added, as
    it is to the association's own covariance: eq. (6.22) of the theory. Where the adjustment finds no answer, or one
    that the association's ellipse does not reach, the association's fix stands and its notes say so.

    Parameters
    ----------
    epochs : the window that was associated
    found : what `navfix.association.window.associate.solve_jointly` said of it
    radar, kernel : as for `navfix.fix`
    prior : pose at the first epoch that the association knew too, from data older than the window

    Returns
    -------
    Fix - its epoch is the newest; residuals are means of the tracks over the window
    """
    rough = found.fix
    assert isinstance(rough.position, Position)
    heading_deg = found.association.heading_deg  # of true bearings only how they are turned: the fix has no heading
    assert heading_deg is not None
    try:
        fine = adjust_window(
            epochs, found.labels, start=(rough.position, heading_deg), radar=radar, kernel=kernel, prior=prior
        )
    except NoFix as error:
        return _unrefined(rough, f"the adjustment of all scans gives none ({error.reason})")
    if _misfit_sq(rough, fine) > adjustment_model().agrees_sq:
        return _unrefined(rough, _ELSEWHERE)
    unknowns = len(fine.covariance)
    covariance = fine.covariance + found.spread[:unknowns, :unknowns]
    return replace(
        fine,
        covariance=covariance,
        cofactor_matrix=covariance / fine.sigma0**2,
        association=found.association,
        notes=fine.notes,
    )


def contradicted(fix: Fix) -> bool:
    """Tell whether a fix is that of an association whose scans, adjusted together, lead elsewhere."""
    return any(_ELSEWHERE in note for note in fix.notes)


def _unrefined(rough: Fix, why: str) -> Fix:
    return replace(rough, notes=(*rough.notes, f"The fix is that of the association: {why}."))


def _misfit_sq(rough: Fix, fine: Fix) -> float:
    """Return the squared Mahalanobis distance of a refined fix from the association's; true bearings: of places."""
    assert isinstance(rough.position, Position)
    assert isinstance(fine.position, Position)
    north_m, east_m = LocalPlane(rough.position).to_plane(fine.position)
    if fine.heading_deg is None or rough.heading_deg is None:
        step = np.array([north_m, east_m])
    else:
        step = np.array([north_m, east_m, math.radians(wrap_180(fine.heading_deg - rough.heading_deg))])
    return float(step @ np.linalg.solve(rough.covariance[: len(step), : len(step)], step))
