"""The SPH model, as the driver sees it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import psutil

from ecume.errors import BadInput, Fault, SceneError
from ecume.models.model import Model
from ecume.models.sph.building import kernel_of, liquid_of, parameters_of, smoothing_of
from ecume.models.sph.fields import FIELDS, RATES
from ecume.models.sph.gates import exchange, filled
from ecume.models.sph.motions import at_reference
from ecume.models.sph.observing import observe
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.solids import shape_of
from ecume.models.sph.splitting import require_right_split
from ecume.models.sph.state import State, Workspace, likely_neighbors, make_state, workspace_at
from ecume.models.sph.stepping import advance
from ecume.scenes.sph import SphScene

PAIRS_PER_SECOND = 1.5e8
"""Of the sums, on one core: a rough figure."""
FEW_NEIGHBORS = {2: 12, 3: 30}
MANY_NEIGHBORS = {2: 80, 3: 250}


def start(scene: SphScene, parameters: Parameters) -> State:
    """The liquid at time 0."""
    return filled(parameters, scene, make_state(parameters, liquid_of(scene, parameters.material)))


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Lists and tables at the state's reference positions."""
    return workspace_at(at_reference(parameters, state), state)


def checked_parameters(scene: SphScene) -> Parameters:
    """The parameters of a scene that fits into the machine."""
    count = particles_expected(scene)
    wanted = count * bytes_per_particle(scene)
    there = psutil.virtual_memory().total
    if wanted > there:
        message = f"about {count:.3g} particles need {wanted / 1e9:.3g} GB, this machine has {there / 1e9:.3g} GB"
        raise SceneError([Fault("spacing", f"came {scene.spacing:g} m: {message}; use a wider spacing")])
    require_right_split(scene)
    return parameters_of(scene)


def particles_expected(scene: SphScene) -> float:
    """A rough upper bound, before anything is laid out."""
    total = 0.0
    for region in scene.fluid:
        low, high = shape_of(region).bounds()
        total += float(np.prod((high - low) / scene.spacing + 1.0))
    return total


def bytes_per_particle(scene: SphScene) -> float:
    """State, tables and lists."""
    dimension = len(scene.tank.low)
    reach = 1.1 * kernel_of(scene).support * smoothing_of(scene)
    neighbors = likely_neighbors(dimension, reach / scene.spacing)
    return 8.0 * (FIELDS + RATES + 5 * dimension + 5) + 4.0 * neighbors


def diagnosis(parameters: Parameters, state: State) -> str:
    """Who broke, when, and what to do."""
    speed = np.sqrt((state.velocity**2).sum(axis=0))
    broken = ~(np.isfinite(speed) & np.isfinite(state.acceleration).all(axis=0))
    worst = int(np.flatnonzero(broken)[0]) if broken.any() else int(np.argmax(speed))
    what = "has no finite motion any more" if broken.any() else f"goes {speed[worst]:.3g} m/s"
    where = ", ".join(f"{x:.4g}" for x in state.position[:, worst])
    time = int(state.step[0]) * parameters.time_step
    return (
        f"at t = {time:.6g} s particle {int(state.identity[worst])} {what} (at {where} m); the scene expects "
        f"{parameters.material.fastest:.3g} m/s. Set liquid.fastest to what the flow reaches, or method.courant to "
        f"{0.5 * parameters.courant:.2g}, or look for liquid that starts inside of other liquid or of a wall"
    )


def extended(extra_laws: Sequence[Callable[..., float]]) -> Model:
    """There is no seam for a user's own laws here."""
    raise BadInput("extra_laws: the sph model takes none; the floating model does")


def summary(scene: SphScene) -> list[tuple[str, str, str]]:
    """Derived numbers: name, value with unit, remark."""
    parameters = checked_parameters(scene)
    state = start(scene, parameters)
    count, dimension = state.position.shape[1], parameters.dimension
    material, smoothing = parameters.material, smoothing_of(scene)
    neighbors = likely_neighbors(dimension, parameters.support / scene.spacing) / 1.15
    frames = round(scene.duration / scene.frame_every)
    steps = frames * parameters.steps_per_frame
    mach = material.fastest / material.sound_speed
    walls = parameters.boundary.dummies.position.shape[1]
    seconds = 2.0 * steps * (count * neighbors / PAIRS_PER_SECOND + 3e-4)
    return [
        ("particles", str(count), f"{walls} more in walls" if walls else "walls are mirrors"),
        ("smoothing length", f"{smoothing:.4g} m", f"{smoothing / scene.spacing:.3g} spacings"),
        ("neighbors", f"{neighbors:.0f}", neighbor_remark(neighbors, dimension)),
        ("sound speed", f"{material.sound_speed:.4g} m/s", f"of the numerical liquid; Mach {mach:.2g} to be expected"),
        (
            "compression",
            f"{100.0 * mach**2:.2g} %",
            "to be expected" if mach <= 0.11 else "large: raise liquid.sound_speed",
        ),
        ("time step", f"{parameters.time_step:.3g} s", "divided where the flow asks for it"),
        ("steps", str(steps), f"{frames} frames of {parameters.steps_per_frame} steps"),
        (
            "memory",
            f"{1e-6 * count * bytes_per_particle(scene):.3g} MB",
            f"{bytes_per_particle(scene):.0f} bytes a particle",
        ),
        ("time on this machine", duration(seconds), "roughly, after compilation"),
    ]


def neighbor_remark(neighbors: float, dimension: int) -> str:
    """Whether that is a good number."""
    if neighbors < FEW_NEIGHBORS[dimension]:
        return "few: raise method.smoothing"
    return "many: costly; lower method.smoothing" if neighbors > MANY_NEIGHBORS[dimension] else "good"


def duration(seconds: float) -> str:
    """In the unit that fits."""
    if seconds < 100:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.2g} min" if seconds < 6000 else f"{seconds / 3600:.2g} h"


SPH = Model(
    name="sph",
    state=State,
    parameters=checked_parameters,
    start=start,
    workspace=workspace,
    advance=advance,
    observe=observe,
    diagnosis=diagnosis,
    extended=extended,
    summary=summary,
    exchange=exchange,
)
