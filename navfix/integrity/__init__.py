"""Integrity: what the fix says about the GNSS that it did not use."""

from __future__ import annotations

from navfix.integrity.gnss import gnss_verdict

__all__ = ["gnss_verdict"]
