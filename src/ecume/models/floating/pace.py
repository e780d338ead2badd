"""How long a time step may be: from the stiffness of the pull between touching floats, and from their speed."""

from __future__ import annotations

import math

import numpy as np

from ecume.models.floating.pair_choice import law_of, row_of, two_floats
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    Floats,
    Parameters,
)
from ecume.models.floating.walls.wall_laws import wall_stiffness
from ecume.units import Array

GOOD = 0.05
"""Time steps over the shortest time scale: the error of a step is then below a thousandth."""
LOOSEST_OVER_CHOSEN = 4.0
LARGEST_OVER_CHOSEN = 20.0
"""Beyond this the scheme is unstable."""
RAFT_NEIGHBORS = 6.0
PACKED = 0.9069
"""Of the surface that touching discs cover on a triangular lattice."""
FINE = 1e-6
"""Step of finite differences, over the distance."""
PLACES = 400
"""Number of distances for the integral of a force over a half-plane."""
SKIN_PER_STEP = 0.1
"""Nobody may go farther in a step, over the skin."""


def pair_stiffness(parameters: Parameters, radius: tuple[float, float], charge: tuple[float, float]) -> float:
    """The stiffness |dF/dl| of the pair law for two floats in contact (N/m)."""
    row, law, distance = row_of(parameters), law_of(parameters), radius[0] + radius[1]
    own = two_floats(parameters, radius, charge)
    if row.stiffness is not None:
        return parameters.stiffer * float(row.stiffness(distance, own, law))
    near, far = (float(row.force((1.0 + change) * distance, own, law)) for change in (-FINE, FINE))
    return parameters.stiffer * abs(far - near) / (2.0 * FINE * distance)


def stiffness_over_mass(parameters: Parameters) -> tuple[Array, Array]:
    """Of each distinct kind of float in the crowd's worst place: stiffness (N/m) and mass (kg)."""
    floats = parameters.floats
    kinds = np.unique(np.stack([floats.radius, np.abs(floats.charge), floats.mass], axis=1), axis=0)
    # The strongest partner of any kind, as small or as large as any, bounds them all: a table of a thousand different
    # floats costs two thousand evaluations.
    strongest, extremes = float(np.max(kinds[:, 1])), {float(np.min(kinds[:, 0])), float(np.max(kinds[:, 0]))}
    wall = wall_stiffness(parameters)
    stiffness = [
        2.0 * RAFT_NEIGHBORS * max(pair_stiffness(parameters, (radius, other), (felt, strongest)) for other in extremes)
        + wall
        for radius, felt in kinds[:, :2].tolist()
    ]
    return np.array(stiffness), kinds[:, 2]


def chosen_step(parameters: Parameters, speed: float) -> float:
    """The longest good step (s).

    A float on a spring k turns back after about sqrt(m/k), or relaxes in zeta/k where drag rules; the kick takes drag
    exactly, so that the longer of the two counts: syrup needs no tinier step than water.
    """
    stiffness, mass = stiffness_over_mass(parameters)
    friction = _least_friction(parameters.floats)
    slow = not parameters.scheme.inertia
    scales = [
        max(0.0 if slow else math.sqrt(m / k), friction / k) if k > 0.0 else math.inf
        for k, m in zip(stiffness, mass, strict=True)
    ]
    step = min(GOOD * min(*scales, parameters.quickest), wandering_step(parameters))
    if slow:
        speed += gathering_speed(parameters)
    return min(step, SKIN_PER_STEP * parameters.skin / speed) if speed > 0.0 else step


def gathering_speed(parameters: Parameters) -> float:
    """The fastest that walls and all others together, in a raft, can move a float that has no inertia (m/s)."""
    floats, length = parameters.floats, float(parameters.pair[CAPILLARY_LENGTH])
    mobility, charge = floats.relaxation_time / floats.mass, np.abs(floats.charge)
    area = math.pi * float(np.sum(floats.radius**2)) / PACKED
    walls = np.abs(parameters.wall_strength).sum(axis=0) / length
    return float(np.max(mobility * (parameters.stiffer * raft_pull(parameters, charge, area) + walls)))


def raft_pull(parameters: Parameters, charge: Array, area: float) -> Array:
    """The force of the pair law on each float at the edge of a raft of all floats that covers this area (N)."""
    row, law, floats = row_of(parameters), law_of(parameters), parameters.floats
    if row.raft_pull is not None:
        return np.asarray(row.raft_pull(charge, area, float(parameters.pair[CAPILLARY_LENGTH]), law))
    # A half-plane of floats with the largest charge: F = 2 n int |F(l)| l dl, with n floats per m^2.
    near, strongest = 2.0 * float(floats.radius.min()), float(charge.max())
    own = two_floats(parameters, (0.5 * near, 0.5 * near), (strongest, strongest))
    distance = np.geomspace(near, max(parameters.cutoff, 2.0 * near), PLACES)
    force = np.array([abs(float(row.force(each, own, law))) for each in distance.tolist()])
    whole = 2.0 * len(charge) / area * float(np.trapezoid(force * distance, distance))
    return np.full(len(charge), whole)


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
