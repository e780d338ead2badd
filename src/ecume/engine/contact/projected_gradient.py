"""Contacts of bodies whose mobility is known by its products only: projected gradients.

The conditions are those of `projected_gauss_seidel`. Gauss-Seidel sweeps require the response to each single impulse;
with the flow of ten thousand floats only the response to all impulses at once is affordable. The impulses minimize a
quadratic function under p >= 0, by steps along the projected gradient with the lengths of Barzilai & Borwein, as for
suspensions in [yan2019]. Each step is one product.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ecume._jit import compiled
from ecume._portable import dot
from ecume.engine.contact.contacts import Contacts, normal_velocities
from ecume.engine.contact.projected_gauss_seidel import Goal
from ecume.units import Array

MOST_PRODUCTS = 400


@compiled
def spread_forces(contacts: Contacts, push: Array, force: Array) -> None:
    """Compute the forces of contacts on bodies (N + walls, 2), equal and opposite along the normals."""
    force[:] = 0.0
    first, second, normal = contacts.first, contacts.second, contacts.normal
    for row in range(contacts.total[0]):
        i, j = first[row], second[row]
        for axis in range(2):
            force[i, axis] -= push[row] * normal[row, axis]
            force[j, axis] += push[row] * normal[row, axis]


def residual(excess: Array, push: Array, weight: Array) -> float:
    """The largest violation of the conditions (m/s): approach, or force on separating bodies."""
    return float(np.max(np.maximum(-excess, np.minimum(excess, push / weight)), initial=0.0))


def solve(contacts: Contacts, velocity: Array, respond: Callable[[Array], Array], goal: Goal) -> int:
    """Solve for the forces in `contacts.impulse`, which are also the initial guess, and change velocities (N + walls,
    2) by them; `respond(forces)` returns the velocities by forces on all bodies. Returns the number of products,
    MOST_PRODUCTS + 1 if the residual is above `goal.acceptable`.
    """
    total = int(contacts.total[0])
    scale, bound = np.sqrt(contacts.weight[:total]), contacts.bound[:total]
    given, force, excess = velocity.copy(), np.zeros_like(velocity), np.zeros(total)

    def gradient(share: Array) -> Array:
        spread_forces(contacts, scale * share, force)
        velocity[:] = given + respond(force)
        normal_velocities(contacts, velocity, excess)
        return np.asarray(scale * (excess - bound))

    share = contacts.impulse[:total] / scale
    slope, products, length = gradient(share), 1, 1.0
    best, least = share, residual(slope / scale, scale * share, contacts.weight[:total])
    while least > goal.target and products < MOST_PRODUCTS:
        other = np.maximum(share - length * slope, 0.0)
        steeper = gradient(other)
        products += 1
        step, change = other - share, steeper - slope
        share, slope = other, steeper
        left = residual(slope / scale, scale * share, contacts.weight[:total])
        if left < least:
            best, least = share, left
        curvature = dot(step, change)
        if not curvature > 0.0:
            break
        # The two lengths in turns: the first is the longer one.
        length = dot(step, step) / curvature if products % 2 else curvature / dot(change, change)
    if best is not share:
        gradient(best)
    contacts.impulse[:total] = scale * best
    return products if least <= max(goal.target, goal.acceptable) else MOST_PRODUCTS + 1
