"""Frames of floats: copies of the state, numbers of the whole system, and the invariants that follow from them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers, images_in, into_box
from ecume.engine.contact.contacts import Candidates, apart
from ecume.engine.walls import Walls, wall_count
from ecume.engine.walls.rings import wall_distance
from ecume.laws.moving_dish import sway_place
from ecume.models.floating.contacts.contact_models import contacts_of, gaps_between
from ecume.models.floating.forces.barrier import with_walls_of
from ecume.models.floating.forces.interactions import interactions_of
from ecume.models.floating.forces.pair_forces import row_of
from ecume.models.floating.parameters import (
    COLLISIONS,
    DEEPEST,
    SWEEPS,
    UNCONVERGED,
    WORK,
    Parameters,
    State,
    Workspace,
    compiled_state,
    is_driven,
)
from ecume.models.floating.time_integration.integration import inertia_of
from ecume.models.invariants import INJECTED, Invariant, NumberHistory, energy_never_rises, kept, part_of
from ecume.scenes.floating import FloatingScene
from ecume.trajectories.frame import Frame
from ecume.units import Array

ARRAY_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "radius": "m",
    "mass": "kg",
    "charge": "m",
    "density": "kg/m^3",
    "contact_angle": "rad",
    "species": "1",
}

NUMBER_UNITS = {
    "kinetic_energy": "J",
    "pair_energy": "J",
    "wall_energy": "J",
    "total_energy": "J",
    "momentum_x": "kg*m/s",
    "momentum_y": "kg*m/s",
    "angular_momentum": "kg*m^2/s",
    "largest_speed": "m/s",
    "clusters": "1",
    "mean_cluster_size": "1",
    "contacts": "1",
    "largest_overlap": "m",
    "deepest_overlap": "m",
    "collisions": "1",
    "contact_sweeps": "1",
    "unconverged_steps": "1",
}

SIDES = ("box_width", "box_height")
"""The sides of a periodic cell, in frames."""

NOT_IN_CELLS = {
    "angular_momentum": "images at different borders have different angular momenta",
}
"""Numbers that frames of a periodic cell do not contain, and why they are not defined there."""

CONTACT_GAP = 1e-3
"""Floats whose gap is below this fraction of the smaller radius count as touching."""


@compiled
def touching_pairs(
    position: Array, radius: Array, candidates: Candidates, label: Integers, periods: Array
) -> tuple[int, float]:
    """Label clusters by their lowest member; return the number of touching pairs and the deepest overlap."""
    first, partner = candidates.first, candidates.partner
    contacts, deepest = 0, 0.0
    for i in range(position.shape[0]):
        label[i] = i
    for i in range(position.shape[0]):
        for place in range(first[i], first[i + 1]):
            j = partner[place]
            x, y = apart(position, i, j, periods)
            gap = math.sqrt(x * x + y * y) - radius[i] - radius[j]
            if gap < CONTACT_GAP * min(radius[i], radius[j]):
                contacts += 1
                deepest = max(deepest, -gap)
                _join(label, i, j)
    for i in range(position.shape[0]):
        label[i] = _root(label, i)
    return contacts, deepest


@compiled
def _root(label: Integers, i: int) -> int:
    while label[i] != i:
        label[i] = label[label[i]]
        i = label[i]
    return i


@compiled
def _join(label: Integers, i: int, j: int) -> None:
    low, high = _root(label, i), _root(label, j)
    label[max(low, high)] = min(low, high)


@compiled
def deepest_in_walls(walls: Walls, position: Array, radius: Array) -> float:
    """The deepest overlap of a float with a wall (m)."""
    worst = 0.0
    for i in range(position.shape[0]):
        for number in range(wall_count(walls)):
            worst = max(worst, radius[i] - wall_distance(walls, number, position[i, 0], position[i, 1])[0])
    return worst


def touching_shapes(parameters: Parameters, state: State, label: Integers) -> tuple[int, float]:
    """Label clusters of shapes as `touching_pairs` does; the deepest overlap includes walls."""
    radius, contacts, deepest = parameters.floats.radius, 0, 0.0
    label[:] = np.arange(len(radius))
    for i, j, gap in gaps_between(parameters, state.position, state.turning[:, 0], CONTACT_GAP * float(radius.min())):
        deepest = max(deepest, -gap)
        if j < len(radius):
            contacts += 1
            _join(label, i, j)
    for i in range(len(label)):
        label[i] = _root(label, i)
    return contacts, deepest


def observe(parameters: Parameters, state: State, workspace: Workspace) -> Frame:
    """Return the frame of this state."""
    parameters, floats = with_walls_of(parameters, state), parameters.floats
    arrays = {
        "position": into_box(state.position, parameters.periods),
        "velocity": state.velocity.copy(),
        **{name: getattr(floats, name).copy() for name in ARRAY_UNITS if hasattr(floats, name)},
    }
    units = dict(ARRAY_UNITS)
    if inertia_of(parameters) is not None:
        # Torques and rotational diffusion change the headings of active floats.
        heading = state.turning[:, 0] + (state.active[:, 2] if len(state.active) else 0.0)
        arrays |= {"angle": heading, "spin": state.turning[:, 1].copy()}
        units |= {"angle": "rad", "spin": "rad/s"}
    elif len(state.active):
        arrays["angle"], units["angle"] = state.active[:, 2].copy(), "rad"
    for part, row in interactions_of(parameters):
        for name, (values, unit) in row.arrays(part).items():
            arrays[name], units[name] = values, unit
    numbers = {
        **energies(parameters, state, workspace),
        **motion(parameters, state),
        **contact_numbers(parameters, state, workspace),
    }
    numbers = {name: float(numbers[name]) for name in NUMBER_UNITS}
    units |= NUMBER_UNITS
    for part, row in interactions_of(parameters):
        for name, (value, unit) in row.numbers(part, state).items():
            numbers[name], units[name] = value, unit
    if np.any(parameters.periods):
        for name in NOT_IN_CELLS:
            del numbers[name], units[name]
        numbers |= dict(zip(SIDES, parameters.periods[0].tolist(), strict=True))
        units |= dict.fromkeys(SIDES, "m")
        arrays["image"], units["image"] = images_in(state.position, parameters.periods), "1"
    time = int(state.step[0]) * parameters.time_step
    if is_driven(parameters) and len(state.tally) > WORK:
        numbers[INJECTED], units[INJECTED] = float(state.tally[WORK]), "J"
    if parameters.drift.sway.moves:
        numbers |= dish_position(parameters, time)
        units |= {"dish_x": "m", "dish_y": "m"}
    return Frame(time, arrays, numbers, units)


def dish_position(parameters: Parameters, time: float) -> dict[str, float]:
    """The position of a moving dish, which is the frame of reference of the floats."""
    sway = parameters.drift.sway
    x, y = (
        speed * time + sway_place(far, sway.turning, time)
        for speed, far in zip(sway.velocity.tolist(), sway.amplitude.tolist(), strict=True)
    )
    return {"dish_x": x, "dish_y": y}


def energies(parameters: Parameters, state: State, workspace: Workspace) -> dict[str, float]:
    """Kinetic, pair and wall energies (J), and their sum; without kinetic energy if floats have no inertia."""
    kinetic = 0.5 * float(np.sum(parameters.floats.mass * np.sum(state.velocity**2, axis=1)))
    if (inertia := inertia_of(parameters)) is not None:
        kinetic += 0.5 * float(np.sum(inertia * state.turning[:, 1] ** 2))
    moving = compiled_state(state)
    pairs, walls = contacts_of(parameters).energy(
        parameters.parts.contacts, workspace.scratch.contacts, parameters, moving, workspace
    )
    for (part, row), own in zip(interactions_of(parameters), workspace.scratch.interactions, strict=True):
        among, at_walls = row.energy(part, own, parameters, moving, workspace)
        pairs, walls = pairs + among, walls + at_walls
    return {
        "kinetic_energy": kinetic,
        "pair_energy": pairs,
        "wall_energy": walls,
        "total_energy": (kinetic if parameters.scheme.inertia else 0.0) + pairs + walls,
    }


def motion(parameters: Parameters, state: State) -> dict[str, float]:
    """Momenta and the largest speed."""
    mass, position, velocity = parameters.floats.mass, state.position, state.velocity
    turning = position[:, 0] * velocity[:, 1] - position[:, 1] * velocity[:, 0]
    inertia = inertia_of(parameters)
    spins = float(np.sum(inertia * state.turning[:, 1])) if inertia is not None else 0.0
    return {
        "momentum_x": float(np.sum(mass * velocity[:, 0])),
        "momentum_y": float(np.sum(mass * velocity[:, 1])),
        "angular_momentum": float(np.sum(mass * turning)) + spins,
        "largest_speed": float(np.sqrt(np.max(np.sum(velocity**2, axis=1)))),
    }


def contact_numbers(parameters: Parameters, state: State, workspace: Workspace) -> dict[str, float]:
    """Clusters, contacts, overlaps, and the counts of the contact solver since the start."""
    radius = parameters.floats.radius
    label = np.zeros(len(radius), np.int64)
    if contacts_of(parameters).gaps is not None:
        contacts, deepest = touching_shapes(parameters, state, label)
    else:
        contacts, deepest = touching_pairs(state.position, radius, workspace.candidates, label, parameters.periods)
        deepest = max(deepest, deepest_in_walls(parameters.walls, state.position, radius))
    clusters = len(np.unique(label))
    return {
        "clusters": clusters,
        "mean_cluster_size": len(radius) / clusters,
        "contacts": contacts,
        "largest_overlap": deepest,
        "deepest_overlap": state.tally[DEEPEST],
        "collisions": state.tally[COLLISIONS],
        "contact_sweeps": state.tally[SWEEPS],
        "unconverged_steps": state.tally[UNCONVERGED],
    }


RISE = 1e-3
"""Tolerance of the energy with the default time step."""

OVERLAP = 0.02
"""Over the smallest radius: contacts tolerate 1e-4; many fast floats overlap more for one step."""

UNSETTLED = 0.01
"""Tolerated fraction of steps whose contacts do not converge."""

ROUNDING = 1e-9
"""Tolerance of momentum: pair forces cancel exactly, sums to rounding."""


def invariants(scene: FloatingScene, parameters: Parameters) -> list[Invariant]:
    """The invariants of a scene."""
    return list(_rows(scene, parameters))


def _rows(scene: FloatingScene, parameters: Parameters) -> Iterator[Invariant]:
    if scene.contacts.law != "none":
        smallest = float(parameters.floats.radius.min())
        yield Invariant(
            "overlap", "the deepest so far, over the smallest radius", OVERLAP,
            lambda seen: seen.now["deepest_overlap"] / smallest,
        )  # fmt: skip
        yield Invariant(
            "contacts", "steps whose contacts did not converge, over all", UNSETTLED,
            lambda seen: part_of(seen.now["unconverged_steps"], max(seen.now["step"], 1.0 / UNSETTLED)),
        )  # fmt: skip
    if row_of(parameters).energy is not None:
        yield _energy(parameters)
    for _, row in interactions_of(parameters):
        yield from row.invariants
    if _alone(scene, parameters):
        mass = float(parameters.floats.mass.sum())
        yield kept("momentum", ("momentum_x", "momentum_y"), lambda seen: _momenta(seen, mass), ROUNDING)


def _energy(parameters: Parameters) -> Invariant:
    """The invariant that energy minus injected work never increases. Without inertia it is potential energy only, and
    thermal noise changes it by kT per float. A law that is not reciprocal has no energy.

    In a raft at rest, contacts correct overlaps of 1e-10 radii. The work of these corrections is proportional to the
    energy of the raft. Energies whose terms cancel rise and fall by rounding.
    """
    rounding = sum(row.rounding(part, parameters) for part, row in interactions_of(parameters))
    least = len(parameters.floats.mass) * parameters.drift.thermal + 2.0 * rounding / RISE
    motion = ("kinetic_energy",) if parameters.scheme.inertia else ()
    energy = energy_never_rises(RISE, lambda seen: least + RESOLVED * _deepest(seen), motion)
    if not is_driven(parameters):
        return energy
    # Runs of former versions have no injected work.
    return energy._replace(value=lambda seen: energy.value(seen) if INJECTED in seen.now else 0.0)


RESOLVED = 1e-6
"""The share of the energy that counts as moved in a raft at rest: a thousandth of it may be gained."""


def _deepest(seen: NumberHistory) -> float:
    """The largest magnitude of the energy so far (J)."""
    return max(seen.largest["total_energy"], -seen.least["total_energy"])


def _alone(scene: FloatingScene, parameters: Parameters) -> bool:
    """Whether floats interact only with each other."""
    dragged = any(math.isfinite(float(time)) for time in parameters.floats.relaxation_time)
    pushed = is_driven(parameters) or not row_of(parameters).reciprocal or not parameters.scheme.inertia
    return scene.dish is None and not dragged and not pushed


def _momenta(seen: NumberHistory, mass: float) -> float:
    """The largest possible momentum at this energy, sqrt(2 m E)."""
    return math.sqrt(2.0 * mass * seen.largest["kinetic_energy"])
