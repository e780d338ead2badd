"""The state of the soft model, and the scratch memory of a step."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.linear_solvers import block_matrix
from ecume.engine.linear_solvers.block_matrix import Matrix
from ecume.engine.linear_solvers.solvers import Kept, accuracy_for
from ecume.engine.walls import nearest_points
from ecume.laws import soft_pair
from ecume.models.soft.cell import Cell, make_cell
from ecume.models.soft.contacts.connected_pieces import anchors, dangling_spheres, pieces, turning_pieces
from ecume.models.soft.contacts.contact import ROUNDING
from ecume.models.soft.contacts.films import ContactResponses, Films, Pairs, make_films, make_responses
from ecume.models.soft.contacts.rotation import Spins, make_spins, turned_orientation
from ecume.models.soft.contacts.user_forces import across
from ecume.models.soft.contacts.walls import Touches, Walls, make_walls
from ecume.models.soft.integration.bordered_system import MOST, Borders, make_borders
from ecume.models.soft.integration.dirk_schemes import SCHEMES
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.permeation import Permeation, make_permeation
from ecume.models.soft.waiting import Waiting, make_waiting, present, rates_of
from ecume.units import Array

LENGTH, PAST_ERROR, CLOCK, FORCE_RESIDUAL = range(4)
"""Indices of `State.pace`: the length of the next step (s), the last error over the tolerance, the time (s), and the
largest residual force on a sphere over the typical force.
"""
ACCEPTED, REJECTED, FAILED = range(3)
"""Indices of `State.tally`."""
NO_BUDGET = np.zeros(0)
"""The energy budget in runs of earlier versions: empty."""
UNPREPARED = np.zeros(0)
"""The end of the preparation of scenes without one."""
NO_LAYERS = np.zeros(0)
"""The layers of scenes without permeation."""
NO_RATES = np.zeros(0)
NONE_REACHED = np.zeros(0, np.int64)
NO_STRESSES = np.zeros((0, 2))
"""The rates of scenes in which none waits for a stationary stress, and their stresses."""

UPRIGHT = {0: np.zeros(0), 1: np.zeros(1), 3: np.array([1.0, 0.0, 0.0, 0.0])}
"""The orientation at time 0, by the number of components of a spin."""


class State(NamedTuple):
    """The state of a run: all arrays that can change a later result."""

    position: Array
    """(N, d) m; not wrapped into the box"""
    velocity: Array
    """(N, d) m/s, mean over the last step"""
    orientation: Array
    """(N, 1) rad in a layer, (N, 4) quaternions in 3D; (N, 0) for spheres without spin"""
    spin: Array
    """(N, s) rad/s, mean over the last step"""
    step: Integers
    """(1,) time in ticks"""
    contacts: Integers
    """(1,) number of contacts; their arrays have room for more"""
    generation: Integers
    """(1,) number of times that contacts opened or closed"""
    pair: Integers
    """(room, 2) the spheres of each contact"""
    image: Integers
    """(room, d) the periodic image of the second sphere, in boxes"""
    log_gap: Array
    """(room,)"""
    direction: Array
    """(room, d) of the gap vector"""
    order: Integers
    """(N,) order of the spheres in the matrix: neighbors close to one another"""
    touching: Integers
    """(N, W) whether each sphere has a contact with each wall"""
    wall_gap: Array
    """(N, W) ln of its gap"""
    slip: Array
    """(N, W, d) tangential displacement of the gap vector, in radii; of glued spheres the vector to the wall"""
    wall: Array
    """(W, 3) m: the position of each wall on its axis, and its displacements along the others"""
    wall_rate: Array
    """(W, 3) m/s at the end of the last step"""
    cell: Array
    """(5,) the shape of the box: `cell.Cell`"""
    cell_rate: Array
    """(5,) its rate at the end of the last step (1/s)"""
    pace: Array
    """(4,) see LENGTH"""
    tally: Integers
    """(3,) number of steps accepted, rejected for their error, and not solved"""
    effort: Integers
    """(3,) data for the choice of the solver: iterations of the last linear system, steps since the last one by an
    iterative solver, and failed attempts since the last success of that solver
    """
    budget: Array = NO_BUDGET
    """(4,) J: injected, dissipated and stored energy: see `report.energy_budget`"""
    layer_force: Array = NO_LAYERS
    """(L,) N: the rise of the pore pressure across each layer, times its area: see `permeation`"""
    permeating: Array = NO_LAYERS
    """(N,) m/s: velocities across the layers at the end of the last step"""
    prepared: Array = UNPREPARED
    """(2,) the duration of the preparation (s), and the part of contact forces by which they changed in its last
    1/rate"""
    rate_ends: Array = NO_RATES
    """(W,) s: see `waiting.Waiting`, as for the next three"""
    rate_reached: Integers = NONE_REACHED
    rate_stresses: Array = NO_STRESSES
    rate_frames: Integers = NONE_REACHED


class Workspace(NamedTuple):
    """Scratch memory; a new one gives the same results."""

    step: Step
    kept: Kept
    """data of the solvers, valid as long as no contact opens or closes"""
    generation: int
    """the generation of contacts for which it was made"""


def make_state(parameters: Parameters, position: Array, room: int) -> State:
    """The state at time 0, without contacts."""
    (count, dimensions), walls = position.shape, len(parameters.walls.modulus)
    return State(
        position=np.array(position, np.float64),
        velocity=np.zeros((count, dimensions)),
        orientation=np.tile(UPRIGHT[parameters.torque.shape[1]], (count, 1)),
        spin=np.zeros_like(parameters.torque),
        step=np.zeros(1, np.int64),
        contacts=np.zeros(1, np.int64),
        generation=np.zeros(1, np.int64),
        pair=np.zeros((room, 2), np.int64),
        image=np.zeros((room, dimensions), np.int64),
        log_gap=np.zeros(room),
        direction=np.zeros((room, dimensions)),
        order=np.arange(count),
        touching=np.zeros((count, walls), np.int64),
        wall_gap=np.zeros((count, walls)),
        slip=np.zeros((count, walls, dimensions)),
        wall=nearest_points(parameters.walls.surfaces),
        wall_rate=parameters.walls.surfaces.velocity.copy(),
        cell=np.zeros(5),
        cell_rate=np.zeros(5),
        pace=np.zeros(4),
        tally=np.zeros(3, np.int64),
        effort=np.zeros(3, np.int64),
        budget=np.zeros(4),
        **resting_layers(parameters, count),
        **waiting_rates(parameters),
    )


def resting_layers(parameters: Parameters, count: int) -> dict[str, Any]:
    """The arrays of permeating liquid at rest; none without permeation."""
    if not parameters.permeation:
        return {}
    return {"layer_force": np.zeros(parameters.permeation.layers), "permeating": np.zeros(count)}


def waiting_rates(parameters: Parameters) -> dict[str, Any]:
    """The arrays of rates that wait for a stationary stress; none without such rates."""
    if not len(rates_of(parameters.protocol)):
        return {}
    made = make_waiting(parameters.protocol, parameters.time_step * parameters.steps_per_frame)
    return {f"rate_{name}": values for name, values in made._asdict().items()}


def waiting_of(state: State) -> Waiting:
    """The rates that wait for a stationary stress, as views of the state."""
    return Waiting(state.rate_ends, state.rate_reached, state.rate_stresses, state.rate_frames)


def at_present(parameters: Parameters, state: State) -> Parameters:
    """The parameters with the protocol as it is after the rates that have ended early."""
    if not len(state.rate_ends):
        return parameters
    frames = parameters.steps_per_frame, parameters.time_step, parameters.end
    return parameters._replace(protocol=present(parameters.protocol, waiting_of(state), frames))


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Scratch memory for the present contacts."""
    count, dimensions = state.position.shape
    contacts = int(state.contacts[0])
    pairs = pairs_of(parameters, state)
    stages, width = len(SCHEMES[parameters.scheme].tableau.times), dimensions + parameters.torque.shape[1]
    pattern = block_matrix.make_pattern(count, pairs.first, pairs.second, state.order)
    unknowns = len(parameters.walls.free) + (parameters.permeation.layers + 1 if parameters.permeation else 0)
    shared = make_borders(count, width, max(MOST, unknowns, width - dimensions))
    anchor = anchors(parameters, state.pair[:contacts], state.touching)
    bodies = Bodies(
        position=state.position.copy(),
        before=state.position.copy(),
        moved=np.zeros((count, dimensions)),
        start=np.zeros((count, dimensions)),
        slope=np.zeros((stages, count, dimensions)),
        drag=parameters.drag,
        anchor=anchor,
        spin_anchor=np.where(turning_pieces(state.pair[:contacts], state.image[:contacts], anchor), anchor, 0.0),
        force=parameters.force,
        weight=parameters.weight,
        right=shared.right[0],
        change=shared.change[0],
        diagonal=np.zeros((count, width)),
    )
    step = Step(
        pairs=pairs,
        films=make_films(contacts),
        responses=make_responses(contacts),
        slope=np.zeros((stages, contacts, 4)),
        log_gap=state.log_gap[:contacts].copy(),
        direction=in_3d(state.direction[:contacts]),
        bodies=bodies,
        spins=make_spins(
            parameters.radius,
            (parameters.spin_drag, held_spins(parameters, state, anchor)),
            parameters.torque,
            (stages, contacts, width),
        ),
        walls=walls_of(parameters, state, stages),
        permeation=permeation_of(parameters, state, stages),
        matrix=block_matrix.make_matrix(pattern, width),
        cell=make_cell(parameters.box, state.cell, state.cell_rate, stages),
        borders=shared,
        budget=make_budget_sums(stages, contacts + int(state.touching.sum())),
    )
    kept = Kept(pattern, width, parameters.dimensions, accuracy_for(count))
    return Workspace(step, kept, int(state.generation[0]))


