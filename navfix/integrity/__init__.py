"""Integrity: what can be promised about a fix, and what it says about the GNSS and the AIS."""

from __future__ import annotations

from navfix.integrity.gnss import gnss_verdict
from navfix.integrity.monitor import GnssMonitor
from navfix.integrity.protection import with_integrity
from navfix.integrity.veracity import AisVeracity
from navfix.integrity.window import with_window_integrity

__all__ = ["AisVeracity", "GnssMonitor", "gnss_verdict", "with_integrity", "with_window_integrity"]
