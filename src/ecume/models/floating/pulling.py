"""The loop over pairs, and how threads share it.

Each pair is worked out once and counts for both. Slots are parted into stretches of about as many pairs each; a
stretch adds up its pairs into a window of its own, from its first slot to the last one's last neighbor, and the windows
are added up in order. How many stretches there are follows from the crowd alone, so that bits do not depend on threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ecume._fused import lane_sum
from ecume._jit import admit, by_type, compiled, compiled_inside, prange, threaded
from ecume.engine.cells import Integers
from ecume.engine.neighbors import STRETCHES, THREADS_FROM, Rows
from ecume.laws import capillarity, dipoles, ewald, pair_laws, screened, special
from ecume.laws.pair_laws import row_of
from ecume.models.floating.parameters import CAPILLARY_LENGTH, CUTOFF, SURFACE_TENSION, PairParameters
from ecume.units import Array

admit(capillarity, dipoles, pair_laws, screened, special, ewald)

PADDED = 8
"""Neighbors are padded to a multiple of the vector width, since what is left over runs one by one."""
LEAST_DISTANCE = 1e-300
"""m: shorter distances count as this one, so that nothing is divided by zero."""


@compiled_inside
def pairs_of(rows: Rows) -> Any:
    """What sums over pairs want of the lists, in two dimensions."""
    x, y = rows.sorted_position[0], rows.sorted_position[1]
    return rows.first, rows.later, rows.neighbor, x, y, rows.edge, rows.place


@compiled
def add_windows(edge: Integers, place: Integers, windows: Array, force: Array) -> None:
    """Add up all windows in order."""
    force[:] = 0.0
    for k in range(STRETCHES):
        for axis in range(2):
            for spot in range(place[k], place[k + 1]):
                force[axis, edge[k] + spot - place[k]] += windows[axis, spot]


def _pull_for(constants: type) -> Callable[..., float]:
    return row_of(constants).pull or pull_by_force


def pull_by_force(square: float, own: PairParameters, law: Any) -> float:
    """-force/distance, for laws that define their force alone."""
    distance = max(math.sqrt(square), LEAST_DISTANCE)
    pull: float = -pair_force(distance, own, law) / distance
    return pull


pair_pull = by_type(_pull_for)
"""pair_pull(square, own, law): minus the force over the distance (N/m), from the square of the distance."""
pair_force = by_type(lambda constants: row_of(constants).force)
"""pair_force(distance, own, law): the force of the law (N), positive when it repels."""
pair_energy = by_type(lambda constants: row_of(constants).energy or no_energy)
"""pair_energy(distance, own, law): the energy of the law (J)."""


def no_energy(distance: float, own: PairParameters, law: Any) -> float:
    """Zero, for laws without a potential."""
    return 0.0


@compiled_inside
def _all_radii(radius: Array, law: Any) -> Array:
    return radius


@compiled_inside
def _no_radii(radius: Array, law: Any) -> Array:
    return radius[:0]


seen_radii = by_type(lambda constants: _all_radii if row_of(constants).needs_radii else _no_radii)
"""seen_radii(radius, law): the radii if the law depends on them, otherwise an empty array."""


@compiled
def pull_stretch(
    law: Any,
    stretch: tuple[int, int],
    rows: Any,
    floats: tuple[Array, Array],
    pair: Array,
    window: tuple[Array, Array],
) -> None:
    """Add the forces between a stretch of slots and the later slots, by a pair law.

    Four plain loops instead of one: gather the neighbors, work out all their forces (this one vectorizes, without
    changing a bit), give them to the neighbors, add them up in lanes. The second one is in the precision of `pair`, of
    the law and of the charges; distances are computed and forces added up in double. Radii are gathered only for laws
    that depend on them.
    """
    first, later, neighbor, x, y, _, _ = rows
    charge, radius = floats[0], seen_radii(floats[1], law)
    cutoff, length, tension = pair[CUTOFF], pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION]
    nothing = cutoff - cutoff
    longest, start = 0, np.uint64(stretch[0])
    for slot in range(stretch[0], stretch[1]):
        longest = max(longest, first[slot + 1] - later[slot])
    room, kind = longest + PADDED, charge.dtype
    apart_x, apart_y, charges, radii = np.empty(room, kind), np.empty(room, kind), np.zeros(room, kind), np.ones(room)
    force_x, force_y = window
    for slot in range(stretch[0], stretch[1]):
        begin, found = np.uint64(later[slot]), np.uint64(first[slot + 1] - later[slot])
        own_x, own_y, own_charge, own_radius = x[slot], y[slot], charge[slot], 0.0
        for k in range(found):
            j = np.uint64(neighbor[begin + k])
            apart_x[k], apart_y[k], charges[k] = x[j] - own_x, y[j] - own_y, charge[j]
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
def pull_in_threads(
    law: Any, edge: Any, place: Any, rows: Any, floats: Any, pair: Array, along: Array, across: Array
) -> None:
    """Add the forces of many stretches, each into its own window, in parallel."""
    for k in prange(len(edge) - 1):
        window = along[place[k] : place[k + 1]], across[place[k] : place[k + 1]]
        pull_stretch(law, (edge[k], edge[k + 1]), rows, floats, pair, window)


@compiled
def pull_serial(law: Any, rows: Any, floats: tuple[Array, Array], pair: Array, force: Array) -> None:
    """The forces of all pairs on all slots, computed by one thread."""
    force[:] = 0.0
    pull_stretch(law, (0, force.shape[1]), rows, floats, pair, (force[0], force[1]))


@compiled
def pull_parallel(law: Any, rows: Any, floats: tuple[Array, Array], pair: Array, force: Array) -> None:
    """The forces of all pairs on all slots, computed by several threads if there are many floats."""
    if force.shape[1] < THREADS_FROM:
        pull_serial(law, rows, floats, pair, force)
    else:
        edge, place = rows[5], rows[6]
        windows = np.zeros((2, place[STRETCHES]))
        pull_in_threads(law, edge, place, rows, floats, pair, windows[0], windows[1])
        add_windows(edge, place, windows, force)


@compiled
def pull_one_sided(law: Any, rows: Any, floats: tuple[Array, Array], pair: Array, force: Array) -> None:
    """The forces of all pairs on all slots for a law that is not reciprocal: each slot sums over all its neighbors."""
    first, _, neighbor, x, y, _, _ = rows
    charge, radius = floats
    length, tension, cutoff = pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION], pair[CUTOFF]
    for slot in range(force.shape[1]):
        total_x, total_y = 0.0, 0.0
        for place in range(first[slot], first[slot + 1]):
            j = neighbor[place]
            apart_x, apart_y = x[j] - x[slot], y[j] - y[slot]
            square = apart_x * apart_x + apart_y * apart_y
            if math.sqrt(square) < cutoff:
                own = PairParameters(radius[slot], radius[j], charge[slot], charge[j], length, tension)
                factor = pair_pull(square, own, law)
                total_x += factor * apart_x
                total_y += factor * apart_y
        force[0, slot], force[1, slot] = total_x, total_y


def _sum_for(constants: type) -> Callable[..., None]:
    row = row_of(constants)
    if not row.reciprocal:
        return pull_one_sided
    return pull_parallel if row.threaded else pull_serial


pull = by_type(_sum_for, 0)
"""pull(law, rows, floats, pair, force): the forces of all pairs on all slots."""
