"""Surface tension between the particles of the liquid: the continuum surface force (CSF), or cohesion.

There is no gas. Images behind walls count as liquid, so that the contact angle at a mirror is 90 degrees by default.
With two liquids the denser one has the color, and the tension is that of the interface.

The continuum surface force is the gradient of an energy, sigma int psi(c) |grad c| dV, summed over nodes. The color c
and its gradient at the nodes of a fixed square (cubic) grid are sums over nearby particles; the energy is a sum over
nodes (see `ecume.laws.tension.surface_weight`), and the force on each particle is exactly minus its derivative with
respect to the particle's position, second derivatives of the kernel included:

    F_j = sigma a^d V_j sum_g (psi' phi grad W_gj + psi grad grad W_gj . n_g),  n = grad c / max(|grad c|, g_0)

An oscillation can therefore only lose energy. Nodes are needed because the same energy sampled at the particles, which
are on one side of their surface only, has deep minima at disordered configurations.

A particle contributes m/rho_0 to the color, whatever its density: forces depend on positions alone. There are no nodes
behind planes, because half of the color of images, and half of the force on images, would be counted twice. The force
on an image is added to its source.

Other contact angles: nodes at a mirror have the additional energy -sigma cos(theta) chi(c) per area of the wall (see
`ecume.laws.tension.wetted_share`), and solids of dummy particles contribute the color of their angle (see
`solid_color`), without a force on them. [young1805, brackbill1992, wendland1995]
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside, prange, spread, summed_inside
from ecume.engine.cells import Integers
from ecume.engine.vectors import Vector, add_vector, axpy, dot, zeros
from ecume.laws import kernels, tension
from ecume.laws.kernels import kernel
from ecume.models.sph.fields import FIELD, Floats, Numbers
from ecume.models.sph.parameters import Material, Parameters
from ecume.models.sph.rates.neighbor_sums import Particle, Reading, neighbor_sum
from ecume.models.sph.rates.sum_evaluation import evaluate_sum
from ecume.models.sph.state import State, Workspace
from ecume.units import Array

admit(tension, kernels)

NODES = 0.6
"""The distance of nodes in spacings. At 0.5 and 0.67 forces are equal within some percent of their noise."""
BLOCKS = 16
"""The number of parts of the grid that are filled separately; it must not depend on the number of threads."""
ENERGY = 4
"""The row of the nodes' energy over sigma and a node's volume, after color and gradient."""


class GridNumbers(NamedTuple):
    """Constants of the nodes and of the color kernel."""

    reach: float
    """m, the range of a particle's color"""
    inverse_length: float
    """1/h"""
    step: float
    """m, from node to node"""
    value: float
    """the factors of the kernel and of its first and second derivative"""
    slope: float
    bend: float
    least: float
    """the least steepness that gives a normal (1/m)"""


class Grid(NamedTuple):
    """The grid of nodes, with three axes; in 2D the third has one node."""

    low: Array
    shape: Integers
    """(3,)"""
    numbers: GridNumbers


class Colors(NamedTuple):
    """The particles that contribute to the color, and the nodes around them."""

    position: Array
    """(3, columns)"""
    volume: Array
    grid: Grid
    nodes: Array
    """(5, nodes): color and gradient, later the terms of the forces; and the energy"""


def colors_of(parameters: Parameters, workspace: Workspace) -> Colors:
    """The particles and nodes of the color, from the fields that forces and energy require."""
    fields, dimension = workspace.fields, parameters.dimension
    position = np.zeros((3, fields.shape[1]))
    position[:dimension] = fields.position[:dimension]
    # The density of columns of solids is not set.
    wet = fields.density * fields.volume / colored(parameters).density
    if parameters.second is not None:
        wet = np.where(fields.kind == 1.0 + (colored(parameters) is parameters.second.material), wet, 0.0)
    dry = solid_colors(parameters, workspace) * fields.volume
    volume = np.where(fields.liquid > 0.0, wet, dry).astype(np.float64)
    grid = grid_around(parameters, position[:, inside_of(parameters, workspace)])
    return Colors(position, volume, grid, nodes_of(parameters, position, volume, grid))


