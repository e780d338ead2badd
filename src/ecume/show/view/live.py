"""The page of a run in progress: a server on this machine alone, for who has the address with its token.

Everything asked needs the token; a page of somebody else's has none, and what it makes a browser ask comes with its own
origin, or under a name of ours that is not the address: both are refused.
"""

from __future__ import annotations

import contextlib
import json
import secrets
import struct
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, cast
from urllib.parse import parse_qs, urlsplit

from ecume.errors import BadInput, StorageError
from ecume.show.view.chunks import pack
from ecume.show.view.page import page, policy_of, run_header, stage_of
from ecume.show.view.staging import Stage
from ecume.trajectories.reader import Trajectory, open_trajectory

HOST = "127.0.0.1"
MOST_FRAMES = 50
"""In one answer."""
PATIENCE = 30.0
"""Seconds for which a run may have no frame."""
EVERY = 0.1
"""Seconds between two looks whether there is one."""
FAREWELL = 3.0
"""Seconds for which the server stays when the run has ended, so that the page hears of it."""


@dataclass
class Source:
    """A run, as the server reads it. Requests come in threads of their own; the files are one's at a time."""

    directory: Path
    state: Callable[[], str]
    """`running`, or how the run ended"""
    stop: Callable[[], None]
    """ask the run to end with a checkpoint"""
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    asked: bool = False
    """whether a page has been given out"""
    told: bool = False
    """whether it has heard that the run ended"""
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _trajectory: Trajectory | None = None
    _stage: Stage | None = None

    def first_page(self) -> str:
        """The page, without frames yet."""
        self.asked = True
        with self._lock:
            trajectory, stage = self._opened()
            return page(run_header(trajectory, stage, live=True), [], live=True)

    def frames(self, begin: int) -> bytes:
        """What came since the page's last frame: the length of a JSON, the JSON, bytes of the frames."""
        state = self.state()  # asked first: who has heard of the end has all that was written before
        with self._lock:
            trajectory, stage = self._opened()
            count = trajectory.refresh()
            fresh = trajectory[max(begin, 0) : max(begin, 0) + MOST_FRAMES]
            chunk = pack(list(fresh), stage) if len(fresh) else None
        whole = max(begin, 0) + len(fresh) >= count
        self.told = self.told or (state != "running" and whole)
        told = {"state": state if whole else "running", "chunk": None if chunk is None else chunk.header}
        text = json.dumps(told, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        return struct.pack("<I", len(text)) + text + (b"" if chunk is None else chunk.blob)

    def _opened(self) -> tuple[Trajectory, Stage]:
        if self._trajectory is None or self._stage is None:
            self._trajectory = awaited(self.directory)
            self._stage = stage_of(self._trajectory)
        return self._trajectory, self._stage


def awaited(directory: Path) -> Trajectory:
    """The trajectory of a run that may just have begun."""
    end = time.monotonic() + PATIENCE
    while True:
        with contextlib.suppress(BadInput, StorageError):
            trajectory = open_trajectory(directory)
            if len(trajectory):
                return trajectory
            trajectory.close()
        if time.monotonic() > end:
            raise BadInput(f"{directory}: no frame came in {PATIENCE:g} s; there is nothing to show")
        time.sleep(EVERY)


class _Answers(BaseHTTPRequestHandler):
    """One request."""

    server_version, sys_version = "ecume", ""

    @property
    def source(self) -> Source:
        """The run."""
        return cast(Source, self.server.source)  # type: ignore[attr-defined]

    def do_GET(self) -> None:
        """The page, or frames."""
        asked = urlsplit(self.path)
        query = parse_qs(asked.query)
        if asked.path == "/" and self._trusted(query.get("token", [""])[0]):
            self._answer(self.source.first_page().encode(), "text/html; charset=utf-8")
        elif asked.path == "/frames" and self._trusted(self.headers.get("X-Token", "")):
            self._answer(self.source.frames(_whole(query.get("from", ["0"])[0])), "application/octet-stream")
        else:
            self._refuse()

    def do_POST(self) -> None:
        """Stop the run."""
        if urlsplit(self.path).path == "/stop" and self._trusted(self.headers.get("X-Token", "")):
            self.source.stop()
            self._answer(b"", "text/plain")
        else:
            self._refuse()

    def _trusted(self, token: str) -> bool:
        """Whether it comes from the page that we gave out: by its address, its origin, and the token."""
        host, port = cast("tuple[str, int]", self.server.server_address)
        ours = f"{host}:{port}"
        origin = self.headers.get("Origin", f"http://{ours}")
        known = secrets.compare_digest(token.encode(), self.source.token.encode())
        return known and self.headers.get("Host") == ours and origin == f"http://{ours}"

    def _answer(self, content: bytes, kind: str) -> None:
        self.send_response(200)
        headers = {
            "Content-Type": kind,
            "Content-Length": str(len(content)),
            "Content-Security-Policy": policy_of(live=True),
            "X-Content-Type-Options": "nosniff",
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
        }
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        with contextlib.suppress(ConnectionError):  # the page was closed meanwhile
            self.wfile.write(content)

    def _refuse(self) -> None:
        self.send_error(403, "not for you")

    def log_message(self, *_: Any) -> None:
        """Say nothing: the terminal belongs to the run."""


def _whole(text: str) -> int:
    return int(text) if text.isdecimal() and len(text) < 10 else 0


@contextlib.contextmanager
def serving(source: Source) -> Iterator[str]:
    """Serve a run while the block lasts; the page's address. At the end the page is given time to hear of it."""
    server = ThreadingHTTPServer((HOST, 0), _Answers)
    server.daemon_threads = True
    server.source = source  # type: ignore[attr-defined]
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://{HOST}:{server.server_address[1]}/?token={source.token}"
    finally:
        end = time.monotonic() + FAREWELL
        while source.asked and not source.told and time.monotonic() < end:
            time.sleep(EVERY)
        time.sleep(EVERY)  # the last answer may be on its way
        server.shutdown()
        server.server_close()
