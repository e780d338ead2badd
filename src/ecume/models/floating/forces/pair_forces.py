"""Forces between floats by a pair law: the law of a scene, the loop over pairs, and the sum with the walls' menisci.

The loop evaluates each pair once and adds the force to both floats. Slots are divided into stretches with about the
same number of pairs. Each stretch adds its forces into a separate window, from its first slot to the last neighbor of
its last slot, and the windows are added up in order. The number of stretches follows from the number of pairs alone,
so that bits do not depend on the number of threads.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from types import FunctionType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._fused import lane_sum
from ecume._jit import admit, by_type, compiled, compiled_inside, prange, threaded
from ecume.engine.cells import Integers, nearest
from ecume.engine.contact.contacts import apart
from ecume.engine.neighbors import STRETCHES, THREADS_FROM, NeighborLists, Rows, Slots
from ecume.engine.walls import wall_count
from ecume.engine.walls.surfaces import farthest
from ecume.errors import BadInput, SceneError
from ecume.laws import capillarity, ewald, pair_laws, special
from ecume.laws.pair_laws import CAPABILITIES, PAIR_LAWS, PairLaw, Setting, described, settable
from ecume.models.floating.dishes import acts, wall_energy, wall_force
from ecume.models.floating.options import Built, Option, scene_error
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    OWN,
    SURFACE_TENSION,
    Floats,
    PairParameters,
    Parameters,
    State,
    Workspace,
    distinct_rows,
)
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

ADMITTED = (capillarity, pair_laws, special, ewald)
"""The modules whose functions a pair law may call in compiled code."""
admit(*ADMITTED)


def require_admitted(function: Callable[..., Any]) -> None:
    """Raise TypeError if a law, or a function that it calls, is in a module that is not admitted to compiled code."""
    known = {module.__name__ for module in ADMITTED} | {lane_sum.__module__}
    seen, ahead = {function}, [function]
    while ahead:
        caller: Any = ahead.pop()
        called = {caller.__globals__.get(name) for name in caller.__code__.co_names if name in caller.__globals__
                  and isinstance(caller.__globals__[name], FunctionType)} - seen  # fmt: skip
        for each in called:
            if each.__module__ not in known:
                raise TypeError(
                    f"the pair law's {function.__name__} calls {each.__name__} of {each.__module__}, which compiled "
                    "code does not know; add that module to ADMITTED in models/floating/forces/pair_forces.py"
                )
        seen |= called
        ahead += called


for _row in PAIR_LAWS.values():
    for _function in (_row.force, _row.energy, _row.pull):
        if _function is not None:
            require_admitted(_function)


NAMES = tuple(PAIR_LAWS)


def row_of(parameters: Parameters) -> PairLaw:
    """The row of the scene's pair law in the table."""
    return PAIR_LAWS[NAMES[parameters.pair_law]]


def law_of(parameters: Parameters) -> Any:
    """The constants of the scene's pair law, in double precision."""
    row = row_of(parameters)
    return row.constants(*map(float, parameters.pair[OWN:]))


def law_in_precision(parameters: Parameters, law: Any) -> Any:
    """The constants of a law in the precision of the sum over pairs. Their type selects the compiled code of the
    law.
    """
    return type(law)(*map(np.float32, law)) if parameters.single else law


def summed_law(parameters: Parameters) -> Any:
    """The constants of the scene's pair law, in the precision of the sum over pairs."""
    return law_in_precision(parameters, law_of(parameters))


def two_floats(parameters: Parameters, radius: tuple[float, float], charge: tuple[float, float]) -> PairParameters:
    """The arguments of pair laws for two floats in the liquid of the scene."""
    length, tension = float(parameters.pair[CAPILLARY_LENGTH]), float(parameters.pair[SURFACE_TENSION])
    return PairParameters(*radius, *charge, length, tension)


def row_of_law(law: Any) -> PairLaw:
    """The row of the pair law with these constants."""
    return pair_laws.row_of(type(law))


def in_double(law: Any, parameters: Parameters) -> Any:
    """The constants of the scene's law in double precision, as first computed."""
    return type(law)(*law_of(parameters)) if parameters.single else law