def inside_of(parameters: Parameters, workspace: Workspace) -> Integers:
    """The columns of the liquid, and of images beyond periodic sides: their color reaches back into the tank."""
    images, mirrors = workspace.images, parameters.boundary.sides.mirrors
    liquid, real = workspace.rates.shape[1], len(workspace.lists.counts)
    parts = zip(itertools.pairwise(images.start.tolist()), mirrors, strict=True)
    beyond = [np.arange(real + first, real + end) for (first, end), mirror in parts if not mirror]
    found: Integers = np.concatenate([np.arange(liquid), *beyond]).astype(np.int64)
    return found


def colored(parameters: Parameters) -> Material:
    """The liquid whose color defines the interface: of two the denser one, since the forces accelerate it less."""
    return max(parameters.materials, key=lambda liquid: liquid.density)


def nodes_of(parameters: Parameters, position: Array, volume: Array, grid: Grid) -> Array:
    """The fields at the nodes, and their energy, from particles with these volumes."""
    nodes = np.empty((ENERGY + 1, int(np.prod(grid.shape))))
    color(nodes, position, volume, *grid)
    weigh(nodes, planes_of(parameters), *grid)
    return nodes


def solid_colors(parameters: Parameters, workspace: Workspace) -> Array:
    """The color of each column's solid; zero for liquid."""
    images, boundary = workspace.images, parameters.boundary
    liquid, real = workspace.rates.shape[1], len(workspace.lists.counts)
    found = np.zeros(workspace.fields.shape[1])
    found[liquid:real] = boundary.color[boundary.dummies.owner]
    # Images follow in the order of their sides; the source of an image may be an image of an earlier side.
    for first, end in itertools.pairwise(images.start.tolist()):
        found[real + first : real + end] = found[images.source[first:end]]
    return found


def grid_around(parameters: Parameters, position: Array) -> Grid:
    """A grid of nodes that covers the range of the liquid's color."""
    dimension, step, reach = parameters.dimension, NODES * parameters.spacing, parameters.color_reach
    low, high = np.zeros(3, np.int64), np.zeros(3, np.int64)
    low[:dimension] = np.floor((position[:dimension].min(axis=1) - reach) / step)
    high[:dimension] = np.ceil((position[:dimension].max(axis=1) + reach) / step)
    h = 0.5 * reach
    factor = kernel("wendland-c4", dimension).normalization / h**dimension
    numbers = GridNumbers(reach, 1.0 / h, step, factor, factor / h**2, factor / h**4, tension.RELIABLE / h)
    return Grid((step * low).astype(np.float64), high - low + 1, numbers)


def planes_of(parameters: Parameters) -> Array:
    """(sides, 7) a point of each, its normal into the liquid, and the cosine of its contact angle."""
    boundary, dimension = parameters.boundary, parameters.dimension
    planes = np.zeros((len(boundary.sides.normal), 7))
    planes[:, :dimension] = boundary.sides.point - parameters.origin
    planes[:, 3 : 3 + dimension] = boundary.sides.normal
    planes[:, 6] = np.where(boundary.image_owner >= 0, boundary.wetting[boundary.image_owner], 0.0)
    return planes


def contour_energy(parameters: Parameters, workspace: Workspace) -> float:
    """The surface energy (J, in 2D per meter of depth): sigma times the sum over nodes, minus the energy of dry solids,
    of which fewer nodes remain as the liquid spreads.
    """
    colors = colors_of(parameters, workspace)
    energy = colors.nodes[ENERGY]
    dry = np.where(workspace.fields.liquid > 0.0, 0.0, colors.volume)
    if dry.any():
        energy = energy - nodes_of(parameters, colors.position, dry, colors.grid)[ENERGY]
    return node_share(parameters) * float(energy.sum())


def contour_forces(parameters: Parameters, workspace: Workspace, mass: Array) -> Array:
    """The forces (d, N) in N: minus the derivatives of `contour_energy` with respect to the positions of the liquid."""
    colors = colors_of(parameters, workspace)
    force = np.zeros_like(colors.position)
    draw(force, colors.position, colors.volume, colors.nodes, *colors.grid)
    force *= node_share(parameters)
    give_back(parameters, workspace, force)
    found: Array = force[: parameters.dimension, : len(mass)]
    if alone(parameters, workspace):
        # The net force of the fixed grid is subtracted, as if the grid moved with the liquid.
        found -= found.sum(axis=1)[:, None] * (mass / mass.sum())
    return found


def alone(parameters: Parameters, workspace: Workspace) -> bool:
    """Whether the liquid has no solids and no mirrors within range."""
    mirrored = np.diff(workspace.images.start) * parameters.boundary.sides.mirrors
    return len(workspace.lists.counts) == workspace.rates.shape[1] and not mirrored.any()


