"""The time that an answer took, step by step."""

from __future__ import annotations

import time


class StepClock:
    """Milliseconds by step, from the making of this object on; ``epoch_ms`` is what the epoch took before it."""

    def __init__(self, epoch_ms: float | None) -> None:
        self.laps_ms: dict[str, float] = {} if epoch_ms is None else {"epoch": epoch_ms}
        self._began = time.perf_counter()

    def lap(self, step: str) -> None:
        """End a step: its time is what passed since the last one."""
        now = time.perf_counter()
        self.laps_ms[step] = round(1e3 * (now - self._began), 3)
        self._began = now
