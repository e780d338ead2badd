"""The part of a step that solves for the pressure: the one that keeps the density of each particle.

With the excess s_i of the density over that at rest, and the compression c_i(v) by the flow, liquid with a free surface
has

    p_i >= 0,   s'_i + time c_i(v) <= 0,   p_i (s'_i + time c_i(v)) = 0,   s' = max(s, 0)/10 + min(s, 0) :

it resists compression, and not separation [gerszewski2013]. s_i counts what lacks above a flat surface as liquid, see
`missing_density`; a single drop may approach others until its density is that at rest. Liquid that fills its tank has
an equation without bounds, with a tenth of s_i, and the mean pressure zero.
"""

from __future__ import annotations

import math

import numpy as np

from ecume.laws.incompressible import correction, density_excess, free_correction
from ecume.models.sph.boundaries.prescribed_motion import instant
from ecume.models.sph.incompressible.complementarity import Problem, Solution, solve
from ecume.models.sph.incompressible.system import (
    System,
    accelerations,
    applied,
    assemble,
    known_compression,
    moving_compressions,
)
from ecume.models.sph.parameters import Parameters, Projection
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.report.energy_budget import forces_work, power_of_forces
from ecume.models.sph.state import ITERATIONS, MOST_ITERATIONS, RATE, RESIDUAL, WORST, State, Workspace
from ecume.units import Array


def project(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Solve for the pressure, and change the velocities by it."""
    settings = parameters.projection
    if settings is None:
        raise ValueError("got a compressible liquid; expected one with a Projection")
    now = instant(parameters, state)
    fill(now, state._replace(pressure=np.zeros_like(state.pressure)), workspace)
    system = assemble(now, settings, workspace, time)
    summed = density_excess(system.summed, settings.lattice_sum)
    excess = summed + missing_density(system, settings)
    stretch = moving_compressions(system, workspace, state.velocity)
    stretch += time * known_compression(now, system, state.position)
    corrected = free_correction(excess) if settings.free_surface else correction(excess)
    found = pressures(system, corrected + time * stretch, state.pressure, settings)
    state.pressure[...] = found.x
    state.velocity[...] += time * (system.resting + accelerations(system, found.x))
    counted = np.maximum(summed, 0.0) if settings.free_surface else summed
    state.density[...] = now.material.density * (1.0 + counted)
    record(state, found)
    if forces_work(parameters):
        fill(now, state, workspace)
        with np.errstate(over="ignore", invalid="ignore"):  # the integration reports what is not finite
            state.budget[RATE] = power_of_forces(now, state, workspace)


def missing_density(system: System, settings: Projection) -> Array:
    """What the density of particles at a free surface lacks because there is nothing above, over the density.

    It is that of a row of a lattice below a flat surface with the same sum of gradients. Where that sum is small, as in
    drops and between approaching surfaces, the density is low because particles are missing: these may approach.
    """
    if not settings.free_surface:
        return np.zeros(len(system.summed))
    found: Array = np.interp(system.steepness, settings.steepness, settings.missing)
    return found


def pressures(system: System, right: Array, guess: Array, settings: Projection) -> Solution:
    """The pressures, and the error that is left of the density of each particle.

    Unknowns are scaled with the diagonal of V A, where V are the volumes, so that the matrix is symmetric.
    """
    scale = 1.0 / np.sqrt(system.volume * system.diagonal)
    weight = scale * system.volume
    if not settings.free_surface:
        right = right - float(np.sum(system.volume * right) / np.sum(system.volume))

    def scaled(x: Array) -> Array:
        return weight * applied(system, scale * x)

    def error(gradient: Array) -> float:
        return math.sqrt(float(np.mean((gradient / weight) ** 2)))

    problem = Problem(scaled, weight * right, settings.free_surface, settings.step, error)
    found = solve(problem, guess / scale, settings.tolerance, settings.iterations)
    return found._replace(x=scale * found.x, gradient=found.gradient / weight)


def record(state: State, found: Solution) -> None:
    """Count iterations, and keep the error that is left."""
    state.tally[ITERATIONS] += found.iterations
    state.tally[MOST_ITERATIONS] = max(state.tally[MOST_ITERATIONS], found.iterations)
    state.tally[RESIDUAL] = found.error
    state.tally[WORST] = state.identity[int(np.argmax(np.abs(found.gradient)))]


def failed(parameters: Parameters, state: State) -> bool:
    """Whether the solver did not reach its tolerance in the last step."""
    return parameters.projection is not None and not state.tally[RESIDUAL] <= parameters.projection.tolerance
