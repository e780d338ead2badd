"""Particle shifting: a transport velocity relative to the liquid, which keeps the particles evenly spaced."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import prange, spread
from ecume.engine.neighbor_rows import Lists
from ecume.engine.shapes import Flags
from ecume.laws.incompressible import shifting_coefficient
from ecume.models.sph.integration.particle_loops import largest
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.concentration import CONCENTRATION
from ecume.models.sph.rates.sum_evaluation import evaluate_sum
from ecume.models.sph.state import State, Workspace
from ecume.units import Array

INDEX = np.uint64
SURFACE = 0.75
"""The divergence of position, over that in full surroundings, below which a particle is at the surface."""
MOST = 0.5
"""The largest shifting velocity, over the fastest speed of the flow."""


def shift(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Set the transport velocity of the next drift."""
    evaluate_sum(CONCENTRATION, parameters, workspace)
    concentration_gradient = workspace.rates.concentration_gradient[: parameters.dimension].astype(np.float64)
    state.transport[...] = SHIFTINGS[parameters.shifting].transport(
        parameters, state, workspace, concentration_gradient, time
    )
    if not parameters.fixed_volume:
        correct_for_spreading(
            state, workspace.rates.even_concentration_gradient[: parameters.dimension].astype(np.float64), time
        )


def correct_for_spreading(state: State, concentration_gradient: NDArray[np.floating], time: float) -> None:
    """Reduce the density by the mean of 2 W.sum_j V_j F x_ij over particles with a transport velocity W; dummies count
    half.

    The equation of continuity includes the compression by the flow, but not the spreading by the transport velocity:
    without this correction the whole volume shrinks, by a percent in a few turns of a vortex. The sum is the difference
    between div W in the form with sums and in the form with differences (Sun et al. 2019, eq. 5); applied to single
    particles it would add noise to the pressure. [sun2019]

    The factor of one half of dummies: in a pair of liquid particles, W_i and W_j are part of the sums of both
    particles, which over all pairs is twice W_i.F x_ij; a dummy has neither a W nor a sum.
    """
    spread = (state.transport * concentration_gradient).sum(axis=0)
    moved = (state.transport != 0.0).any(axis=0)
    count = int(moved.sum())
    if count:
        state.density[moved] *= 1.0 - 2.0 * time * float(spread.sum()) / count


def of_background(
    parameters: Parameters, state: State, workspace: Workspace, concentration_gradient: Array, time: float
) -> Array:
    """The change of velocity in half a step by a background pressure p_b: (dt/2) (2 p_b / rho) sum_j V_j F x_ij (Adami
    et al. 2013, eq. 13, with equal volumes).
    """
    return time * parameters.background / state.density * concentration_gradient


def delta_plus(
    parameters: Parameters, state: State, workspace: Workspace, concentration_gradient: Array, time: float
) -> Array:
    """The velocity 4 h u sum_j (1 + 0.2 (W/W(dx))^4) V_j F x_ij, at most half the fastest speed u, and zero near a
    surface (Sun et al. 2017). It is reduced in steps in which particles would move beyond the middle between their
    neighbors.
    """
    fastest = fastest_speed(parameters, state)
    strongest = parameters.shifting_limit / time
    transport = (
        min(shifting_coefficient(parameters.numbers.smoothing_length, fastest), strongest) * concentration_gradient
    )
    speed = np.sqrt((transport**2).sum(axis=0))
    limited: Array = transport * np.minimum(1.0, MOST * fastest / np.maximum(speed, 1e-300))
    limited[:, near_surface(parameters, workspace)] = 0.0
    return limited


def fastest_speed(parameters: Parameters, state: State) -> float:
    """The fastest speed of the flow (m/s), at most the maximum speed of the scene."""
    return min(parameters.material.fastest, largest(state.velocity))


def shifts_needed(parameters: Parameters, state: State, time: float) -> int:
    """The number of equal shifts into which a step of this time is divided, so that none of them
    overshoots.

    Steps that resolve sound waves need one; those of incompressible liquids are about ten times as long.
    """
    coefficient = shifting_coefficient(parameters.numbers.smoothing_length, fastest_speed(parameters, state))
    return max(1, math.ceil(coefficient * time / parameters.shifting_limit))


def near_surface(parameters: Parameters, workspace: Workspace) -> Flags:
    """Flags of the particles at the surface, and of all particles whose support contains one of these."""
    lists, images = workspace.lists, workspace.images
    liquid = workspace.rates.shape[1]
    real = len(lists.counts)
    at_surface = np.zeros(real + len(images.source), np.bool_)
    at_surface[:liquid] = workspace.rates.fullness < SURFACE * parameters.dimension
    # One side after the other, since images have images behind later sides.
    for first, last in zip(images.start[:-1], images.start[1:], strict=True):
        at_surface[real + first : real + last] = at_surface[images.source[first:last]]
    near = at_surface[:liquid].copy()
    spread_flags(near, at_surface, lists)
    return near


@spread
def spread_flags(near: Flags, flags: Flags, lists: Lists) -> None:
    """Flag all particles with a flagged neighbor."""
    counts, start, neighbor = lists
    for i in prange(len(near)):
        for k in range(counts[i]):
            if flags[neighbor[start[i] + k]]:
                near[i] = True


class Shifting(NamedTuple):
    """A shifting method."""

    transport: Callable[[Parameters, State, Workspace, Array, float], Array]
    """the transport velocity (d, N) of the next drift, relative to the liquid, from the concentration gradient"""
    tensile: bool
    """whether near neighbors have larger weights in the gradient: see `concentration.pair_concentration`"""


SHIFTINGS = {"none": Shifting(of_background, tensile=False), "delta-plus": Shifting(delta_plus, tensile=True)}
"""The shifting methods by name; with "none", only a background pressure, if there is one, shifts particles."""
UNIT = np.array([[1.0], [1.0], [1.0], [0.0], [0.0], [0.0]])
"""The unit matrix, for the correction in buffers, in which the liquid continues."""