def node_share(parameters: Parameters) -> float:
    """The factor sigma a^d of a node's energy."""
    material = parameters.material if parameters.second is None else parameters.second.material
    return material.surface_tension * (NODES * parameters.spacing) ** parameters.dimension


def give_back(parameters: Parameters, workspace: Workspace, force: Array) -> None:
    """Add the force on images to their sources, in reverse order since images may be images of earlier ones."""
    images, sides, real = workspace.images, parameters.boundary.sides, len(workspace.lists.counts)
    for side in reversed(range(len(sides.normal))):
        here = slice(images.start[side], images.start[side + 1])
        share = force[: parameters.dimension, real:][:, here].copy()
        if sides.mirrors[side]:
            axis = sides.normal[side]
            share -= 2.0 * axis[:, None] * (axis @ share)
        # A particle has at most one image behind a side, so that indices are unique.
        force[: parameters.dimension, images.source[here]] += share


@compiled_inside
def first_node(place: float, low: float, numbers: GridNumbers) -> int:
    """The first node along an axis within reach of a particle."""
    return max(0, math.ceil((place - numbers.reach - low) / numbers.step))


@compiled_inside
def end_node(place: float, low: float, numbers: GridNumbers, most: int) -> int:
    """The first node along an axis that is beyond the range of a particle."""
    return min(most, math.floor((place + numbers.reach - low) / numbers.step) + 1)


@spread
def color(nodes: Array, position: Array, volume: Array, low: Array, shape: Integers, numbers: GridNumbers) -> None:
    """Fill color and gradient, sum_j V_j W and sum_j V_j grad W. Each slab of nodes takes the particles in order."""
    slab = (shape[0] + BLOCKS - 1) // BLOCKS
    reach = numbers.reach
    for block in prange(BLOCKS):
        begin, end = min(shape[0], block * slab), min(shape[0], (block + 1) * slab)
        for row in range(ENERGY):
            for node in range(begin * shape[1] * shape[2], end * shape[1] * shape[2]):
                nodes[row, node] = 0.0
        for i in range(position.shape[1]):
            x, y, z, own = position[0, i], position[1, i], position[2, i], volume[i]
            first = max(begin, first_node(x, low[0], numbers))
            last = min(end, end_node(x, low[0], numbers, shape[0]))
            for a in range(first, last):
                dx = low[0] + a * numbers.step - x
                for b in range(first_node(y, low[1], numbers), end_node(y, low[1], numbers, shape[1])):
                    dy = low[1] + b * numbers.step - y
                    line = (a * shape[1] + b) * shape[2]
                    for c in range(first_node(z, low[2], numbers), end_node(z, low[2], numbers, shape[2])):
                        dz = low[2] + c * numbers.step - z
                        square = dx * dx + dy * dy + dz * dz
                        if square < reach * reach:
                            q = math.sqrt(square) * numbers.inverse_length
                            pull = own * numbers.slope * kernels.wendland_c4_slope(q)
                            nodes[0, line + c] += own * numbers.value * kernels.wendland_c4_value(q)
                            nodes[1, line + c] += pull * dx
                            nodes[2, line + c] += pull * dy
                            nodes[3, line + c] += pull * dz


@spread
def weigh(nodes: Array, planes: Array, low: Array, shape: Integers, numbers: GridNumbers) -> None:
    """Compute the energies of the nodes, and replace color and gradient by the derivatives of the energies: psi' phi
    and psi n for the part of the volume of a node in front of all planes, minus psi cos(theta) for its part in a plane.
    """
    step, least = numbers.step, numbers.least
    for node in prange(nodes.shape[1]):
        a, rest = divmod(node, shape[1] * shape[2])
        b, c = divmod(rest, shape[2])
        share, wall = 1.0, 0.0
        for side in range(len(planes)):
            before = (low[0] + a * step - planes[side, 0]) * planes[side, 3]
            before += (low[1] + b * step - planes[side, 1]) * planes[side, 4]
            before += (low[2] + c * step - planes[side, 2]) * planes[side, 5]
            inside = min(max(0.5 + before / step, 0.0), 1.0)
            # A plane between two nodes is divided between them by linear weights.
            within = planes[side, 6] / step * max(0.0, 1.0 - abs(before) / step)
            wall = wall * inside + share * within
            share *= inside
        gx, gy, gz = nodes[1, node], nodes[2, node], nodes[3, node]
        length = math.sqrt(gx * gx + gy * gy + gz * gz)
        value, steep = nodes[0, node], tension.steepness(length, least)
        weight = share * tension.surface_weight(value)
        nodes[ENERGY, node] = weight * steep - wall * tension.wetted_share(value)
        nodes[0, node] = share * tension.surface_weight_slope(value) * steep - wall * tension.surface_weight(value)
        weight /= max(length, least)
        nodes[1, node] = weight * gx
        nodes[2, node] = weight * gy
        nodes[3, node] = weight * gz


