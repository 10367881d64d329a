"""Constant error of all radar ranges, over minutes: a ring of marks tells it from the position, a sector does not."""

from __future__ import annotations

from dataclasses import replace

from navfix.sequence.common_error import CommonError, CommonErrors
from navfix.types import AdjustedObservation, Epoch, Fix, Mark

SPAN_S = 600.0
LEAST_MARKS = 4
LEAST_SEPARABLE = 0.2  # all marks within 100 deg leave less
NEAREST_M = 1.0


class RangeBias:
    """Estimates what the radar measures too much [m] from the fixes that are fed; says so where it cannot."""

    def __init__(self, *, span_s: float = SPAN_S) -> None:
        self._errors = CommonErrors(_column, span_s=span_s, least_marks=LEAST_MARKS, least_separable=LEAST_SEPARABLE)

    def feed(self, fix: Fix, *, applied_m: float = 0.0) -> None:
        """Take a fix, from whose ranges `with_bias` has taken off ``applied_m``."""
        self._errors.feed(fix, applied=applied_m)

    def estimate(self) -> CommonError | None:
        """Return the bias [m], None before any fix."""
        return self._errors.estimate()

    @property
    def bias_m(self) -> float:
        """The bias to take off [m]: 0 unless it is significant."""
        found = self.estimate()
        return found.value if found is not None and found.significant else 0.0


def with_bias(epoch: Epoch, bias_m: float) -> Epoch:
    """Return an epoch with ``bias_m`` taken off all ranges."""
    if bias_m == 0.0:
        return epoch
    targets = tuple(replace(t, range_m=max(t.range_m - bias_m, NEAREST_M)) for t in epoch.targets)
    return replace(epoch, targets=targets)


def _column(o: AdjustedObservation, mark: Mark, range_m: float, azimuth_rad: float) -> float:
    """Return d observation / d bias."""
    return 1.0 if o.kind == "range" else 0.0
