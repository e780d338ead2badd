"""Active floats: a random force with a memory, propulsion along a heading that diffuses, and a constant torque."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.neighbors import NeighborLists
from ecume.engine.philox import counter_of, normals
from ecume.laws import brownian_motion
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import WORK, Parameters, State, Workspace
from ecume.models.floating.setup.kinds import turning_frictions
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

FORCES, HEADINGS = 2, 3
"""Purposes of random numbers; those of thermal noise are 0 and 1."""
START = 11
"""Separates the random numbers of the first forces and headings from others."""
DEVIATIONS = 5.0
"""Standard deviations of the random force that a time step allows for."""


class Activity(NamedTuple):
    """Constants of active floats."""

    force: Array
    """(N,) N: root mean square of the random force along each axis"""
    persistence: float
    """s: correlation time of the random force"""
    propulsion: Array
    """(N,) N"""
    diffusion: Array
    """(N,) rad^2/s: rotational diffusion coefficient of the headings"""
    turning: Array
    """(N,) rad/s by the torque"""
    seed: int
    aligned: bool
    """whether floats are propelled along their own axis"""


class ActivityScratch(NamedTuple):
    """The state and the forces of the previous step."""

    active: Array
    """(N, 3) that of the state"""
    turning: Array
    """that of the state"""
    before: Array
    """(N, 2) N"""


def make_activity_scratch(
    part: Activity, parameters: Parameters, state: State, workspace: Workspace
) -> ActivityScratch:
    """Return the workspace."""
    return ActivityScratch(state.active, state.turning, np.zeros((len(state.position), 2)))


def with_activity(part: Activity, state: State) -> State:
    """Return the state with random forces drawn from their stationary distribution, in units of their root mean square,
    and with random headings. The heading of a float that turns is relative to its angle.
    """
    rng = np.random.default_rng([part.seed, START])
    count = len(state.position)
    heading = rng.uniform(0.0, 2.0 * math.pi, count)
    heading = np.zeros(count) if part.aligned else heading
    return state._replace(active=np.column_stack([rng.normal(size=(count, 2)), heading]))


@compiled
def active_force(part: Activity, scratch: ActivityScratch, i: int) -> tuple[float, float]:
    """The force on one float (N)."""
    heading = scratch.active[i, 2]
    if scratch.turning.shape[1] > 0:
        heading += scratch.turning[i, 0]
    x = part.force[i] * scratch.active[i, 0] + part.propulsion[i] * math.cos(heading)
    return x, part.force[i] * scratch.active[i, 1] + part.propulsion[i] * math.sin(heading)


@compiled
def activity_forces(
    part: Activity,
    scratch: ActivityScratch,
    parameters: Parameters,
    position: Array,
    lists: NeighborLists,
    force: Array,
) -> None:
    """Add the active forces."""
    for i in range(len(force)):
        x, y = active_force(part, scratch, i)
        force[i, 0] += x
        force[i, 1] += y


@compiled
def renew_activity(part: Activity, scratch: ActivityScratch, parameters: Parameters, state: State, first: bool) -> None:
    """Advance random forces and headings by one time step, before the floats move; the new forces are those at the end
    of the step.
    """
    if not first:
        return
    time, step = parameters.time_step, int(state.step[0])
    kept = math.exp(-time / part.persistence)
    fresh = math.sqrt(1.0 - kept * kept)
    for i in range(len(part.force)):
        scratch.before[i, 0], scratch.before[i, 1] = active_force(part, scratch, i)
        along, across = normals(counter_of(i, step, FORCES), part.seed)
        scratch.active[i, 0] = kept * scratch.active[i, 0] + fresh * along
        scratch.active[i, 1] = kept * scratch.active[i, 1] + fresh * across
        turned = normals(counter_of(i, step, HEADINGS), part.seed)[0]
        scratch.active[i, 2] += part.turning[i] * time + math.sqrt(2.0 * part.diffusion[i] * time) * turned


@compiled
def add_work_of_activity(
    part: Activity, scratch: ActivityScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add the work (J) of the active forces in a step, by the mean of the forces at its beginning and end; a scheme
    with forces in the middle has those of the end.
    """
    midstep_velocity, power = workspace.midstep_velocity, 0.0
    last = 0.5 if parameters.scheme.forces_at_end else 1.0
    for i in range(len(part.force)):
        x, y = active_force(part, scratch, i)
        power += ((1.0 - last) * scratch.before[i, 0] + last * x) * midstep_velocity[i, 0]
        power += ((1.0 - last) * scratch.before[i, 1] + last * y) * midstep_velocity[i, 1]
    state.tally[WORK] += power * parameters.time_step


def no_activity_energy(
    part: Activity, scratch: ActivityScratch, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Return zero: active forces have no potential."""
    return 0.0, 0.0


def activity_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the activity of a scene."""
    given, floats = scene.activity, parameters.floats
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen it
    names = [name for name, *_ in scene.kinds]
    if unknown := [name for name in given.species if name not in names]:
        raise scene_error("activity.species", f"got {unknown[0]!r}; expected names among {', '.join(map(repr, names))}")
    active = np.array([not given.species or names[number] in given.species for number in floats.species], np.float64)
    # Noise turns elongated bodies themselves, and their headings with them.
    thermal = 0.0 if scene.shaped else parameters.drift.thermal
    friction = turning_frictions(scene) if given.torque or thermal > 0.0 else np.ones(len(active))
    spread = np.array([brownian_motion.diffusivity(thermal, each) for each in friction])
    part = Activity(
        given.force * active / math.sqrt(2.0), given.persistence or 1.0, given.propulsion * active,
        given.rotational_diffusion + spread, given.torque * active / friction, scene.seed,
        scene.shaped,
    )  # fmt: skip
    rates = [1.0 / part.persistence if given.force else 0.0, float(part.diffusion.max())]
    rates.append(float(np.abs(part.turning).max()))
    speed = float(np.max((DEVIATIONS * part.force + part.propulsion) * floats.relaxation_time / floats.mass))
    # A step moves a float by at most a tenth of the skin.
    rates.append(0.5 * parameters.raft_mobility * speed / parameters.skin)
    return Built(part, shortest_time=min(1.0 / rate if rate > 0.0 else math.inf for rate in rates))
