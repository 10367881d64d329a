"""Constant error of all radar ranges: a ring of marks tells it from the position, a sector does not."""

from __future__ import annotations

from dataclasses import replace

from navfix.types import AdjustedObservation, Epoch, Mark

NEAREST_M = 1.0


def with_bias(epoch: Epoch, bias_m: float) -> Epoch:
    """Return an epoch with ``bias_m`` taken off all ranges."""
    if bias_m == 0.0:
        return epoch
    targets = tuple(replace(t, range_m=max(t.range_m - bias_m, NEAREST_M)) for t in epoch.targets)
    return replace(epoch, targets=targets)


def column(o: AdjustedObservation, mark: Mark, range_m: float, azimuth_rad: float) -> float:
    """Return d observation / d bias."""
    return 1.0 if o.kind == "range" else 0.0
