"""Reports: pure functions from the answer of one epoch to text; nothing here prints or opens files."""

from navfix.report.answer import Answer, Truth

__all__ = ["Answer", "Truth"]