def constants_of(scene: FloatingScene, setting: Setting) -> Any:
    """The constants of the scene's pair law, from the numbers that the scene gives. Raises SceneError."""
    name, given = str(scene.interaction.law), scene.interaction.constants
    row = PAIR_LAWS[name]
    known = [f"{each} ({unit})" for each, unit in settable(row).items()]
    if len(given) > len(known):
        expected = f"expected {', '.join(known)}" if known else "its constants cannot be set"
        raise scene_error("interaction.constants", f"got {len(given)} numbers for the law {name!r}; {expected}")
    try:
        return row.make_constants(setting, *given)
    except SceneError:
        raise
    except BadInput as error:
        raise scene_error("interaction.constants" if known else "particles", str(error)) from None
    except (ArithmeticError, ValueError) as error:
        raise scene_error("interaction.constants", _without_meaning(scene, str(error))) from None


def _without_meaning(scene: FloatingScene, why: str) -> str:
    name, given = str(scene.interaction.law), scene.interaction.constants
    numbers = described(PAIR_LAWS[name], given) or "no numbers"
    return f"the law {name!r} cannot be evaluated with {numbers}: {why}; expected other numbers"


def require_finite_forces(parameters: Parameters, scene: FloatingScene) -> None:
    """Raise SceneError if the pair law returns NaN or infinity for the smallest and the largest floats, at contact or
    at the cutoff.
    """
    row, law, radius = row_of(parameters), law_of(parameters), parameters.floats.radius
    for i in {int(np.argmin(radius)), int(np.argmax(radius))}:
        own, charge = float(radius[i]), float(parameters.floats.charge[i])
        pair = two_floats(parameters, (own, own), (charge, charge))
        for distance in (2.0 * own, max(parameters.cutoff, 2.0 * own)):
            try:
                found = [each(distance, pair, law) for each in (row.force, row.energy) if each is not None]
            except (ArithmeticError, ValueError) as error:
                raise scene_error("interaction.constants", _without_meaning(scene, str(error))) from None
            if not np.all(np.isfinite(found)):
                why = f"at the distance {distance:.3g} m the force is {found[0]} N"
                raise scene_error("interaction.constants", _without_meaning(scene, why))


def force_left(parameters: Parameters) -> float:
    """The force of the pair law at the cutoff, over that of two touching floats; the largest ratio of all sizes."""
    row, law, floats = row_of(parameters), law_of(parameters), parameters.floats
    kinds = distinct_rows(floats.radius, floats.charge).tolist()
    pairs = [(2.0 * radius, two_floats(parameters, (radius, radius), (charge, charge))) for radius, charge in kinds]
    forces = [(abs(row.force(touch, own, law)), abs(row.force(parameters.cutoff, own, law))) for touch, own in pairs]
    return max((far / near for near, far in forces if near > 0.0), default=0.0)


class CutoffWarning(UserWarning):
    """The cutoff of the pair law is at a distance where its force is not small."""


def warn_of_long_range(parameters: Parameters, scene: FloatingScene) -> None:
    """Warn if the cutoff is too short, for a law that is not a superposition of menisci and whose range sets the
    cutoff.
    """
    accuracy, within = scene.interaction.accuracy, parameters.cutoff < 2.0 * farthest(parameters.walls)
    if row_of(parameters).menisci or not within or not (left := force_left(parameters)) > accuracy:
        return
    message = (
        f"interaction.accuracy: at the cutoff, {parameters.cutoff:.3g} m, the force of the law "
        f"{str(scene.interaction.law)!r} is {left:.2g} of that at contact, which is above {accuracy:g}; beyond, it is "
        "ignored. Expected a lower interaction.accuracy, which lengthens the cutoff, or constants of a shorter range"
    )
    warnings.warn(message, CutoffWarning, stacklevel=2)


def pair_option(name: str) -> Option:
    """The option of the pair law with this name, with its capabilities."""
    row = PAIR_LAWS[name]
    gives = frozenset(capability for capability in CAPABILITIES if getattr(row, capability))
    charges = {"charges"} if row.menisci or not row.has_force else set()
    return Option(slot="pair law", path="interaction.law", name=repr(name), gives=gives | charges)


PADDED = 8
"""Neighbors are padded to a multiple of the vector width, since a remainder is not vectorized."""

