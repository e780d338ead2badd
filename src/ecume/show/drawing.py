"""Pictures of a run drawn by several processes: each reads the run for itself, and all draw the same pictures."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.show.picture import Pixels

if TYPE_CHECKING:
    from ecume.show.movies import Cut

AHEAD = 3
"""Pictures of each process that may wait to be taken: more would fill the memory."""

desk: dict[str, Any] = {}
"""What a process draws with."""


def drawn_by_many(directory: Path, cut: Cut, target: Path, workers: int) -> Iterator[Pixels]:
    """The pictures of a run, one after the other."""
    with ProcessPoolExecutor(
        workers, mp_context=get_context("spawn"), initializer=_set_up, initargs=(directory, cut, target)
    ) as pool:
        waiting: deque[Future[Any]] = deque()
        coming = iter(itertools.count())
        for number in itertools.islice(coming, AHEAD * workers):
            waiting.append(pool.submit(_draw, number))
        while (picture := waiting.popleft().result()) is not None:
            waiting.append(pool.submit(_draw, next(coming)))
            yield picture


def _set_up(directory: Path, cut: Cut, target: Path) -> None:
    from ecume._jit import use_threads
    from ecume.show.movies import picture_of
    from ecume.trajectories.reader import open_trajectory

    use_threads(1)
    trajectory = open_trajectory(directory)
    shown = cut.shown(trajectory)
    desk.update(shown=shown, picture=picture_of(trajectory.scene, shown, cut, target))


def _draw(number: int) -> Any:
    """The picture of that number; None where there is none any more."""
    if number >= len(desk["shown"]):
        return None
    return np.ascontiguousarray(desk["picture"].pixels(desk["shown"][number])[..., :3])
