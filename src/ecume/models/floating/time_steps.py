"""A scene's time step: the longest that is good, or the asked one judged by it; and the kicks that follow."""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple

import numpy as np

from ecume.engine.walls import enclosures
from ecume.errors import Fault, SceneError
from ecume.models.floating.drifting import drift_of
from ecume.models.floating.pace import LARGEST_OVER_CHOSEN, LOOSEST_OVER_CHOSEN, chosen_step
from ecume.models.floating.parameters import Drift, Floats, Kick, Parameters, Scheme
from ecume.models.floating.walls.shapes import walls_of
from ecume.scenes.floating import FloatingScene

FARTHEST_CHANCE = 6.5
"""Standard deviations that chance is allowed for when neighbors are listed."""


class StepWarning(UserWarning):
    """The time step is longer than is good for the result."""


def kick_of(scheme: Scheme, time_step: float, floats: Floats, walls: int) -> Kick:
    """One kick of the scheme: half a step for velocity Verlet, a whole one for the others."""
    time = 0.5 * time_step if scheme.half_kicks else time_step
    if not scheme.inertia:
        gain = floats.relaxation_time / floats.mass
        return Kick(np.zeros_like(gain), gain, np.concatenate([gain / time, np.zeros(walls)]))
    ratio = time / floats.relaxation_time
    decay = np.exp(-ratio)
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(ratio > 0.0, -np.expm1(-ratio) / ratio, 1.0)
    gain = time / floats.mass * held
    mobility = np.concatenate([gain / time, np.zeros(walls)])
    return Kick(decay, gain, mobility)


def good_step(parameters: Parameters, scene: FloatingScene) -> float:
    """The longest time step that is good (s)."""
    return chosen_step(parameters, _speeds(scene))


class Step(NamedTuple):
    """A time step, and what follows from it."""

    time_step: float
    steps_per_frame: int
    kick: Kick
    drift: Drift


def step_of(parameters: Parameters, scene: FloatingScene) -> Step:
    """The time step: the scene's own, or the longest that is good, a whole number of times in the time between
    frames.
    """
    good, frame = good_step(parameters, scene), scene.frame_every
    asked = scene.integration.time_step
    if asked is not None:
        _judge(asked, good)
    steps = max(1, math.ceil(frame / (asked if asked is not None else good) * (1.0 - 1e-9)))
    if asked is not None and abs(steps * asked - frame) > 1e-9 * frame:
        raise _fault(
            "integration.time_step",
            f"{asked:g} s does not divide frame_every = {frame:g} s; {frame / steps:.9g} s would do",
        )
    time_step = frame / steps
    kick = kick_of(
        parameters.scheme, time_step, parameters.floats, len(parameters.kick.mobility) - len(parameters.floats.mass)
    )
    stiffest = float(parameters.floats.relaxation_time.min())
    if scene.integration.integrator == "rk4" and time_step > 2.0 * stiffest:
        raise _fault(
            "integration.integrator", f"'rk4' needs a time step below {2.0 * stiffest:.3g} s in so viscous a liquid; "
            f"it is {time_step:.3g} s. Set integration.time_step, or use 'velocity-verlet'"
        )  # fmt: skip
    jump = FARTHEST_CHANCE * math.sqrt(2.0 * parameters.drift.thermal * float(kick.gain.max()) * time_step)
    jump = (jump if parameters.drift.thermal > 0.0 else 0.0) + time_step * _swaying(parameters, kick)
    drift = parameters.drift._replace(jump=jump)
    return Step(time_step, steps, kick, drift)


def _swaying(parameters: Parameters, kick: Kick) -> float:
    """The most that a dish in motion changes a velocity by in a kick (m/s)."""
    sway, floats = parameters.drift.sway, parameters.floats
    far = float(np.hypot(*sway.amplitude))
    speed, change = float(np.hypot(*sway.velocity)) + far * sway.turning, far * sway.turning**2
    change = change if parameters.scheme.inertia else 0.0
    return sway.slip * float(np.max(kick.gain * floats.mass * (change + speed / floats.relaxation_time)))


def _judge(asked: float, good: float) -> None:
    """Refuse or warn of a step too large, with the number that would do."""
    if asked > LARGEST_OVER_CHOSEN * good:
        raise _fault(
            "integration.time_step",
            f"{asked:.3g} s is unstable here; wanted at most {LARGEST_OVER_CHOSEN * good:.3g} s, "
            f"{good:.3g} s is good"
        )  # fmt: skip
    if asked > LOOSEST_OVER_CHOSEN * good:
        warnings.warn(
            f"integration.time_step: {asked:.3g} s is coarse; {good:.3g} s is good", StepWarning, stacklevel=2
        )


def _speeds(scene: FloatingScene) -> float:
    """The fastest start, or the fastest that the surface flows in the dish."""
    reach = max((math.hypot(*place) for species in scene.particles for place in species.positions), default=0.0)
    if scene.dish is not None:
        reach = enclosures.farthest(walls_of(scene.dish))
    drift = drift_of(scene)
    flow, nodes = drift.flow, np.hypot(drift.nodes[0], drift.nodes[1])
    flowing = math.hypot(flow[0], flow[1]) + reach * float(np.abs(flow[2:]).sum()) + float(nodes.max(initial=0.0))
    speeds = [math.hypot(*each) for species in scene.particles for each in (species.velocities or [species.velocity])]
    flowing += drift.sway.slip * (float(np.hypot(*drift.sway.velocity + drift.sway.turning * drift.sway.amplitude)))
    return max([flowing, *speeds, *(math.hypot(row.vx, row.vy) for row in scene.rows)])


def _fault(path: str, message: str) -> SceneError:
    return SceneError([Fault(path, message)])
