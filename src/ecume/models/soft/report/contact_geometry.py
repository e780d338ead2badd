"""The deflections of all contacts of a state, for reports: how far a state is from the limits of the contact laws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._portable import exp
from ecume.engine.cells import Integers
from ecume.laws.deflections import DEFINITE, TANGENTIAL, TENSION
from ecume.models.soft.contacts.contact_list import box_in
from ecume.models.soft.loading.cell import Box
from ecume.models.soft.parameters import Contacts, Parameters
from ecume.models.soft.state import State
from ecume.units import Array
from ecume.value_texts import with_prefix

FAINT = 1e-3
"""Of the radius: in smaller deflections the ratio of both parts means nothing."""
LARGE = 0.1
"""Deflection over radius above which the contact laws are inaccurate."""


class Deflections(NamedTuple):
    """The contacts of a state; those with walls follow those of pairs."""

    pair: Integers
    """(C, 2) the spheres; at walls the sphere, and -1 less the wall"""
    radius: Array
    """(C,) m, the smaller one"""
    gap: Array
    normal: Array
    """(C,) m, the normal deflection, positive in tension"""
    tangential: Array
    """(C,) m, the magnitude of the tangential deflection"""
    vector: Array
    """(C, d) m"""

    @property
    def magnitude(self) -> Array:
        """Of the whole deflection over the radius."""
        return np.asarray(np.hypot(self.normal, self.tangential) / self.radius)


def deflections(parameters: Parameters, state: State) -> Deflections:
    """The deflections of all contacts."""
    pairs, walls = _of_pairs(parameters, state), _of_walls(parameters, state)
    return Deflections(*(np.concatenate(parts) for parts in zip(pairs, walls, strict=True)))


def _of_pairs(parameters: Parameters, state: State) -> Deflections:
    count, box = int(state.contacts[0]), box_in(parameters, state)
    pair, direction = state.pair[:count].copy(), state.direction[:count]
    gap, radius = exp(state.log_gap[:count]), parameters.radius[pair]
    reach = (radius.sum(axis=1) + gap)[:, None] * direction
    return _split(pair, radius.min(axis=1, initial=np.inf), gap, between(state, box) - reach, direction)


def between(state: State, box: Box) -> Array:
    """The vectors between the centers of all pairs in contact (C, d)."""
    count = int(state.contacts[0])
    pair, image = state.pair[:count], state.image[:count]
    vectors = state.position[pair[:, 1]] - state.position[pair[:, 0]] + image * box.sides
    vectors[:, 0] += box.tilt * image[:, 1]
    return np.asarray(vectors)


def _of_walls(parameters: Parameters, state: State) -> Deflections:
    first, wall = np.nonzero(state.touching)
    dimensions, radius = state.position.shape[1], parameters.radius[first]
    normal = -parameters.walls.surfaces.place[wall, :dimensions]
    gap = exp(state.wall_gap[first, wall])
    apart = state.wall[wall, :dimensions] - state.position[first] - radius[:, None] * state.slip[first, wall]
    pair = np.stack([first, -1 - wall], axis=1).astype(np.int64)
    return _split(pair, radius, gap, apart - (radius + gap)[:, None] * normal, normal)


def _split(pair: Integers, radius: Array, gap: Array, vector: Array, direction: Array) -> Deflections:
    normal = (vector * direction).sum(axis=1)
    tangential = np.linalg.norm(vector - normal[:, None] * direction, axis=1)
    return Deflections(pair, radius, gap, normal, tangential, vector)


def extremes(found: Deflections) -> dict[str, float]:
    """Numbers of a frame: how far contacts are from the limits of their laws."""
    magnitude = found.magnitude
    loaded = magnitude > FAINT
    ratio = found.tangential[loaded] / np.maximum(np.abs(found.normal[loaded]), FAINT**2 * found.radius[loaded])
    return {
        "largest_deflection": float(magnitude.max(initial=0.0)),
        "largest_shear_ratio": float(ratio.max(initial=0.0)),
    }


def worst_contact(found: Deflections) -> str:
    """The contact with the largest deflection, and its values; empty without contacts."""
    if not len(found.radius):
        return ""
    at = int(np.argmax(found.magnitude))
    first, second = found.pair[at]
    other = f"sphere {second}" if second >= 0 else f"wall {-1 - second}"
    sign = "tension" if found.normal[at] > 0.0 else "compression"
    values = [
        f"gap {with_prefix(float(found.gap[at]), 'm', 3)}",
        f"normal deflection {abs(found.normal[at]) / found.radius[at]:.3g} radii in {sign}",
        f"tangential deflection {found.tangential[at] / found.radius[at]:.3g} radii",
    ]
    return f"the largest deflection is that of sphere {first} with {other}: {', '.join(values)}"


def is_beyond(found: Deflections) -> bool:
    """Whether a deflection is finite and beyond the range of the contact laws."""
    return bool((found.magnitude > LARGE).any() and np.isfinite(found.magnitude).all())


def remedy(found: Deflections, contacts: Contacts) -> str:
    """What to change in the scene, by the contacts beyond the limits and by the laws."""
    tangential, tension = list(TANGENTIAL)[contacts.tangential_law], list(TENSION)[contacts.tension_law]
    beyond = found.magnitude > LARGE
    stretched = bool((found.normal[beyond] > LARGE * found.radius[beyond]).any())
    sheared = bool((found.tangential[beyond] > DEFINITE * np.abs(found.normal[beyond])).any())
    if stretched and tension != "gap":
        return 'films hold stretched pairs together; set films.tension_law = "gap"'
    if sheared and tangential != "potential":
        return 'the secant law has lost its definite stiffness; set films.tangential_law = "potential"'
    if beyond.any():
        return "deflections exceed the range of the contact laws; reduce forces, shear rate or volume fraction"
    return "look for forces that the surfaces cannot balance, or set integration.tolerance lower"
