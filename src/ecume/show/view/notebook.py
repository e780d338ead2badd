"""The player in a notebook: what `_repr_html_` of frames, trajectories and runs returns."""

from __future__ import annotations

import html
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.errors import BadInput, StorageError
from ecume.show.picture import Species
from ecume.show.style import PALETTE
from ecume.show.view.chunks import pack
from ecume.show.view.page import MEGABYTE, looks, page, run_header, spacing, stage_of
from ecume.show.view.scenery import Stage
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory

if TYPE_CHECKING:
    pass

MOST = 4.0
"""MB that a cell's output may take by default: notebooks are kept with what they showed."""
HEIGHT = 560
"""Of the player, pixels."""
EDGE = 0.05
"""Room around a frame's particles, over their extent."""


def player(trajectory: Trajectory, max_size: float = MOST) -> str:
    """The page of a run as a piece of HTML of at most so many MB: it is a separate document, with scripts, without
    the notebook's origin and without network. Where not all frames fit, each second, third ... is shown.
    """
    if not len(trajectory):
        raise BadInput(f"{trajectory.directory}: the run has no frames yet; nothing to show")
    stage = stage_of(trajectory)
    header = run_header(trajectory, stage)
    every = spacing(trajectory, stage, len(_framed(page(header, [])).encode()), max_size)
    while True:
        text = _framed(page(header, [pack(list(trajectory[::every]), stage)]))
        if len(text.encode()) <= MEGABYTE * max_size or every > len(trajectory):
            return text
        every += 1


def still(frame: Frame) -> str:
    """One frame as a piece of HTML. It knows its particles and numbers, and nothing of walls, which a scene knows."""
    stage = bare_stage(frame)
    facts = {"title": f"at {frame.time:.6g} s", "model": "", "facts": [], "papers": [], "scene": "", "live": False}
    # One instant is no curve.
    header: dict[str, Any] = {**facts, **looks(frame, frame, stage), "shown": ()}
    return _framed(page(header, [pack([frame], stage)]))


def bare_stage(frame: Frame) -> Stage:
    """Particles, and nothing around them."""
    position = frame.arrays["position"]
    if not len(position):
        raise BadInput("the frame has no particles; nothing to show")
    reach = float(np.max(frame.arrays.get("radius", np.zeros(1))))
    low, high = position.min(axis=0) - reach, position.max(axis=0) + reach
    edge = EDGE * float(np.max(high - low)) or 1.0
    count = int(frame.arrays["species"].max()) + 1 if "species" in frame.arrays else 1
    kinds = [Species(f"species {number + 1}", PALETTE[number % len(PALETTE)]) for number in range(count)]
    return Stage(low - edge, high + edge, kinds, radius=edge / 5)


def shown(what: Any) -> str | None:
    """The notebook view of a frame, a trajectory or the directory of a run; None where nothing can be shown."""
    try:
        if isinstance(what, Frame):
            return still(what)
        if isinstance(what, Trajectory):
            return player(what)
        with Trajectory(Path(what) / "traj") as trajectory:
            return player(trajectory)
    except (BadInput, StorageError):  # then the notebook prints the object as text
        return None


def _framed(text: str) -> str:
    return (
        f'<iframe title="ecume" sandbox="allow-scripts" srcdoc="{html.escape(text)}" '
        f'style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'
    )
