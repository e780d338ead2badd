"""Particle shifting: a transport velocity relative to the liquid that keeps the particles evenly spaced."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import prange, spread, summing
from ecume.engine.neighbor_rows import Lists
from ecume.engine.shapes import Flags
from ecume.laws.incompressible import shifting_coefficient, tensile_weight
from ecume.models.sph.fields import FIELD, RATE, Constants, Floats
from ecume.models.sph.integration.particle_loops import largest
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.kernel_types import slope_of, value_of
from ecume.models.sph.state import State, Workspace
from ecume.units import Array

INDEX = np.uint64

SURFACE = 0.75
"""A particle with a divergence of position below this fraction of the full one is at the surface."""
MOST = 0.5
"""The largest transport velocity, over the largest flow speed."""


def shift(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Compute the transport velocity of the next drift."""
    lists = workspace.lists
    sum_concentration_gradient(workspace.fields.table, lists, parameters.constants, workspace.rates.table)
    gradient = workspace.rates.concentration_gradient[: parameters.dimension].astype(np.float64)
    state.transport[...] = SHIFTINGS[parameters.shifting].transport(parameters, state, workspace, gradient, time)
    if not parameters.fixed_volume:
        keep_volume(state, workspace.rates.even_concentration_gradient[: parameters.dimension].astype(np.float64), time)


def keep_volume(state: State, gradient: NDArray[np.floating], time: float) -> None:
    """Reduce the density by the mean of 2 W.sum_j V_j F x_ij over particles with a transport velocity W; dummies count
    half.

    The equation of continuity includes the compression by the flow, but not the spreading by the transport velocity:
    without this correction the whole volume shrinks, by a percent in a few turns of a vortex. The sum is the difference
    of div W by sums and div W by differences (Sun et al. 2019, eq. 5); applied particle by particle it would be noise
    in the pressure. [sun2019]

    The factor of one half: for a pair of liquid particles, W_i and W_j enter the sums of differences of both, which
    over all pairs is twice W_i.F x_ij; a dummy has no W, and no sum that W_i could enter.
    """
    spread = (state.transport * gradient).sum(axis=0)
    moved = (state.transport != 0.0).any(axis=0)
    count = int(moved.sum())
    if count:
        state.density[moved] *= 1.0 - 2.0 * time * float(spread.sum()) / count


def of_background(parameters: Parameters, state: State, workspace: Workspace, gradient: Array, time: float) -> Array:
    """Half a step's velocity from a background pressure p_b: (dt/2) (2 p_b / rho) sum_j V_j F x_ij (Adami et al. 2013,
    eq. 13, with equal volumes).
    """
    return time * parameters.background / state.density * gradient


def delta_plus(parameters: Parameters, state: State, workspace: Workspace, gradient: Array, time: float) -> Array:
    """4 h u sum_j (1 + 0.2 (W/W(dx))^4) V_j F x_ij, no faster than half the fastest speed u, and zero near a surface
    (Sun et al. 2017). Less in a step in which particles would move beyond the middle between their neighbors.
    """
    fastest = fastest_speed(parameters, state)
    strongest = parameters.shifting_limit / time
    transport = min(shifting_coefficient(parameters.numbers.smoothing_length, fastest), strongest) * gradient
    speed = np.sqrt((transport**2).sum(axis=0))
    limited: Array = transport * np.minimum(1.0, MOST * fastest / np.maximum(speed, 1e-300))
    limited[:, near_surface(parameters, workspace)] = 0.0
    return limited


def fastest_speed(parameters: Parameters, state: State) -> float:
    """The largest speed of the flow (m/s), at most the expected maximum."""
    return min(parameters.material.fastest, largest(state.velocity))


def shifts_needed(parameters: Parameters, state: State, time: float) -> int:
    """The number of equal shifts into which a step of this time is divided, so that none
    overshoots.

    Steps that resolve sound waves need one; those of incompressible liquids are about ten times as long.
    """
    coefficient = shifting_coefficient(parameters.numbers.smoothing_length, fastest_speed(parameters, state))
    return max(1, math.ceil(coefficient * time / parameters.shifting_limit))


def near_surface(parameters: Parameters, workspace: Workspace) -> Flags:
    """Flags of the particles at the surface, and of all that have one of them in their support."""
    lists, images = workspace.lists, workspace.images
    liquid = workspace.rates.shape[1]
    real = len(lists.counts)
    at_surface = np.zeros(real + len(images.source), np.bool_)
    at_surface[:liquid] = workspace.rates.fullness < SURFACE * parameters.dimension
    # One side after the other: an image may copy an image of an earlier side.
    for first, last in zip(images.start[:-1], images.start[1:], strict=True):
        at_surface[real + first : real + last] = at_surface[images.source[first:last]]
    near = at_surface[:liquid].copy()
    spread_flags(near, at_surface, lists)
    return near


@summing
def sum_concentration_gradient(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
    """Sum the reversed concentration gradient sum_j V_j F x_ij, zero in a lattice, and the fullness -sum_j V_j F r^2.

    The even sum has equal weights and counts dummies half (see `keep_volume`).

    With a reference value W(dx) each neighbor counts `tensile_weight` times in the first.
    """
    kernel, deep, inverse, scale = (
        constants[0].kernel,
        constants[0].dimension == 3,
        constants[0].inverse_length,
        constants[0].slope_factor,
    )
    tensile = 1.0 / constants[0].reference_value if constants[0].reference_value > 0.0 else 0.0
    counts, neighbor = lists
    for particle in prange(rates.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        ax, ay, az, space = 0.0, 0.0, 0.0, 0.0
        bx, by, bz = 0.0, 0.0, 0.0
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz, volume = (
                fields[FIELD.position, j] - x,
                fields[FIELD.position + 1, j] - y,
                fields[FIELD.position + 2, j] - z,
                fields[FIELD.volume, j],
            )
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            q = math.sqrt(square) * inverse
            pull = slope_of(q, kernel) * volume
            space -= pull * square
            even = pull * (0.5 + 0.5 * fields[FIELD.liquid, j])
            bx += even * dx
            by += even * dy
            bz += even * dz
            pull *= tensile_weight(value_of(q, kernel) * tensile)
            ax += pull * dx
            ay += pull * dy
            az += pull * dz
        rates[RATE.fullness, i] = scale * space
        rates[RATE.concentration_gradient, i] = scale * ax
        rates[RATE.concentration_gradient + 1, i] = scale * ay
        rates[RATE.concentration_gradient + 2, i] = scale * az
        rates[RATE.even_concentration_gradient, i] = scale * bx
        rates[RATE.even_concentration_gradient + 1, i] = scale * by
        rates[RATE.even_concentration_gradient + 2, i] = scale * bz


@spread
def spread_flags(near: Flags, flags: Flags, lists: Lists) -> None:
    """Flag all particles with a flagged neighbor."""
    counts, neighbor = lists
    for i in prange(len(near)):
        for k in range(counts[i]):
            if flags[neighbor[i, k]]:
                near[i] = True


class Shifting(NamedTuple):
    """A shifting method."""

    transport: Callable[[Parameters, State, Workspace, Array, float], Array]
    """the transport velocity (d, N) of the next drift, relative to the liquid, from the concentration gradient"""
    tensile: bool
    """whether near neighbors have larger weights in the gradient: see `sum_concentration_gradient`"""


SHIFTINGS = {"none": Shifting(of_background, tensile=False), "delta-plus": Shifting(delta_plus, tensile=True)}
"""Shifting methods by name; with "none", a background pressure, if there is one, still spreads particles."""
