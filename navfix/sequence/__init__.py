"""Over time: the bank of hypotheses, the navigator that holds a place, and what guards it."""

from __future__ import annotations
