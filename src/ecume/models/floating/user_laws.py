"""Pair laws of the user: one more interaction, compiled for the functions of a run.

Its forces are added to those of the scene; its energy is the integral of the force. It acts as far as it is larger than
`interaction.accuracy` of its largest value beyond contact, at least up to the cutoff of the scene.
"""

from __future__ import annotations

import collections
import itertools
import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import of_this_process
from ecume.engine.cells import nearest
from ecume.engine.contact.contacts import apart
from ecume.engine.neighbors import NeighborLists
from ecume.engine.walls import surfaces
from ecume.models.floating.forces.interactions import BY_CONSTANTS, ROUND, Interaction
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    SURFACE_TENSION,
    PairParameters,
    Parameters,
    State,
    Workspace,
)
from ecume.models.floating.time_integration.step_size import FINE, RAFT_NEIGHBORS
from ecume.models.user_laws import (
    PAIR,
    BoundLaw,
    compiled_for_laws,
    energy_between,
    key_of,
    masks_of,
    require_force,
    require_kinds,
    sum_of_pair_laws,
)
from ecume.units import Array, with_prefix

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class FloatPair(NamedTuple):
    """The properties of the two floats of a pair that user-defined laws get, in addition to the distance of their
    centers.
    """

    radius_i: float
    radius_j: float
    charge_i: float
    charge_j: float
    capillary_length: float
    surface_tension: float
    constants: tuple[float, ...]


@compiled_for_laws
def joined(own: PairParameters, constants: Any) -> FloatPair:
    """The parameters of a law."""
    return FloatPair(
        own.radius_i, own.radius_j, own.charge_i, own.charge_j, own.capillary_length, own.surface_tension, constants
    )


DISTANCES = (3.2e-3, 5e-3, 2e-2)
"""m: distances at which user laws are tested."""
ONE = PairParameters(1e-3, 2e-3, 1e-4, -3e-5, 2.7e-3, 0.07)
OTHER = PairParameters(2e-3, 1e-3, -3e-5, 1e-4, 2.7e-3, 0.07)
"""Two typical spheres, and the same exchanged."""

FIELDS = ("mask", "species", "radius", "charge", "cutoff", "length", "tension")
"""The arrays of a part: (S, S) laws of each pair of species; (N,) properties of floats; lengths (m), surface tension
(N/m).
"""

NUMBERS = itertools.count()
KEPT = "UserLaws_"
"""Compiled code identifies a type by its name: other laws need another name."""


def __getattr__(name: str) -> Any:
    """The class of the constants of laws, by a name with their digest: code on the disk looks for it here."""
    if not name.startswith(KEPT):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _kept(name)


def _kept(name: str) -> Any:
    if name not in globals():
        globals()[name] = collections.namedtuple(name, FIELDS, module=__name__)
    return globals()[name]


def interaction_of(laws: Sequence[BoundLaw]) -> Interaction:
    """The interaction of these laws. Raises BadInput for functions that are not pair laws.

    A law is the same when i and j are exchanged. Faults are reported before the time step is compiled.
    """
    require_kinds("floating", laws, [PAIR])
    for law in laws:
        require_force(law, DISTANCES, FloatPair(*ONE, law.constants), FloatPair(*OTHER, law.constants))
    total = sum_of_pair_laws(laws, joined)
    potential = _sum_of_energies(energy_between(total))
    add_forces = _adding(total)
    key = key_of(add_forces)
    constants = _kept(KEPT + key) if key else of_this_process(f"UserLaws{next(NUMBERS)}", FIELDS)

    def make(parameters: Parameters, scene: FloatingScene) -> Built:
        if parameters.single:
            raise scene_error("interaction.precision", "got 'single'; expected 'double' with user-defined laws")
        floats = parameters.floats
        part = constants(
            masks_of(laws, len(scene.kinds)), floats.species, floats.radius, floats.charge, parameters.cutoff,
            float(parameters.pair[CAPILLARY_LENGTH]), float(parameters.pair[SURFACE_TENSION]),
        )  # fmt: skip
        reach = range_of(total, part, parameters, scene.interaction.accuracy)
        part = part._replace(cutoff=max(reach, parameters.cutoff))
        periods = parameters.periods[0]
        if np.any(periods) and 2.0 * reach > periods[periods > 0.0].min():
            raise scene_error(
                "cell",
                f"a user law acts up to {with_prefix(reach, 'm')}, beyond the nearest images; expected "
                f"sides of at least {with_prefix(2.0 * reach, 'm')}, or a larger interaction.accuracy",
            )
        return Built(part, shortest_time(total, part, parameters), reach=part.cutoff)

    def energy(
        part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace
    ) -> tuple[float, float]:
        return float(potential(part, state.position, workspace.lists)), 0.0

    row = Interaction(
        path="extra_laws", name="a user law", constants=constants, make=make, add_forces=add_forces, energy=energy,
        gives=ROUND | {"moving walls", "pair sum", "undulations", "grid", "superposed", "no torques"},
        needs={
            "reciprocal": "its sum counts each pair once",
            "pair sum": "it is added to the pair law, as far as lists of neighbors reach",
        },
    )  # fmt: skip
    BY_CONSTANTS[constants] = row
    return row


