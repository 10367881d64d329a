"""The fix of a window, refined: its pairs adjusted as one factor graph over all scans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from navfix.adjustment.window import adjust_window
from navfix.association.window.associate import WindowAnswer
from navfix.catalog import RadarModel
from navfix.errors import NoFix
from navfix.geodesy import LocalPlane
from navfix.kernels import Kernel
from navfix.types import Epoch, Fix, Position

AGREES = 16.27  # chi-square, 3 degrees of freedom, 99.9 %


def refined(
    epochs: Sequence[Epoch], found: WindowAnswer, *, radar: RadarModel | str = "imo", kernel: Kernel | str = "hampel"
) -> Fix:
    """Adjust the pairs that the association of a window found, from its pose, over all of its epochs.

    The marginal covariance of the graph trusts the errors that it was told of. On real traffic few tracks carry a
    window and err in ways that nobody stated, so the spread of the pose without one track after the other is added, as
    it is to the association's own covariance: eq. (6.18) of the theory. Where the adjustment finds no answer, or one
    that the association's ellipse does not reach, the association's fix stands and its notes say so. Where all
    bearings are true neither has a heading, and their covariances are (2, 2).

    Parameters
    ----------
    epochs : the window that was associated
    found : what `navfix.association.window.associate.solve_window` said of it
    radar, kernel : as for `navfix.fix`

    Returns
    -------
    Fix - its epoch is the newest; residuals are means of the tracks over the window
    """
    rough = found.fix
    assert isinstance(rough.position, Position)
    try:
        fine = adjust_window(
            epochs, found.labels, start=(rough.position, rough.heading_deg or 0.0), radar=radar, kernel=kernel
        )
    except NoFix as error:
        return _unrefined(rough, f"the adjustment of all scans gives none ({error.reason})")
    if len(rough.covariance) != len(fine.covariance):
        return _unrefined(rough, "in the adjustment of all scans bearings of the other reference take part")
    if _misfit_sq(rough, fine) > AGREES:
        return _unrefined(rough, "the adjustment of all scans leads elsewhere")
    return replace(
        fine,
        covariance=fine.covariance + found.spread[: len(fine.covariance), : len(fine.covariance)],
        association=found.association,
        notes=(*rough.notes, *fine.notes),
    )


def _unrefined(rough: Fix, why: str) -> Fix:
    return replace(rough, notes=(*rough.notes, f"The fix is that of the association: {why}."))


def _misfit_sq(rough: Fix, fine: Fix) -> float:
    """Return the squared Mahalanobis distance of a refined fix from the association's."""
    assert isinstance(rough.position, Position)
    assert isinstance(fine.position, Position)
    north_m, east_m = LocalPlane(rough.position).to_plane(fine.position)
    turned_deg = ((fine.heading_deg or 0.0) - (rough.heading_deg or 0.0) + 180.0) % 360.0 - 180.0
    step = np.array([north_m, east_m, math.radians(turned_deg)])[: len(rough.covariance)]
    return float(step @ np.linalg.solve(rough.covariance, step))
