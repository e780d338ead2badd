"""Runs imported from trajectories of other programs: positions and velocities are read, all other quantities are
computed.
"""

from __future__ import annotations

import dataclasses
import os
import shutil
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ecume.analysis.boxes import Box, nearest
from ecume.analysis.series import warn_of_far_moves
from ecume.engine.cells import into_box, periods_of
from ecume.errors import BadInput, SceneError, Stopped
from ecume.models import MODELS
from ecume.models.model import DONE, EXCHANGE, Engine, Model
from ecume.run.directory import RunDirectory, refuse_existing
from ecume.run.lock import put_in_place
from ecume.run.progress import Progress
from ecume.run.runner import RunOptions, RunResult, run
from ecume.scenes.load import Source, assembled, parsed, placed, source_of
from ecume.scenes.overrides import overridden
from ecume.scenes.schema import Scene
from ecume.scenes.starts import RUN, all_frames
from ecume.trajectories.foreign.particles import Particles
from ecume.trajectories.foreign.series import Series
from ecume.trajectories.records import partial_of, storing
from ecume.units import Array

MODELS_OF_PARTICLES = {
    "floating": "",
    "tracers": "",
    "sph": "the pressure of a tank follows from densities, which such files do not contain in our definition",
    "soft": "the forces of soft spheres follow from the history of their deflections, which such files do not contain",
}
"""For each model, the reason why its frames do not follow from positions and velocities; empty if they do."""
SAME = 1e-9
"""The largest distance of a particle of the file from its counterpart in the scene, over the extent of all."""
SAME_SIDE = 1e-5
"""The relative difference of sides of boxes that count as equal, since files hold them in single precision."""
SAME_INTERVAL = 0.05
"""The same of times between frames, which files round: those of 30 frames a second in ms are 33 and 34."""


class NoUnit(UserWarning):
    """Numbers of a file are ignored, since the scene does not state their unit."""