LEAST_DISTANCE = 1e-300
"""The lower limit of distances (m), which prevents divisions by zero."""


@compiled_inside
def pairs_of(rows: Rows) -> Any:
    """The parts of the neighbor lists that sums over pairs require, in 2D."""
    x, y = rows.sorted_position[0], rows.sorted_position[1]
    return rows.first, rows.later, rows.neighbor, x, y, rows.edge, rows.place, rows.periods


@compiled
def add_windows(edge: Integers, place: Integers, windows: Array, force: Array) -> None:
    """Add up all windows in order."""
    force[:] = 0.0
    for k in range(STRETCHES):
        for axis in range(2):
            for spot in range(place[k], place[k + 1]):
                force[axis, edge[k] + spot - place[k]] += windows[axis, spot]


def _pull_for(constants: type) -> Callable[..., float]:
    return pair_laws.row_of(constants).pull or pull_by_force


def pull_by_force(square: float, own: PairParameters, law: Any) -> float:
    """The value of -force/distance, for laws that define their force alone."""
    distance = max(math.sqrt(square), LEAST_DISTANCE)
    sum_pair_forces: float = -pair_force(distance, own, law) / distance
    return sum_pair_forces


pair_pull = by_type(_pull_for)
"""pair_pull(square, own, law): minus the force over the distance (N/m), from the square of the distance."""

pair_force = by_type(lambda constants: pair_laws.row_of(constants).force)
"""pair_force(distance, own, law): the force of the law (N), positive when it repels."""

pair_energy = by_type(lambda constants: pair_laws.row_of(constants).energy or no_energy)
"""pair_energy(distance, own, law): the energy of the law (J)."""


def no_energy(distance: float, own: PairParameters, law: Any) -> float:
    return 0.0


@compiled_inside
def _all_radii(radius: Array, law: Any) -> Array:
    return radius


@compiled_inside
def _no_radii(radius: Array, law: Any) -> Array:
    return radius[:0]


seen_radii = by_type(lambda constants: _all_radii if pair_laws.row_of(constants).needs_radii else _no_radii)
"""seen_radii(radius, law): the radii if the law depends on them, otherwise an empty array."""


@compiled
def sum_stretch(
    law: Any,
    stretch: tuple[int, int],
    rows: Any,
    floats: tuple[Array, Array],
    pair: Array,
    window: tuple[Array, Array],
) -> None:
    """Add the forces between a stretch of slots and the later slots, by a pair law.

    Four plain loops instead of one: gather the neighbors, compute all forces (this loop vectorizes without changing a
    bit), distribute them to the neighbors, add them up in lanes. The second loop is in the precision of `pair`, of
    the law and of the charges; distances are computed and forces added up in double. Radii are gathered only for laws
    that depend on them.
    """
    first, later, neighbor, x, y, _, _, periods = rows
    charge, radius = floats[0], seen_radii(floats[1], law)
    cutoff, length, tension = pair[CUTOFF], pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION]
    nothing = cutoff - cutoff
    longest, start = 0, np.uint64(stretch[0])
    for slot in range(stretch[0], stretch[1]):
        longest = max(longest, first[slot + 1] - later[slot])
    room, kind = longest + PADDED, charge.dtype
    apart_x, apart_y, charges, radii = np.empty(room, kind), np.empty(room, kind), np.zeros(room, kind), np.ones(room)
    force_x, force_y = window
    periodic = periods[0, 0] > 0.0 or periods[0, 1] > 0.0
    for slot in range(stretch[0], stretch[1]):
        begin, found = np.uint64(later[slot]), np.uint64(first[slot + 1] - later[slot])
        own_x, own_y, own_charge, own_radius = x[slot], y[slot], charge[slot], 0.0
        for k in range(found):
            j = np.uint64(neighbor[begin + k])
            apart_x[k], apart_y[k], charges[k] = x[j] - own_x, y[j] - own_y, charge[j]
        if periodic:
            for k in range(found):
                j = np.uint64(neighbor[begin + k])
                apart_x[k] = nearest(x[j] - own_x, periods[0, 0], periods[1, 0])
                apart_y[k] = nearest(y[j] - own_y, periods[0, 1], periods[1, 1])
        if len(radius) > 0:
            own_radius = radius[slot]
            for k in range(found):
                radii[k] = radius[neighbor[begin + k]]
        padded = (found + np.uint64(PADDED - 1)) // np.uint64(PADDED) * np.uint64(PADDED)
        for k in range(found, padded):
            apart_x[k], apart_y[k] = cutoff + cutoff, nothing
        for k in range(padded):
            square = apart_x[k] * apart_x[k] + apart_y[k] * apart_y[k]
            own = PairParameters(own_radius, radii[k], own_charge, charges[k], length, tension)
            factor = pair_pull(square, own, law)
            factor = factor if square < cutoff * cutoff else nothing
            apart_x[k] *= factor
            apart_y[k] *= factor
        for k in range(found):
            j = np.uint64(neighbor[begin + k]) - start
            force_x[j] -= apart_x[k]
            force_y[j] -= apart_y[k]
        force_x[np.uint64(slot) - start] += lane_sum(apart_x, padded)
        force_y[np.uint64(slot) - start] += lane_sum(apart_y, padded)


