"""What is wrong with the radar as a whole, estimated over minutes and taken off: its clock and its ranges together.

Single scans have both taken off. A window of scans and the navigator estimate the clock in every window anew, with what
is known of it beforehand: there only the ranges are corrected, and the clock is told but left to them, or it would be
taken off twice.
"""

from __future__ import annotations

import math
from dataclasses import replace

from navfix.adjustment.visible_side import adjust_visible_side
from navfix.catalog import RadarErrorsModel, RadarModel, radar_errors_model
from navfix.errors import NoFix
from navfix.kernels import Kernel
from navfix.sequence import clock, range_bias
from navfix.sequence.common_doubt import with_common_doubt
from navfix.sequence.common_error import CommonErrors, Wanted
from navfix.types import Association, CommonError, Epoch, Fix, Position, RadarErrors


class RadarErrorsOverTime:
    """Estimates clock offset and range bias from fixes as they come, and corrects epochs by what is significant.

    Correct an epoch, fix it, feed the fix: what was taken off is added again, so the estimate stays that of the whole.
    `doubted` gives the fix the doubt about what was taken off.

    Parameters
    ----------
    model : constants, by name or record
    windows : whether the fixes are those of windows, which estimate the clock themselves: then it is not taken off, and
        of each fix the newest scan is adjusted by itself, so that what the window found is not in its residuals
    correct : False only estimates
    radar, kernel : of the adjustment of single scans, where a fix is not one of a single scan
    """

    def __init__(
        self,
        *,
        model: RadarErrorsModel | str = "default",
        windows: bool = False,
        correct: bool = True,
        radar: RadarModel | str = "imo",
        kernel: Kernel | str = "hampel",
    ) -> None:
        self._model = m = radar_errors_model(model)
        self._windows, self._correct = windows, correct
        self._radar, self._kernel = radar, kernel
        of_clock = Wanted(
            clock.column, m.clock_sigma_s, m.clock_walk, m.clock_common_s, m.least_ships, m.least_clock_share,
            "too few ships move",
        )  # fmt: skip
        of_ranges = Wanted(
            range_bias.column, m.range_sigma_m, m.range_walk, m.range_common_m, m.least_marks, m.least_range_share,
            "too few marks",
        )  # fmt: skip
        self._errors = CommonErrors((of_clock, of_ranges), memory_s=m.memory_s, probability=m.probability)
        self._offset_s = self._bias_m = 0.0
        self._doubts = (0.0, 0.0)
        self._stamp_s = math.nan

    def corrected(self, epoch: Epoch) -> Epoch:
        """Return the epoch without the errors that are told from zero; the same epoch where there is none."""
        if not self._correct:
            return epoch
        found = self.estimate()
        self._bias_m = _to_apply(found.ranges, self._model.largest_m)
        if not self._windows:
            self._offset_s = self._slewed(epoch, _to_apply(found.clock, self._model.largest_s))
            self._doubts = _doubt(found.clock, self._offset_s), _doubt(found.ranges, self._bias_m)
        return range_bias.with_bias(clock.with_offset(epoch, self._offset_s, self._model), self._bias_m)

    def feed(self, fix: Fix | None) -> None:
        """Take the fix of the epoch that was corrected last, if there is one."""
        single = self._of_newest_scan(fix) if self._windows and fix is not None else fix
        if single is not None:
            self._errors.feed(single, applied=(self._offset_s, self._bias_m))

    def doubted(self, fix: Fix) -> Fix:
        """Return the fix of the epoch that was corrected last with the sigma of what was taken off in its covariance.

        The fix of a window is returned as it is: its adjustment has both errors among its unknowns.
        """
        return with_common_doubt(fix, (clock.column, range_bias.column), self._doubts)

    def estimate(self) -> RadarErrors:
        """Return both errors, with what is taken off now."""
        found = self._errors.estimate()
        return RadarErrors(replace(found[0], applied=self._offset_s), replace(found[1], applied=self._bias_m))

    def _slewed(self, epoch: Epoch, offset_s: float) -> float:
        """Return an offset that is no farther from the last than time has gone on: time must not run backward."""
        stamp_s = math.nan if epoch.time_utc is None else epoch.time_utc.timestamp()
        last_s, self._stamp_s = self._stamp_s, stamp_s
        most_s = self._model.clock_slew * (stamp_s - last_s)
        if not most_s >= 0.0:
            return self._offset_s
        return self._offset_s + min(max(offset_s - self._offset_s, -most_s), most_s)

    def _of_newest_scan(self, fix: Fix) -> Fix | None:
        pairs = None if fix.association is None else fix.association.pairs
        if fix.epoch is None or pairs is None or len(pairs) < 3 or not isinstance(fix.position, Position):
            return None
        seen_from = replace(
            Association.from_pairs(fix.epoch, pairs.tolist()), position=fix.position, heading_deg=fix.heading_deg
        )
        try:
            return adjust_visible_side(fix.epoch, seen_from, radar=self._radar, kernel=self._kernel)
        except NoFix:
            return None


def _to_apply(found: CommonError, largest: float) -> float:
    """Return an error where it is told from zero and possible, else 0."""
    return found.value if found.significant and abs(found.value) <= largest else 0.0


def _doubt(found: CommonError, applied: float) -> float:
    """Return 1 sigma of what is left of an error: its own, and what is not yet taken off; 0 where nothing is."""
    return math.hypot(found.sigma, found.value - applied) if applied != 0.0 else 0.0