@spread
def draw(
    force: Array, position: Array, volume: Array, nodes: Array, low: Array, shape: Integers, numbers: GridNumbers
) -> None:
    """Compute the force on each position: minus the derivative of the total energy."""
    reach = numbers.reach
    for i in prange(position.shape[1]):
        x, y, z = position[0, i], position[1, i], position[2, i]
        fx, fy, fz = 0.0, 0.0, 0.0
        for a in range(first_node(x, low[0], numbers), end_node(x, low[0], numbers, shape[0])):
            dx = low[0] + a * numbers.step - x
            for b in range(first_node(y, low[1], numbers), end_node(y, low[1], numbers, shape[1])):
                dy = low[1] + b * numbers.step - y
                line = (a * shape[1] + b) * shape[2]
                for c in range(first_node(z, low[2], numbers), end_node(z, low[2], numbers, shape[2])):
                    dz = low[2] + c * numbers.step - z
                    square = dx * dx + dy * dy + dz * dz
                    if square < reach * reach:
                        q = math.sqrt(square) * numbers.inverse_length
                        nx, ny, nz = nodes[1, line + c], nodes[2, line + c], nodes[3, line + c]
                        slope = numbers.slope * kernels.wendland_c4_slope(q)
                        bend = numbers.bend * kernels.wendland_c4_bend(q)
                        along = nodes[0, line + c] * slope + bend * (dx * nx + dy * ny + dz * nz)
                        fx += along * dx + slope * nx
                        fy += along * dy + slope * ny
                        fz += along * dz + slope * nz
        force[0, i] = volume[i] * fx
        force[1, i] = volume[i] * fy
        force[2, i] = volume[i] * fz


STRENGTHS = {2: tension.cohesion_strength_in_plane, 3: tension.cohesion_strength_in_space}
COUNTED = {2: 0.331, 3: 0.236}
"""The part of the tension by cohesion that remains beside the pressure that it causes, for which div v in the sum of
continuity is zero up to a flat surface. Computed for Wendland's C2 and uniform liquid: see the page on the physics, and
`tests/models/sph/test_tension.py`.
"""


