"""What is wrong with the radar as a whole, estimated over minutes and taken off: its clock and its ranges."""

from __future__ import annotations

from navfix.sequence.clock import ClockOffset, with_offset
from navfix.sequence.common_error import CommonError
from navfix.sequence.range_bias import RangeBias, with_bias
from navfix.types import Epoch, Fix


class RadarErrors:
    """Estimates clock offset and range bias from fixes as they come, and corrects epochs by what is significant.

    Correct an epoch, fix it, feed the fix: what was taken off is added again, so the estimate stays that of the whole.
    """

    def __init__(self) -> None:
        self.clock, self.ranges = ClockOffset(), RangeBias()
        self._offset_s = self._bias_m = 0.0

    def corrected(self, epoch: Epoch) -> Epoch:
        """Return the epoch without the errors that are told from zero; the same epoch where there is none."""
        self._offset_s, self._bias_m = self.clock.offset_s, self.ranges.bias_m
        return with_bias(with_offset(epoch, self._offset_s), self._bias_m)

    def feed(self, fix: Fix) -> None:
        """Take the fix of the epoch that was corrected last."""
        self.clock.feed(fix, applied_s=self._offset_s)
        self.ranges.feed(fix, applied_m=self._bias_m)

    def notes(self) -> tuple[str, ...]:
        """Return a sentence for each estimate: value, sigma, whether it is applied, and why not."""
        return (
            _note("radar clock minus AIS", "s", self.clock.estimate(), self.clock.offset_s != 0.0),
            _note("range bias", "m", self.ranges.estimate(), self.ranges.bias_m != 0.0),
        )


def _note(name: str, unit: str, found: CommonError | None, applied: bool) -> str:
    if found is None:
        return f"{name}: no fix yet"
    stands = f"{found.marks} marks in {found.fixes} fixes"
    if found.sigma == float("inf"):
        return f"{name}: not observable ({found.reason}; {stands})"
    end = "applied" if applied else f"not applied: {found.reason or 'too large to be one'}"
    return f"{name}: {found.value:+.1f} {unit}, sigma {found.sigma:.1f} {unit} ({stands}), {end}"
