"""The compression of dummies at and near free bodies by the liquid, which the liquid around them takes up.

The force of a dummy w on a particle i contains P_i and P_w. The part with P_i does the work that the equation of
continuity of i stores. The part with P_w = sum_j c_wj (P_j + rho g.x_jw), with c_wj = W_wj / sum_k W_wk (Adami, Hu and
Adams 2012, eq. 27), does the work P_w V_w C_w at the compression C_w of the dummy, its sum of continuity over the
liquid. A dummy stores no energy. Forces and continuity are adjoint, so that pressure neither creates nor destroys
energy, if the particles from which the pressure is read take up this compression:

    sum_j V_j P_j C_j' = sum_w V_w C_w sum_j c_wj P_j,   C_j' = sum_w (V_w / V_j) c_wj C_w.

(Bonet and Lok 1999 derive the forces between particles from the same condition.) C' also completes the divergence:
dummies move with their solid, so that a particle at a wall sees only half of an expansion along the wall, and the
dummies the other half. Without it, liquid in a gap narrower than a spacing, between a sinking box and a floor, gained a
third of the potential energy of a tank.

Dummies of walls, obstacles and driven bodies take part near a free body, where they bound the gap that it closes; this
is blended out where the distance from the body is between half a support and a whole one. Elsewhere their work remains
work of the numerical method: liquid that slides along a wall compresses disordered dummies at random. With C' at all
walls a cavity whose lid moves lost 7 % of its kinetic energy, and the front of a dam break was 10 % too fast.

A dummy whose pressure is clipped to zero does no work, and its compression has no effect. The weight of the liquid
between w and j remains: see `report.energy_budget.power_of_dummies`. [adami2012, bonet1999]
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import compiled_inside, prange, spread
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists
from ecume.models.sph.boundaries.touching_solids import share_at, solids_now
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.fill_fields import NOTHING, read_from_sources
from ecume.models.sph.rates.kernel_loops import slope_of, value_of
from ecume.models.sph.state import State, Workspace
from ecume.units import Array


def takes_up(parameters: Parameters) -> bool:
    """Whether the liquid takes up the compression of dummies: of free bodies, in forces that are sums of two pressures
    of one liquid.
    """
    alone = parameters.second is None and not parameters.pressure_force.transported
    free = len(parameters.bodies.shapes) > len(parameters.bodies.paths)
    return alone and free and parameters.pressure_method.compressible


def shares(now: Parameters, pose: Array) -> Array:
    """The part (D,) of the compression of each dummy that the liquid takes up."""
    first, place = len(now.boundary.names) - len(now.bodies.shapes), now.boundary.dummies.position.T
    driven, found = {first + body for body, _ in now.bodies.paths}, np.zeros(len(place))
    for solid in solids_now(now, pose):
        if not solid.moves or solid.owner in driven:
            continue
        reach = float(np.sqrt((solid.panels[0] ** 2).sum(axis=1).max())) + now.support
        near = ((place - solid.middle) ** 2).sum(axis=1) < reach**2
        found[near] = np.maximum(found[near], share_at(now, solid.gap(place[near])))
    return found


def taken_up(now: Parameters, state: State, workspace: Workspace) -> Array:
    """The compressions C' (N,) of the liquid, in the unit of `Rates.continuity`, from filled fields."""
    fields, lists, by_mass = workspace.fields, workspace.lists, now.pressure_force.by_mass
    passed, found = np.zeros(fields.shape[1], fields.table.dtype), np.zeros(len(state.density))
    share = shares(now, state.pose)
    mine = np.flatnonzero(share)
    rules = now.walls_clip, by_mass
    compress(fields.table, len(found) + mine, share[mine], lists, now.constants, rules, passed)
    read_from_sources(passed, workspace.images, len(lists.counts))
    take_up(fields.table, lists, now.constants, by_mass, passed, found)
    return found


@compiled_inside
def apart_of(fields: Floats, i: int, j: int) -> tuple[float, float, float]:
    """The vector from particle i to j."""
    return (
        fields[FIELD.position, j] - fields[FIELD.position, i],
        fields[FIELD.position + 1, j] - fields[FIELD.position + 1, i],
        fields[FIELD.position + 2, j] - fields[FIELD.position + 2, i],
    )


@compiled_inside
def counted_as(fields: Floats, i: int, by_mass: bool) -> float:
    """The factor of a pressure in the power of a compression: V, or m/rho^2 of sums by mass."""
    found: float = fields[FIELD.weight, i]
    if by_mass:
        found /= fields[FIELD.density, i] * fields[FIELD.density, i]
    return found


@spread
def compress(
    fields: Floats, mine: Integers, share: Array, lists: Lists, constants: Constants, rules: tuple[bool, bool],
    passed: Floats,
) -> None:  # fmt: skip
    """Set V_w C_w / sum W of some dummies, times their shares."""
    kernel, scale, inverse = constants[0].kernel, constants[0].slope_factor, constants[0].inverse_length
    counts, start, neighbor = lists
    clips, by_mass = rules
    for place in prange(len(mine)):
        dummy = mine[place]
        if clips and fields[FIELD.enthalpy, dummy] <= 0.0:
            continue
        around, rate = 0.0, 0.0
        for k in range(counts[dummy]):
            j = neighbor[start[dummy] + k]
            if fields[FIELD.liquid, j] == 0.0:
                continue
            dx, dy, dz = apart_of(fields, dummy, j)
            q = math.sqrt(dx * dx + dy * dy + dz * dz) * inverse
            around += value_of(q, kernel)
            radial = (fields[FIELD.velocity, j] - fields[FIELD.velocity, dummy]) * dx
            radial += (fields[FIELD.velocity + 1, j] - fields[FIELD.velocity + 1, dummy]) * dy
            radial += (fields[FIELD.velocity + 2, j] - fields[FIELD.velocity + 2, dummy]) * dz
            rate += slope_of(q, kernel) * fields[FIELD.weight, j] * radial
        if around > NOTHING:
            passed[dummy] = share[place] * counted_as(fields, dummy, by_mass) * scale * rate / around


@spread
def take_up(
    fields: Floats, lists: Lists, constants: Constants, by_mass: bool, passed: Floats, found: Array
) -> None:  # fmt: skip
    """Sum what dummies give to the particles of the liquid."""
    kernel, inverse = constants[0].kernel, constants[0].inverse_length
    counts, start, neighbor = lists
    for i in prange(len(found)):
        total = 0.0
        for k in range(counts[i]):
            j = neighbor[start[i] + k]
            if passed[j] != 0.0:
                dx, dy, dz = apart_of(fields, i, j)
                total += value_of(math.sqrt(dx * dx + dy * dy + dz * dz) * inverse, kernel) * passed[j]
        if total != 0.0:
            found[i] = total / counted_as(fields, i, by_mass)
