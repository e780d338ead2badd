"""What esbuild made of `web/`, and how a page is put together from it."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from importlib import resources
from typing import Any, NamedTuple


class Parts(NamedTuple):
    """The files of a page."""

    page: str
    style: str
    script: str


VIEW = Parts("page.html", "view.css", "view.js")
PLAY = Parts("play.html", "play.css", "play.js")
TANK = Parts("tank.html", "play.css", "tank.js")


def filled(parts: Parts, title: str, data: str, *, live: bool) -> str:
    """The page as text: its script, its style and its data inside. `live` pages may ask the server they came from."""
    marks = {
        "@POLICY@": policy_of(parts, live=live),
        "@TITLE@": html.escape(title),
        "@STYLE@": _bundled(parts.style),
        "@SCRIPT@": _bundled(parts.script),
        "@DATA@": data,
    }
    text = _bundled(parts.page)
    # Split and joined, not replaced one after the other: what stands in a scene is never taken for a mark of ours.
    for mark in marks:
        text = text.replace(mark, f"\0{mark}\0")
    return "".join(marks.get(piece, piece) for piece in text.split("\0"))


def policy_of(parts: Parts, *, live: bool) -> str:
    """What the browser may do with the page: run its script, use its style, and ask nobody but a server of ours."""
    script, style = (_hash(_bundled(name)) for name in (parts.script, parts.style))
    connect = "'self'" if live else "'none'"
    return (
        f"default-src 'none'; script-src {script}; style-src {style}; img-src data: blob:; connect-src {connect}; "
        "base-uri 'none'; form-action 'none'"
    )


def json_of(value: Any) -> str:
    """JSON that no title can leave: what HTML could read is written as its number."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def data_of(name: str, kind: str, text: str) -> str:
    """Something for the page's script to read."""
    return f'<script type="{kind}" id="{name}">{text}</script>'


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _bundled(name: str) -> str:
    return resources.files("ecume.show.view").joinpath("bundle", name).read_text(encoding="utf-8")
