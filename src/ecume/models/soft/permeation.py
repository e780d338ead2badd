"""The liquid that permeates a packing between walls: its pressure in layers, and its forces on the spheres.

Liquid and spheres are incompressible, so that their total flux Q normal to the walls is the same everywhere. It is that
of an undrained wall, which moves with the liquid; if both ends are drained, Q is such that the pressures at both ends
are equal. Relative to spheres with the mean velocity v, the liquid of a layer then flows with Q - v, which requires the
pressure gradient dp/dy = (eta/k) (v - Q): Darcy's law, integrated once. The force on the spheres is -dp/dy per volume
of the layer, and is divided among spheres by their volumes in the layer.

The force of a layer, f = A dy dp/dy, is an unknown of each stage, in addition to the positions:

    f / zeta = sum of b_i v_i - Q,    zeta = A dy eta / k,    force on sphere i: -b_i f.

This is a symmetric resistance: the liquid dissipates the sum of f^2 / zeta. It resists only mean velocities, since
films resist the relative velocities of neighbors.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import admit, compiled, compiled_inside, selection, where_there
from ecume.engine.array_copies import copy_line
from ecume.laws import permeability
from ecume.laws.permeability import PERMEABILITIES
from ecume.models.law_codes import codes
from ecume.models.soft.contacts.walls import Places, Walls
from ecume.models.soft.integration.bordered_system import Borders
from ecume.models.soft.integration.dirk_schemes import Scheme
from ecume.models.soft.medium import OPEN, Medium
from ecume.units import Array

admit(permeability)

permeability_by = selection(
    "permeability_by", codes(PERMEABILITIES, lambda row: row.law), __name__, __file__,
    ("solid_fraction", "diameter", "medium"),
)  # fmt: skip

ROUNDING = 1e-15
"""The rounding error of a displacement, over the largest coordinate."""


class Permeation(NamedTuple):
    """The layers in a step."""

    medium: Medium
    held: NDArray[np.bool_]
    """(N,) whether films connect the sphere to a wall; others are suspended, and stay where they are"""
    share: Array
    """(N, L) parts b of the spheres in the mean velocity of a layer"""
    fraction: Array
    """(L,) the fraction of the layer that is solid"""
    resistance: Array
    """(L,) zeta (N s/m); 0 without spheres"""
    force: Array
    """(L,) f (N): the rise of the pressure across a layer times its area"""
    before: Array
    """(L,) at the start of the step"""
    start: Array
    """(N,) m along the axis: displacement at the start of the stage"""
    slope: Array
    """(S, N) m/s at each stage"""
    past: Array
    """(N,) m/s at the end of the last step"""
    flux: Array
    """(1,) m: Q times the time span of the stage, where both ends are drained"""
    change: Array
    """(L + 1,) of the forces, and of the flux, in Newton's step"""


def make_permeation(medium: Medium, held: NDArray[np.bool_], now: tuple[Array, Array], stages: int) -> Permeation:
    """The layers at the start of a step; `now` contains the forces of layers and the velocities of spheres."""
    count, layers = len(held), medium.layers
    force, velocity = now
    return Permeation(
        medium=medium,
        held=held,
        share=np.zeros((count, layers)),
        fraction=np.zeros(layers),
        resistance=np.zeros(layers),
        force=force.copy(),
        before=force.copy(),
        start=np.zeros(count),
        slope=np.zeros((stages, count)),
        past=velocity.copy(),
        flux=np.zeros(1),
        change=np.zeros(layers + 1),
    )


@compiled_inside
def ends_of(medium: Medium, places: Places) -> tuple[float, float]:
    """The ends of the layers."""
    axis, place = medium.axis, places.place
    if medium.lower == OPEN:
        return place[medium.upper, axis] - medium.height, place[medium.upper, axis]
    if medium.upper == OPEN:
        return place[medium.lower, axis], place[medium.lower, axis] + medium.height
    return place[medium.lower, axis], place[medium.upper, axis]


@compiled_inside
def part_below(height: float, radius: float) -> float:
    """The part of a sphere below a plane at this height over its center.

    >>> part_below(0.0, 2.0), part_below(-1.0, 1.0), part_below(3.0, 2.0)
    (0.5, 0.0, 1.0)
    """
    s = min(max(height / radius, -1.0), 1.0)
    return 0.25 * (1.0 + s) ** 2 * (2.0 - s)


