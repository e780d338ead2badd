"""The toy model, for all tests of runs."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import toy

from ecume.models import MODELS
from ecume.run import RunDirectory, checkpoints
from ecume.scenes.schema import SCENES


@pytest.fixture(autouse=True)
def _toy_among_the_models(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SCENES, "toy", toy.ToyScene)  # first: SCENES also finds the scenes of models
    monkeypatch.setitem(MODELS, "toy", toy.model())


@pytest.fixture
def scene() -> Callable[..., toy.ToyScene]:
    """Makes toy scenes: 50 frames of ten steps, by default."""
    return lambda **changes: toy.ToyScene(**{"duration": 0.5, "frame_every": 0.01, "seed": 7, **changes})


@pytest.fixture
def server() -> Iterator[Callable[..., Served]]:
    """Starts the toy in processes that begin at once, one after the other."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, toy.__file__, "serve"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment) as one:
        yield lambda *words: Served(one, [json.dumps(word) if isinstance(word, dict) else str(word) for word in words])
        one.communicate()


class Served:
    """A process of the server."""

    def __init__(self, server: subprocess.Popen[str], words: list[str]) -> None:
        assert server.stdin is not None
        self._server = server
        server.stdin.write(json.dumps(words) + "\n")
        server.stdin.flush()
        self.pid = self._answer()

    def end(self) -> int:
        """Wait for it; its exit code, or minus the signal that killed it."""
        return self._answer()

    def _answer(self) -> int:
        assert self._server.stdout is not None
        return int(self._server.stdout.readline())


def _results(directory: Path) -> dict[str, bytes]:
    home = RunDirectory(directory)
    files = [*home.trajectory.glob("*"), home.scalars, home.resolved, checkpoints.newest_first(home)[0]]
    return {path.name: path.read_bytes() for path in files}


@pytest.fixture
def results() -> Callable[[Path], dict[str, bytes]]:
    """All bytes of a run's results: frames, numbers, the resolved scene, the last state."""
    return _results