def store(parameters: Parameters, state: State, step: Step) -> None:
    """Copy the result of a step to the state: positions, spins, gap vectors, walls and the box."""
    contacts, dimensions = int(state.contacts[0]), state.position.shape[1]
    state.position[:] = step.bodies.before
    state.pace[FORCE_RESIDUAL] = force_residual(step)
    if state.spin.shape[1]:
        state.orientation[:] = turned_orientation(state.orientation, step.spins.turn / parameters.radius[:, None])
    state.log_gap[:contacts] = step.log_gap
    state.direction[:contacts] = step.direction[:, :dimensions]
    if step.walls:
        places, touches = step.walls
        state.wall_gap[touches.first, touches.wall] = touches.log_gap_before
        state.slip[touches.first, touches.wall] = touches.slip_before[:, :dimensions]
        state.wall[:], state.wall_rate[:] = places.before, places.past
    state.cell[:], state.cell_rate[:] = step.cell.before, step.cell.past
    if step.permeation:
        state.layer_force[:], state.permeating[:] = step.permeation.before, step.permeation.past


def permeation_of(parameters: Parameters, state: State, stages: int) -> Permeation | tuple[()]:
    """The layers of the permeating liquid, if any. Spheres without a connection to a wall are suspended in it."""
    if not parameters.permeation:
        return ()
    piece = pieces(state.pair[: state.contacts[0]], state.touching)
    now = state.layer_force, state.permeating
    return make_permeation(parameters.permeation, piece[:-1] == piece[-1], now, stages)


