"""Six small spheres with a short-ranged attraction: weights of rigid clusters, entropy production of transitions."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ecume.analysis.clusters import entropy_production, rigid_weight, topology_of, touching_pairs
from ecume.analysis.series import Mean
from ecume.laws.brownian_motion import thermal_energy
from ecume.laws.capillarity import pair_energy, pair_strength
from ecume.models import MODELS
from ecume.models.floating.time_integration.step_size import StepWarning
from ecume.models.liquids import liquid_of
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import Array
from ecume_validation.runner import Row, above, within

RADIUS, TEMPERATURE = 1e-6, 300.0
STEEPNESS, FARTHEST, SPRING = 10.0, 2.9, 400.0
"""Parameters of the short-ranged attraction: inverse range (1/diameter), largest distance (diameters), and the spring
beyond it (kT per diameter squared). The spring keeps six spheres together and does not act inside a rigid cluster of
six.
"""


class Spheres(NamedTuple):
    """The attraction of the spheres, and the initial clusters."""

    depth: float
    """of the short-ranged attraction (kT)"""
    starts: tuple[int, int, int]
    """relative numbers of groups that start as each of the ground states: nearly the shares in equilibrium"""
    density: float = 1000.0
    surface_tension: float = 1e-7
    interaction: dict[str, Any] = {"law": "none", "accuracy": 0.1}  # noqa: RUF012  (read only)


SHORT_RANGED = Spheres(4.0, (1, 3, 3))
CAPILLARY = Spheres(3.0, (1, 2, 4), 6900.0, 1e-6, {"accuracy": 1e-3})
"""Heavy spheres, whose menisci attract with 2.6 kT K0(r/L); the capillary length L is five diameters."""
BOND = 1.25
"""The largest distance of bonded spheres, in diameters."""
GROUPS, SPREAD = 49, 1.2e-4
"""The number of independent groups of six in a run, and their distance (m)."""
STEP, STEPS, FRAMES = 5e-4, 150, 2500
"""Time step (s), steps per frame, and frames in equilibrium; with persistence there are twice as many frames."""
FORCE, PERSISTENCE = 3.6e-14, 0.6
"""The active force (N), as large as the attraction, and its correlation time (s), many vibrations long."""
APART = 20.0
"""Diameters beyond which two spheres belong to different groups."""
LATTICE = np.array([[1.0, 0.0], [0.5, math.sqrt(0.75)]])
GROUND_STATES = {
    "triangle": [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)],
    "parallelogram": [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)],
    "chevron": [(0, 0), (1, 0), (0, 1), (-1, 1), (-1, 0), (1, -1)],
}
"""Rigid clusters of six spheres, in steps along two directions of a triangular lattice."""


def rows() -> list[Row]:
    """Compare equilibrium with and without menisci, then a persistent force."""
    return [*equilibrium(), *menisci(), *persistence()]


def attraction(distance: Any, parameters: Any) -> Any:
    """The force of Morse's potential in contact, and of a spring between distant spheres of a group (N)."""
    depth, steepness, farthest, spring = parameters.constants
    diameter = parameters.radius_i + parameters.radius_j
    x = distance / diameter
    decay = math.exp(-steepness * (x - 1.0))
    force = -2.0 * depth * steepness / diameter * (decay - decay * decay)
    if farthest < x < APART:
        force -= spring * (x - farthest) / diameter
    return force


def equilibrium() -> Iterator[Row]:
    """Compare the shares of rigid clusters of Brownian spheres with their weights, and the entropy production with
    zero.
    """
    found = sequences({"hydrodynamics": {"brownian": True}}, FRAMES)
    yield from shares(found, weights_of_ground_states(), "in equilibrium")
    rate = entropy_production(found, STEP * STEPS, blocks=1)
    name = "in equilibrium: entropy production, over its standard error (tolerance: 2)"
    yield within(name, rate.value / rate.error, 0.0, 2.0)


def menisci() -> Iterator[Row]:
    """Compare the shares of rigid clusters of Brownian spheres with menisci to their weights times exp(-U/kT), with the
    capillary energy U of the rigid cluster.
    """
    driving = {"hydrodynamics": {"brownian": True}}
    scene = scene_of(np.zeros((1, 2)), driving, 1, CAPILLARY)
    energies = [energy / thermal_energy(TEMPERATURE) for energy in capillary_energies(scene)]
    weights = {
        label: weight * math.exp(min(energies) - energy)
        for (label, weight), energy in zip(weights_of_ground_states().items(), energies, strict=True)
    }
    yield from shares(sequences(driving, FRAMES, CAPILLARY), weights, "with menisci")


def shares(found: list[list[str]], weights: dict[str, float], name: str) -> Iterator[Row]:
    """Rows that compare the share of each rigid cluster with the share of its weight."""
    for (label, weight), cluster in zip(weights.items(), GROUND_STATES, strict=True):
        share = share_of(label, list(weights), found)
        row = f"{name}: share of the {cluster} among rigid clusters (tolerance: 3 standard errors)"
        yield within(row, share.value, weight / sum(weights.values()), 3.0 * share.error)


