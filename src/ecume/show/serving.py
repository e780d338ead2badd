"""A server of pages on the local machine, which answers only requests with its token.

Each request must contain the token, which foreign pages do not have. Requests that foreign pages cause have a foreign
origin, or a host name other than the address; both are refused.
"""

from __future__ import annotations

import contextlib
import html
import os
import secrets
import shutil
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, NamedTuple, Protocol, cast
from urllib.parse import SplitResult, parse_qs, urlsplit

from ecume.errors import EcumeError

HOST = "127.0.0.1"
HTML = "text/html; charset=utf-8"
JSON = "application/json"
SILENCE = 30.0
"""Seconds after which a connection without traffic is closed."""
MOST = 100_000
"""The largest number of bytes that a page may send at once."""

Query = Mapping[str, list[str]]


class Answer(NamedTuple):
    """An answer of the server."""

    content: bytes
    kind: str


class Site(Protocol):
    """A site that is served, to trusted requests only."""

    token: str

    @property
    def policy(self) -> str:
        """The content security policy of the pages."""
        ...

    def get(self, path: str, query: Query) -> Answer | None:
        """A page, at `/`, or data; None for unknown paths."""
        ...

    def post(self, path: str, body: bytes) -> Answer | None:
        """Answer a request; None for unknown paths."""
        ...


class _Requests(BaseHTTPRequestHandler):
    """The handler of one request."""

    server_version, sys_version = "ecume", ""
    timeout = SILENCE

    @property
    def site(self) -> Site:
        """The site that is served."""
        return cast(Site, self.server.site)  # type: ignore[attr-defined]

    def do_GET(self) -> None:
        """Answer a request for a page, with the token in its address, or for data, with the token in a header."""
        if (asked := self._asked()) is None:
            return
        query = parse_qs(asked.query)
        token = query.get("token", [""])[0] if asked.path == "/" else self.headers.get("X-Token", "")
        if not self._trusted(token):
            self._answer(None)
            return
        try:
            self._answer(self.site.get(asked.path, query))
        except EcumeError as error:  # damaged files
            self.send_error(503, "the run cannot be read", html.escape(str(error)))

    def do_POST(self) -> None:
        """Answer a request with the token in a header."""
        if (asked := self._asked()) is None:
            return
        length = self.headers.get("Content-Length", "0")
        size = int(length) if length.isdecimal() and len(length) < 10 else MOST + 1
        if size > MOST or not self._trusted(self.headers.get("X-Token", "")):
            self._answer(None)
            return
        self._answer(self.site.post(asked.path, self.rfile.read(size)))

    def _asked(self) -> SplitResult | None:
        """The requested address; None if it is malformed, after the answer was sent."""
        try:
            return urlsplit(self.path)
        except ValueError:
            self.send_error(400, "no such address")
            return None

    def _trusted(self, token: str) -> bool:
        """Whether a request comes from a page of this server, by its address, origin and token."""
        host, port = cast("tuple[str, int]", self.server.server_address)
        ours = f"{host}:{port}"
        origin = self.headers.get("Origin", f"http://{ours}")
        known = secrets.compare_digest(token.encode(), self.site.token.encode())
        return known and self.headers.get("Host") == ours and origin == f"http://{ours}"

    def _answer(self, answer: Answer | None) -> None:
        if answer is None:
            self.send_error(403, "not for you")
            return
        self.send_response(200)
        headers = {
            "Content-Type": answer.kind,
            "Content-Length": str(len(answer.content)),
            "Content-Security-Policy": self.site.policy,
            "X-Content-Type-Options": "nosniff",
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
        }
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        with contextlib.suppress(ConnectionError):  # the page was closed meanwhile
            self.wfile.write(answer.content)

    def log_message(self, *_: Any) -> None:
        """Ignore log messages, since the terminal belongs to the run."""


class _Server(ThreadingHTTPServer):
    """A server with a thread for each connection."""

    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report exceptions, except those of broken connections."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


@contextlib.contextmanager
def redirect_file(address: str) -> Iterator[str]:
    """A context with the address of a file that redirects a browser to `address`.

    The address with which a browser is started is an argument that all users of the machine can read. The file is
    readable only for its owner, so that the token in the address remains private. The file is removed when the block
    ends.
    """
    folder = Path(tempfile.mkdtemp(prefix="ecume-"))  # mode 0700
    file = folder / "open.html"
    try:
        target = html.escape(address)
        with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as page:
            page.write(
                f'<!doctype html><meta http-equiv="refresh" content="0; url={target}"><a href="{target}">ecume</a>'
            )
        yield file.as_uri()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def served(site: Site) -> Iterator[str]:
    """Run the server while the block lasts; yield the address of the page."""
    server = _Server((HOST, 0), _Requests)
    server.site = site  # type: ignore[attr-defined]
    # Time limit of the shutdown of the server.
    threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
    try:
        yield f"http://{HOST}:{server.server_address[1]}/?token={site.token}"
    finally:
        server.shutdown()
        server.server_close()
