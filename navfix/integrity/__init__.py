"""Integrity: what can be promised about a fix, and what it says about the GNSS and the AIS."""

from __future__ import annotations

from navfix.integrity.gnss import gnss_verdict
from navfix.integrity.protection import with_integrity

__all__ = ["gnss_verdict", "with_integrity"]