def add_surface_tension(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the acceleration by surface tension to the state's."""
    TENSIONS[parameters.tension].pull(parameters, state, workspace)


def surface_energy(parameters: Parameters, workspace: Workspace) -> float:
    """The surface energy (J): under cohesion that of all pairs, otherwise that of the color function; forces are its
    derivatives.
    """
    return TENSIONS[parameters.tension].energy(parameters, workspace)


def add_nothing(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Leave the accelerations unchanged, without surface tension."""


def no_energy(parameters: Parameters, workspace: Workspace) -> float:
    """Return zero, without surface tension."""
    return 0.0


def add_contour_force(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the acceleration by the continuum surface force."""
    state.acceleration[...] += contour_forces(parameters, workspace, state.mass) / state.mass


def add_cohesion(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the acceleration by cohesion."""
    strength = cohesion_strength(parameters)
    evaluate_sum(COHESION, parameters, workspace, state.acceleration, (parameters.support, strength))


def energy_of_pairs(parameters: Parameters, workspace: Workspace) -> float:
    """The energy of cohesion (J)."""
    energy = np.zeros((1, workspace.rates.shape[1]))
    evaluate_sum(COHESION_ENERGY, parameters, workspace, energy, (parameters.support, cohesion_strength(parameters)))
    return float(energy.sum())


def cohesion_strength(parameters: Parameters) -> float:
    """The strength of cohesion that gives the surface tension of the liquid."""
    material, law = parameters.material, STRENGTHS[parameters.dimension]
    target = material.surface_tension / COUNTED[parameters.dimension]
    return law(target, material.density, parameters.support)


@summed_inside
def given_cohesion(numbers: Numbers, settings: tuple[float, float], like: Vector) -> tuple[float, float]:
    """The support and the strength."""
    return settings


@summed_inside
def no_pull(zero: float, like: Vector) -> Vector:
    """An empty sum of vectors, in double precision."""
    found: Vector = zeros(0.0, like)
    return found


@summed_inside
def no_sum(zero: float, like: Vector) -> float:
    """An empty sum of energies, in double precision."""
    return 0.0


@summed_inside
def pair_cohesion(
    total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: tuple[float, float]
) -> Vector:
    """The sum of m_j C(r) x_ij/r with the term of a pair, which is the same for both; walls and images attract like the
    liquid.
    """
    distance = math.sqrt(dot(apart, apart))
    pull = other.weight * other.value * tension.cohesion_kernel(distance, given[0]) / max(distance, SAME)
    found: Vector = axpy(total, pull, apart)
    return found


@summed_inside
def add_to_acceleration(
    acceleration: Array, fields: Floats, i: int, total: Vector, own: Particle, given: tuple[float, float]
) -> None:  # fmt: skip
    """Add to the acceleration of the liquid."""
    add_vector(acceleration, 0, i, given[1], total)


@summed_inside
def pair_energy(
    total: float, apart: Vector, slope: float, own: Particle, other: Particle, given: tuple[float, float]
) -> float:
    """The energy with the term of a pair: half of it for a particle or an image, all of it for a dummy."""
    distance, mass = math.sqrt(dot(apart, apart)), math.fabs(other.weight) * other.value
    share = 0.5 if other.weight > 0.0 else 1.0
    return total + (share * mass * tension.cohesion_energy(distance, given[0]) if distance > SAME else 0.0)


@summed_inside
def store_energy(
    energy: Array, fields: Floats, i: int, total: float, own: Particle, given: tuple[float, float]
) -> None:  # fmt: skip
    """Store the energy of a particle."""
    energy[0, i] = given[1] * own.weight * own.value * total


SAME = 1e-30
"""The distance (m) below which two particles are the same one: see `neighbor_sums`."""
COHESION = neighbor_sum(
    Reading(weight=FIELD.volume, value=FIELD.density), given_cohesion, no_pull, pair_cohesion, add_to_acceleration
)
COHESION_ENERGY = neighbor_sum(
    Reading(weight=FIELD.volume, value=FIELD.density, signed=True),
    given_cohesion,
    no_sum,
    pair_energy,
    store_energy,
)


class Tension(NamedTuple):
    """A model of surface tension."""

    pull: Callable[[Parameters, State, Workspace], None]
    """adds its acceleration to the state"""
    energy: Callable[[Parameters, Workspace], float]
    """the energy (J) whose derivatives are its forces"""
    color_reaches: Mapping[int, float]
    """the range of its color function, in spacings, by dimension; zero without one"""
    inner_pressure: float
    """a quarter of the pressure in the liquid that it causes beside Laplace's, in tensions over supports"""
    accuracy: Mapping[int, str]
    """a remark on its accuracy, by dimension"""
    laws: tuple[Callable[..., float], ...]
    """the laws that it uses, for citations"""


TENSIONS: Mapping[str, Tension] = {
    "none": Tension(add_nothing, no_energy, {2: 0.0, 3: 0.0}, inner_pressure=0.0, accuracy={}, laws=()),
    "cohesion": Tension(
        add_cohesion, energy_of_pairs, {2: 0.0, 3: 0.0}, inner_pressure=6.0,
        accuracy={
            2: "swings below a tenth are too fast, wide ones right within 5 %",
            3: "draws round, but does not swing: particles that keep their neighbors hold each other",
        },
        laws=(tension.cohesion_kernel, tension.cohesion_strength_in_plane),
    ),
    # A narrower color kernel resolves single particles; a wider one flattens curved surfaces.
    "csf": Tension(
        add_contour_force, contour_energy, {2: 4.8, 3: 4.0}, inner_pressure=0.0,
        accuracy={
            2: "periods and pressures within some percent at ten particles a radius",
            3: "periods within 9 % at five particles a radius, 5 % at six; pressures within 14 %",
        },
        laws=(tension.surface_weight, tension.wetted_share, tension.steepness, kernels.wendland_c4_bend),
    ),
}  # fmt: skip
"""The methods of surface tension by name."""