def _adding(total: Any) -> Any:
    """Return the loop over pairs of neighbors, each once."""

    @compiled_for_laws
    def add_forces(
        part: Any, scratch: Any, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
    ) -> None:
        order, rows = lists.cells.order, lists.rows
        x, y = rows.sorted_position[0], rows.sorted_position[1]
        for slot in range(len(order)):
            i = order[slot]
            for place in range(rows.later[slot], rows.first[slot + 1]):
                other = rows.neighbor[place]
                j = order[other]
                mask = part.mask[part.species[i], part.species[j]]
                along = nearest(x[other] - x[slot], rows.periods[0, 0], rows.periods[1, 0])
                across = nearest(y[other] - y[slot], rows.periods[0, 1], rows.periods[1, 1])
                distance = math.sqrt(along * along + across * across)
                if mask and 0.0 < distance < part.cutoff:
                    pair = PairParameters(
                        part.radius[i], part.radius[j], part.charge[i], part.charge[j], part.length, part.tension
                    )
                    over = total(distance, pair, mask) / distance
                    force[i, 0] -= over * along
                    force[i, 1] -= over * across
                    force[j, 0] += over * along
                    force[j, 1] += over * across

    return add_forces


def _sum_of_energies(energy: Any) -> Any:
    """Return the sum of the energies of all pairs (J), zero at the cutoff."""

    @compiled_for_laws
    def sum_of_energies(part: Any, position: Array, lists: NeighborLists) -> float:
        # The sorted positions of the lists are those of the last forces.
        order, rows, sum_of_pairs = lists.cells.order, lists.rows, 0.0
        for slot in range(len(order)):
            i = order[slot]
            for place in range(rows.later[slot], rows.first[slot + 1]):
                j = order[rows.neighbor[place]]
                mask = part.mask[part.species[i], part.species[j]]
                along, across = apart(position, i, j, rows.periods)
                distance = math.sqrt(along * along + across * across)
                if mask and 0.0 < distance < part.cutoff:
                    pair = PairParameters(
                        part.radius[i], part.radius[j], part.charge[i], part.charge[j], part.length, part.tension
                    )
                    sum_of_pairs += energy(distance, part.cutoff, pair, mask)
        return sum_of_pairs

    return sum_of_energies


MOST_RADII, PLACES = 1e4, 400
"""The range of user laws without a cutoff, in contact distances, and the number of distances at which they are
evaluated.
"""


def range_of(total: Any, part: Any, parameters: Parameters, accuracy: float) -> float:
    """The distance (m) beyond which the laws are smaller than this fraction of their largest value, at most the width
    of the dish; 0 for laws that act on no pair.
    """
    widest, found = 2.0 * surfaces.farthest(parameters.walls), 0.0
    for touching, pair, mask, _ in pairs_of_kinds(part, parameters):
        distances = np.geomspace(touching, max(min(widest, MOST_RADII * touching), 2.0 * touching), PLACES)
        force = np.abs([float(total(distance, pair, mask)) for distance in distances.tolist()])
        acting = np.flatnonzero(force > accuracy * force.max())
        if len(acting):
            found = max(found, min(float(distances[acting[-1]]), widest))
    return found


def pairs_of_kinds(part: Any, parameters: Parameters) -> Iterator[tuple[float, PairParameters, int, tuple[int, int]]]:
    """Each pair of species with a law, of each its smallest and largest float and that of the strongest charge: the
    distance of contact (m), the parameters, the mask, and both floats.
    """
    floats = parameters.floats
    kinds: set[int] = set()
    for species in np.unique(floats.species):
        members = np.flatnonzero(floats.species == species)
        radius, charge = floats.radius[members], np.abs(floats.charge[members])
        kinds |= {int(members[place]) for place in (radius.argmin(), radius.argmax(), charge.argmax())}
    for i, j in itertools.combinations_with_replacement(sorted(kinds), 2):
        mask = int(part.mask[floats.species[i], floats.species[j]])
        if mask:
            pair = PairParameters(
                float(floats.radius[i]), float(floats.radius[j]), float(floats.charge[i]), float(floats.charge[j]),
                part.length, part.tension,
            )  # fmt: skip
            yield float(floats.radius[i] + floats.radius[j]), pair, mask, (i, j)


def shortest_time(total: Any, part: Any, parameters: Parameters) -> float:
    """The shortest time scale of the laws (s): each is a spring of stiffness |dF/dl| at contact, with six neighbors."""
    floats, shortest = parameters.floats, math.inf
    for touching, pair, mask, (i, j) in pairs_of_kinds(part, parameters):
        near, far = (float(total((1.0 + change) * touching, pair, mask)) for change in (-FINE, FINE))
        spring = 2.0 * RAFT_NEIGHBORS * abs(far - near) / (2.0 * FINE * touching)
        if spring > 0.0:
            lighter = i if floats.mass[i] < floats.mass[j] else j
            inertial = math.sqrt(float(floats.mass[lighter]) / spring)
            drag = float(floats.mass[lighter] / floats.relaxation_time[lighter])
            shortest = min(shortest, inertial if parameters.scheme.inertia else drag / spring)
    return shortest
