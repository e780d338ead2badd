"""Formulas as MathML, which browsers draw without a script."""

from __future__ import annotations

import html
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.util import logging

log = logging.getLogger(__name__)


def formula(text: str, display: str, node: nodes.Node) -> str:
    """The MathML of a formula. What cannot be read is a warning, and with that an error."""
    try:
        return str(convert(text, display=display))
    except Exception as fault:  # whatever the converter stumbled over
        log.warning("formula cannot be read: %s (%s)", text, fault, location=node)
        return f"<code>{html.escape(text)}</code>"


def inline(self: Any, node: nodes.math) -> None:
    """A formula in a line."""
    self.body.append(formula(node.astext(), "inline", node))
    raise nodes.SkipNode


def display(self: Any, node: nodes.math_block) -> None:
    """A formula of its own."""
    self.body.append(f'<div class="formula">{formula(node.astext(), "block", node)}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
