"""The errors of many answers against a known track, in one line: median, 95 %, worst, and whether the ellipses hold."""

from __future__ import annotations

import numpy as np

from navfix.report.answer import Truth


class ErrorSummary:
    """Collects the truths beside answers as they come; 8 bytes a fix are kept."""

    def __init__(self) -> None:
        self._errors_m: list[float] = []
        self._inside = 0
        self._known = 0

    def feed(self, truth: Truth | None) -> None:
        """Take the truth beside the next answer, None where the track tells nothing of its time."""
        self._known += truth is not None
        if truth is not None and truth.error_m is not None:
            self._errors_m.append(truth.error_m)
            self._inside += bool(truth.in_ellipse)

    def words(self) -> str:
        """Return how many answers have a truth beside them, and the errors [m] of the fixes among them."""
        known = f"{self._known} of them with a truth"
        if not self._errors_m:
            return known
        median_m, most_m = np.percentile(self._errors_m, (50.0, 95.0))
        share = 100.0 * self._inside / len(self._errors_m)
        worst_m = max(self._errors_m)
        return (
            f"{known}: off {median_m:.0f} m in the median, {most_m:.0f} m at 95 %, {worst_m:.0f} m at worst; "
            f"{share:.0f} % inside the 95 % ellipse"
        )
