"""Six small spheres with a short-ranged attraction: weights of rigid clusters, entropy production of transitions."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from ecume.analysis.clusters import touching_pairs
from ecume.analysis.series import Mean
from ecume.analysis.topologies import rigid_weight, topology_of
from ecume.analysis.transitions import entropy_production
from ecume.laws.brownian import thermal_energy
from ecume.models.floating.time_integration.step_size import StepWarning
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import Array
from ecume.validation.rows import Row, above, within

RADIUS, TEMPERATURE = 1e-6, 300.0
DEPTH, STEEPNESS, FARTHEST, SPRING = 4.0, 10.0, 2.9, 400.0
"""Of the attraction: depth (kT), inverse range (1/diameter), largest distance (diameters), and the spring beyond it
(kT per diameter squared), which keeps six spheres together and does not act inside a rigid cluster of six.
"""
BOND = 1.25
"""Distance, in diameters, up to which two spheres are bound."""
GROUPS, SPREAD = 49, 1.2e-4
"""Independent groups of six in a run, and their distance (m)."""
STEP, STEPS, FRAMES = 5e-4, 150, 2500
"""Time step (s), steps in a frame, frames in equilibrium; with persistence twice as many."""
FORCE, PERSISTENCE = 3.6e-14, 0.6
"""Of the active force (N, s): as large as the attraction, with a correlation time of many vibrations."""
LATTICE = np.array([[1.0, 0.0], [0.5, math.sqrt(0.75)]])
GROUND_STATES = {
    "triangle": [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)],
    "parallelogram": [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)],
    "chevron": [(0, 0), (1, 0), (0, 1), (-1, 1), (-1, 0), (1, -1)],
}
"""Rigid clusters of six spheres, in steps along two directions of a triangular lattice."""


def rows() -> list[Row]:
    """In equilibrium, then with a persistent force."""
    return [*equilibrium(), *persistence()]


def attraction(distance: Any, parameters: Any) -> Any:
    """Morse's potential between spheres in contact, and a spring at large distances (N)."""
    depth, steepness, farthest, spring = parameters.constants
    diameter = parameters.radius_i + parameters.radius_j
    x = distance / diameter
    decay = math.exp(-steepness * (x - 1.0))
    force = -2.0 * depth * steepness / diameter * (decay - decay * decay)
    if x > farthest:
        force -= spring * (x - farthest) / diameter
    return force


def equilibrium() -> Iterator[Row]:
    """Shares of the rigid clusters, beside their weights, and entropy production, for Brownian spheres."""
    found = sequences({"hydrodynamics": {"brownian": True}}, FRAMES)
    weights = weights_of_ground_states()
    total = sum(weights.values())
    names = dict(zip(weights, GROUND_STATES, strict=True))
    for label, weight in weights.items():
        share = share_of(label, list(weights), found)
        name = f"in equilibrium: share of the {names[label]} among rigid clusters (tolerance: 3 standard errors)"
        yield within(name, share.value, weight / total, 3.0 * share.error)
    rate = entropy_production(found, STEP * STEPS, blocks=1)
    name = "in equilibrium: entropy production, over its standard error (tolerance: 2)"
    yield within(name, rate.value / rate.error, 0.0, 2.0)


def persistence() -> Iterator[Row]:
    """Entropy production of spheres with a persistent random force instead of noise."""
    found = sequences({"activity": {"force": FORCE, "persistence": PERSISTENCE}}, 2 * FRAMES)
    rate = entropy_production(found, STEP * STEPS, blocks=1)
    yield above("with persistence: entropy production, over its standard error", rate.value / rate.error, 2.0)


def sequences(driving: dict[str, Any], frames: int) -> list[list[str]]:
    """The labels of each group over the frames, without the first fifth. Groups start as rigid clusters in the shares
    of equilibrium, so that relaxation makes no currents.
    """
    starts = [name for name, weight in zip(GROUND_STATES, (1, 3, 3), strict=True) for _ in range(weight)]
    side = math.ceil(math.sqrt(GROUPS))
    places = [
        2.0 * RADIUS * np.array(GROUND_STATES[starts[group % len(starts)]]) @ LATTICE
        + SPREAD * np.array([group % side, group // side])
        for group in range(GROUPS)
    ]
    thermal = thermal_energy(TEMPERATURE)
    scene = from_plain({
        "model": "floating", "duration": frames * STEPS * STEP, "frame_every": STEPS * STEP, "seed": 3,
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "surface_tension": 1e-7, "temperature": TEMPERATURE},
        "particles": [{"radius": RADIUS, "density": 1000.0, "contact_angle": 0.5 * math.pi,
                       "positions": np.concatenate(places).tolist()}],
        "integration": {"integrator": "overdamped", "time_step": STEP}, "contacts": {"law": "none"},
        "interaction": {"law": "none", "accuracy": 0.1},
        "user_laws": [{"law": "attraction", "constants": [DEPTH * thermal, STEEPNESS, FARTHEST, SPRING * thermal]}],
        **driving,
    })  # fmt: skip
    found: list[list[str]] = [[] for _ in range(GROUPS)]
    with warnings.catch_warnings():
        # The step that is advised is for six neighbors at the steepest place of the law.
        warnings.simplefilter("ignore", StepWarning)
        for frame in simulate(scene, extra_laws=[attraction]):
            for group, place in enumerate(frame.arrays["position"].reshape(GROUPS, 6, 2)):
                found[group].append(label_of(place))
    return [labels[len(labels) // 5 :] for labels in found]


def label_of(place: Array) -> str:
    """The label of the bonds of six spheres, which may be in several pieces."""
    one, other = np.triu_indices(6, 1)
    bound = np.linalg.norm(place[one] - place[other], axis=1) < BOND * 2.0 * RADIUS
    return label_of_bonds(tuple(bound.tolist()))


@cache
def label_of_bonds(bound: tuple[bool, ...]) -> str:
    """The label of these bonds among all pairs of six spheres."""
    pairs = [(int(i), int(j)) for i, j, there in zip(*np.triu_indices(6, 1), bound, strict=True) if there]
    return topology_of(pairs, 6).label


def weights_of_ground_states() -> dict[str, float]:
    """The weight of each rigid cluster of six by its label."""
    found = {}
    for steps in GROUND_STATES.values():
        place = np.array(steps) @ LATTICE
        pairs = touching_pairs(place, np.full(6, 0.5))
        found[topology_of(pairs, 6).label] = float(rigid_weight(place, pairs))
    return found


def share_of(label: str, among: list[str], found: list[list[str]]) -> Mean:
    """The share of a label among others, and its standard error from the groups."""
    own = np.array([labels.count(label) for labels in found], dtype=float)
    every = np.array([sum(labels.count(each) for each in among) for labels in found], dtype=float)
    share = float(own.sum() / every.sum())
    spread = float(np.sqrt(np.sum((own - share * every) ** 2) * len(found) / (len(found) - 1)))
    return Mean(share, spread / float(every.sum()))
