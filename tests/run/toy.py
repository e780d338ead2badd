"""A model for tests: a few beads on springs, integrated in plain NumPy; and a program that runs it, to be killed.

python toy.py run DIRECTORY '{"duration": 1.0}' 0.05
python toy.py resume DIRECTORY 0.05
python toy.py serve    # a line of JSON on standard input for each of the above; answers with a process and how it ended
"""

from __future__ import annotations

import importlib
import json
import math
import os
import sys
import time
import types
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic.dataclasses import dataclass

from ecume.models import MODELS
from ecume.models.layouts import Layout
from ecume.models.model import Model
from ecume.scenes.common import Common
from ecume.scenes.quantities import STRICT
from ecume.scenes.schema import SCENES
from ecume.trajectories.frame import Frame

TIME_STEP = 0.001
ROUNDING = 0.0
"""By how much this processor rounds otherwise: the relative error of all that the toy derives and computes."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ToyScene(Common):
    """Beads on springs, that may blow up at a step, or rest a while (s of wall time) at each call."""

    model: str = "toy"
    count: int = 5
    blow_up_at: int = -1
    rest: float = 0.0


class Parameters(NamedTuple):
    time_step: float
    steps_per_frame: int
    blow_up_at: int
    rest: float
    stiffness: NDArray[np.float64] = np.ones(1)


class State(NamedTuple):
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    step: NDArray[np.int64]


def parameters(scene: ToyScene) -> Parameters:
    per_frame = max(1, round(scene.frame_every / TIME_STEP))
    stiffness = np.full(scene.count, 1.0 + ROUNDING)
    return Parameters(TIME_STEP * (1.0 + ROUNDING), per_frame, scene.blow_up_at, scene.rest, stiffness)


def start(scene: ToyScene, _: Parameters) -> State:
    random = np.random.default_rng(scene.seed)
    return State(
        (1.0 + ROUNDING) * random.normal(size=(scene.count, 2)), np.zeros((scene.count, 2)), np.zeros(1, np.int64)
    )


def advance(given: Parameters, state: State, _: Any, steps: int) -> int:
    time.sleep(given.rest)
    for _step in range(min(steps, 40) if given.rest else steps):
        force = given.stiffness[:, None] * state.position**3 + np.roll(state.position, 1, 0)
        state.velocity[:] -= given.time_step * (1.0 + ROUNDING) * force
        state.position[:] += given.time_step * state.velocity
        state.step[0] += 1
        if state.step[0] == given.blow_up_at:
            state.position[1] = math.nan
            return 2
    return 0


def observe(given: Parameters, state: State, _: Any) -> Frame:
    arrays = {
        "position": state.position.copy(),
        "velocity": state.velocity.copy(),
        "radius": np.full(len(state.position), 0.05),
        "species": np.arange(len(state.position)) % 2,
    }
    numbers = {"kinetic_energy": float(0.5 * (state.velocity**2).sum()), "pairs": 0.0}
    units = {"position": "m", "velocity": "m/s", "radius": "m", "kinetic_energy": "J"}
    return Frame(float(state.step[0] * given.time_step), arrays, numbers, units)


def diagnosis(given: Parameters, state: State) -> str:
    return f"bead 1 is nowhere at t = {state.step[0] * given.time_step:g} s; take a smaller step"


def model() -> Model:
    return Model(
        name="toy",
        state=State,
        parameters=parameters,
        start=start,
        workspace=lambda given, state, room: None,
        advance=advance,
        observe=observe,
        diagnosis=diagnosis,
        layout=lambda scene, given, state: Layout(start(scene, given)),
        extended=lambda laws: model(),
        summary=lambda scene: [],
    )


def stand_alone() -> None:
    """Put the toy among the models, and nothing in the place of Numba, so that a process starts at once."""
    jit = types.ModuleType("ecume._jit")
    jit.use_threads = lambda count: count or 1  # type: ignore[attr-defined]
    jit.require_threads = lambda particles: None  # type: ignore[attr-defined]
    sys.modules["ecume._jit"] = jit
    MODELS["toy"] = model()
    SCENES["toy"] = ToyScene


def serve() -> int:
    """Do each line of the standard input in a process of its own, that begins without importing anything."""
    stand_alone()
    importlib.import_module("ecume.run")
    for line in sys.stdin:
        if not (child := os.fork()):
            os._exit(main(*json.loads(line)))
        print(child, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    return 0


def main(verb: str, directory: str = "", *rest: str) -> int:
    if verb == "serve":
        return serve()
    stand_alone()
    driving = importlib.import_module("ecume.run")
    options = driving.RunOptions(checkpoint_every=float(rest[-1]))
    errors = importlib.import_module("ecume.errors")
    try:
        if verb == "run":
            driving.run(ToyScene(**json.loads(rest[0])), directory, options=options)
        else:
            driving.resume(directory, options=options)
    except errors.EcumeError as error:
        print(error, file=sys.stderr)
        return int(error.exit_code)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
