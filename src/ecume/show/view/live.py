"""The page of a run in progress, from a server on this machine."""

from __future__ import annotations

import contextlib
import json
import secrets
import struct
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ecume.errors import BadInput, StorageError
from ecume.show.serving import HTML, Answer, Query, served
from ecume.show.view.chunks import pack
from ecume.show.view.page import VIEW, page, policy_of, run_header, stage_of
from ecume.show.view.scenery import Stage
from ecume.trajectories.reader import Trajectory, open_trajectory

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
    end_reported: bool = False
    """whether it has heard that the run ended"""
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _trajectory: Trajectory | None = None
    _stage: Stage | None = None

    @property
    def policy(self) -> str:
        """The content security policy of the page."""
        return policy_of(VIEW, live=True)

    def get(self, path: str, query: Query) -> Answer | None:
        """The page, or frames."""
        if path == "/":
            return Answer(self.first_page().encode(), HTML)
        if path == "/frames":
            return Answer(self.frames(_whole(query.get("from", ["0"])[0])), "application/octet-stream")
        return None

    def post(self, path: str, body: bytes) -> Answer | None:
        """Stop the run."""
        if path != "/stop":
            return None
        self.stop()
        return Answer(b"", "text/plain")

    def first_page(self) -> str:
        """The page, without frames yet."""
        self.asked = True
        with self._lock:
            trajectory, stage = self._opened()
            return page(run_header(trajectory, stage, live=True), [], live=True)

    def frames(self, begin: int) -> bytes:
        """The frames since the page's last one: the length of a JSON, the JSON, bytes of the frames."""
        state = self.state()  # asked first: who has heard of the end has all that was written before
        with self._lock:
            trajectory, stage = self._opened()
            count = trajectory.refresh()
            fresh = trajectory[max(begin, 0) : max(begin, 0) + MOST_FRAMES]
            chunk = pack(list(fresh), stage) if len(fresh) else None
        whole = max(begin, 0) + len(fresh) >= count
        self.end_reported = self.end_reported or (state != "running" and whole)
        report = {"state": state if whole else "running", "chunk": None if chunk is None else chunk.header}
        text = json.dumps(report, separators=(",", ":")).encode()
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
            raise BadInput(f"{directory}: no frame within {PATIENCE:g} s; nothing to show")
        time.sleep(EVERY)


def _whole(text: str) -> int:
    return int(text) if text.isdecimal() and len(text) < 10 else 0


@contextlib.contextmanager
def serving(source: Source) -> Iterator[str]:
    """Serve a run while the block lasts; the page's address. At the end the page is given time to hear of it."""
    with served(source) as address:
        try:
            yield address
        finally:
            end = time.monotonic() + FAREWELL
            while source.asked and not source.end_reported and time.monotonic() < end:
                time.sleep(EVERY)
            time.sleep(EVERY)  # the last answer may be on its way
