"""The loop over pairs, and how threads share it.

Each pair is worked out once and counts for both. Slots are parted into stretches of about as many pairs each; a
stretch adds up its pairs into a window of its own, from its first slot to the last one's last neighbor, and the windows
are added up in order. How many stretches there are follows from the crowd alone, so that bits do not depend on threads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ecume._fused import lane_sum
from ecume._jit import compiled, compiled_inside, inlined
from ecume.engine.cells import Integers
from ecume.engine.neighbors import STRETCHES, THREADS_FROM, Rows
from ecume.models.floating.parameters import CAPILLARY_LENGTH, CUTOFF, SURFACE_TENSION, PairParameters
from ecume.units import Array

PADDED = 8
"""Neighbors are padded to a multiple of the vector width, since what is left over runs one by one."""


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


@inlined
def pull_pairs_with(
    pull_of: Callable[..., float],
    law_of: Callable[[Array], Any],
    stretch: tuple[int, int],
    rows: Any,
    floats: tuple[Array, Array],
    pair: Array,
    window: tuple[Array, Array],
) -> None:
    """Add the forces of the pairs of a stretch of slots with later ones, by a law's pull over the distance.

    Four plain loops instead of one: gather the neighbors, work out all their forces (this one vectorizes, without
    changing a bit), give them to the neighbors, add them up in lanes. The second one is in the precision of `pair` and
    of the charges; distances are taken and forces added up in double. Laws that look at no radius are given none.
    """
    first, later, neighbor, x, y, _, _ = rows
    charge, radius = floats
    law, cutoff, length, tension = law_of(pair), pair[CUTOFF], pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION]
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
            factor = pull_of(square, own, law)
            factor = factor if square < cutoff * cutoff else nothing
            apart_x[k] *= factor
            apart_y[k] *= factor
        for k in range(found):
            j = np.uint64(neighbor[begin + k]) - start
            force_x[j] -= apart_x[k]
            force_y[j] -= apart_y[k]
        force_x[np.uint64(slot) - start] += lane_sum(apart_x, padded)
        force_y[np.uint64(slot) - start] += lane_sum(apart_y, padded)


@inlined
def pull_all_with(
    pull_stretch: Callable[..., None],
    pull_in_threads: Callable[..., None],
    rows: Any,
    floats: tuple[Array, Array],
    pair: Array,
    force: Array,
) -> None:
    """The forces of all pairs on all slots, by threads where there are many."""
    if force.shape[1] < THREADS_FROM:
        force[:] = 0.0
        pull_stretch((0, force.shape[1]), rows, floats, pair, (force[0], force[1]))
    else:
        edge, place = rows[5], rows[6]
        windows = np.zeros((2, place[STRETCHES]))
        pull_in_threads(edge, place, rows, floats, pair, windows[0], windows[1])
        add_windows(edge, place, windows, force)