@where_there()
def permeation_response(permeation: Permeation, walls: Walls, position: Array) -> None:
    """Compute shares, solid fractions and resistances of the layers at the present positions, and the force of the
    liquid on an undrained wall. Each sphere contributes to a layer by its volume there; the two end layers extend
    beyond the ends.
    """
    medium, share, fraction, resistance = (
        permeation.medium,
        permeation.share,
        permeation.fraction,
        permeation.resistance,
    )
    places = walls.places
    (begin, end), axis, layers = ends_of(medium, places), medium.axis, medium.layers
    thick = (end - begin) / layers
    solid, wetted, carried = np.zeros(layers), np.zeros(layers), np.zeros(layers)
    for i in range(len(position)):
        below = 0.0
        for layer in range(layers):
            above = 1.0
            if layer < layers - 1:
                above = part_below(begin + (layer + 1) * thick - position[i, axis], medium.radius[i])
            part, below = above - below, above
            share[i, layer] = part * medium.volume[i] if permeation.held[i] else 0.0
            solid[layer] += part * medium.volume[i]
            wetted[layer] += part * medium.surface[i]
            carried[layer] += share[i, layer]
    total = 0.0
    for layer in range(layers):
        fraction[layer], resistance[layer] = solid[layer] / (medium.area * thick), 0.0
        if carried[layer] > 0.0:
            diameter = 6.0 * solid[layer] / wetted[layer]
            passes = permeability_by(fraction[layer], diameter, medium, medium.law)
            resistance[layer] = medium.area * thick * medium.viscosity / passes
            for i in range(len(position)):
                share[i, layer] /= carried[layer]
        total += permeation.force[layer]
    if medium.closed != OPEN:
        places.lift[medium.closed, axis] = total


@where_there(0.0)
def add_seepage(permeation: Permeation, right: Array) -> float:
    """Add the forces of the liquid to the residuals of spheres. Returns the largest."""
    share, force, axis, largest = permeation.share, permeation.force, permeation.medium.axis, 0.0
    for i in range(len(share)):
        pushed = 0.0
        for layer in range(len(force)):
            pushed += share[i, layer] * force[layer]
        right[i, axis] -= pushed
        largest = max(largest, abs(pushed))
    return largest


@compiled_inside
def carried_along(permeation: Permeation, places: Places) -> float:
    """The displacement of liquid and spheres together since the start of the stage (m)."""
    closed, axis = permeation.medium.closed, permeation.medium.axis
    if closed == OPEN:
        return float(permeation.flux[0])
    return float(places.place[closed, axis] - places.start[closed, axis])


@compiled
def unmet_flow(permeation: Permeation, places: Places, moved: Array, span: float) -> tuple[Array, Array]:
    """The residual of Darcy's law for each layer over the time span of a stage (m), and the largest residual that
    rounding and the tolerance of forces explain. Over a time span of zero, spheres and liquid do not move relative to
    each other.
    """
    share, force, resistance = permeation.share, permeation.force, permeation.resistance
    axis, along = permeation.medium.axis, carried_along(permeation, places)
    missing, size, largest = np.zeros(len(force)), np.zeros(len(force)), abs(along)
    for layer in range(len(force)):
        if resistance[layer] > 0.0:
            missing[layer] = -along - span * force[layer] / resistance[layer]
            for i in range(len(share)):
                step = share[i, layer] * (moved[i, axis] - permeation.start[i])
                missing[layer] += step
                largest = max(largest, abs(step))
            largest = max(largest, span * abs(force[layer]) / resistance[layer])
    begin, end = ends_of(permeation.medium, places)
    far = max(abs(begin), abs(end))
    for layer in range(len(force)):
        size[layer] = FLOW_BALANCE * largest + ROUNDING * far
    return missing, size


FLOW_BALANCE = 1e-9
"""The largest permitted residual of Darcy's law over the largest displacement."""


@where_there(0.0)
def flow_residual(permeation: Permeation, walls: Walls, moved: Array, span: float) -> float:
    """The largest residual of Darcy's law, over the permitted one."""
    missing, permitted = unmet_flow(permeation, walls.places, moved, span)
    worst = 0.0
    for layer in range(len(missing)):
        if missing[layer] != 0.0:
            worst = max(worst, abs(missing[layer]) / permitted[layer])
    return worst


def layer_unknowns(permeation: Permeation | tuple[()]) -> int:
    """The number of unknowns of the layers: their forces and, where both ends are drained, the flux."""
    return permeation.medium.layers + (permeation.medium.closed == OPEN) if permeation else 0


