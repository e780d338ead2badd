"""Forces of the liquid on obstacles and bodies that touch a wall or one another.

Sums over pairs of particles give the total force on all solids together, but not the force on each of two solids that
touch. Around the contact the neighbors of a dummy are other dummies instead of liquid and exert no force, so that a
disc on the floor was pulled down. Near contacts the force of the pressure on a solid is therefore its surface integral,

F = -sum_k p_k n_k A_k, p_k = sum_j w_kj [p_j + rho g.(x_k - x_j)] / sum_j w_kj,

over panels k of its surface. The error is of first order in the spacing, and zero in liquid at rest apart from the
discretization by panels [monaghan1994]. The weights are w_kj = V_j W_kj f_j^4, with the sum f_j of V W over the liquid
around j, and a kernel with a support of one and a half supports. The factor f_j^4 suppresses single particles in a
wedge. They have dummies instead of liquid around them, and a pressure error of up to the hydrostatic pressure of a
third of a spacing; without the factor a disc on the floor, five particles across, lost 6 % of its weight. The excess of
one solid over its pair sum is subtracted from the other one, so that the total stays that of the pairs. A gap that is
too narrow for particles counts as wet, with the pressure of the nearest liquid. The face of an obstacle that lies on a
wall is dry. The integral is blended out where the gap is between half a support and a whole one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, prange, spread
from ecume._portable import product
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Grid, Sorted, cell_at, grid_around, sort_by_cell
from ecume.engine.shapes import Flags, Hollow, Panels, Shape
from ecume.engine.walls.sheets import SIZE
from ecume.engine.walls.surfaces import PLANE
from ecume.laws import kernels
from ecume.models.sph.boundaries.forces_on_solids import forces_on_dummies, total
from ecume.models.sph.boundaries.rigid_bodies import rotations
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import State, Workspace
from ecume.units import Array

admit(kernels)

SEALED = 1e-6
"""The distance to a wall, in spacings, below which a panel of an obstacle is dry."""
PROBE = 0.01
"""The step along the normal, in spacings, of the test whether a panel faces a nearby surface."""
FAR = 1.5
"""The distance, in supports, within which liquid contributes to the pressure at a panel."""
TRUST = 4
"""The exponent of f_j, the sum over the liquid around a particle, in its weight."""


class Solid(NamedTuple):
    """An obstacle or a body at its present position."""

    owner: int
    """a place in `Boundary.names`"""
    shape: Shape
    turn: Array
    """(d, d) from the axes of the shape to those of the tank"""
    middle: Array
    """(d,) the origin of the axes of the shape"""
    moves: bool
    panels: Panels
    """of its surface, in the axes of the shape"""

    def gap(self, points: Array) -> Array:
        """The distances (N,) of points from its surface, positive outside."""
        return self.shape.nearest(product(points - self.middle, self.turn))[0]


def solids_now(now: Parameters, pose: Array) -> list[Solid]:
    """All obstacles, followed by all bodies."""
    d, bodies = now.dimension, now.bodies
    first, still = len(now.boundary.names) - len(bodies.panels), len(bodies.obstacles)
    turns = rotations(pose) if bodies.shapes else np.zeros((0, 3, 3))
    found = []
    for k, (shape, panels) in enumerate(zip((*bodies.obstacles, *bodies.shapes), bodies.panels, strict=True)):
        moves = k >= still
        turn, middle = (turns[k - still][:d, :d], pose[:d, k - still]) if moves else (np.eye(d), np.zeros(d))
        found.append(Solid(first + k, shape, turn, middle, moves, panels))
    return found


def gaps_of(now: Parameters, solids: list[Solid], mine: Solid, points: Array) -> dict[int, Array]:
    """The distances of points from walls and other solids, by owner."""
    guard, d, found = now.boundary.guard, now.dimension, dict[int, Array]()
    kind, number = guard.sheet.kind, guard.sheet.number
    middle = points.mean(axis=0)
    reach = float(np.sqrt(((points - middle) ** 2).sum(axis=1).max())) + now.support
    for k in np.flatnonzero((kind[:, 0] == PLANE) & (kind[:, 2] == 0)):
        if float(product(number[k, :d], middle)) - number[k, SIZE] < reach:
            found[int(guard.owner[k])] = product(points, number[k, :d]) - number[k, SIZE]
    for other in solids:
        if other.owner != mine.owner and other.gap(middle[None])[0] < reach:
            found[other.owner] = other.gap(points)
    return found


def _faces(now: Parameters, solids: list[Solid], mine: Solid, panels: tuple[Array, Array], gap: Array) -> Flags:
    """Flags of the panels, each a point with a normal, that face the nearby surface to within 60 degrees. For example,
    the side of a block that is dry above the floor does not form a narrow gap with the floor.
    """
    step = PROBE * now.spacing
    ahead = gaps_of(now, solids, mine, panels[0] + step * panels[1])
    found: Flags = np.min([*ahead.values(), np.full(len(gap), np.inf)], axis=0) < gap - 0.5 * step
    return found


def pressures_at(now: Parameters, state: State, workspace: Workspace, points: Array, narrow: Flags) -> Array:
    """The pressures (N,) in Pa at points of a surface: zero where the surface is dry; in narrow gaps the pressure of
    the nearest liquid.
    """
    count, fields = state.position.shape[1], workspace.fields
    reach, found = FAR * now.support, np.zeros(len(points))
    low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
    close = ((low[:, None] < state.position) & (high[:, None] > state.position)).all(axis=0)
    if not close.any():
        return found
    place, density = state.position[:, close], fields.density[:count][close].astype(np.float64)
    push = fields.force_term[:count][close].astype(np.float64)
    push *= density**2 if now.pressure_force.by_mass else 1.0
    volume = fields.volume[:count][close].astype(np.float64)
    weight = volume * kernel_sums(place, place, volume[None], now.support)[0][0] ** TRUST
    (there, pushed, *moments), nearest = kernel_sums(
        np.ascontiguousarray(points.T), place, weight * np.stack([np.ones_like(push), push, *place]), reach
    )
    gravity = now.gravity - now.pull_rate**2 * (points - now.pull_center)
    known = np.flatnonzero(nearest >= 0)
    away = np.full(len(points), np.inf)
    away[known] = np.sqrt(((points[known] - place.T[nearest[known]]) ** 2).sum(axis=1))
    wet = (away < now.support) & (there > 0.0)
    rise = now.material.density * (gravity * (points * there[:, None] - np.array(moments).T)).sum(axis=1)
    found[wet] = (pushed + rise)[wet] / there[wet]
    lonely = np.flatnonzero(~wet & narrow)
    if (nearest[lonely] < 0).any():
        from scipy.spatial import cKDTree

        nearest[lonely] = cKDTree(place.T).query(points[lonely])[1]
    way = points[lonely] - place.T[nearest[lonely]]
    found[lonely] = push[nearest[lonely]] + now.material.density * (gravity[lonely] * way).sum(axis=1)
    return np.maximum(found, 0.0) if now.walls_clip else found


def kernel_sums(points: Array, place: Array, values: Array, reach: float) -> tuple[Array, Integers]:
    """Sums over the particles at `place`, (d, M), of their values, (rows, M), times a kernel without its normalization,
    at points, (d, N): (rows, N); and the number of the nearest particle within reach, or -1.
    """
    grid = grid_around(place, reach)
    cells = sort_by_cell(place, grid)
    sums, nearest = np.zeros((points.shape[1], len(values))), np.full(points.shape[1], -1)
    add_around(points, sums, nearest, np.ascontiguousarray(values.T[cells.order]), cells, grid, reach)
    nearest[nearest >= 0] = cells.order[nearest[nearest >= 0]]
    return sums.T, nearest


@spread
def add_around(
    points: Array, sums: Array, nearest: Integers, values: Array, cells: Sorted, grid: Grid, reach: float
) -> None:
    """Add `kernel_sums` of values in the order of cells; `nearest` is an index in this order."""
    (low, edge, shape), start, place = grid, cells.start, cells.position
    dimension, inverse = len(low), 2.0 / reach  # the kernel's support is two of its lengths
    deep, last, farthest = dimension == 3, dimension - 1, reach * reach
    for row in prange(points.shape[1]):
        i = np.uint64(row)
        x, y, z = points[last, i], points[last - 1, i], points[0, i]
        middle = cell_at((y - low[last - 1]) / edge[last - 1], shape[last - 1])
        layer = cell_at((z - low[0]) / edge[0], shape[0]) if deep else 0
        layers, least = shape[0] if deep else 1, farthest
        for k in range(max(layer - 1, 0), min(layer + 2, layers)):
            for m in range(max(middle - 1, 0), min(middle + 2, shape[last - 1])):
                line = (k * shape[last - 1] + m) * shape[last]
                begin = start[line + cell_at((x - reach - low[last]) / edge[last], shape[last])]
                end = start[line + cell_at((x + reach - low[last]) / edge[last], shape[last]) + 1]
                for number in range(begin, end):
                    n = np.uint64(number)
                    along, across = place[last, n] - x, place[last - 1, n] - y
                    square = along * along + across * across
                    if deep:
                        square += (place[0, n] - z) ** 2
                    if square < farthest:
                        weight = kernels.wendland_c2_value(math.sqrt(square) * inverse)
                        for value in range(values.shape[1]):
                            sums[i, value] += weight * values[n, value]
                        if square < least:
                            least = square
                            nearest[i] = number


Load = tuple[Array, Array]
"""Force and torque, (3,) each."""
Forces = tuple[Array, Array]
"""Forces and the places where they act, (3, n) each."""


def exchanged_loads(
    now: Parameters, state: State, workspace: Workspace, movers: bool = False, on_dummies: Forces | None = None
) -> dict[int, Load]:
    """The force and torque to add to those of pairs, by owner; with `movers`, only for bodies and the solids that they
    touch. `on_dummies` are the pressure forces of pairs on all dummies, if known.
    """
    solids, found = solids_now(now, state.pose), dict[int, Load]()
    owner = now.boundary.dummies.owner
    first = now.bodies.first if movers else 0
    for mine in solids:
        if (movers and not mine.moves) or isinstance(mine.shape, Hollow):
            continue  # The excess of a basin over its pair sum belongs to places far from the solids in it.
        local, normal, area = mine.panels
        points = mine.middle + product(local, mine.turn.T)
        gaps = gaps_of(now, solids, mine, points)
        least = {owner: float(gap.min()) for owner, gap in gaps.items()}
        share = _share(now, min(least.values(), default=np.inf))
        if share <= 0.0:
            continue
        gap = np.min(list(gaps.values()), axis=0)
        narrow = gap < now.spacing
        if narrow.any():
            ahead = product(normal[narrow], mine.turn.T)
            narrow[narrow] = _faces(now, solids, mine, (points[narrow], ahead), gap[narrow])
        pressure = pressures_at(now, state, workspace, points, narrow)
        if not mine.moves:
            pressure[gap < SEALED * now.spacing] = 0.0
        force = np.zeros((3, len(points)))
        force[: now.dimension] = -(pressure * area) * product(normal, mine.turn.T).T
        place = np.zeros((3, len(points)))
        place[: now.dimension] = points.T
        center = now.boundary.centers[mine.owner]
        integral = total(force, place, center)
        on_dummies = on_dummies or forces_on_dummies(now._replace(friction=None), workspace, first)
        pushed, at = (each[:, owner[first:] == mine.owner] for each in on_dummies)
        by_pairs = total(pushed, at, center)
        more = share * (integral[0] - by_pairs[0]), share * (integral[1] - by_pairs[1])
        exchanged = [*_shared(now, mine, least, more)]
        if not movers:
            exchanged += _along_walls(now, mine, least, on_dummies)
        for owner_of, load in exchanged:
            had = found.get(owner_of, (np.zeros(3), np.zeros(3)))
            found[owner_of] = had[0] + load[0], had[1] + load[1]
    return found


def _along_walls(
    now: Parameters, mine: Solid, least: dict[int, float], on_dummies: Forces
) -> Iterator[tuple[int, Load]]:
    """Yield the loads that correct the forces along walls near a solid that touches two walls. Half of the force on the
    dummies of a wall along this wall is moved to the wall across it.

    Where liquid ends on a wall, the force of pairs along the wall is twice the force that pairs across any other
    section of the liquid transmit to the wall: half of it acts between parts of the wall. In a corner of the tank it
    acts on the dummies there (`bearer`). The solid itself has the force of its surface integral alone.
    """
    boundary, (force, place) = now.boundary, on_dummies
    sides = {owner: _share(now, gap) for owner, gap in least.items() if owner < 2 * now.dimension}
    for wall, touched in sides.items():
        of_wall = boundary.dummies.bearer == wall
        if touched == 0.0 or not of_wall.any():
            continue
        near = of_wall.any(axis=0)
        near[near] = mine.gap(place[: now.dimension, near].T) < now.support
        for other, share in sides.items():
            axis = other // 2
            if axis == wall // 2 or share == 0.0:
                continue
            opposite = sides.get(other ^ 1, 0.0)
            part = 0.5 * min(touched, max(share, opposite)) * share / (share + opposite)
            along = np.zeros((3, int(near.sum())))
            along[axis] = part * force[axis, near] * of_wall[axis, near]
            yield other, total(along, place[:, near], boundary.centers[other])
            yield wall, total(-along, place[:, near], boundary.centers[wall])


def _shared(now: Parameters, mine: Solid, least: dict[int, float], more: Load) -> Iterator[tuple[int, Load]]:
    """Yield the additional loads of a solid and of its neighbors, which add up to zero: see `_portions`. Each of two
    solids gets half of its difference, and the opposite of half of the other's. Neighbors are the walls in reach, and
    the nearest solid, since a more distant solid may not touch anything.
    """
    centers, (force, torque) = now.boundary.centers, more
    nearest = min((gap for owner, gap in least.items() if owner >= 2 * now.dimension), default=np.inf)
    nearest += 1e-9 * abs(nearest)  # solids may overlap: their gap is negative
    weight = {
        owner: share
        for owner, gap in least.items()
        if (share := _share(now, gap)) > 0.0 and (owner < 2 * now.dimension or gap <= nearest)
    }
    portions = np.array([_portions(now, weight, axis) for axis in range(3)]).T
    whole = sum(weight.values())
    for other, portion in zip(weight, portions, strict=True):
        once = 1.0 if other < 2 * now.dimension else 0.5
        part, turn = once * portion * force, once * weight[other] / whole * torque
        yield mine.owner, (part, turn)
        yield other, (-part, -turn - np.cross(centers[mine.owner] - centers[other], part))


def _share(now: Parameters, gap: float) -> float:
    """The weight of the integral at a smallest gap."""
    return float(share_at(now, np.array(gap)))


def share_at(now: Parameters, gap: Array) -> Array:
    """One up to a gap of half a support, zero from a whole support on."""
    found: Array = np.clip(2.0 - 2.0 * gap / now.support, 0.0, 1.0)
    return found


def _portions(now: Parameters, weight: dict[int, float], axis: int) -> list[float]:
    """The part of a force along an axis that is exchanged with each neighbor: with walls across the axis in proportion
    to the contact of the solid with them, and the remainder with all neighbors.
    """
    across = [share * (owner < 2 * now.dimension and owner // 2 == axis) for owner, share in weight.items()]
    most, total_across, whole = max(across), sum(across) or 1.0, sum(weight.values())
    return [
        most * wall / total_across + (1.0 - most) * share / whole
        for wall, share in zip(across, weight.values(), strict=True)
    ]


def power_on_bodies(now: Parameters, state: State, workspace: Workspace) -> float:
    """The power (W) of the exchanged loads on bodies, which is not contained in the forces of pairs."""
    bodies, first = len(now.bodies.shapes), len(now.boundary.names) - len(now.bodies.shapes)
    found = exchanged_loads(now, state, workspace, movers=True) if workspace.exchanged is None else workspace.exchanged
    power, driven = 0.0, {body for body, _ in now.bodies.paths}
    for body in range(bodies):
        if body in driven:
            continue
        force, torque = found.get(first + body, (np.zeros(3), np.zeros(3)))
        power += float(np.sum(force * state.motion[:3, body]) + np.sum(torque * state.motion[3:, body]))
    return power
