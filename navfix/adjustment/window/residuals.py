"""The residual report of a window: one pair of rows for each track, the mean over the window."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from navfix.adjustment.window.components import Judged
from navfix.adjustment.window.problem import Sighting, WindowNetwork
from navfix.adjustment.window.rows import (
    NEW_BEARING,
    NEW_RANGE,
    OFFSET,
    STEADY_BEARING,
    STEADY_RANGE,
)
from navfix.types import AdjustedObservation, ObservationKind


def track_observations(
    sightings: Sequence[Sighting], window: WindowNetwork, found: Judged, at: int | None
) -> tuple[AdjustedObservation, ...]:
    """Return range and bearing of each track: mean residual over the window against the mark as given; eq. (10.10).

    With ``at`` only the tracks of that epoch, as observed there.
    """
    plan, state = found.damper.plan, found.descended.state
    bare = state.copy()
    bare[plan.layout.shared + 5 :] = 0.0
    v, a = plan.sights.rows(bare)
    sigma = plan.sights.sigma
    v, a = v.reshape(-1, 2) * sigma, a.reshape(-1, 2, a.shape[1]) * sigma[:, :, None]
    columns = plan.columns[plan.radar].reshape(-1, 2, a.shape[2])
    weights = found.descended.weights
    rows = []
    for track, label in enumerate(window.tracks.label):
        members = np.flatnonzero(window.seen.track == track)
        here = members if at is None else members[window.seen.epoch[members] == at]
        if not len(here):
            continue
        mark = int(window.tracks.mark[track])
        static = float(weights.static[mark]) * float(found.damper.taking_part[mark])
        for part in (0, 1):
            w = weights.sighting[members, part]
            share = w / w.sum() if w.sum() > 0.0 else np.full(len(members), 1.0 / len(members))
            last = here[-1]
            kept = [0, 1, 2, 6, 7]  # pose and globals: what stays with the mark is the residual's own business
            row, entry = a[last, part, kept], columns[last, part, kept]
            spread = _spread(window, found, track, part, members, float(share**2 @ sigma[members, part] ** 2))
            explained = float(row @ found.cofactor[entry[:, None], entry] @ row)
            rows.append(
                _row(
                    sightings[last], label, part, float(share @ v[members, part]), spread, explained,
                    static * float(np.mean(w)),
                )
            )  # fmt: skip
    return tuple(rows)


def _spread(window: WindowNetwork, found: Judged, track: int, part: int, members: np.ndarray, new: float) -> float:
    """Return 1 sigma of a track's mean: what stays with track and mark, and the variance of what is ``new``."""
    components, mark = found.damper.components, int(window.tracks.mark[track])
    across = 1.0 if part == 0 else 1.0 / max(float(window.seen.value[members[-1], 0]), 1.0)
    offset = window.mark_sigma_m[mark] * across
    steady = window.tracks.sigma[track, part]
    variance = components[OFFSET] * offset**2 + components[(STEADY_RANGE, STEADY_BEARING)[part]] * steady**2
    variance += components[(NEW_RANGE, NEW_BEARING)[part]] * new
    return math.sqrt(float(variance))


def _row(
    last: Sighting, label: str, part: int, residual: float, sigma: float, explained: float, weight: float
) -> AdjustedObservation:
    unit = 1.0 if part == 0 else math.degrees(1.0)
    kind: ObservationKind = "range"
    if part == 1:
        kind = "true_bearing" if last.target.bearing_reference == "true" else "relative_bearing"
    return AdjustedObservation.of_track(
        label,
        last.mark.label,
        kind,
        observed=last.target.range_m if part == 0 else last.target.bearing_deg,
        residual=residual * unit,
        sigma=sigma * unit,
        redundancy_number=min(max(1.0 - weight * explained / sigma**2, 0.0), 1.0),
        weight=weight,
    )