@threaded
def sum_stretches(
    law: Any, edge: Any, place: Any, rows: Any, floats: Any, pair: Array, along: Array, across: Array
) -> None:
    """Add the forces on several ranges of slots in parallel, each range into a separate window."""
    for k in prange(len(edge) - 1):
        window = along[place[k] : place[k + 1]], across[place[k] : place[k + 1]]
        sum_stretch(law, (edge[k], edge[k + 1]), rows, floats, pair, window)


@compiled
def sum_serially(law: Any, rows: Any, floats: tuple[Array, Array], pair: Array, force: Array) -> None:
    """The forces of all pairs on all slots, computed by one thread."""
    force[:] = 0.0
    sum_stretch(law, (0, force.shape[1]), rows, floats, pair, (force[0], force[1]))


@compiled
def sum_in_parallel(law: Any, rows: Any, floats: tuple[Array, Array], pair: Array, force: Array) -> None:
    """Sum the pair forces on all slots, with threads in large systems."""
    if force.shape[1] < THREADS_FROM:
        sum_serially(law, rows, floats, pair, force)
    else:
        edge, place = rows[5], rows[6]
        windows = np.zeros((2, place[STRETCHES]))
        sum_stretches(law, edge, place, rows, floats, pair, windows[0], windows[1])
        add_windows(edge, place, windows, force)


@compiled
def sum_one_sided(law: Any, rows: Any, floats: tuple[Array, Array], pair: Array, force: Array) -> None:
    """Compute the forces of all pairs on all slots for a law that is not reciprocal: each slot sums over all its
    neighbors.
    """
    first, _, neighbor, x, y, _, _, periods = rows
    charge, radius = floats
    length, tension, cutoff = pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION], pair[CUTOFF]
    for slot in range(force.shape[1]):
        total_x, total_y = 0.0, 0.0
        for place in range(first[slot], first[slot + 1]):
            j = neighbor[place]
            apart_x = nearest(x[j] - x[slot], periods[0, 0], periods[1, 0])
            apart_y = nearest(y[j] - y[slot], periods[0, 1], periods[1, 1])
            square = apart_x * apart_x + apart_y * apart_y
            if math.sqrt(square) < cutoff:
                own = PairParameters(radius[slot], radius[j], charge[slot], charge[j], length, tension)
                factor = pair_pull(square, own, law)
                total_x += factor * apart_x
                total_y += factor * apart_y
        force[0, slot], force[1, slot] = total_x, total_y


def _sum_for(constants: type) -> Callable[..., None]:
    row = pair_laws.row_of(constants)
    if not row.reciprocal:
        return sum_one_sided
    return sum_in_parallel if row.threaded else sum_serially


sum_pair_forces = by_type(_sum_for, 0)
"""pull(law, rows, floats, pair, force): the forces of all pairs on all slots."""


class Sorted(NamedTuple):
    """Workspace in the order of the slots."""

    charge: Array
    radius: Array
    force: Array
    """(2, N)"""
    pair: Array
    """the constants of the pair law, in the precision of the sums, as the charges"""