UNTURNED = 1e9
"""The resistance of glued spheres to spins, over modulus times radius: they do not rotate."""


def held_spins(parameters: Parameters, state: State, anchor: Array) -> Array:
    """The resistance of each sphere to rotation (N/m, at the equator): that of the glue, and of spheres that could roll
    freely, which exerts no torque; zero for others.
    """
    size, glued = parameters.modulus * parameters.radius, parameters.walls.glue.any(axis=1)
    if not parameters.torque.shape[1]:
        return np.where(glued, UNTURNED * size, 0.0)
    dangling = dangling_spheres(parameters, state.pair[: state.contacts[0]], state.touching, anchor)
    return np.where(glued, UNTURNED * size, np.where(dangling, size, 0.0))


def drained(scratch: Workspace) -> Workspace:
    """The same without permeating liquid: in which loads act for so long that it is at rest."""
    return scratch._replace(step=scratch.step._replace(permeation=()))


def walls_of(parameters: Parameters, state: State, stages: int) -> Walls | tuple[()]:
    """The walls of the scene, if any, and the present contacts with them."""
    if not len(parameters.walls.modulus):
        return ()
    first, wall = (np.ascontiguousarray(index) for index in np.nonzero(state.touching))
    count, radius = len(first), parameters.radius
    moduli = parameters.modulus[first], parameters.walls.modulus[wall]
    modulus = np.array([soft_pair.pair_modulus(*pair) for pair in zip(*moduli, strict=True)])
    glue = parameters.walls.glue[first, wall]
    log_gap, slip = state.wall_gap[first, wall], in_3d(state.slip[first, wall])
    room = (np.zeros((count, *shape)) for shape in ((3,), (3,), (3, 3), (4,), (4, 3), (4,)))
    places = (log_gap.copy(), slip.copy(), log_gap.copy(), slip.copy(), log_gap, slip)
    touches = Touches(first, wall, radius[first], modulus, glue, *places, np.zeros((stages, count, 4)), *room)
    return Walls(make_walls(parameters.walls, (state.wall, state.wall_rate), stages), touches)


