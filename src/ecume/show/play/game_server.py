"""The server of a game: its requests and answers, and the clock that drives the simulation."""

from __future__ import annotations

import json
import secrets
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

from ecume.errors import BadInput
from ecume.scenes.writing import to_toml
from ecume.show.serving import HTML, JSON, Answer, Query
from ecume.show.view.page import Parts, data_of, filled, json_of, policy_of

TICK = 1.0 / 60.0
"""Seconds between two looks at the clock, where there is time."""
BREATH = 0.002
"""Seconds between two checks for requests if none is waiting."""
STEADY = 0.1
"""The weight of the last tick in the displayed rate: single ticks are sometimes late."""
SPEEDS = (0.0, 0.25, 1.0, 4.0)
"""Of the toy's time over the clock's."""

Asked = Mapping[str, Any]
Deed = Callable[[Asked], None]


class Moving(Protocol):
    """A simulation that a user plays with."""

    time: float
    """s, simulated so far"""

    def play(self, seconds: float) -> None:
        """Go on by so much simulated time, or as far as there is time for."""

    def present(self) -> Any:
        """The scene as it stands."""
        ...


class Toy(Protocol):
    """A simulation together with its page: what it draws, and what can be done."""

    @property
    def parts(self) -> Parts:
        """The page's files."""
        ...

    @property
    def deeds(self) -> Mapping[str, Deed]:
        """The actions by name; they raise BadInput for what is impossible."""
        ...

    @property
    def moving(self) -> Moving:
        """The simulation."""
        ...

    def header(self) -> dict[str, Any]:
        """The data that the page gets once, with a `title`."""
        ...

    def now(self) -> dict[str, Any]:
        """The data that the page draws, requested repeatedly."""
        ...

    def paint(self, now: float) -> None:
        """Update what is drawn less often than the page asks; `now` is the clock's time."""


class Game:
    """A game and its viewers. Each request has its thread; a lock gives access to one at a time."""

    def __init__(self, toy: Toy) -> None:
        self.token = secrets.token_urlsafe(24)
        self.toy, self.speed, self.pace = toy, 1.0, 1.0
        self.lock, self.over = threading.Lock(), threading.Event()

    @property
    def policy(self) -> str:
        """The content security policy of the page."""
        return policy_of(self.toy.parts, live=True)

    def get(self, path: str, query: Query) -> Answer | None:
        """The page, how all stands now, or the scene of it."""
        with self.lock:
            if path == "/":
                return Answer(self._page().encode(), HTML)
            if path == "/now":
                return Answer(json.dumps(self.now(), separators=(",", ":")).encode(), JSON)
            if path == "/scene":
                return Answer(to_toml(self.toy.moving.present()).encode(), "text/plain; charset=utf-8")
        return None

    def post(self, path: str, body: bytes) -> Answer | None:
        """Do something. What cannot be done is answered with why."""
        if path != "/do":
            return None
        with self.lock:
            try:
                self._do(json.loads(body))
                said = ""
            except BadInput as refusal:
                said = str(refusal)
            except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as fault:
                said = f"unknown action ({fault})"
        return Answer(json.dumps({"said": said}).encode(), JSON)

    def run(self) -> None:
        """Let the toy go by the clock until the game is over."""
        last = time.monotonic()
        while not self.over.wait(max(BREATH, TICK - (time.monotonic() - last))):
            now = time.monotonic()
            with self.lock:
                if self.speed > 0.0:
                    self._tick(self.speed * (now - last))
                self.toy.paint(now)
            last = now

    def _tick(self, seconds: float) -> None:
        moving, before = self.toy.moving, self.toy.moving.time
        moving.play(seconds)
        self.pace += STEADY * ((moving.time - before) / seconds - self.pace)

    def now(self) -> dict[str, Any]:
        """The data that the page draws, requested repeatedly."""
        return {"time": self.toy.moving.time, "speed": self.speed, "pace": self.pace, **self.toy.now()}

    def _page(self) -> str:
        header = {"speeds": SPEEDS, **self.toy.header()}
        return filled(self.toy.parts, str(header["title"]), data_of("toy", JSON, json_of(header)), live=True)

    def _do(self, asked: dict[str, Any]) -> None:
        what = asked["what"]
        if what == "speed":
            self.speed = min(SPEEDS, key=lambda speed: abs(speed - number(asked["value"])))
        elif what in self.toy.deeds:
            self.toy.deeds[what](asked)
        else:
            raise BadInput(f"there is no {what!r} to do")


def number(value: Any) -> float:
    """A number from a page. Raises BadInput for NaN and infinity."""
    found = float(value)
    if not np.isfinite(found):
        raise BadInput("got NaN or infinity; expected a finite number")
    return found
