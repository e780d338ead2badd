"""The energy budget of soft spheres: injected work, and stored and dissipated energy.

Without inertia all work is stored in deflections, or dissipated in films and by the drag of the surrounding liquid. The
powers are evaluated at each stage of a step and added with the weights of the scheme, so that the budget closes with
the order of the scheme. The work of external forces follows from displacements, since positions have no rates.

The surface law has no potential: the size of a contact depends on its gap, without a force on the film. The energy that
surfaces gain or lose in this way is a separate entry; see `soft_pair.gap_energy`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled, compiled_inside, composed, prange, shared, where_there
from ecume._portable import exp
from ecume.laws.surfaces import Body
from ecume.models.soft.cell import STRAIN, TILT, WIDTH, Cell, flow_gradient, unknowns
from ecume.models.soft.contacts.contact import (
    Elastic,
    Vector,
    contact_gap_energy,
    dot,
    elastic_of,
    remote_energy_by,
    remote_force_and_slope,
    sheared_energy_by,
    square_across,
)
from ecume.models.soft.contacts.films import Films, Pairs, center_distance, stored_energy, turned
from ecume.models.soft.contacts.rotation import Spins, carry
from ecume.models.soft.contacts.user_forces import user_energies
from ecume.models.soft.contacts.walls import Touches, Walls, normal_of, wall_distance, wall_energy
from ecume.models.soft.integration.dirk_schemes import Scheme
from ecume.models.soft.integration.newton import CHUNK
from ecume.models.soft.medium import OPEN
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.permeation import Permeation, seepage_powers
from ecume.models.soft.state import Bodies, Step, StepRequest
from ecume.units import Array

INJECTED, FILMS, DRAG, SIZE = range(4)
"""Indices of `State.budget` (J): injected work, dissipation by films, by drag and permeation, and work of changing
contact sizes.
"""
TO_FILMS, TO_SIZE, DRIVEN, SHRUNK, DRAGGED, RESPONDING, BY_LOAD, BY_WEIGHT = range(8)
"""Columns of the row of a stage: powers (W), except SHRUNK, BY_LOAD and BY_WEIGHT (J). DRIVEN is the power of
prescribed motion, RESPONDING that of motion controlled by stresses, whose displacement is the weighted sum of its
rates.
"""

OF_CONTACTS = ("first", "second", "image", "offset", "radius_sum", "reduced_radius", "modulus")
"""The fields of `Pairs` that determine the stored energy."""
ContactArrays = tuple[tuple[Any, ...], tuple[Any, ...], tuple[Array, Array], tuple[Array, Array], tuple[Any, ...]]
"""Arrays of contacts: spheres and images; sizes; states of films; forces and rates; positions with the rates of the box
and the values of the last stage.
"""


@compiled_inside
def surface_work(
    contacts: Contacts, body: Body, at: tuple[float, float, float], before: tuple[float, float]
) -> tuple[float, float, Elastic]:
    """The power by which the size of a contact changes energy, per rate of ln(gap) (J); the energy change by its
    tangential stiffness since the previous stage (J), for tangential laws without a potential; and the elastic
    response. `at` contains gap, stretch and shear squared; `before` the tangential stiffness and the shear squared at
    the previous stage.
    """
    gap, stretch, square = at
    surface = elastic_of(contacts, body, gap, stretch, math.sqrt(square))
    stiffer, mean = surface.tangential - before[0], 0.5 * (square + before[1])
    shrunk: float = -sheared_energy_by(stiffer, mean, contacts, contacts.tangential_law)
    return -contact_gap_energy(contacts, body, gap, stretch, square), shrunk, surface


@composed
def add_stage(contacts: Contacts, step: Step, scheme: Scheme, during: StepRequest, stage: int) -> None:
    """Write the row of a solved stage; after the last stage, the contribution of the step to the energy budget."""
    pairs, bodies, spins, cell, lines = step.pairs, step.bodies, step.spins, step.cell, step.budget.lines
    line, sheared, span = lines[stage], step.budget.sheared, scheme.diagonal * during.length
    among = (bodies.position, box_rates(cell, stage), sheared)
    start_line(line, sum_pairs(contacts, pairs, step.films, (step.responses.force, step.slope[stage]), among), cell)
    at_walls = (bodies.position, spins.turn, sheared[len(pairs.first) :], line)
    add_walls(step.walls, contacts, at_walls, stage)
    add_permeation(step.permeation, step.walls, stage, line)
    add_bodies((bodies, spins), carried(cell, stage, span), stage, line)
    if stage == len(scheme.times) - 1:
        add_step(lines, scheme, during.length, during.drives)


def count_pairs(contacts: Contacts, pairs: Pairs, *_: object) -> int:
    """The number of contacts, for the choice between serial and threaded loops."""
    return len(pairs.first)


@shared(count_pairs)
def sum_pairs(
    contacts: Contacts, pairs: Pairs, films: Films, moving: tuple[Array, Array], at: tuple[Array, Array, Array]
) -> Array:
    """Sum the energy budget of all pairs, with one row per chunk. `moving` contains forces and rates, `at` the
    positions, the rates of the box, and the values of the last stage.
    """
    first, second, offset, image, turn = pairs.first, pairs.second, pairs.offset, pairs.image, pairs.turn
    radius_sum, reduced_radius, modulus = pairs.radius_sum, pairs.reduced_radius, pairs.modulus
    across, log_gap, direction = pairs.across, films.log_gap, films.direction
    (force, slope), (position, box, sheared), count = moving, at, len(first)
    sums = np.zeros(((count + CHUNK - 1) // CHUNK, 4))
    for chunk in prange(len(sums)):
        who, sizes = (first, second, offset, image, turn), (radius_sum, reduced_radius, modulus, across)
        arrays = (who, sizes, (log_gap, direction), (force, slope), (position, box, sheared))
        add_pairs(contacts, arrays, (chunk * CHUNK, min((chunk + 1) * CHUNK, count)), sums, chunk)
    return sums


@compiled_inside
def add_pairs(contacts: Contacts, arrays: ContactArrays, among: tuple[int, int], sums: Array, chunk: int) -> None:
    """Sum the energy budget of a chunk of pairs. The power F.dG/dt of a film, in the frame that rotates with its pair,
    is dissipated except for the power of long-range forces.
    """
    (first, second, offset, image, turn), (radius_sum, reduced_radius, modulus, across) = arrays[0], arrays[1]
    (log_gap, direction), (force, slope), (position, box, sheared) = arrays[2], arrays[3], arrays[4]
    film, size, driven, shrunk = 0.0, 0.0, 0.0, 0.0
    for c in range(among[0], among[1]):
        x = center_distance(position, offset, first[c], second[c], c)
        f = (force[c, 0], force[c, 1], force[c, 2])
        driven += dot(f, image_velocity(box, image, c))
        if len(turn) > 0:
            back = (-turn[c, 0], -turn[c, 1], -turn[c, 2])
            x, f = turned(x, back), turned(f, back)
        n, gap, opening = (direction[c, 0], direction[c, 1], direction[c, 2]), math.exp(log_gap[c]), slope[c, 0]
        turning, pull = (slope[c, 1], slope[c, 2], slope[c, 3]), dot(x, n)
        apart = remote_force_and_slope(gap, reduced_radius[c], contacts)[0] + across[c, 0]
        film += gap * opening * (dot(f, n) + apart)
        film += (radius_sum[c] + gap) * dot(f, turning)
        at = (gap, pull - radius_sum[c] - gap, square_across(x, n))
        body, before = Body(radius_sum[c], reduced_radius[c], modulus[c], 0.0, 0.0), (sheared[c, 0], sheared[c, 1])
        by_gap, more, surface = surface_work(contacts, body, at, before)
        size += by_gap * opening + (surface.tangential - surface.normal) * at[1] * dot(x, turning)
        shrunk += more
        sheared[c, 0], sheared[c, 1] = surface.tangential, at[2]
    sums[chunk, TO_FILMS], sums[chunk, TO_SIZE] = film, size
    sums[chunk, DRIVEN], sums[chunk, SHRUNK] = driven, shrunk


@compiled
def start_line(line: Array, sums: Array, cell: Cell) -> None:
    """Start the row of a stage with the sums over all pairs."""
    for k in range(len(line)):
        line[k] = 0.0
    for chunk in range(len(sums)):
        for k in range(4):
            line[k] += sums[chunk, k]
    if unknowns(cell) > 0:
        line[RESPONDING], line[DRIVEN] = line[DRIVEN], 0.0


@compiled_inside
def image_velocity(box: Array, image: Array, c: int) -> Vector:
    """The velocity of the periodic image in a contact, relative to its sphere (m/s)."""
    i, j, k = image[c, 0], image[c, 1], image[c, 2]
    return box[0, 0] * i + box[0, 1] * j, box[1, 1] * j, box[2, 2] * k


@where_there()
def add_walls(walls: Walls, contacts: Contacts, at: tuple[Array, Array, Array, Array], stage: int) -> None:
    """Add the sums over contacts with walls to the row of a stage. `at` contains the positions and rotations of
    spheres, the values of the last stage, and the row.
    """
    touches, places, (position, turn, sheared, line) = walls.touches, walls.places, at
    film, size, driven, shrunk, answered = 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(len(touches.first)):
        w, radius = touches.wall[c], touches.radius[c]
        n, x = normal_of(places, w), wall_distance(walls, position, turn, c)
        slip = (touches.slip[c, 0], touches.slip[c, 1], touches.slip[c, 2])
        f = (touches.force[c, 0], touches.force[c, 1], touches.force[c, 2])
        for k in range(3):
            power = touches.force[c, k] * places.slope[stage, w, k]
            prescribed = places.velocity[w, k] != 0.0
            driven, answered = driven + (power if prescribed else 0.0), answered + (0.0 if prescribed else power)
        if touches.glue[c] > 0.0:
            continue
        gap, opening = math.exp(touches.log_gap[c]), touches.rate[stage, c, 0]
        sliding = (touches.rate[stage, c, 1], touches.rate[stage, c, 2], touches.rate[stage, c, 3])
        film += gap * opening * (dot(f, n) + remote_force_and_slope(gap, radius, contacts)[0]) + radius * dot(
            f, sliding
        )
        apart = (x[0] - radius * slip[0], x[1] - radius * slip[1], x[2] - radius * slip[2])
        stretch, square = dot(x, n) - radius - gap, square_across(apart, n)
        body = Body(radius, radius, touches.modulus[c], 0.0, 0.0)
        by_gap, more, surface = surface_work(contacts, body, (gap, stretch, square), (sheared[c, 0], sheared[c, 1]))
        size, shrunk = size + by_gap * opening, shrunk + more
        sheared[c, 0], sheared[c, 1] = surface.tangential, square
    line[TO_FILMS] += film
    line[TO_SIZE] += size
    line[DRIVEN] += driven
    line[SHRUNK] += shrunk
    line[RESPONDING] += answered


@where_there()
def add_permeation(permeation: Permeation, walls: Walls, stage: int, line: Array) -> None:
    """Add the dissipation of the permeating liquid, and the power of the undrained wall that drives it."""
    dissipated, driven = seepage_powers(permeation, walls, stage)
    medium, places = permeation.medium, walls.places
    line[DRAGGED] += dissipated
    if medium.closed != OPEN and places.velocity[medium.closed, medium.axis] != 0.0:
        line[DRIVEN] += driven
    else:
        line[RESPONDING] += driven


@compiled
def box_rates(cell: Cell, stage: int) -> Array:
    """The rates of the edge vectors of the box (m/s), as columns."""
    rates, slope, shape = np.zeros((3, 3)), cell.slope[stage], cell.shape
    for k in range(3):
        rates[k, k] = cell.sides[k] * math.exp(shape[WIDTH + k]) * slope[WIDTH + k]
    width = cell.sides[0] * math.exp(shape[WIDTH])
    rates[0, 1] = width * (slope[TILT] + shape[TILT] * slope[WIDTH])
    return rates


@compiled
def carried(cell: Cell, stage: int, span: float) -> Array:
    """The velocity gradient of the liquid for the drag in a stage (1/s): the displacement gradient since the start of
    the stage, over its time span. For an oscillating strain this differs from the rate at the stage.
    """
    if stage > 0:
        return flow_gradient(cell) / span
    gradient = np.zeros((3, 3))
    for k in range(3):
        gradient[k, k] = cell.slope[0, WIDTH + k]
    gradient[0, 1] = cell.slope[0, STRAIN]
    return gradient


@compiled
def add_bodies(spheres: tuple[Bodies, Spins], along: Array, stage: int, line: Array) -> None:
    """Add drag and the work of external forces and torques to the row of a stage; `along` is the velocity gradient of
    the liquid.
    """
    bodies, spins = spheres
    position, moved, force, weight, drag = bodies.position, bodies.moved, bodies.force, bodies.weight, bodies.drag
    for i in range(len(drag)):
        for k in range(position.shape[1]):
            line[BY_LOAD] += force[i, k] * moved[i, k]
            line[BY_WEIGHT] += weight[i, k] * moved[i, k]
            if drag[i] > 0.0:
                liquid = along[k, k] * position[i, k] + (along[0, 1] * position[i, 1] if k == 0 else 0.0)
                add_drag(line, drag[i], bodies.slope[stage, i, k], liquid)
        for k in range(spins.turn.shape[1]):
            line[BY_LOAD] += spins.torque[i, k] * spins.turn[i, k]
            if spins.drag[i] > 0.0:
                swirl = -0.5 * along[0, 1] * spins.radius[i] if k == spins.turn.shape[1] - 1 else 0.0
                add_drag(line, spins.drag[i], spins.slope[stage, i, k], swirl)


@compiled_inside
def add_drag(line: Array, friction: float, speed: float, along: float) -> None:
    """Add the dissipation by the drag on a sphere, and the power of the box, which moves the liquid."""
    line[DRAGGED] += friction * (speed - along) ** 2
    line[RESPONDING] -= friction * (speed - along) * along


@compiled
def add_step(lines: Array, scheme: Scheme, length: float, drives: Array) -> None:
    """Sum the rows of all stages to the contribution of the step to the energy budget.

    The work of a force with a load l(t), linear within a step, is the integral of l dY over its displacement Y. This is
    l Y at the end, minus the integral of Y dl.
    """
    added, last = lines[len(lines) - 1], len(lines) - 2
    grown = drives[last, 0] - drives[0, 0]
    for k in range(len(added)):
        added[k] = 0.0
    for stage in range(last + 1):
        part, mean = length * scheme.weights[0, stage], scheme.weights[1, stage]
        added[INJECTED] += part * lines[stage, RESPONDING] + mean * length * lines[stage, DRIVEN]
        added[INJECTED] -= mean * grown * lines[stage, BY_LOAD]
        added[FILMS] += part * lines[stage, TO_FILMS]
        added[DRAG] += part * lines[stage, DRAGGED]
        added[SIZE] += part * lines[stage, TO_SIZE] + (lines[stage, SHRUNK] if stage > 0 else 0.0)
    added[INJECTED] += drives[last, 0] * lines[last, BY_LOAD] + lines[last, BY_WEIGHT]


def elastic_energy(contacts: Contacts, step: Step) -> float:
    """The elastic energy of all deflections (J)."""
    position = step.bodies.position
    between = stored_energy(contacts, step.pairs, step.films, position)
    return float(between + wall_energy(step.walls, contacts, position, position[:, :0]))


def elastic_energy_at_end(contacts: Contacts, step: Step) -> float:
    """The elastic energy at the end of a step that is not accepted yet (J), in which the contacts rotate with their
    spheres.
    """
    direction = step.films.direction.copy()
    carry(step.pairs.turn, direction)
    between = stored_energy(contacts, step.pairs, step.films._replace(direction=direction), step.bodies.position)
    return float(between + wall_energy(step.walls, contacts, step.bodies.position, step.spins.turn))


def remote_energy(contacts: Contacts, step: Step) -> float:
    """The energy of long-range forces in films (J), relative to that at their reach."""
    pairs, log_gap = step.pairs, step.films.log_gap
    found = across_energy(contacts, log_gap, pairs.reduced_radius)
    if step.walls:
        touches = step.walls.touches
        films = touches.glue == 0.0
        found += across_energy(contacts, touches.log_gap[films], touches.radius[films])
    if pairs.laws:
        found += user_energies(pairs.laws, log_gap).sum()
        if contacts.fade_from < math.inf:
            found -= user_energies(pairs.laws, np.full(len(log_gap), math.log(contacts.fade_from))).sum()
    return float(found)


@compiled
def across_energy(contacts: Contacts, log_gap: Array, radius: Array) -> float:
    """The energy of the long-range law of the scene in films between spheres with these reduced radii (J)."""
    total, reach = 0.0, contacts.fade_from
    for c in range(len(log_gap)):
        total += remote_energy_by(math.exp(log_gap[c]), radius[c], contacts, contacts.remote)
        if reach < math.inf:
            total -= remote_energy_by(reach, radius[c], contacts, contacts.remote)
    return total


def stake(step: Step) -> float:
    """The energy scale of tolerances (J): the work of contact forces if each gap opened by its width and each gap
    vector turned by a radian.
    """
    between = stake_of(step.responses.force, step.films.direction, exp(step.films.log_gap), step.pairs.radius_sum)
    if not step.walls:
        return between
    places, touches = step.walls
    films = touches.glue == 0.0
    force, normal, gap = touches.force[films], places.normal[touches.wall[films]], exp(touches.log_gap[films])
    return between + stake_of(force, normal, gap, touches.radius[films])


def stake_of(force: Array, normal: Array, gap: Array, radius_sum: Array) -> float:
    """The energy scale of tolerances (J), from forces (N) and gap vectors of contacts."""
    pull = np.abs((force * normal).sum(axis=1))
    along = np.sqrt(np.maximum((force**2).sum(axis=1) - pull**2, 0.0))
    return float((pull * gap + along * (radius_sum + gap)).sum())


def faded_at_walls(touches: Touches, far: float) -> NDArray[np.bool_]:
    """Whether the film of each contact with a wall has faded: its ln(gap) is beyond `far`."""
    return np.asarray((touches.log_gap >= far) & (touches.glue == 0.0))


def energy_of_faded(contacts: Contacts, step: Step) -> float:
    """The elastic energy of contacts whose films have faded (J), which counts as dissipated at once."""
    if math.isinf(contacts.fade_to):
        return 0.0
    far, total = math.log(contacts.fade_to), 0.0
    faded = np.flatnonzero(step.log_gap >= far)
    if len(faded):
        pairs = step.pairs._replace(**{name: getattr(step.pairs, name)[faded] for name in OF_CONTACTS})
        films = Films._make(array[faded] for array in step.films)
        total += stored_energy(contacts, pairs, films, step.bodies.position)
    if (walls := step.walls) and (gone := np.flatnonzero(faded_at_walls(walls.touches, far))).size:
        used = ("first", "wall", "radius", "modulus", "glue", "log_gap", "slip")
        touches = walls.touches._replace(**{name: getattr(walls.touches, name)[gone] for name in used})
        position = step.bodies.position
        total += wall_energy(Walls(walls.places, touches), contacts, position, position[:, :0])
    return float(total)
