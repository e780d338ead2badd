"""Additions to the built pages for screen readers and keyboards, which the theme lacks."""

from __future__ import annotations

import re
from pathlib import Path

CAPTION = re.compile(r'(role="heading")(?! aria-level)')
CODE = re.compile(r"<pre>")
"""Blocks of code scroll sideways, and without a place in the order of the tab key no keyboard moves them."""
SCROLLS = re.compile(r'<div class="(table-wrapper[^"]*|formula)"(?! tabindex)')
DRAWER = re.compile(r'<aside class="(toc-drawer[^"]*)"(?! aria-label)')
SIDEBAR = re.compile(r'<aside class="(sidebar-drawer[^"]*)"(?! aria-label)')


def completed(page: str) -> str:
    """A page whose headings have a level, whose blocks of code can be focused, and whose landmarks have names."""
    page = CAPTION.sub(r'\1 aria-level="2"', page)
    page = CODE.sub('<pre tabindex="0">', page)
    page = SCROLLS.sub(r'<div class="\1" tabindex="0" role="group"', page)
    page = DRAWER.sub(r'<aside class="\1" aria-label="contents of this page"', page)
    return SIDEBAR.sub(r'<aside class="\1" aria-label="pages"', page)


def complete(folder: Path) -> None:
    """Complete all pages of the site."""
    for path in folder.rglob("*.html"):
        if "_players" not in path.parts:
            path.write_text(completed(path.read_text(encoding="utf-8")), encoding="utf-8")
