"""Hook of the documentation site: equations become MathML, so that pages need no script and no network."""

from __future__ import annotations

import re
from html import unescape

from latex2mathml.converter import convert

_BLOCK = re.compile(r'<div class="arithmatex">\\\[(.*?)\\\]</div>', re.DOTALL)
_INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)


def on_page_content(html: str, **_: object) -> str:
    """Replace each equation of a rendered page."""
    html = _BLOCK.sub(lambda match: convert(unescape(match[1]).strip(), display="block"), html)
    return _INLINE.sub(lambda match: convert(unescape(match[1]).strip()), html)