def pairs_of(parameters: Parameters, state: State) -> Pairs:
    """The constants of the present contacts."""
    contacts = int(state.contacts[0])
    first, second = np.ascontiguousarray(state.pair[:contacts].T)
    radius, modulus = parameters.radius, parameters.modulus
    return Pairs(
        first=first,
        second=second,
        image=in_3d(state.image[:contacts].astype(np.float64)),
        offset=np.zeros((contacts, 3)),
        turn=np.zeros((contacts if parameters.torque.shape[1] else 0, 3)),
        radius_sum=radius[first] + radius[second],
        reduced_radius=np.asarray(soft_pair.reduced_radius(radius[first], radius[second])),
        modulus=np.asarray(soft_pair.pair_modulus(modulus[first], modulus[second])),
        laws=across(parameters.user_forces, parameters.species, state.pair[:contacts]),
        across=np.zeros((contacts, 2)),
    )


def force_residual(step: Step) -> float:
    """The largest residual force on a sphere over the typical force, minus the rounding error of positions. The typical
    force is the root mean square of contact forces, or of external forces if that is larger.
    """
    forces = [step.responses.force, step.bodies.force, step.bodies.weight]
    # As in `newton.imbalance`: the rounding error is relative to positions, not to the distances between spheres.
    far = 2.0 * float(np.abs(step.bodies.position).max(initial=0.0))
    size = step.pairs.radius_sum + far + np.abs(step.pairs.offset).max(axis=1)
    firmest = stiffest(step.responses.stiffness, size)
    if step.walls:
        touches = step.walls.touches
        forces.append(touches.force)
        firmest = max(firmest, stiffest(touches.stiffness, touches.radius + far))
    typical = max(float(np.sqrt((force**2).sum(axis=1).mean())) if len(force) else 0.0 for force in forces)
    rounding = ROUNDING * firmest
    residual = float(np.abs(step.bodies.right).max())
    return max(residual - rounding, 0.0) / typical if typical > rounding else 0.0


@compiled
def stiffest(stiffness: Array, radius_sum: Array) -> float:
    """The largest stiffness times center distance (N)."""
    largest = 0.0
    for c in range(len(radius_sum)):
        for k in range(3):
            for m in range(3):
                largest = max(largest, stiffness[c, k, m] * radius_sum[c])
    return largest


def in_3d(vectors: Array) -> Array:
    """Vectors with three components; missing ones are zero."""
    space = np.zeros((len(vectors), 3))
    space[:, : vectors.shape[1]] = vectors
    return space


# --- Data of one time step


class Bodies(NamedTuple):
    """The spheres in a step."""

    position: Array
    """(N, d) m at the stage"""
    before: Array
    """(N, d) m at the start of the step"""
    moved: Array
    """(N, d) m: displacement since then; stored separately, since in short steps it would be lost in the rounding of
    positions
    """
    start: Array
    """(N, d) m: displacement at the start of the stage; used with drag only"""
    slope: Array
    """(S, N, d) m/s at each stage, with drag only"""
    drag: Array
    """(N,) N s/m"""
    anchor: Array
    """(N,) N/m: anchors of free pieces; see `connected_pieces`"""
    spin_anchor: Array
    """(N,) N/m: the same against spins, of pieces that can rotate"""
    force: Array
    """(N, d) N external, proportional to the load"""
    weight: Array
    """(N, d) N external, constant"""
    right: Array
    """(N, d + s) N: residual forces, and torques as forces at the equator"""
    change: Array
    """(N, d + s) m: Newton's step of positions and spins"""
    diagonal: Array
    """(N, d + s) N/m"""


class StepRequest(NamedTuple):
    """The length, drive and tolerance of a step."""

    length: float
    """s"""
    drives: Array
    """(S, 10) the drive at each stage, as the fields of a `Drive`"""
    tolerance: float


class BudgetSums(NamedTuple):
    """The energy budget of a step; see `energy_budget`."""

    lines: Array
    """(S + 1, 8) a row per stage, zero for stages with zero weight; the last row is the contribution of the step to
    `State.budget` (J)
    """
    sheared: Array
    """(C + walls', 2) of each contact at the last stage: tangential stiffness (N/m) and shear squared (m^2)"""


class Step(NamedTuple):
    """All data of a time step."""

    pairs: Pairs
    films: Films
    responses: ContactResponses
    slope: Array
    """(S, C, 4) rates at each stage"""
    log_gap: Array
    direction: Array
    """the contacts at the start of the step"""
    bodies: Bodies
    spins: Spins
    walls: Walls | tuple[()]
    """empty without walls, so that their code is not compiled"""
    permeation: Permeation | tuple[()]
    """empty without permeation"""
    matrix: Matrix
    cell: Cell
    borders: Borders
    budget: BudgetSums


def make_budget_sums(stages: int, contacts: int) -> BudgetSums:
    """Zero sums for the energy budget of a step."""
    return BudgetSums(np.zeros((stages + 1, 8)), np.zeros((contacts, 2)))
