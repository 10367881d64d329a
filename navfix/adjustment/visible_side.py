"""Adjust with every paired mark at the side of its hull that own ship sees, which takes an idea of where that is."""

from __future__ import annotations

from navfix.adjustment.epoch import adjust
from navfix.catalog import RadarModel
from navfix.geodesy import inverse
from navfix.kernels import Kernel
from navfix.picture.hull import facing
from navfix.types import Association, Epoch, Fix, Position

SEEN_FROM_ELSEWHERE_M = 50.0  # at 1 km that turns the side of a hull by 3 deg


def adjust_visible_side(
    epoch: Epoch, association: Association, *, radar: RadarModel | str = "imo", kernel: Kernel | str = "hampel"
) -> Fix:
    """Adjust with the marks of the pairs moved from the centres of their hulls to the visible sides.

    From where the hulls are seen follows from the association, else from an adjustment with their centres; once more
    from the adjusted place where the two differ. The epoch of the fix holds the marks as moved.

    Raises
    ------
    NoFix : as `adjust`
    """
    own = association.position
    if own is None:
        own = _on_earth(adjust(epoch, association, radar=radar, kernel=kernel))
    found = adjust(facing(epoch, own, association.pairs), association, radar=radar, kernel=kernel)
    place = _on_earth(found)
    if inverse(own, place)[0] <= SEEN_FROM_ELSEWHERE_M:
        return found
    return adjust(facing(epoch, place, association.pairs), association, radar=radar, kernel=kernel)


def _on_earth(fix: Fix) -> Position:
    assert isinstance(fix.position, Position)  # an epoch's marks are on earth, and so is what follows from them
    return fix.position
