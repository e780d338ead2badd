"""How long a time step may be: from the stiffness of the pull between touching floats, and from their speed."""

from __future__ import annotations

import math

import numpy as np

from ecume.laws.capillarity import pair_strength
from ecume.laws.special import bessel_k0, bessel_k1
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    ONE_SIDED,
    OVERDAMPED,
    STRENGTH,
    SURFACE_TENSION,
    TABLED,
    Floats,
    Parameters,
)
from ecume.models.floating.wall_tables import HEIGHT, IMAGE
from ecume.units import Array

GOOD = 0.05
"""Time steps over the shortest time scale: the error of a step is then below a thousandth."""
LOOSEST_OVER_CHOSEN = 4.0
LARGEST_OVER_CHOSEN = 20.0
"""Beyond this the scheme is unstable."""
RAFT_NEIGHBORS = 6.0
PACKED = 0.9069
"""Of the surface that touching discs cover on a triangular lattice."""
SKIN_PER_STEP = 0.1
"""Nobody may go farther in a step, over the skin."""


def pair_stiffness(parameters: Parameters, reach: float, charges: float) -> float:
    """|dF/dl| = (S/L^2) (K0(x) + K1(x)/x) at the distance `reach` = x L, for a product of charges (N/m)."""
    length = parameters.pair[CAPILLARY_LENGTH]
    x = reach / length
    unit = parameters.pair[STRENGTH]
    if parameters.pair_law == ONE_SIDED:  # whose strength is no constant of the pair
        unit = pair_strength(float(parameters.pair[SURFACE_TENSION]), 1.0, 1.0)
    strength = abs(unit * charges)
    return parameters.stiffer * float(strength / length**2 * (bessel_k0(x) + bessel_k1(x) / x))


def stiffness_over_mass(parameters: Parameters) -> tuple[Array, Array]:
    """Of each distinct kind of float in the crowd's worst place: stiffness (N/m) and mass (kg)."""
    floats = parameters.floats
    kinds = np.unique(np.stack([floats.radius, np.abs(floats.charge), floats.mass], axis=1), axis=0)
    # The strongest partner of any kind bounds them all: a table of a thousand different floats costs a thousand
    # evaluations.
    strongest, smallest = float(np.max(kinds[:, 1])), float(np.min(kinds[:, 0]))
    wall = wall_stiffness(parameters)
    strongest_felt = np.full(len(kinds), strongest) if parameters.pair_law == ONE_SIDED else kinds[:, 1]
    stiffness = [
        2.0 * RAFT_NEIGHBORS * pair_stiffness(parameters, radius + smallest, felt * strongest) + wall
        for radius, felt in zip(kinds[:, 0], strongest_felt, strict=True)
    ]
    return np.array(stiffness), kinds[:, 2]


def wall_stiffness(parameters: Parameters) -> float:
    """|dF/dd| of the walls on whom they act upon most (N/m), as near as the smallest float comes."""
    strongest = float(np.max(np.abs(parameters.wall_strength), initial=0.0))
    if parameters.wall_law != TABLED:
        return strongest / float(parameters.pair[CAPILLARY_LENGTH]) ** 2
    floats, distance = parameters.floats, parameters.wall_table[1]
    near = distance >= float(np.min(floats.radius))
    stiffness = 0.0
    for row, strength in ((HEIGHT, strongest), (IMAGE, parameters.image_strength * float(np.max(floats.charge**2)))):
        force = parameters.wall_table[row + 1] / distance
        stiffness += strength * float(np.max(np.abs(np.gradient(force, distance)[near])))
    return stiffness


def chosen_step(parameters: Parameters, speed: float) -> float:
    """The longest good step (s).

    A float on a spring k turns back after about sqrt(m/k), or relaxes in zeta/k where drag rules; the kick takes drag
    exactly, so that the longer of the two counts: syrup needs no tinier step than water.
    """
    stiffness, mass = stiffness_over_mass(parameters)
    friction = _least_friction(parameters.floats)
    slow = parameters.scheme == OVERDAMPED
    scales = [
        max(0.0 if slow else math.sqrt(m / k), friction / k) if k > 0.0 else math.inf
        for k, m in zip(stiffness, mass, strict=True)
    ]
    step = min(GOOD * min(*scales, parameters.quickest), wandering_step(parameters))
    if slow:
        speed += gathering_speed(parameters)
    return min(step, SKIN_PER_STEP * parameters.skin / speed) if speed > 0.0 else step


def gathering_speed(parameters: Parameters) -> float:
    """The fastest that walls and all others together can draw a float that has no inertia (m/s).

    At the edge of a raft of all floats F = pi S A n min(L, r), where n is the raft's charge per area and r its radius:
    a half-plane's pull, or that of the whole raft as if it stood in its middle.
    """
    floats, length = parameters.floats, float(parameters.pair[CAPILLARY_LENGTH])
    mobility, charge = floats.relaxation_time / floats.mass, np.abs(floats.charge)
    area = math.pi * float(np.sum(floats.radius**2)) / PACKED
    crowd = math.pi * float(np.sum(charge)) / area * min(length, math.sqrt(area / math.pi))
    walls = np.abs(parameters.wall_strength).sum(axis=0) / length
    return float(np.max(mobility * (parameters.stiffer * abs(parameters.pair[STRENGTH]) * charge * crowd + walls)))


def wandering_step(parameters: Parameters) -> float:
    """The step in which chance carries floats by GOOD of their radius, r.m.s. along an axis (s)."""
    thermal, floats = parameters.drift.thermal, parameters.floats
    if thermal == 0.0:
        return math.inf
    friction = floats.mass / floats.relaxation_time
    return float(np.min((GOOD * floats.radius) ** 2 * friction)) / (2.0 * thermal)


def _least_friction(floats: Floats) -> float:
    """N s/m, of the float that drag slows least; zero without drag."""
    return float(np.min(floats.mass / floats.relaxation_time))