def import_run(
    scene: str | Path,
    directory: str | os.PathLike[str],
    *,
    overrides: Sequence[str] = (),
    force: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> RunResult:
    """Import the file that `[start_from]` of a scene names as a run, with frames at intervals of `frame_every`.

    All frames are read into a temporary run, which replaces `directory` when it is complete; until then an existing run
    is unchanged. Raises RunExists if `directory` exists, SceneError for a scene that cannot start from the first frame,
    and BadInput for frames that do not fit.
    """
    source = source_of(scene)
    raw = parsed(source)
    overridden(raw, overrides)
    every = all_frames(raw.get(RUN), source.folder)
    name, series = every.name, every.in_si()
    if series.frames < 2:
        raise BadInput(f"{RUN}.file: {name} has one frame; a scene starts from it with `ecume run`")
    first = _starting_at(source, overrides, f"{name}@0")
    if reason := MODELS_OF_PARTICLES[first.model]:
        raise BadInput(f"{RUN}.file: {name} cannot become a run of the model {first.model!r}: {reason}")
    if every.ignores_velocities:
        warnings.warn(f"{name}: its velocities are ignored; {RUN}.time_unit states their unit", NoUnit, stacklevel=2)
    whole = first.replace("duration", (series.frames - 1) * first.frame_every)
    options = RunOptions(
        threads=1, progress=progress, engine=Engine(reader_of(whole, name, series)), imported=Path(name).name
    )
    home = RunDirectory(Path(directory))
    refuse_existing(home, force=force)
    with storing(home.path):
        home.path.parent.mkdir(parents=True, exist_ok=True)
    beside = RunDirectory(partial_of(home.path.absolute()))
    try:
        done = run(whole, beside.path, options=options)
        put_in_place(beside, home, force=force)
    except Stopped:
        raise Stopped(f"{home.path}: stopped; no frame was imported, and nothing was changed") from None
    finally:
        shutil.rmtree(beside.path, ignore_errors=True)
    return done._replace(directory=home.path)


def _starting_at(source: Source, overrides: Sequence[str], frame: str) -> Scene:
    """The scene that starts from a frame of its file. Raises SceneError."""
    raw = parsed(source)
    changed, faults = overridden(raw, overrides)
    raw[RUN]["file"] = frame
    scene, found = assembled(raw, source.folder)
    if scene is None or faults:
        raise SceneError(placed(source, [*faults, *found], changed), source.name)
    return scene


def reader_of(scene: Scene, name: str, series: Series) -> Callable[[Model], Model]:
    """An engine that reads every frame, including the first one, instead of integrating."""
    model, paths, before = MODELS[scene.model], Paths(name), _read(name, series, 0)
    alike = Alike(name, before, scene.frame_every)
    order: list[NDArray[np.int64]] = []

    def start(scene: Any, parameters: Any) -> Any:
        state = model.start(scene, parameters)
        order.append(_matched(state, before.position, model.access.sides(parameters), name))
        _write(state, before, parameters, 0)
        return state

    def advance(parameters: Any, state: Any, workspace: Any, steps: int) -> int:
        state.step[0] += steps
        frame, rest = divmod(int(state.step[0]), parameters.steps_per_frame)
        if rest:
            return DONE
        _write(state, _read(name, series, frame), parameters, frame)
        if frame == series.frames - 1:
            warn_of_far_moves(*paths.farthest)
        return EXCHANGE

    def _write(state: Any, found: Particles, parameters: Any, frame: int) -> None:
        arrays, place = model.access.arrays(state), order[0]
        if len(found.position) != len(place):
            raise BadInput(f"{name}: frame {frame} has {len(found.position)} particles; expected {len(place)}")
        dimensions = state.position.shape[1]
        alike.require(found, model.access.sides(parameters)[:dimensions], frame)
        position = paths.continued(found, model.access.sides(parameters)[:dimensions], frame * scene.frame_every)
        model.access.place(parameters, state, position[place])
        arrays["velocity"][...] = 0.0 if found.velocity is None else found.velocity[place, :dimensions]
        if faults := model.access.faults(scene, parameters, state):
            raise BadInput(f"{name}: frame {frame}: {faults[0]}")
        model.access.changed(state, True)

    return lambda model: dataclasses.replace(
        model, start=start, advance=advance, exchange=lambda parameters, state: state
    )


class Alike:
    """The properties that are equal in all frames of a file: box, type of each particle, and interval of times, which
    is `frame_every` (s) if the unit of times is known.
    """

    def __init__(self, name: str, first: Particles, frame_every: float = 0.0) -> None:
        self.name, self.kinds, self.frame_every = name, np.array(first.names)[first.kind], frame_every
        self.first = self.last = first.instant

    def require(self, found: Particles, sides: Array, frame: int) -> None:
        """Raise BadInput for a frame that differs; frames are passed in order. `sides` is that of the scene (m)."""
        if found.sides is not None and sides.any():
            self._require_box(found, sides, frame)
        kinds = np.array(found.names)[found.kind]
        if (other := np.flatnonzero(kinds != self.kinds)).size:
            got, before = kinds[other[0]], self.kinds[other[0]]
            raise BadInput(
                f"{self.name}: frame {frame}: particle {other[0] + 1} is of type {got}, and of type {before} in frame "
                "0; expected the same order in all frames, or a column id"
            )
        if frame:
            self._require_interval(found.instant, frame)
            if found.timed and self.frame_every:
                self._require_time(frame)

    def _require_box(self, found: Particles, sides: Array, frame: int) -> None:
        own = np.array(found.sides)[: len(sides)]
        periodic = sides > 0.0
        if (np.abs(own - sides)[periodic] > SAME_SIDE * sides[periodic]).any() or found.tilt > SAME_SIDE * sides.max():
            tilted = f", tilted by {found.tilt:.4g} m" if found.tilt > SAME_SIDE * sides.max() else ""
            got, there = (" x ".join(f"{side:.6g}" for side in each[periodic]) for each in (own, sides))
            raise BadInput(
                f"{self.name}: frame {frame}: the periodic box is {got} m{tilted}; expected {there} m as in frame 0, "
                "since boxes that change cannot be imported"
            )

    def _require_interval(self, now: float | None, frame: int) -> None:
        """Raise BadInput if the time between two frames differs from the mean of the earlier frames, or is negative."""
        if now is None or self.first is None or self.last is None:
            return
        interval = now - self.last
        usual = (self.last - self.first) / (frame - 1) if frame > 1 else interval
        if interval < 0.0:
            raise BadInput(f"{self.name}: frame {frame}: is before the one before it; expected frames in order of time")
        if abs(interval - usual) > SAME_INTERVAL * max(usual, interval):
            raise BadInput(
                f"{self.name}: frame {frame}: is {interval:g} steps or units of time after the one before, and the "
                f"frames so far are {usual:g} apart; expected equal intervals, which are frame_every of the run: leave "
                "other frames out"
            )
        self.last = now

    def _require_time(self, frame: int) -> None:
        """Raise BadInput if the times in the file (s) are not those of the run."""
        if self.first is None or self.last is None:
            return
        usual = (self.last - self.first) / frame
        if abs(usual - self.frame_every) > SAME_INTERVAL * self.frame_every:
            raise BadInput(
                f"{self.name}: frame {frame}: frames are {usual:.6g} s apart by the times in the file and "
                f'{RUN}.time_unit, and frame_every is {self.frame_every:.6g} s; expected frame_every = "{usual:.6g} s"'
            )


class Paths:
    """The paths of particles in a file, without jumps at the borders of a periodic box."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.last: Array | None = None
        self.farthest = (0.0, 0.0)
        """the farthest move between two frames without image numbers, over the side, and its time (s)"""

    def continued(self, found: Particles, sides: Array, time: float) -> Array:
        """The unwrapped positions (N, d) of a frame: by its image numbers, or else by nearest images."""
        position = found.position[:, : len(sides)]
        if sides.any() and found.image is not None:
            position = position + found.image[:, : len(sides)] * sides
        elif sides.any() and self.last is not None and len(self.last) == len(position):
            box = Box(sides)
            moved = nearest(position - self.last, box)
            far = float(np.max(np.abs(moved) / np.where(sides > 0.0, sides, np.inf)))
            self.farthest = max(self.farthest, (far, time))
            position = self.last + moved
        self.last = position
        return position


def _read(name: str, series: Series, frame: int) -> Particles:
    try:
        return series.read(frame)
    except ValueError as fault:
        raise BadInput(f"{name}: {fault}") from None


def _matched(state: Any, position: Array, sides: Array, name: str) -> NDArray[np.int64]:
    """The index in the file of each particle of the state, found by equal positions up to periods."""
    dimensions = state.position.shape[1]
    periods = periods_of(sides[:dimensions].tolist())
    home = into_box(position[:, :dimensions], periods)
    from scipy.spatial import cKDTree

    found = cKDTree(home, boxsize=periods[0] if periods.any() else None).query(into_box(state.position, periods))
    distance, place = np.asarray(found[0], np.float64), np.asarray(found[1], np.int64)
    extent = max(float(np.ptp(position, axis=0).max()), float(sides.max()))
    if len(np.unique(place)) != len(position) or distance.max() > SAME * extent:
        raise BadInput(
            f"{name}: the scene starts with {len(place)} particles at other positions; expected those of the file alone"
        )
    return place
