"""In words beside the numbers: a second place, a compass that the echoes refute, and how far the log is off."""

from __future__ import annotations

import math

from navfix.types import Association, Epoch, Fix
from navfix.units import wrap_180

GYRO_DISAGREES_DEG = 10.0  # radar alignment and gyro together explain a few degrees, not this
CHECK_COMPASS = "Check the compass"
TRUE_BEARINGS_OFF_DEG = 2.0  # the alignment of a radar that shows true bearings is in it as well


def association_cautions(association: Association, epoch: Epoch) -> tuple[str, ...]:
    """Return what the reader must not miss: AIS positions shifted alike, a compass that the echoes refute."""
    return (*_group_caution(association), *_compass_caution(association, epoch))


def heading_notes(found: Fix, epoch: Epoch) -> tuple[str, ...]:
    """Return how far the heading in the log is from the one found, where that is no caution."""
    hint = epoch.heading_hint
    if hint is None or found.heading_deg is None:
        return ()
    off_deg = wrap_180(hint.heading_deg - found.heading_deg)
    if abs(off_deg) > GYRO_DISAGREES_DEG + 3.0 * hint.sigma_deg:
        return ()  # a caution
    return (f"The heading in the log differs by {off_deg:+.1f}° (radar alignment and compass error together).",)


def _group_caution(association: Association) -> tuple[str, ...]:
    group = association.second_group
    if group is None:
        return ()
    where = f"{group.offset_m:.0f} m along {group.azimuth_deg:03.0f}°"
    return (
        f"{len(group.targets)} targets agree on another place, {where}: the AIS positions of one of the two groups are "
        "shifted alike. Check the position with something that is neither.",
    )


def _compass_caution(association: Association, epoch: Epoch) -> tuple[str, ...]:
    hint, found_deg = epoch.heading_hint, association.heading_deg
    if found_deg is None or association.covariance is None:
        return ()
    references = {epoch.targets[int(target)].bearing_reference for target in association.pairs[:, 0]}
    if references == {"true"}:
        off_deg, sigma_deg = -wrap_180(found_deg), math.degrees(math.sqrt(association.covariance[2, 2]))
        if abs(off_deg) > TRUE_BEARINGS_OFF_DEG + 3.0 * sigma_deg:
            return (f"{CHECK_COMPASS}: the true bearings of the radar are {off_deg:+.1f}° off.",)
    elif references == {"relative"} and hint is not None:
        off_deg = wrap_180(hint.heading_deg - found_deg)
        if abs(off_deg) > GYRO_DISAGREES_DEG + 3.0 * hint.sigma_deg:
            told = f"the heading in the log, {hint.heading_deg:.1f}°"
            return (f"{CHECK_COMPASS}: {told}, is {off_deg:+.1f}° off.",)
    return ()
