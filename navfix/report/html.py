"""The report as one self-contained page: the picture and the text, no script, nothing to load."""

from __future__ import annotations

from html import escape

from navfix.report import words
from navfix.report.answer import Answer
from navfix.report.svg import svg_text
from navfix.report.text import report_text

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ margin: 1rem; color: #1d2733; background: #ffffff; font-family: sans-serif; }}
main {{ display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start; }}
svg {{ width: 100%; max-width: 1000px; height: auto; border: 1px solid #b9c6d2; }}
pre {{ margin: 0; overflow-x: auto; font-size: 13px; line-height: 1.35; font-family: monospace; }}
@media (prefers-color-scheme: dark) {{ body {{ color: #d5c3b0; background: #0d1117; }} }}
</style>
</head>
<body>
<main>
<pre>{report}</pre>
{picture}</main>
</body>
</html>
"""


def html_text(answer: Answer) -> str:
    """Return the page of an answer."""
    verdict = "no fix" if answer.fix is None else "fix"
    title = f"navfix: {verdict}, {words.utc(answer.time_utc)}"
    return _PAGE.format(title=escape(title), report=escape(report_text(answer)), picture=svg_text(answer))
