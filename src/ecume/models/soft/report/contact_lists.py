"""Contacts as arrays over spheres, for frames: each contact is listed at its sphere of lower number.

By default the narrowest gaps of a sphere, with scalars. With `films.output = "vectors"` all contacts, and what a force
network, the balance of forces and the stress follow from: image, force vectors, deflection.
"""

from __future__ import annotations

import math

import numpy as np

from ecume._portable import exp
from ecume.engine.cells import Integers
from ecume.models.soft.contacts.contact_list import box_in, wraps
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.report.contact_geometry import between
from ecume.models.soft.state import State, Step
from ecume.units import Array

SLOTS = {2: 8, 3: 16}
"""Contacts that a frame lists for a sphere by default, by dimension: those with later spheres, the narrowest gaps
first.
"""
MOST = 1000
"""Components that an array of a trajectory can have for a particle."""
UNITS = {
    "gap": "m",
    "tension": "N",
    "shear": "N",
    "normal_force": "N",
    "tangential_force": "N",
    "deflection": "m",
}
UNLISTED = "unlisted_contacts"


def slots_of(parameters: Parameters) -> int:
    """The number of contacts for which frames have room at each sphere."""
    dimensions, others = parameters.dimensions, max(len(parameters.radius) - 1, 1)
    if parameters.listed == "scalars":
        return min(SLOTS[dimensions], others)
    reach, smallest, largest = parameters.contacts.fade_to, parameters.radius.min(), parameters.radius.max()
    images = 2 if parameters.box.any() else 1
    if math.isinf(reach):
        return min(others, MOST)
    # As many of the smallest spheres as fill the shell within reach of the largest.
    outer, inner = largest + 2.0 * smallest + reach, largest
    shell = (outer**dimensions - inner**dimensions) / smallest**dimensions
    return int(min(max(math.ceil(shell), 1), images * others, MOST))


def listed(parameters: Parameters, state: State, step: Step) -> tuple[dict[str, Array | Integers], int]:
    """The arrays of contacts, and the number of contacts without room; -1 fills the rest of `neighbor`."""
    first, count, slots = step.pairs.first, len(parameters.radius), slots_of(parameters)
    order = np.lexsort((step.log_gap, first))
    place = np.arange(len(first)) - np.searchsorted(first[order], first[order])
    fits = place < slots
    one, place = order[fits], place[fits]
    arrays: dict[str, Array | Integers] = {}
    for name, values in _columns(parameters, state, step).items():
        shape = (count, slots, *values.shape[1:])
        arrays[name] = np.full(shape, -1, np.int64) if name == "neighbor" else np.zeros(shape, values.dtype)
        arrays[name][first[one], place] = values[one]
    return arrays, int((~fits).sum())


def _columns(parameters: Parameters, state: State, step: Step) -> dict[str, Array | Integers]:
    """The values of all contacts, in their order."""
    d, force, direction = parameters.dimensions, step.answers.force, step.direction
    gap, tension = exp(step.log_gap), (force * direction).sum(axis=1)
    along = force - tension[:, None] * direction
    values: dict[str, Array | Integers] = {
        "neighbor": step.pairs.second,
        "gap": gap,
        "tension": tension,
        "shear": np.linalg.norm(along, axis=1),
    }
    if parameters.listed == "scalars":
        return values
    box = box_in(parameters, state)
    away, count = wraps(state.position, box), int(state.contacts[0])
    image = state.image[:count] + away[step.pairs.second] - away[step.pairs.first]
    reach = (step.pairs.radius_sum + gap)[:, None] * direction[:, :d]
    return values | {
        "contact_image": image,
        "normal_force": tension[:, None] * direction[:, :d],
        "tangential_force": along[:, :d],
        "deflection": between(state, box) - reach,
    }


def widths(parameters: Parameters) -> dict[str, int]:
    """The numbers per sphere in each array of contacts."""
    slots, d = slots_of(parameters), parameters.dimensions
    scalars = dict.fromkeys(("neighbor", "gap", "tension", "shear"), slots)
    if parameters.listed == "scalars":
        return scalars
    return scalars | dict.fromkeys(("contact_image", "normal_force", "tangential_force", "deflection"), d * slots)