class Superposed(NamedTuple):
    """Floats that interact by a pair law, and separately with each wall."""

    law: Any
    """constants of the pair law, in the precision of the sum over pairs"""


def make_sorted(part: Superposed, parameters: Parameters, state: State, workspace: Workspace) -> Sorted:
    """Return the workspace."""
    count, kind = len(state.position), np.float32 if parameters.single else np.float64
    return Sorted(np.zeros(count, kind), np.zeros(count), np.zeros((2, count)), parameters.pair.astype(kind))


@compiled
def superposed_forces(
    part: Superposed, own: Sorted, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces of all pairs and of the walls."""
    sum_pair_forces(part.law, pairs_of(lists.rows), (own.charge, own.radius), own.pair, own.force)
    add_from_slots(lists.cells.order, own.force, force)
    add_wall_forces(parameters, position, force)


@compiled
def sort_floats(part: Any, own: Sorted, parameters: Parameters, lists: NeighborLists) -> None:
    """Copy charges and radii into the order of the slots, after each rebuild of the neighbor lists."""
    floats, order = parameters.floats, lists.cells.order
    charge, radius = own.charge, own.radius
    for slot in range(len(order)):
        charge[slot], radius[slot] = floats.charge[order[slot]], floats.radius[order[slot]]


@compiled
def add_from_slots(order: Integers, sorted_force: Array, force: Array) -> None:
    """Add forces in the order of the slots to those in the order of the floats."""
    for slot in range(len(order)):
        force[order[slot], 0] += sorted_force[0, slot]
        force[order[slot], 1] += sorted_force[1, slot]


@compiled
def add_wall_forces(parameters: Parameters, position: Array, force: Array) -> None:
    """Add the forces of the wall menisci on each float."""
    strength, charge = parameters.wall_strength, parameters.floats.charge
    if not acts(parameters):
        return
    for i in range(position.shape[0]):
        place = (position[i, 0], position[i, 1])
        for number in range(wall_count(parameters.walls)):
            away, inward_x, inward_y = wall_force(parameters, number, place, strength[number, i], charge[i])
            force[i, 0] += away * inward_x
            force[i, 1] += away * inward_y


def superposed_energy(
    part: Superposed, own: Sorted, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Energies (J) of all pairs and of all walls."""
    lists, pairs = workspace.lists, 0.0
    rows = lists.rows.first, lists.rows.neighbor, lists.cells.order, lists.rows.periods
    if row_of_law(part.law).energy is not None:
        law = in_double(part.law, parameters)
        pairs = float(sum_of_pair_energies(law, state.position, parameters.floats, parameters.pair, rows))
    return pairs, float(sum_of_wall_energies(parameters, state.position))


@compiled
def sum_of_pair_energies(
    law: Any, position: Array, floats: Floats, pair: Array, rows: tuple[Integers, Slots, Integers, Array]
) -> float:
    """The energies of all pairs within the cutoff, each minus its value at the cutoff, so that the energy is
    continuous.
    """
    first, neighbor, order, periods = rows
    length, tension, cutoff = pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION], pair[CUTOFF]
    radius, charge, total = floats.radius, floats.charge, 0.0
    for slot in range(len(order)):
        i = order[slot]
        own = 0.0
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = apart(position, i, j, periods)
            distance = math.sqrt(x * x + y * y)
            if i < j and 0.0 < distance < cutoff:
                two = PairParameters(radius[i], radius[j], charge[i], charge[j], length, tension)
                own += pair_energy(distance, two, law) - pair_energy(cutoff, two, law)
        total += own
    return total


@compiled
def sum_of_wall_energies(parameters: Parameters, position: Array) -> float:
    """The energies of all floats in the menisci of the walls, including mirror images."""
    strength, charge, total = parameters.wall_strength, parameters.floats.charge, 0.0
    if not acts(parameters):
        return total
    for i in range(position.shape[0]):
        place = (position[i, 0], position[i, 1])
        for number in range(wall_count(parameters.walls)):
            meniscus, image = wall_energy(parameters, number, place, strength[number, i], charge[i])
            total += meniscus
            total += image
    return total


def superposed_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the pair forces of a scene."""
    return Built(Superposed(summed_law(parameters)))
