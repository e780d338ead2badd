"""Magnetic floats: vertical dipoles that repel one another, in addition to capillary forces."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import apart
from ecume.engine.neighbors import NeighborLists, Slots
from ecume.laws import dipoles
from ecume.laws.dipoles import dipole_energy, dipole_force, dipole_strength
from ecume.laws.pair_laws import Dipoles
from ecume.models.floating.forces.pair_forces import add_from_slots, pairs_of, sum_pair_forces
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import CAPILLARY_LENGTH, CUTOFF, STRENGTH, SURFACE_TENSION, Parameters
from ecume.models.floating.setup.kinds import moments_of
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.time_integration.step_size import RAFT_NEIGHBORS
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


admit(dipoles)


class DipoleMoments(NamedTuple):
    """Magnetic moments, the constants of this interaction."""

    moment: Array
    """(N,) A m^2, upward"""
    pair: Array
    """the law's constants, the first of them as in `parameters.pack_pair`: strength of two unit moments, cutoff"""


class SortedMoments(NamedTuple):
    """Workspace in the order of the slots."""

    moment: Array
    force: Array
    """(2, N) N"""


def make_dipole_moments(moment: Array, cutoff: float) -> DipoleMoments:
    """Return moments that act up to a cutoff (m)."""
    pair = np.zeros(max(STRENGTH, CUTOFF, SURFACE_TENSION) + 1)
    pair[STRENGTH], pair[CUTOFF], pair[CAPILLARY_LENGTH] = dipole_strength(1.0, 1.0), cutoff, 1.0
    return DipoleMoments(np.asarray(moment, np.float64), pair)


def make_sorted_moments(
    part: DipoleMoments, parameters: Parameters, state: State, workspace: Workspace
) -> SortedMoments:
    """Return the workspace."""
    return SortedMoments(np.zeros_like(part.moment), np.zeros((2, len(part.moment))))


@compiled
def sort_moments(part: DipoleMoments, own: SortedMoments, parameters: Parameters, lists: NeighborLists) -> None:
    """Copy moments into the order of the slots; after each new neighbor list."""
    order = lists.cells.order
    for slot in range(len(order)):
        own.moment[slot] = part.moment[order[slot]]


@compiled
def dipole_forces(
    part: DipoleMoments, own: SortedMoments, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces of all pairs of dipoles."""
    sum_pair_forces(Dipoles(part.pair[STRENGTH]), pairs_of(lists.rows), (own.moment, own.moment), part.pair, own.force)
    add_from_slots(lists.cells.order, own.force, force)


def dipole_energies(
    part: DipoleMoments, own: SortedMoments, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of all pairs of dipoles (J)."""
    rows = workspace.lists.rows
    listed = rows.first, rows.neighbor, workspace.lists.cells.order, rows.periods
    return float(sum_of_dipole_energies(state.position, part, listed)), 0.0


@compiled
def sum_of_dipole_energies(
    position: Array, part: DipoleMoments, listed: tuple[Integers, Slots, Integers, Array]
) -> float:
    """The energies (J) of all pairs within the cutoff, each minus its value at the cutoff."""
    first, neighbor, order, periods = listed
    moment, cutoff, total = part.moment, part.pair[CUTOFF], 0.0
    for slot in range(len(order)):
        i, own = order[slot], 0.0
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = apart(position, i, j, periods)
            distance = math.sqrt(x * x + y * y)
            if i < j and 0.0 < distance < cutoff:
                strength = dipole_strength(moment[i], moment[j])
                own += dipole_energy(distance, strength) - dipole_energy(cutoff, strength)
        total += own
    return total


def dipoles_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the dipoles of a scene. Two touching floats are a spring of 4 F/l; a float has at most six neighbors."""
    moment = moments_of(scene)
    radius, walls = parameters.floats.radius, parameters.walls
    touching = 2.0 * float(radius.min())
    across = 2.0 * min(walls.disc_radius, float(np.hypot.reduce(walls.offset)) if len(walls.offset) else math.inf)
    cutoff = min(touching / math.sqrt(scene.interaction.accuracy), across)
    strongest = float(np.abs(moment).max())
    at_contact = dipole_force(touching, dipole_strength(strongest, strongest))
    spring, floats = 2.0 * RAFT_NEIGHBORS * 4.0 * at_contact / touching, parameters.floats
    quickest = float(np.min(np.sqrt(floats.mass / spring)))
    if not parameters.scheme.inertia:
        quickest = float(np.min(floats.mass / floats.relaxation_time)) / spring
    return Built(make_dipole_moments(moment, cutoff), quickest, reach=cutoff)