def fill_layer_borders(permeation: Permeation, places: Places, moved: Array, span: float, borders: Borders) -> None:
    """Fill the borders of the system for the forces of layers, after those of movable walls.

    The law of a layer is b . x - g - span f / zeta = 0, where g is the displacement of the undrained wall or the flux:
    its row is minus the column of its forces.
    """
    medium, (left, corner), first = permeation.medium, (borders.left, borders.corner), len(places.free)
    last = first + medium.layers
    corner[first : last + 1, : last + 1] = corner[: last + 1, first : last + 1] = 0.0
    borders.right[1 + first : 1 + last] = borders.rows[first:last] = 0.0
    borders.right[1 + first : 1 + last, :, medium.axis] = -permeation.share.T
    borders.rows[first:last, :, medium.axis] = permeation.share.T
    left[first:last], _ = unmet_flow(permeation, places, moved, span)
    for layer, resistance in enumerate(permeation.resistance):
        row = first + layer
        corner[row, row] = -span / resistance if resistance > 0.0 else -1.0
        left[row] -= 0.0 if resistance > 0.0 else permeation.force[layer]
    coupled = first + np.flatnonzero(permeation.resistance > 0.0)
    moving = [place for place, (wall, axis) in enumerate(places.free) if (wall, axis) == (medium.closed, medium.axis)]
    if medium.closed == OPEN:
        left[last] = -permeation.force.sum()
        borders.right[1 + last] = borders.rows[last] = 0.0
        moving = [last]
    for unknown in moving:
        corner[coupled, unknown] = corner[unknown, coupled] = -1.0


def change_layers(permeation: Permeation, found: Array) -> None:
    """Store the change of the unknowns for the next move."""
    permeation.change[:] = 0.0
    permeation.change[: len(found)] = found


# --- The layers through the stages of a step


@where_there()
def move_layers(permeation: Permeation, part: float) -> None:
    """Add a fraction of Newton's step to the forces of layers and to the flux."""
    layers = permeation.medium.layers
    for layer in range(layers):
        permeation.force[layer] += part * permeation.change[layer]
    permeation.flux[0] += part * permeation.change[layers]


@where_there()
def first_layers(permeation: Permeation) -> None:
    """Reset the layers to the start of the step."""
    copy_line(permeation.force, permeation.before)
    copy_line(permeation.slope[0], permeation.past)
    for i in range(len(permeation.start)):
        permeation.start[i] = 0.0
    permeation.flux[0] = 0.0
    for unknown in range(len(permeation.change)):
        permeation.change[unknown] = 0.0


@where_there()
def begin_layers(permeation: Permeation, row: Array, time_step: float) -> None:
    """Set the displacements of spheres at the start of a stage."""
    start, slope = permeation.start, permeation.slope
    for i in range(len(start)):
        start[i] = 0.0
        for earlier in range(len(row)):
            start[i] += time_step * row[earlier] * slope[earlier, i]


@where_there()
def end_layers(permeation: Permeation, moved: Array, stage: int, span: float) -> None:
    """Compute the velocities of spheres in a solved stage."""
    for i in range(len(permeation.start)):
        permeation.slope[stage, i] = (moved[i, permeation.medium.axis] - permeation.start[i]) / span


@where_there(0.0)
def layer_error(permeation: Permeation, scheme: Scheme, time_step: float) -> float:
    """The largest difference from the embedded scheme, of the mean displacement of a layer over the smallest radius."""
    share, slope, least = permeation.share, permeation.slope, math.inf
    largest = 0.0
    for layer in range(share.shape[1]):
        value = 0.0
        for i in range(len(share)):
            for stage in range(len(scheme.error)):
                value += scheme.error[stage] * share[i, layer] * slope[stage, i]
        largest = max(largest, abs(time_step * value))
    for i in range(len(share)):
        least = min(least, permeation.medium.radius[i])
    return largest / least


@where_there()
def accept_layers(permeation: Permeation) -> None:
    """Start the next step of the layers."""
    copy_line(permeation.before, permeation.force)
    copy_line(permeation.past, permeation.slope[-1])


@where_there((0.0, 0.0))
def seepage_powers(permeation: Permeation, walls: Walls, stage: int) -> tuple[float, float]:
    """The dissipation by permeation, and the power of the undrained wall that drives the liquid (W)."""
    medium, dissipated, total = permeation.medium, 0.0, 0.0
    for layer in range(medium.layers):
        if permeation.resistance[layer] > 0.0:
            dissipated += permeation.force[layer] ** 2 / permeation.resistance[layer]
            total += permeation.force[layer]
    if medium.closed == OPEN:
        return dissipated, 0.0
    return dissipated, -float(total * walls.places.slope[stage, medium.closed, medium.axis])


def pore_pressures(permeation: Permeation) -> Array:
    """The pore pressure between layers, from the lower end to the upper one, (L + 1,) in Pa, in 2D N/m; zero at a
    drained end.
    """
    medium = permeation.medium
    found = np.concatenate([[0.0], np.cumsum(permeation.before)]) / medium.section
    return np.asarray(found - found[-1] if medium.closed != OPEN and medium.closed == medium.lower else found)
