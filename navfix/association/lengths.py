"""More evidence: the size of an echo against the length of a ship, as a ratio to the lengths that this picture shows.

Some radars tell how long an echo is. Seen end on, an echo is as long as the ship is wide; smeared by beam and pulse it
is longer: so the logarithm of the ratio is spread widely, and a coaster among coasters proves nothing. As with speeds,
what a length proves depends on how common it is among the marks and among the echoes.
"""

from __future__ import annotations

import numpy as np

from navfix.association.speeds import ratio_to_the_picture
from navfix.catalog import AssociationModel, association_model
from navfix.types import FloatArray


def log_length_ratio(target_m: FloatArray, mark_m: FloatArray, model: AssociationModel | str = "seeded") -> FloatArray:
    """Return ln [f(length of echo i | mark j) / f(length of echo i)] (m, n): eq. (6.13) of the theory.

    Parameters
    ----------
    target_m, mark_m : lengths (m,) and (n,), NaN where unknown: such pairs get 0
    """
    target, mark = (np.log(np.where(length_m > 0.0, length_m, np.nan)) for length_m in (target_m, mark_m))
    m = association_model(model)
    return ratio_to_the_picture(target + m.length_shortening, mark, m.length_shares, m.length_sigmas, m.most_told)