def capillary_energies(scene: Any) -> list[float]:
    """The energy of the menisci of each rigid cluster (J): a sum over its pairs."""
    charge, length = float(MODELS["floating"].parameters(scene).floats.charge[0]), liquid_of(scene).capillary_length
    strength = pair_strength(CAPILLARY.surface_tension, charge, charge)
    one, other = np.triu_indices(6, 1)
    energies = []
    for steps in GROUND_STATES.values():
        place = 2.0 * RADIUS * np.array(steps) @ LATTICE
        distances = np.linalg.norm(place[one] - place[other], axis=1).tolist()
        energies.append(math.fsum(pair_energy(distance, strength, length) for distance in distances))
    return energies


def persistence() -> Iterator[Row]:
    """Compute the entropy production of spheres with a persistent random force instead of noise."""
    found = sequences({"activity": {"force": FORCE, "persistence": PERSISTENCE}}, 2 * FRAMES)
    rate = entropy_production(found, STEP * STEPS, blocks=1)
    yield above("with persistence: entropy production, over its standard error", rate.value / rate.error, 2.0)


def sequences(driving: dict[str, Any], frames: int, spheres: Spheres = SHORT_RANGED) -> list[list[str]]:
    """The labels of each group over the frames, without the first fifth. The initial clusters have the shares of
    equilibrium, so that relaxation causes no probability currents.
    """
    starts = [name for name, part in zip(GROUND_STATES, spheres.starts, strict=True) for _ in range(part)]
    side = math.ceil(math.sqrt(GROUPS))
    places = [
        2.0 * RADIUS * np.array(GROUND_STATES[starts[group % len(starts)]]) @ LATTICE
        + SPREAD * np.array([group % side, group // side])
        for group in range(GROUPS)
    ]
    scene = scene_of(np.concatenate(places), driving, frames, spheres)
    found: list[list[str]] = [[] for _ in range(GROUPS)]
    with warnings.catch_warnings():
        # The step recommended by the warning is for six neighbors at the steepest point of the law.
        warnings.simplefilter("ignore", StepWarning)
        for frame in simulate(scene, extra_laws=[attraction]):
            for group, place in enumerate(frame.arrays["position"].reshape(GROUPS, 6, 2)):
                found[group].append(label_of(place))
    return [labels[len(labels) // 5 :] for labels in found]


def scene_of(places: Array, driving: dict[str, Any], frames: int, spheres: Spheres) -> Any:
    """The scene of these spheres."""
    thermal = thermal_energy(TEMPERATURE)
    constants = [spheres.depth * thermal, STEEPNESS, FARTHEST, SPRING * thermal]
    return from_plain({
        "model": "floating", "duration": frames * STEPS * STEP, "frame_every": STEPS * STEP, "seed": 3,
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "surface_tension": spheres.surface_tension,
                   "temperature": TEMPERATURE},
        "particles": [{"radius": RADIUS, "density": spheres.density, "contact_angle": 0.5 * math.pi,
                       "positions": places.tolist()}],
        "integration": {"integrator": "overdamped", "time_step": STEP}, "contacts": {"law": "none"},
        "interaction": spheres.interaction, "user_laws": [{"law": "attraction", "constants": constants}], **driving,
    })  # fmt: skip


def label_of(place: Array) -> str:
    """The label of the bonds of six spheres, which may form several pieces."""
    one, other = np.triu_indices(6, 1)
    bound = np.linalg.norm(place[one] - place[other], axis=1) < BOND * 2.0 * RADIUS
    return label_of_bonds(tuple(bound.tolist()))


@cache
def label_of_bonds(bound: tuple[bool, ...]) -> str:
    """The label of these bonds, flags for all pairs of six spheres."""
    pairs = [(int(i), int(j)) for i, j, there in zip(*np.triu_indices(6, 1), bound, strict=True) if there]
    return topology_of(pairs, 6).label


def weights_of_ground_states() -> dict[str, float]:
    """The weight of each rigid cluster of six spheres, by its label."""
    found = {}
    for steps in GROUND_STATES.values():
        place = np.array(steps) @ LATTICE
        pairs = touching_pairs(place, np.full(6, 0.5))
        found[topology_of(pairs, 6).label] = float(rigid_weight(place, pairs))
    return found


def share_of(label: str, among: list[str], found: list[list[str]]) -> Mean:
    """The share of a label among other labels, and its standard error from the groups."""
    own = np.array([labels.count(label) for labels in found], dtype=float)
    every = np.array([sum(labels.count(each) for each in among) for labels in found], dtype=float)
    share = float(own.sum() / every.sum())
    spread = float(np.sqrt(np.sum((own - share * every) ** 2) * len(found) / (len(found) - 1)))
    return Mean(share, spread / float(every.sum()))
